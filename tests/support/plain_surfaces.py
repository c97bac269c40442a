"""Surfaces at random places, and the distance of a point from them by plain arithmetic."""

import numpy as np

from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tests.support.problems import rotation


def any_surface(kind, rng, side="outer"):
    point, direction = rng.normal(size=3) * 20, rotation(rng)[0]
    if kind == "plane":
        return Plane(point, 3.0 * direction)
    return Sphere(point, 5.0, side) if kind == "sphere" else Cylinder(point, 0.1 * direction, 5.0, side)


KINDS = [("plane", "outer"), ("sphere", "outer"), ("sphere", "inner"), ("cylinder", "outer"), ("cylinder", "inner")]


def depth(surface, point):
    """The distance of a point out of the material, from plain distances."""
    if isinstance(surface, Plane):
        return float((point - surface.point) @ surface.normal)
    if isinstance(surface, Sphere):
        away = np.linalg.norm(point - surface.center)
    else:
        away = np.linalg.norm(np.cross(point - surface.point, surface.direction))
    return float(away - surface.radius if surface.side == "outer" else surface.radius - away)
