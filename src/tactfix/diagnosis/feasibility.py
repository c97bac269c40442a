"""Feasibility: a lower bound of chi-square over all poses, from pairs of contacts and from the contacts of one feature.

It costs a thousandth of a search for poses, and rules out most wrong hypotheses.

1. The distance of the tip's centres at two touches does not depend on the pose. It has an upper limit if both features
   are spheres, and a lower limit, the gap between the two features. If the distance is outside by excess, the two
   residuals a and b have |a| + |b| >= excess, so chi-square is at least excess^2 / (sigma_a^2 + sigma_b^2).
2. The contacts on a plane have at least the residuals of the plane that fits them best.
3. A plane whose normal is at an angle d from that best plane leaves residuals of at least sin(d) s. Here s^2 is the
   second moment of the contacts across their longest direction. If the best planes of two features are at a wrong
   angle, both have to be turned, which costs as much as in step 1 with sigma / s for sigma.
4. Within a distance s of a point on it, a sphere or cylinder lies at most s^2 / 2r below the tangent plane there. So
   points on it are at most s^2 / 4r, root mean square, from the plane that fits them best.
5. The bound is the largest of these.

`Feasibility` applies it to corrected contacts of a fixture, in every shape that its relations allow.
"""

from collections.abc import Mapping
from itertools import combinations, combinations_with_replacement

import numpy as np

from tactfix.accessibility.touchable import piece_bounds
from tactfix.contacts import Contacts
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture, TouchBox
from tactfix.geometry.arrays import Floats
from tactfix.geometry.nearest import distance_between
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, offset_radius
from tactfix.noise import SURE, chi_square_limit
from tactfix.probe import residual_sigmas
from tactfix.relations.realization import realize, shape_sigma


class Feasibility:
    """Whether corrected contacts of a fixture may have a pose at all.

    rows: of the contacts that are tested; the cost grows with the square of their number.
    """

    def __init__(self, fixture: Fixture, rows: frozenset[int]) -> None:
        self.fixture, self.rows = fixture, rows
        self.shapes = realize(fixture)
        self.slack = SURE * shape_sigma(fixture)

    def is_feasible(self, contacts: Contacts) -> bool:
        """Whether the contacts of these rows do not rule out every pose of every shape."""
        tested = contacts.subset([i for i, row in enumerate(contacts.rows) if row in self.rows])
        sigmas = np.hypot(residual_sigmas(self.fixture, tested), self.slack)
        limit = chi_square_limit(self.fixture.dof(contacts.features))
        try:
            return not self.shapes or any(
                least_chi_square(shape, tested, sigmas) <= limit
                and not are_beyond_boxes(shape, self.fixture.touch, tested)
                for shape in self.shapes
            )
        except TactfixError:  # a tip that does not fit into a bore
            return False


def least_chi_square(surfaces: Mapping[str, Surface], contacts: Contacts, sigmas: Floats) -> float:
    """A lower bound of chi-square over all poses of the fixture; 0 if these conditions exclude nothing.

    surfaces in any one frame; sigmas (n,) of the residuals. Time and memory grow with the square of the contacts.
    """
    apart = np.linalg.norm(contacts.points[:, None] - contacts.points[None], axis=2)
    variance = sigmas[:, None] ** 2 + sigmas[None] ** 2
    names = np.array(contacts.features)
    touched = {name: surfaces[name] for name in dict.fromkeys(contacts.features)}
    least = 0.0
    for one, other in combinations_with_replacement(touched, 2):
        low, high = _limits(touched, one, other, contacts.tip_radius)
        pairs = np.ix_(names == one, names == other)
        excess: Floats = np.maximum(np.maximum(apart[pairs] - high, low - apart[pairs]), 0.0)
        least = max(least, float((excess**2 / variance[pairs]).max(initial=0.0)))  # step 1
    planes = {name: surface for name, surface in touched.items() if isinstance(surface, Plane)}
    # Steps 2 to 4.
    fitted = {name: _BestPlane(contacts.points[names == name], sigmas[names == name]) for name in planes}
    angles = [_angle_chi_square(planes[a], planes[b], fitted[a], fitted[b]) for a, b in combinations(planes, 2)]
    bends = [_bend_chi_square(name, touched[name], apart, contacts, sigmas) for name in touched]
    return max([least, *angles, *bends, *(plane.chi2 for plane in fitted.values())])  # step 5


def are_beyond_boxes(surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox], contacts: Contacts) -> bool:
    """Whether two contacts are farther apart than 1.5 times what their touch boxes allow; both in the fixture frame.

    The factor of 1.5 keeps noise and a poorly determined pose from deciding here.
    """
    everywhere = TouchBox(np.full(3, -np.inf), np.full(3, np.inf))
    pieces = {name: piece_bounds(surfaces[name], boxes.get(name, everywhere)) for name in set(contacts.features)}
    apart = np.linalg.norm(contacts.points[:, None] - contacts.points[None], axis=2)
    names = np.array(contacts.features)
    for one, other in combinations_with_replacement(pieces, 2):
        a, b = pieces[one], pieces[other]
        if a is None or b is None:
            continue
        farthest = float(np.linalg.norm(np.maximum(a[1], b[1]) - np.minimum(a[0], b[0]))) + 2 * contacts.tip_radius
        if apart[np.ix_(names == one, names == other)].max(initial=0.0) > 1.5 * farthest:
            return True
    return False


def _bend_chi_square(name: str, surface: Surface, apart: Floats, contacts: Contacts, sigmas: Floats) -> float:
    """Step 4: a lower bound from contacts that are farther from any plane than the radius allows; apart (n, n)."""
    index = contacts.by_feature[name]
    if not isinstance(surface, Sphere | Cylinder) or len(index) < 4:
        return 0.0
    points, extent = contacts.points[index], float(apart[np.ix_(index, index)].max())
    thickness = float(np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[2])
    bend = float(np.sqrt(len(index))) / (4 * _tip_distance(name, surface, contacts.tip_radius))
    missing = thickness - bend * extent**2
    if missing <= 0:
        return 0.0
    # Residuals of at most x allow a thickness of bend (extent + 2 x)^2 + x: the feet of the contacts on the surface are
    # at most extent + 2 x apart. Solved for x.
    half = 4 * bend * extent + 1
    least = 2 * missing / (half + np.sqrt(half**2 + 16 * bend * missing))
    return float((least / sigmas[index].max()) ** 2)


def _limits(surfaces: Mapping[str, Surface], one: str, other: str, tip_radius: float) -> tuple[float, float]:
    """The least and the largest distance of the tip's centres at two touches, of two features or of one."""
    a, b = surfaces[one], surfaces[other]
    if one == other:
        return 0.0, 2 * _tip_distance(one, a, tip_radius) if isinstance(a, Sphere | Point) else np.inf
    if not (isinstance(a, Sphere | Point) or isinstance(b, Sphere | Point)):
        return 0.0, np.inf
    distance = distance_between(a, b)
    radii = _tip_distance(one, a, tip_radius) + _tip_distance(other, b, tip_radius)
    # A plane's distance is signed, and the tip's centre is a tip radius above it.
    near = abs(distance - tip_radius) if isinstance(a, Plane) or isinstance(b, Plane) else distance
    both = isinstance(a, Sphere | Point) and isinstance(b, Sphere | Point)
    return max(near - radii, 0.0), distance + radii if both else np.inf


def _tip_distance(name: str, surface: Surface, tip_radius: float) -> float:
    """The distance of the tip's centre from the feature's centre or axis; 0 for a plane or point."""
    if isinstance(surface, Plane | Point):
        return 0.0
    return offset_radius(name, surface.radius, surface.side, tip_radius)


class _BestPlane:
    """The plane that fits points (n, 3) best, all weighted with the largest of their sigmas."""

    def __init__(self, points: Floats, sigmas: Floats) -> None:
        sigma = float(sigmas.max())
        # Three rows at least, so that there are three singular values.
        arms = np.vstack([points - points.mean(axis=0), np.zeros((3, 3))])
        values, axes = np.linalg.svd(arms, full_matrices=False)[1:]
        self.chi2 = float((values[2] / sigma) ** 2)
        self.normal = axes[2]
        # Collinear points leave the normal undetermined.
        self.sigma = sigma / float(values[1]) if values[1] > 0 else np.inf


def _angle_chi_square(one: Plane, other: Plane, first: _BestPlane, second: _BestPlane) -> float:
    """Step 3: a lower bound from the angle between two planes, whichever side of their contacts is outward."""

    def angle(a: Floats, b: Floats) -> float:
        return float(np.arctan2(np.linalg.norm(np.cross(a, b)), abs(a @ b)))

    excess = abs(angle(first.normal, second.normal) - angle(one.normal, other.normal))
    # sin(d) >= 2 d / pi
    return float((2 / np.pi * excess / np.hypot(first.sigma, second.sigma)) ** 2)
