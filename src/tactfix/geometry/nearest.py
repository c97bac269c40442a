"""Nearest points of planes, axes and centres; distances and angles between features; equality of two surfaces.

If vectors have shape (..., 3), a surface may be a stack of positions, as from `charts.displaced`.
"""

from dataclasses import replace

import numpy as np

from tactfix.geometry.arrays import Floats, cross, dot, unit
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, reference_point

PARALLEL = 1e-9
"""Sine of the angle below which two directions are parallel: a million times the rounding of unit vectors, and far
below any manufactured angle."""

ALMOST_PARALLEL = 0.02
"""Sine of the angle, 1.1 degrees, below which axes are treated as parallel and their distance as the spacing: an
error of one axis moves the feet of their common perpendicular by up to 50 times as much."""


def foot(surface: Surface, point: Floats) -> Floats:
    """The point (..., 3) of a plane, an axis or a centre that is nearest to a point (..., 3)."""
    match surface:
        case Plane():
            return np.asarray(point - dot(point - surface.point, surface.normal) * surface.normal)
        case Sphere() | Point():
            return reference_point(surface)
        case Cylinder():
            return np.asarray(surface.point + dot(point - surface.point, surface.direction) * surface.direction)


def anchored(surface: Surface, near: Floats) -> Surface:
    """The same surface, with the reference point of a plane or axis moved to its point nearest to near (3,)."""
    return surface if isinstance(surface, Sphere | Point) else replace(surface, point=foot(surface, near))


def nearest_points(one: Surface, other: Surface, parallel: bool = False) -> tuple[Floats, Floats]:
    """The point (..., 3) of one that is nearest to other and the reverse: feet of the common perpendicular.

    If it is not unique (parallel axes, planes, an axis and a plane), the pair at the reference point of the first, or
    of the axis. parallel: treat two axes as parallel whatever their directions.
    """
    match one, other:
        case ((Sphere() | Point()), _):
            return reference_point(one), foot(other, reference_point(one))
        case _, (Sphere() | Point()):
            return foot(one, reference_point(other)), reference_point(other)
        case Cylinder(), Cylinder():
            return _between_axes(one, other, parallel)
        case Cylinder(), Plane():
            return one.point, foot(other, one.point)
        case _:
            return foot(one, reference_point(other)), reference_point(other)


def _between_axes(one: Cylinder, other: Cylinder, parallel: bool) -> tuple[Floats, Floats]:
    """Feet of the common perpendicular of two axes; of parallel ones those at the reference point of the first."""
    normal = cross(one.direction, other.direction)
    square = dot(normal, normal)
    if parallel or square.max() < ALMOST_PARALLEL**2:
        return one.point, foot(other, one.point)
    gap = other.point - one.point
    along_one = dot(cross(gap, other.direction), normal) / square
    along_other = dot(cross(gap, one.direction), normal) / square
    return one.point + along_one * one.direction, other.point + along_other * other.direction


def direction_of(surface: Plane | Cylinder) -> Floats:
    """The outward normal of a plane, the (unsigned) direction of an axis."""
    return surface.normal if isinstance(surface, Plane) else surface.direction


def distance_between(one: Surface, other: Surface, parallel: bool = False) -> float:
    """The distance of two features as a fixture file defines it (length): between centres and axes.

    From a plane it is signed, positive along its outward normal; from two planes along that of the first. The file
    gives that sign to spheres only.
    """
    match one, other:
        case Plane(), _:
            return float((reference_point(other) - one.point) @ one.normal)
        case _, Plane():
            return float((reference_point(one) - other.point) @ other.normal)
        case _:
            a, b = nearest_points(one, other, parallel)
            return float(np.linalg.norm(b - a))


def direction_between(one: Surface, other: Surface, angle: float = 1e-6) -> Floats | None:
    """The unit direction (3,) from one to other along which their distance is measured; None if there is none.

    angle (rad): up to it directions are parallel. Two axes at distance zero have their common perpendicular; other
    features at distance zero have no direction.
    """
    match one, other:
        case (Plane() as plane, surface) | (surface, Plane() as plane):
            return plane.normal if _has_distance(plane, surface, angle) else None
        case Cylinder(), Cylinder():
            square = np.cross(one.direction, other.direction)
            if np.linalg.norm(square) > angle:
                return unit(square)
            return _unit_or_none(foot(other, one.point) - one.point)
        case ((Sphere() | Point()), _):
            return _unit_or_none(foot(other, reference_point(one)) - reference_point(one))
        case _, (Sphere() | Point()):
            return _unit_or_none(reference_point(other) - foot(one, reference_point(other)))
        case _:  # pragma: no cover - all pairs of the four types are above
            return None


def _has_distance(plane: Plane, other: Surface, angle: float) -> bool:
    """Whether a surface has a distance from a plane: planes and axes have one only if parallel to it."""
    match other:
        case Plane():
            return bool(np.linalg.norm(np.cross(plane.normal, other.normal)) <= angle)
        case Cylinder():
            return bool(abs(plane.normal @ other.direction) <= angle)
        case _:
            return True


def _unit_or_none(vector: Floats) -> Floats | None:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0 else None


def angle_between(one: Plane | Cylinder, other: Plane | Cylinder) -> float:
    """The angle in rad: 0 to pi between outward normals, 0 to pi/2 if one is an axis, which has no sign."""
    a, b = direction_of(one), direction_of(other)
    cosine = float(a @ b)
    if isinstance(one, Cylinder) or isinstance(other, Cylinder):
        cosine = abs(cosine)
    return float(np.arctan2(np.linalg.norm(cross(a, b)), cosine))


def same_surface(one: Surface, other: Surface, length: float, angle: float = 1e-6) -> bool:
    """Whether two surfaces have one type and agree to a length and an angle (rad) at the first's reference point."""
    match one, other:
        case Sphere(), Sphere():
            return bool(np.linalg.norm(one.center - other.center) <= length)
        case Point(), Point():
            return bool(np.linalg.norm(one.point - other.point) <= length)
        case Plane(), Plane():
            facing = float(one.normal @ other.normal) > 0
        case Cylinder(), Cylinder():
            facing = True
        case _:
            return False
    parallel = np.linalg.norm(cross(direction_of(one), direction_of(other))) <= angle
    return bool(facing and parallel and np.linalg.norm(foot(other, one.point) - one.point) <= length)
