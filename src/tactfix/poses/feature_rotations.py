"""Rotations that features located alone leave a rigid fixture: the paper's way, as the start for all contacts at once.

A plane located by its own contacts gives a direction, its normal, on either side; each two spheres give another, from
centre to centre. Two directions that are not parallel fix the rotation, one leaves a turn about it. A pose that
explains all contacts explains those of each feature, so it is as near to one of these rotations as the features are
known.
"""

from collections.abc import Collection, Mapping, Sequence
from itertools import product

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import DegenerateContactsError
from tactfix.geometry.arrays import Bools, Floats, cross, perpendicular, unit
from tactfix.geometry.rigid import rotation_from_vector
from tactfix.geometry.surfaces import Plane, Sphere, Surface, offset_radius
from tactfix.localizers.candidate import SurfaceCandidate
from tactfix.localizers.plane import localize_plane
from tactfix.localizers.sphere import localize_sphere

SURE = 0.02
"""Share of its own contacts' extent by which a feature must be known to be relied on, one standard deviation; ..."""
NEAR = 0.25
"""... angles between directions may be off by so much (rad), a dozen times that, before they are passed over."""
TURNS = 12
"""Turns about a single direction: one every thirty degrees. Of 11,400 problems three kept a pose from these starts, and
no more from new ones around what those led to."""
PARALLEL = 0.2
"""Sine of the angle below which a second direction is not used."""
MOST = 64
"""Combinations of candidates that are worth a start; beyond, all rotations are."""


def feature_rotations(surfaces: Mapping[str, Surface], contacts: Contacts, sigmas: Floats) -> Floats | None:
    """Rotations (3, 3, N) of fixture_from_base near that of every pose; None where no direction is known alone.

    surfaces in the fixture frame; sigmas (n,) of the residuals.
    """
    located = _located(surfaces, contacts, sigmas)
    choices = list(product(*located.values()))
    if len(choices) > MOST:
        return None
    pairs = _sphere_pairs(surfaces, located)
    fixture = _directions([surfaces[name] for name in located], pairs)
    if not len(fixture):
        return None
    base = np.array([_directions(choice, pairs) for choice in choices])
    found = _rotations(fixture, base[_agree(fixture, base)])
    return np.moveaxis(found, 0, -1) if len(found) else None


def _located(surfaces: Mapping[str, Surface], contacts: Contacts, sigmas: Floats) -> dict[str, list[Surface]]:
    """Planes and spheres that their own contacts locate well, with every place they may have."""
    located: dict[str, list[Surface]] = {}
    for name in _worth_locating(surfaces, contacts):
        index = contacts.by_feature[name]
        try:
            found = _candidates(surfaces[name], contacts.points[index], sigmas[index], contacts.tip_radius)
        except DegenerateContactsError:
            continue
        extent = float(np.linalg.norm(np.ptp(contacts.points[index], axis=0)))
        sure = all(c.condition * sigmas[index].max() < SURE * extent and not c.poorly_determined for c in found)
        if found and sure:
            located[name] = [candidate.surface for candidate in found]
    # A direction takes two spheres: one alone would only double the combinations.
    spheres = [name for name in located if isinstance(surfaces[name], Sphere)]
    return {name: places for name, places in located.items() if spheres != [name]}


def _worth_locating(surfaces: Mapping[str, Surface], contacts: Contacts) -> list[str]:
    """Touched planes, and spheres where there are two: one alone gives no direction."""
    planes, spheres = ([n for n in contacts.by_feature if isinstance(surfaces[n], kind)] for kind in (Plane, Sphere))
    return [name for name in contacts.by_feature if name in planes or (name in spheres and len(spheres) > 1)]


def _candidates(surface: Surface, points: Floats, sigmas: Floats, tip_radius: float) -> tuple[SurfaceCandidate, ...]:
    if isinstance(surface, Plane):
        return localize_plane(points, sigmas, tip_radius)
    if isinstance(surface, Sphere):
        return localize_sphere(points, offset_radius("sphere", surface.radius, surface.side, tip_radius), sigmas)
    return ()


def _sphere_pairs(surfaces: Mapping[str, Surface], located: Collection[str]) -> list[tuple[int, int]]:
    """The first located sphere and each other that lies clear of it, by number."""
    spheres = [(number, s) for number, name in enumerate(located) if isinstance(s := surfaces[name], Sphere)]
    return [
        (spheres[0][0], number)
        for number, sphere in spheres[1:]
        if np.linalg.norm(sphere.center - spheres[0][1].center) > sphere.radius + spheres[0][1].radius
    ]


def _directions(places: Sequence[Surface], pairs: Sequence[tuple[int, int]]) -> Floats:
    """Unit vectors (d, 3): the normals of the planes, then the ways between the centres of pairs of spheres."""
    points = [place.center if isinstance(place, Sphere) else place.point for place in places]
    normals = [place.normal for place in places if isinstance(place, Plane)]
    return unit(np.array([*normals, *(points[to] - points[first] for first, to in pairs)]).reshape(-1, 3))


def _agree(fixture: Floats, base: Floats) -> Bools:
    """Whether directions base (c, d, 3) make the same angles as those of the fixture (d, 3)."""
    off = np.arccos(_cosines(fixture)) - np.arccos(_cosines(base))
    return np.asarray(np.abs(off).max(axis=(1, 2)) < NEAR)


def _cosines(vectors: Floats) -> Floats:
    return np.asarray(np.clip(vectors @ np.swapaxes(vectors, -1, -2), -1.0, 1.0))


def _rotations(fixture: Floats, base: Floats) -> Floats:
    """The rotations (k, 3, 3) that take directions base (c, d, 3) to those of the fixture (d, 3), or a turn about them.

    None for three directions and more of the other hand.
    """
    u, values, vt = np.linalg.svd(fixture.T @ base)
    turns = u @ vt
    hand = np.linalg.det(turns)
    turns += (hand - 1)[:, None, None] * u[:, :, 2:] @ vt[:, 2:]
    fixed = values[:, 1] > PARALLEL**2
    mirrored = (hand < 0) & (values[:, 2] > PARALLEL**2)
    about = [_turns_about(fixture[0], single[0]) for single in base[~fixed]]
    return np.concatenate([turns[fixed & ~mirrored], *about])


def _turns_about(axis: Floats, from_axis: Floats) -> Floats:
    """The rotations (TURNS, 3, 3) that take the direction from_axis (3,) to axis (3,)."""
    fixture_frame, base_frame = _frame_about(axis), _frame_about(from_axis)
    angles = np.arange(TURNS) * (2 * np.pi / TURNS)
    return np.asarray(rotation_from_vector(angles[:, None] * axis) @ fixture_frame.T @ base_frame)


def _frame_about(axis: Floats) -> Floats:
    """Rows of a right-handed frame whose third is axis."""
    across = perpendicular(axis)
    return np.array([across, cross(axis, across), axis])
