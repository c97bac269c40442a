"""The middle and the size of a set of unbounded surfaces, and the tolerances that follow from them.

A special position (parallel, coaxial, centre on axis, ...) is recognized by a ratio: an angle in rad, or a length over
the fixture's own size. So the result is the same in m, mm and um, and for any distance of the origin.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.geometry.nearest import foot
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, radius_of, reference_point
from tactfix.values import frozen_value

SPECIAL_POSITION = 1e-6
"""Ratio below which a position counts as special: fixture files have six decimals or more."""

_FLATTEST = 1e-2
"""Ratio of eigenvalues below which a direction is not solved for: that of two planes at 0.2 rad, whose common line may
be far away from the features."""


@frozen_value(eq=True)
class Tolerance:
    """The largest angle (rad; compared with sines) and length (fixture units) that count as zero."""

    angle: float
    length: float


def block_of(surface: Surface) -> Floats:
    """The projector (3, 3) on the directions in which a point leaves the plane, axis or centre of the surface."""
    match surface:
        case Plane():
            return np.outer(surface.normal, surface.normal)
        case Sphere() | Point():
            return np.eye(3)
        case Cylinder():
            return np.eye(3) - np.outer(surface.direction, surface.direction)


def middle_of(surfaces: Iterable[Surface], cutoff: float = _FLATTEST) -> Floats:
    """The point (3,) nearest to all planes, axes and centres: min over x of the sum of squared distances.

    Solves (sum of blocks) x = sum of blocks @ points. Along directions whose eigenvalue is below cutoff times the
    largest, it has the coordinates of the mean of the reference points. A symmetry of all surfaces maps this point to
    itself if it is unique.
    """
    listed = list(surfaces)
    points = np.array([reference_point(surface) for surface in listed])
    blocks = np.array([block_of(s) for s in listed])
    origin = points.mean(axis=0)
    right = np.einsum("nij,nj->i", blocks, points - origin)
    return np.asarray(origin + np.linalg.pinv(blocks.sum(axis=0), rcond=cutoff, hermitian=True) @ right)


def size_of(surfaces: Iterable[Surface]) -> float:
    """The largest distance from the middle to a centre, axis or plane, plus its radius (fixture units)."""
    listed = list(surfaces)
    middle = middle_of(listed)
    distances = [np.linalg.norm(foot(s, middle) - middle) for s in listed]
    radii = [radius_of(s) for s in listed]
    return float(max(r + d for r, d in zip(radii, distances, strict=True)))


_SPREAD_LOSS, _FAR_LOSS = 1e-9, 1e-15
"""Rounding of a place: as a share of the spread of the points (least-squares solution, with a margin), and as a share
of their distance from the origin (coordinates)."""


def tolerance_for(surfaces: Mapping[str, Surface], ratio: float = SPECIAL_POSITION) -> Tolerance:
    """The tolerance at which a position of these surfaces counts as special: ratio rad, and ratio of their size.

    Planes that all meet in one point have size 0; then the rounding of their points is the tolerance.
    """
    points = np.array([reference_point(surface) for surface in surfaces.values()])
    rounding = _SPREAD_LOSS * np.ptp(points, axis=0).max() + _FAR_LOSS * np.abs(points).max()
    return Tolerance(angle=ratio, length=max(ratio * size_of(surfaces.values()), float(rounding)))
