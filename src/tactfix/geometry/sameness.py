"""Whether two surfaces are the same one."""

import numpy as np

from tactfix.geometry.arrays import cross
from tactfix.geometry.nearest import direction_of, foot
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface


def same_surface(one: Surface, other: Surface, length: float, angle: float = 1e-6) -> bool:
    """Whether two surfaces of one type agree to a length and an angle (rad), near the given point of the first."""
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
