"""Contacts that no pose explains, told by a few of them alone, at a thousandth of the cost of a search for poses.

1. Wherever a fixture stands, the tip's centres at two touches are no farther apart than the spheres that they lie on
   allow, and no nearer than the gap between the two features. A pose that leaves the residuals a and b on them would
   have to make up for what is missing, |a| + |b| >= excess, so chi-square is at least
   excess^2 / (sigma_a^2 + sigma_b^2).
2. No pose brings the contacts of a plane nearer to it than the plane through them that fits best.
3. One that is turned by d from that leaves residuals of at least sin(d) s, s^2 the moment of the contacts across their
   longest direction: what the angle of two planes misses must be made up for by turning both, as in step 1 with
   sigma / s in the place of sigma.
4. A sphere or cylinder within s of a point on it lies no deeper than s^2 / 2r below the tangent plane there, so that
   points on it are no farther than s^2 / 4r, root mean square, from the plane that fits them best.
5. The largest of these is what no pose falls below.
"""

from collections.abc import Mapping
from itertools import combinations, combinations_with_replacement

import numpy as np

from tactfix.accessibility.touchable import piece_bounds
from tactfix.contacts import Contacts
from tactfix.fixture import TouchBox
from tactfix.geometry.arrays import Floats
from tactfix.geometry.nearest import distance_between
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, offset_radius


def least_chi_square(surfaces: Mapping[str, Surface], contacts: Contacts, sigmas: Floats) -> float:
    """What no pose of the fixture falls below; 0 where two contacts alone, and those of a plane, contradict nothing.

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
    fitted = {name: _Fitted(contacts.points[names == name], sigmas[names == name]) for name in planes}
    angles = [_angle_chi_square(planes[a], planes[b], fitted[a], fitted[b]) for a, b in combinations(planes, 2)]
    bends = [_bend_chi_square(name, touched[name], apart, contacts, sigmas) for name in touched]
    return max([least, *angles, *bends, *(plane.chi2 for plane in fitted.values())])  # step 5


def are_beyond_boxes(surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox], contacts: Contacts) -> bool:
    """Whether two contacts are clearly farther apart than their touch boxes let them be; both in the fixture frame.

    Clearly: by half, so that neither noise nor a pose that is hardly known decides here.
    """
    everywhere = TouchBox(np.full(3, -np.inf), np.full(3, np.inf))
    pieces = {name: piece_bounds(surfaces[name], boxes.get(name, everywhere)) for name in set(contacts.features)}
    apart = np.linalg.norm(contacts.points[:, None] - contacts.points[None], axis=2)
    names = np.array(contacts.features)
    for one, other in combinations_with_replacement(pieces, 2):
        a, b = pieces[one], pieces[other]
        if a is None or b is None:
            continue
        reach = float(np.linalg.norm(np.maximum(a[1], b[1]) - np.minimum(a[0], b[0]))) + 2 * contacts.tip_radius
        if apart[np.ix_(names == one, names == other)].max(initial=0.0) > 1.5 * reach:
            return True
    return False


def _bend_chi_square(name: str, surface: Surface, apart: Floats, contacts: Contacts, sigmas: Floats) -> float:
    """What contacts on a round feature cost at least that are bent more than its radius allows; apart (n, n)."""
    index = contacts.by_feature[name]
    if not isinstance(surface, Sphere | Cylinder) or len(index) < 4:
        return 0.0
    points, extent = contacts.points[index], float(apart[np.ix_(index, index)].max())
    thickness = float(np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[2])
    bend = float(np.sqrt(len(index))) / (4 * _reach(name, surface, contacts.tip_radius))
    missing = thickness - bend * extent**2
    if missing <= 0:
        return 0.0
    # Residuals of size x make up for x of it themselves, and for more by moving points apart: with the feet of the
    # contacts on the surface, thickness <= bend (extent + 2 x)^2 + x.
    half = 4 * bend * extent + 1
    least = 2 * missing / (half + np.sqrt(half**2 + 16 * bend * missing))
    return float((least / sigmas[index].max()) ** 2)


def _limits(surfaces: Mapping[str, Surface], one: str, other: str, tip_radius: float) -> tuple[float, float]:
    """How near and how far apart the tip's centres can be at touches of two features, or twice of one."""
    a, b = surfaces[one], surfaces[other]
    if one == other:
        return 0.0, 2 * _reach(one, a, tip_radius) if isinstance(a, Sphere | Point) else np.inf
    if not (isinstance(a, Sphere | Point) or isinstance(b, Sphere | Point)):
        return 0.0, np.inf
    distance, reaches = distance_between(a, b), _reach(one, a, tip_radius) + _reach(other, b, tip_radius)
    # A plane's distance is signed, and the tip's centre runs a tip radius above it.
    near = abs(distance - tip_radius) if isinstance(a, Plane) or isinstance(b, Plane) else distance
    both = isinstance(a, Sphere | Point) and isinstance(b, Sphere | Point)
    return max(near - reaches, 0.0), distance + reaches if both else np.inf


def _reach(name: str, surface: Surface, tip_radius: float) -> float:
    """How far from its centre or axis a feature holds the tip's centre; 0 for a plane or point."""
    if isinstance(surface, Plane | Point):
        return 0.0
    return offset_radius(name, surface.radius, surface.side, tip_radius)


class _Fitted:
    """The plane that fits points (n, 3) best, had each the largest sigma of them."""

    def __init__(self, points: Floats, sigmas: Floats) -> None:
        sigma = float(sigmas.max())
        # Three rows at least, so that there are three singular values.
        arms = np.vstack([points - points.mean(axis=0), np.zeros((3, 3))])
        values, axes = np.linalg.svd(arms, full_matrices=False)[1:]
        self.chi2 = float((values[2] / sigma) ** 2)
        self.normal = axes[2]
        # Points in a line hold no normal.
        self.sigma = sigma / float(values[1]) if values[1] > 0 else np.inf


def _angle_chi_square(one: Plane, other: Plane, first: _Fitted, second: _Fitted) -> float:
    """What the angle between two planes costs at least, whichever side of their contacts is outward."""

    def angle(a: Floats, b: Floats) -> float:
        return float(np.arctan2(np.linalg.norm(np.cross(a, b)), abs(a @ b)))

    excess = abs(angle(first.normal, second.normal) - angle(one.normal, other.normal))
    # sin(d) >= 2 d / pi
    return float((2 / np.pi * excess / np.hypot(first.sigma, second.sigma)) ** 2)
