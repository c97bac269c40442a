"""The rotations of a rigid fixture that features located alone allow: the method of the paper, as starts for a fit.

1. Planes, spheres, and cylinders that stand on a plane are located by their own contacts, if these determine them well:
   every candidate of each.
2. A plane gives a direction, its normal, on either side. Each pair of spheres gives the direction from centre to
   centre; a sphere and a cylinder, or two cylinders, give the one across the axis. Each choice of candidates gives a
   set of directions.
3. A set is kept if its angles agree with those of the same directions of the fixture.
4. Two directions that are not parallel determine the rotation. A single direction leaves a rotation about it, of which
   samples are taken.

A pose that explains all contacts explains those of each feature. So it is as near to one of these rotations as the
features are determined.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import product

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import DegenerateContactsError
from tactfix.geometry.arrays import TINY, Bools, Floats, basis_across, cross, lengths, unit
from tactfix.geometry.rigid import rotation_from_vector
from tactfix.geometry.surfaces import (
    Cylinder,
    Plane,
    SidedSurface,
    Sphere,
    offset_radius,
    radius_of,
    reference_point,
)
from tactfix.localizers.candidate import SurfaceCandidate
from tactfix.localizers.plane import localize_plane
from tactfix.localizers.sphere import localize_sphere
from tactfix.poses.pose_domain import ANGLES_AGREE, PoseDomain
from tactfix.poses.starts import TURNS, FeatureRotations

WELL_LOCATED = 0.02
"""Largest sigma of a feature that is used, as a share of the extent of its contacts. 0.01 and 0.04 give the same poses
of the 336 problems of `all_poses.SEARCHED`."""
ONE_DIRECTION = 0.2
"""Sine of the angle between two directions below which the second one is not used: its rotation about the first is then
uncertain by five times as much."""
MOST_ROTATION_COMBINATIONS = 64
"""Combinations of candidates up to which their rotations are starts; with more, a search from all rotations is as
fast."""
CIRCLE_CONTACTS = 3
"""Contacts that determine a circle."""
CLEARLY_OUT = 0.7
"""Cosine of the angle between the outward normal of a plane and the approach above which no pose near a rotation passes
the test of the approach: 45 deg, and rotations are known to ANGLES_AGREE, 14 deg."""
UPRIGHT = 1e-3
"""Sine of the angle between a cylinder's axis and a plane's normal up to which it stands on the plane: files are
typed to a millimetre in a metre or better, and the start is refined anyway."""


def rotations_in(
    domain: PoseDomain, surfaces: Mapping[str, SidedSurface], contacts: Contacts, sigmas: Floats
) -> FeatureRotations | None:
    """The rotations of `feature_rotations` that may lead into the domain; None if there are none.

    None too for constrained directions: a domain with fewer unknowns needs no such starts.
    """
    rotations = feature_rotations(surfaces, contacts, sigmas) if domain.is_free else None
    if rotations is None or domain.looks_beyond:
        return rotations
    near = rotations.of(domain.may_lead_into(rotations.matrices))
    return near if len(near) else None


def not_out_of_material(surfaces: Mapping[str, SidedSurface], contacts: Contacts, rotations: Floats) -> Bools:
    """Which rotations (3, 3, N) of fixture_from_base let the probe travel into every touched plane, not clearly out."""
    normals = np.zeros((len(contacts), 3))
    for name, index in contacts.by_feature.items():
        if isinstance(surface := surfaces[name], Plane):
            normals[index] = surface.normal
    approaches = np.where(contacts.has_approach[:, None], contacts.approaches, 0.0)
    cosines = np.einsum("na,abN,nb->nN", normals, rotations, approaches, optimize=False)
    return np.asarray((cosines < CLEARLY_OUT).all(axis=0))


def feature_rotations(
    surfaces: Mapping[str, SidedSurface], contacts: Contacts, sigmas: Floats
) -> FeatureRotations | None:
    """Rotations of fixture_from_base near that of every pose; None if features give no direction.

    surfaces in the fixture frame; sigmas (n,) of the residuals.
    """
    located = _located(surfaces, contacts, sigmas)  # step 1
    choices = list(product(*located.values()))
    if len(choices) > MOST_ROTATION_COMBINATIONS:
        return None
    # Step 2.
    places = [surfaces[name] for name in located]
    pairs = _pairs(places)
    fixture = _directions(places, pairs)
    if not len(fixture):
        return None
    base = np.array([_directions(choice, pairs) for choice in choices])
    found = _rotations(fixture, base[_agree(fixture, base)])  # steps 3 and 4
    return FeatureRotations(np.moveaxis(found, 0, -1), _fix_place(located.values())) if len(found) else None


def _fix_place(located: Iterable[Sequence[SidedSurface]]) -> bool:
    """Whether these places leave a single translation at each rotation.

    The two sides of a plane belong to two rotations. The two places of a ball may belong to one: it does not count.
    """
    resisted = np.zeros((3, 3))
    for place, *others in located:
        if isinstance(place, Plane):
            resisted += np.outer(place.normal, place.normal)
        elif not others:
            resisted += np.eye(3)
            if isinstance(place, Cylinder):
                resisted -= np.outer(place.direction, place.direction)
    return bool(np.linalg.eigvalsh(resisted)[0] > ONE_DIRECTION)


def _located(surfaces: Mapping[str, SidedSurface], contacts: Contacts, sigmas: Floats) -> dict[str, list[SidedSurface]]:
    """Planes, spheres and cylinders on a plane that their own contacts locate well, with all candidates of each."""
    located: dict[str, list[SidedSurface]] = {}
    upright: dict[str, list[SidedSurface]] = {}
    for name in _worth_locating(surfaces, contacts):
        index = contacts.by_feature[name]
        try:
            found = _candidates(surfaces[name], contacts.points[index], sigmas[index], contacts.tip_radius)
        except DegenerateContactsError:
            continue
        extent = float(np.linalg.norm(np.ptp(contacts.points[index], axis=0)))
        off = max((c.condition * float(sigmas[index].max()) for c in found), default=np.inf)
        if off >= WELL_LOCATED * extent or any(c.poorly_determined for c in found):
            continue
        located[name] = [candidate.surface for candidate in found]
        if isinstance(plane := surfaces[name], Plane) and isinstance(place := found[0].surface, Plane):
            standing = upright_cylinders(surfaces, contacts, sigmas, plane, place.normal, off / extent)
            upright |= {pin: [axis] for pin, (axis, share) in standing.items() if share < WELL_LOCATED}
    located |= upright
    # A direction between features takes two: one alone would only multiply the combinations.
    centred = [name for name in located if not isinstance(surfaces[name], Plane)]
    return {name: places for name, places in located.items() if centred != [name]}


def _worth_locating(surfaces: Mapping[str, SidedSurface], contacts: Contacts) -> list[str]:
    """Touched planes; spheres if there are two, or one and a cylinder on a plane: one alone gives no direction."""
    planes = [name for name in contacts.by_feature if isinstance(surfaces[name], Plane)]
    spheres = [name for name in contacts.by_feature if isinstance(surfaces[name], Sphere)]
    has_cylinders = len(contacts.by_feature) > len(planes) + len(spheres)
    if len(spheres) == 1 and not (planes and has_cylinders):
        spheres = []
    return [name for name in contacts.by_feature if name in planes or name in spheres]


def _candidates(
    surface: SidedSurface, points: Floats, sigmas: Floats, tip_radius: float
) -> tuple[SurfaceCandidate, ...]:
    if isinstance(surface, Plane):
        return localize_plane(points, sigmas, tip_radius)
    if isinstance(surface, Sphere):
        return localize_sphere(points, offset_radius("sphere", surface.radius, surface.side, tip_radius), sigmas)
    return ()


def _pairs(places: Sequence[SidedSurface]) -> list[tuple[int, int]]:
    """Pairs of indices: the first sphere, or else cylinder, with each other one that is clear of it."""
    spheres = [number for number, place in enumerate(places) if isinstance(place, Sphere)]
    centred = spheres + [number for number, place in enumerate(places) if isinstance(place, Cylinder)]
    return [(centred[0], other) for other in centred[1:] if _are_clear(places[centred[0]], places[other])]


def _are_clear(one: SidedSurface, other: SidedSurface) -> bool:
    """Whether two spheres or cylinders are so far apart that the vector between them has a direction."""
    radii = radius_of(one) + radius_of(other)
    return float(np.linalg.norm(_way(one, other))) > radii


def _way(one: SidedSurface, other: SidedSurface) -> Floats:
    """The vector (3,) from centre to centre, or its component across each axis."""
    way = reference_point(other) - reference_point(one)
    for place in (one, other):
        if isinstance(place, Cylinder):
            way = way - (way @ place.direction) * place.direction
    return np.asarray(way)


def _directions(places: Sequence[SidedSurface], pairs: Sequence[tuple[int, int]]) -> Floats:
    """Unit vectors (d, 3): the normals of the planes, then those between pairs of spheres and cylinders."""
    normals = [place.normal for place in places if isinstance(place, Plane)]
    return unit(np.array([*normals, *(_way(places[one], places[other]) for one, other in pairs)]).reshape(-1, 3))


def _agree(fixture: Floats, base: Floats) -> Bools:
    """Whether directions base (c, d, 3) make the same angles as those of the fixture (d, 3)."""
    off = np.arccos(_cosines(fixture)) - np.arccos(_cosines(base))
    return np.asarray(np.abs(off).max(axis=(1, 2)) < ANGLES_AGREE)


def _cosines(vectors: Floats) -> Floats:
    return np.asarray(np.clip(vectors @ np.swapaxes(vectors, -1, -2), -1.0, 1.0))


def _rotations(fixture: Floats, base: Floats) -> Floats:
    """The rotations (k, 3, 3) that take directions base (c, d, 3) to those of the fixture (d, 3).

    None for directions of opposite handedness; samples of the rotations about a single direction.
    """
    u, values, vt = np.linalg.svd(fixture.T @ base)
    turns = u @ vt
    hand = np.linalg.det(turns)
    turns += (hand - 1)[:, None, None] * u[:, :, 2:] @ vt[:, 2:]
    fixed = values[:, 1] > ONE_DIRECTION**2
    mirrored = (hand < 0) & (values[:, 2] > ONE_DIRECTION**2)
    about = [_turns_about(fixture[0], single[0]) for single in base[~fixed]]
    return np.concatenate([turns[fixed & ~mirrored], *about])


def _turns_about(axis: Floats, from_axis: Floats) -> Floats:
    """The rotations (TURNS, 3, 3) that take the direction from_axis (3,) to axis (3,)."""
    fixture_frame, base_frame = _frame_about(axis), _frame_about(from_axis)
    angles = np.arange(TURNS) * (2 * np.pi / TURNS)
    return np.asarray(rotation_from_vector(angles[:, None] * axis) @ fixture_frame.T @ base_frame)


def _frame_about(axis: Floats) -> Floats:
    """Rows of a right-handed frame whose third is axis."""
    return np.vstack([basis_across(axis), axis])


def upright_cylinders(
    surfaces: Mapping[str, SidedSurface], contacts: Contacts, sigmas: Floats, plane: Plane, normal: Floats, tilt: float
) -> dict[str, tuple[Cylinder, float]]:
    """The cylinders perpendicular to a located plane, such as pins and bores of a plate, each in base.

    The normal of the plane is the direction of the axis. Along it the contacts lie on a circle, whose linear fit gives
    a point of the axis.

    surfaces and plane, the located one, in the fixture frame; sigmas (n,) of the residuals; normal (3,): that of the
    plane in base, on either side; tilt: its standard deviation (rad). Returned with each cylinder: the standard
    deviation of its axis across its direction, as a share of the extent of the contacts.
    """
    found: dict[str, tuple[Cylinder, float]] = {}
    for name, index in contacts.by_feature.items():
        surface = surfaces[name]
        if len(index) >= CIRCLE_CONTACTS and isinstance(surface, Cylinder) and _stands_on(surface, plane):
            center, sigma, extent = _circle(contacts.points[index], normal, float(sigmas[index].max()), tilt)
            found[name] = (Cylinder(center, normal, surface.radius, surface.side), sigma / max(extent, TINY))
    return found


def _stands_on(cylinder: Cylinder, plane: Plane) -> bool:
    return bool(lengths(cross(cylinder.direction, plane.normal)) < UPRIGHT)


def _circle(points: Floats, normal: Floats, sigma: float, tilt: float) -> tuple[Floats, float, float]:
    """The centre (3,) of the circle of contacts (n, 3) seen along normal, its sigma, and their extent across.

    Linear least squares of |x|^2 - 2 c . x = constant, whose residuals have the sigma 2 radius sigma.
    """
    middle = points.mean(axis=0)
    arms = points - middle
    across = basis_across(normal)
    flat = arms @ across.T
    squared = (flat**2).sum(axis=1)
    u, spread, vh = np.linalg.svd(flat, full_matrices=False)
    if spread[-1] <= TINY:
        return middle, np.inf, 1.0
    center = ((squared - squared.mean()) @ u / (2 * spread)) @ vh
    radius = np.sqrt(squared.mean() + center @ center)
    height = float(np.ptp(arms @ normal))
    return (
        middle + center @ across,
        float(np.hypot(sigma * radius / spread[-1], tilt * height)),
        float(np.sqrt((np.ptp(flat, axis=0) ** 2).sum())),
    )
