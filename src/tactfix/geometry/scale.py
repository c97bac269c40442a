"""The middle and the size of a set of unbounded surfaces, and the tolerances that follow from them.

A special position (parallel, coaxial, centre on axis, ...) is recognized by a ratio: an angle in rad, or a length over
the fixture's own size. So the result is the same in m, mm and um, and for any distance of the origin.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, radius_of
from tactfix.values import frozen_value

SPECIAL_POSITION = 1e-6
"""Ratio below which a position counts as special: fixture files have six decimals or more."""

_FLATTEST = 1e-2
"""Ratio of eigenvalues below which a direction does not move the middle: that of two planes at 0.2 rad. Their common
line may be far away from the features.
"""


@frozen_value(eq=True)
class Tolerance:
    """What counts as zero: angles in rad (sines, to be exact), lengths in fixture units."""

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


def anchor_of(surface: Surface, near: Floats) -> Floats:
    """The point (3,) of the plane, the axis or the centre that is nearest to near (3,)."""
    point = surface.center if isinstance(surface, Sphere) else surface.point
    return np.asarray(near - block_of(surface) @ (near - point))


def anchored(surface: Surface, near: Floats) -> Surface:
    """The same surface, with the point of a plane or axis moved to where it is nearest to near (3,)."""
    return surface if isinstance(surface, Sphere | Point) else replace(surface, point=anchor_of(surface, near))


def middle_of(surfaces: Iterable[Surface], cutoff: float = _FLATTEST) -> Floats:
    """The point (3,) nearest to all planes, axes and centres: min over x of the sum of squared distances.

    Solves (sum of blocks) x = sum of blocks @ points. Directions whose eigenvalue is below cutoff times the largest are
    left where the mean of the surfaces' points is. A motion that lays all surfaces on themselves maps this point to
    itself whenever it is unique.
    """
    listed = list(surfaces)
    points = np.array([s.center if isinstance(s, Sphere) else s.point for s in listed])
    blocks = np.array([block_of(s) for s in listed])
    origin = points.mean(axis=0)
    right = np.einsum("nij,nj->i", blocks, points - origin)
    return np.asarray(origin + np.linalg.pinv(blocks.sum(axis=0), rcond=cutoff, hermitian=True) @ right)


def size_of(surfaces: Iterable[Surface]) -> float:
    """The largest distance from the middle to a surface, radius included (fixture units); 0 if there is none."""
    listed = list(surfaces)
    middle = middle_of(listed)
    distances = [np.linalg.norm(anchor_of(s, middle) - middle) for s in listed]
    radii = [radius_of(s) for s in listed]
    return float(max(r + d for r, d in zip(radii, distances, strict=True)))


_SPREAD_LOSS, _FAR_LOSS = 1e-9, 1e-15
"""Rounding of a place, as shares of the spread of the points (of a least-squares solution, with some to spare) and
of their distance from the origin (of a coordinate)."""


def tolerance_for(surfaces: Mapping[str, Surface], ratio: float = SPECIAL_POSITION) -> Tolerance:
    """The tolerance at which a position of these surfaces counts as special: ratio rad, and ratio of their size.

    Planes that all meet in one point have no size; there the rounding of their points decides.
    """
    points = np.array([s.center if isinstance(s, Sphere) else s.point for s in surfaces.values()])
    rounding = _SPREAD_LOSS * np.ptp(points, axis=0).max() + _FAR_LOSS * np.abs(points).max()
    return Tolerance(angle=ratio, length=max(ratio * size_of(surfaces.values()), float(rounding)))
