"""Distances between two surfaces as smooth residuals, with their gradients.

p and q are the nearest points of the two surfaces (`geometry.nearest`), n is the normal of a plane, a and b are the
directions of axes, and s = +1 or -1 is the side of the first surface on which the second one lies:

    side         s n.(q - p) - value                  a plane and anything
    askew        s (q - p).(a x b) / |a x b| - value     axes that are not parallel
    apart        |q - p| - value                        centres, a centre and an axis, parallel axes
    coincident   q - p, or E (q - p) across an axis        the same pairs at distance zero

The rows of E (2, 3) are unit vectors perpendicular to the axis. Gradients are with respect to the displacements of
`geometry.charts`.

1. The nearest points p and q, and the unit vector along q - p, are computed.
2. The residual is the signed length of q - p less the value, or its components.
3. Its gradient is the relative displacement of the material points p and q along that unit vector: the derivative of
   where p and q lie on the surfaces drops out, because q - p is perpendicular to both (envelope theorem).
"""

import numpy as np

from tactfix.geometry.arrays import TINY, Floats, cross
from tactfix.geometry.charts import across, material_displacement
from tactfix.geometry.nearest import foot, nearest_points
from tactfix.geometry.surfaces import Cylinder, Plane, Surface, reference_point
from tactfix.relations.angles import Linear


def side(one: Surface, other: Surface, value: float, sign: float) -> Linear:
    """The distance along the normal of the first plane of the two, less its value."""  # steps 1 to 3
    if not isinstance(one, Plane):
        residual, second, first = side(other, one, value, sign)
        return residual, first, second
    far = reference_point(other)
    near, along = foot(one, far), sign * one.normal
    residual = np.array([float((far - one.point) @ along) - value])
    return residual, *_feet_apart(one, other, near, far, along)


def askew(one: Cylinder, other: Cylinder, value: float, sign: float) -> Linear:
    """The signed length of the common perpendicular of two axes, less its value."""
    normal = cross(one.direction, other.direction)
    along = sign * normal / max(float(np.linalg.norm(normal)), TINY)
    residual = np.array([float((other.point - one.point) @ along) - value])
    return residual, *_feet_apart(one, other, *nearest_points(one, other), along)


def apart(one: Surface, other: Surface, value: float) -> Linear:
    """The distance of centres and axes, of two axes their spacing, less its value."""
    near, far = nearest_points(one, other, parallel=True)
    gap = far - near
    size = float(np.linalg.norm(gap))
    return np.array([size - value]), *_feet_apart(one, other, near, far, gap / max(size, TINY))


def coincident(one: Surface, other: Surface, basis: Floats) -> Linear:
    """The components of q - p along the rows of basis: all three for two centres, else the two across the axis."""
    near, far = nearest_points(one, other, parallel=True)
    residual = basis @ (far - near)
    if isinstance(one, Cylinder) and isinstance(other, Cylinder):
        return residual, *_between_axes(one, other, basis)
    return residual, -basis @ material_displacement(one, near), basis @ material_displacement(other, far)


def _feet_apart(one: Surface, other: Surface, near: Floats, far: Floats, along: Floats) -> tuple[Floats, Floats]:
    first, second = material_displacement(one, near), material_displacement(other, far)
    return -(along @ first)[None], (along @ second)[None]


def _between_axes(one: Cylinder, other: Cylinder, basis: Floats) -> tuple[Floats, Floats]:
    """The gradients of the gap between the given point of the first axis and its foot on the second axis."""
    gap, b = one.point - other.point, other.direction
    height, flat = float(gap @ b), np.eye(3) - np.outer(b, b)
    tilts, shifts = across(other).T, across(other).T
    turned = height * tilts + np.outer(b, gap @ tilts)
    first = np.hstack([np.zeros((3, 2)), -flat @ across(one).T])
    return basis @ first, basis @ np.hstack([turned, flat @ shifts])
