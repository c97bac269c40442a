"""Angles between two directions as smooth residuals, with their gradients.

a and b are outward normals or axes (unit vectors), s = +1 or -1 is the sense of an unsigned axis, and
phi = atan2(|a x b|, s a.b) is the angle between a and s b:

    turn      phi - value                     smooth except at 0 and 180 deg
    aligned   (phi / sin phi) E (a x s b)     for a value of 0: the rotation vector from s b to a, across a

The rows of E (2, 3) are unit vectors perpendicular to a. Gradients are with respect to the tilts of `geometry.charts`.

1. phi, and the derivatives of a and b by their tilts, give the residual.
2. `turn`: the gradient of phi is that of a.b over -sin phi.
3. `aligned`: phi / sin phi and its derivative are replaced by their limits below SMALL_ANGLE. Beyond 90 deg only the
   length of the rotation vector is differentiated, because its direction is undefined at 180 deg.
"""

import numpy as np

from tactfix.geometry.arrays import Floats, cross
from tactfix.geometry.charts import across, dimension
from tactfix.geometry.nearest import PARALLEL, direction_of
from tactfix.geometry.surfaces import Cylinder, Plane

Linear = tuple[Floats, Floats, Floats]
"""Residuals (k,), and their gradients (k, dimension) with respect to displacements of the first and second surface."""

SMALL_ANGLE = 1e-4
"""Rad below which phi / sin phi and its derivative are those at phi = 0. They differ by less than phi^2 = 1e-8; above,
the formula of the derivative loses no more than eps / phi^2, also 1e-8."""


def turn(one: Plane | Cylinder, other: Plane | Cylinder, value: float, sign: float) -> Linear:
    """The angle between the two directions less its value (rad)."""  # steps 1 and 2
    a, b = direction_of(one), direction_of(other)
    sine = float(np.linalg.norm(cross(a, b)))
    rate = -sign / max(sine, PARALLEL)
    residual = np.array([np.arctan2(sine, sign * (a @ b)) - value])
    return residual, _tilts(one, rate * (across(one) @ b)[None]), _tilts(other, rate * (across(other) @ a)[None])


def aligned(one: Plane | Cylinder, other: Plane | Cylinder, sign: float, basis: Floats) -> Linear:
    """The components along the rows of basis (2, 3) of the rotation vector from the second direction to the first."""
    a, b = direction_of(one), sign * direction_of(other)  # step 1
    normal, cosine = cross(a, b), float(a @ b)
    sine = float(np.linalg.norm(normal))
    angle = float(np.arctan2(sine, cosine))
    tilts_one, tilts_other = across(one), sign * across(other)
    turned, drop = cross(tilts_one, b[None]) @ basis.T, tilts_one @ b
    turned_other, drop_other = cross(a[None], tilts_other) @ basis.T, tilts_other @ a
    if angle > np.pi / 2:  # step 3
        along = basis @ normal / sine if sine > PARALLEL else np.array([1.0, 0.0])
        first, second = (
            np.outer(along, -d / max(sine, PARALLEL)) + (t - np.outer(t @ along, along)).T
            for t, d in ((turned, drop), (turned_other, drop_other))
        )
        return angle * along, _tilts(one, first), _tilts(other, second)
    stretch, slope = _stretch(angle, sine, cosine)
    first, second = (
        stretch * t.T + slope * np.outer(basis @ normal, d) for t, d in ((turned, drop), (turned_other, drop_other))
    )
    return stretch * basis @ normal, _tilts(one, first), _tilts(other, second)


def _stretch(angle: float, sine: float, cosine: float) -> tuple[float, float]:
    """phi / sin phi, and its derivative by cos phi."""
    if angle < SMALL_ANGLE:
        return 1.0, -1 / 3
    return angle / sine, -(sine - angle * cosine) / sine**3


def _tilts(surface: Plane | Cylinder, gradient: Floats) -> Floats:
    """A gradient (k, 2) by the tilts as a gradient (k, dimension) by all displacements."""
    whole = np.zeros((len(gradient), dimension(surface)))
    whole[:, :2] = gradient
    return whole
