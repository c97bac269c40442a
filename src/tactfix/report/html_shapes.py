"""Finite pieces of surfaces as grids of points (n, m, 3), for drawing."""

import numpy as np

from tactfix.accessibility.touchable import axial_interval, closed_box, face
from tactfix.fixture import TouchBox
from tactfix.geometry.arrays import Floats, basis_across
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface

_CIRCLE_POINTS = 48
"""Points of a drawn circle."""
_FROM_POLE_TO_POLE = 25
"""Points of a drawn meridian."""
_POINT_SIZE = 0.01
"""Radius of the ball drawn for a point, as a share of the fixture's size: a hundredth is a few pixels on a screen."""


def patch(surface: Surface, box: TouchBox | None, middle: Floats, radius: float, points: Floats) -> Floats | None:
    """The piece of a surface within its touch box, or around the fixture's middle, that reaches all points (k, 3).

    None if the box does not intersect a plane.
    """
    closed = closed_box(surface, box, middle, radius)
    match surface:
        case Point():
            return surface.point + ellipsoid_grid(np.full(3, _POINT_SIZE * radius), np.eye(3))
        case Sphere():
            return surface.center + ellipsoid_grid(np.full(3, surface.radius), np.eye(3))
        case Cylinder():
            return _tube(surface, closed, points)
        case Plane():
            return _face(surface, closed, points)


def ellipsoid_grid(half_axes: Floats, axes: Floats) -> Floats:
    """Points (n, m, 3) of an ellipsoid around zero; half_axes (3,) along the columns of axes (3, 3)."""
    polar = np.linspace(0, np.pi, _FROM_POLE_TO_POLE)[:, None]
    around = np.linspace(0, 2 * np.pi, _CIRCLE_POINTS)[None, :]
    ball = np.stack(
        [np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar) + 0 * around], axis=-1
    )
    return np.asarray((ball * half_axes) @ axes.T)


def _tube(cylinder: Cylinder, closed: TouchBox, points: Floats) -> Floats:
    """The lateral surface of a cylinder, up to its box or the points."""
    ends = [*axial_interval(cylinder, closed), *((points - cylinder.point) @ cylinder.direction)]
    u, v = basis_across(cylinder.direction)
    around = np.linspace(0, 2 * np.pi, _CIRCLE_POINTS)[:, None]
    ring = cylinder.radius * (np.cos(around) * u + np.sin(around) * v)
    axis = cylinder.point + np.array([[min(ends)], [max(ends)]]) * cylinder.direction
    return np.asarray(axis[:, None, :] + ring[None, :, :])


def _face(plane: Plane, closed: TouchBox, points: Floats) -> Floats | None:
    """The polygon of a plane in a box, as a fan from its middle; the box is widened to hold the points."""
    reached = TouchBox(np.min([closed.low, *points], axis=0), np.max([closed.high, *points], axis=0))
    corners = face(plane, reached)
    if not len(corners):
        return None
    rim = np.vstack([corners, corners[:1]])
    return np.stack([np.broadcast_to(corners.mean(axis=0), rim.shape), rim])
