"""Distances and angles between surfaces in one frame, as the relations of a fixture file mean them."""

import math

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface, radial, residuals

# Directions typed with four digits are parallel within this sine.
PARALLEL = 1e-4


def direction_of(surface: Surface) -> Floats:
    """The outward normal or the axis (3,); a sphere has none (TypeError)."""
    match surface:
        case Plane():
            return surface.normal
        case Cylinder():
            return surface.direction
    raise TypeError(surface)


def angle_between(a: Surface, b: Surface) -> float:
    """Angle in rad: 0 to pi between outward normals, 0 to pi/2 where an axis takes part."""
    u, v = direction_of(a), direction_of(b)
    angle = math.atan2(float(np.linalg.norm(np.cross(u, v))), float(u @ v))
    axis = isinstance(a, Cylinder) or isinstance(b, Cylinder)
    return min(angle, math.pi - angle) if axis else angle


def are_parallel(a: Surface, b: Surface) -> bool:
    """Whether planes, axes, or an axis and a plane are parallel within the digits that people type."""
    mixed = isinstance(a, Plane) != isinstance(b, Plane)
    angle = angle_between(a, b)
    return abs(math.cos(angle) if mixed else math.sin(angle)) < PARALLEL


def distance_between(a: Surface, b: Surface) -> float:
    """Distance of centres, axes and planes; sphere and plane: signed, positive on the outward side.

    Of planes, and of a plane and an axis, only where they are parallel; two axes: along their common perpendicular, or
    their spacing where parallel.
    """
    match a, b:
        case (Sphere(), Plane()):
            return float(residuals(b, a.center, 0.0))
        case (Plane(), Sphere() | Cylinder()) | (Sphere(), Cylinder()):
            return distance_between(b, a)
        case (Sphere(), Sphere()):
            return float(np.linalg.norm(a.center - b.center))
        case (Cylinder(), Sphere()):
            return float(np.linalg.norm(radial(a, b.center)))
        case (Cylinder() | Plane(), Plane()):
            return abs(float(residuals(b, a.point, 0.0)))
        case (Cylinder(), Cylinder()):
            return float(np.linalg.norm(common_perpendicular(a, b)))
    raise TypeError((a, b))


def common_perpendicular(a: Cylinder, b: Cylinder) -> Floats:
    """The vector (3,) from the axis of a to the axis of b, square to both."""
    between = b.point - a.point
    if are_parallel(a, b):
        return np.asarray(between - (between @ a.direction) * a.direction)
    square = np.cross(a.direction, b.direction)
    return np.asarray((between @ square) / (square @ square) * square)
