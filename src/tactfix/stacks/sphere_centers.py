"""Both centres of spheres of known radius through three contacts (eqs. 3-10), for whole stacks of problems.

The paper solves for a and b in terms of c and divides by the z component of the triangle's normal. Here the
circumcentre m of the three contacts is written in the triangle's own vectors, and no coordinate axis is preferred.

1. Two edges v1, v2 from the first contact and their cross product give the triangle's normal n and area.
2. The circumcentre m follows from the perpendicular bisectors, in v1 and v2.
3. h^2 = radius^2 - circumradius^2; if that is negative by no more than the tolerance and rounding, h = 0.
4. The centres are m +- h n.
"""

import numpy as np

from tactfix.errors import UsageError
from tactfix.geometry.arrays import EPS, Bools, Floats, cross_columns, dot_columns
from tactfix.values import frozen_value

_CACHED_CHUNK = 8192
"""Problems that are solved at once: about thirty numbers of each, 2 MB together, stay in the processor's cache."""

_RADIUS_ROUNDING = 8 * EPS
"""Relative rounding of the squared radius and circumradius."""


def stack_shape(points: Floats, contacts: int) -> tuple[int, ...]:
    """The leading axes of points (..., contacts, 3). Raises UsageError if the last two axes differ from that."""
    shape = np.shape(points)
    if shape[-2:] != (contacts, 3):
        raise UsageError(f"points have the shape {shape}; give (..., {contacts}, 3)")
    return tuple(shape[:-2])


@frozen_value
class SphereCenters:
    """Both centres of each of a stack of spheres through three contacts.

    Attributes
    ----------
    centers : (..., 2, 3) array
        In the contacts' unit, nan where not valid.
    valid : (...) array of bool
        Both centres are real, or a double root within tolerance.
    double : (...) array of bool
        The radius falls short of the circumradius, but by no more than the tolerance; both centres are then the
        circumcentre.

    Examples
    --------
    >>> bool(tactfix.sphere_centers(np.eye(3), radius=0.1).valid)
    False
    """

    centers: Floats
    valid: Bools
    double: Bools


def sphere_centers(points: Floats, radius: Floats | float, tolerance: Floats | float = 0.0) -> SphereCenters:
    """Find both centres of the spheres of known radius through three contacts, for a stack of problems.

    Parameters
    ----------
    points : (..., 3, 3) array
        Three contacts for each problem.
    radius : float or (...) array
        In the contacts' unit, as tolerance.
    tolerance : float or (...) array
        A circumradius that exceeds the radius by up to this is taken for a great circle that noise has moved.

    Returns
    -------
    SphereCenters
        Not valid for contacts on a line and for contacts too far apart: one bad problem does not stop a stack.

    Raises
    ------
    UsageError
        Points of another shape.

    Notes
    -----
    Solves |x_i - c| = radius, i = 1..3: c = m +- h n with m the circumcentre of the three contacts, n the unit normal
    of their plane and h^2 = radius^2 - circumradius^2. Memory beyond the answer does not grow with the stack.

    References
    ----------
    .. [1] Eqs. 3-10 of the paper of the README, which divide by a component of n; here no coordinate axis is preferred.

    Examples
    --------
    >>> tactfix.sphere_centers(np.eye(3), radius=1.0).centers.round(3) + 0.0
    array([[0.667, 0.667, 0.667],
           [0.   , 0.   , 0.   ]])
    """
    shape = stack_shape(points, 3)
    flat = np.asarray(points, dtype=np.float64).reshape(-1, 9)
    radii = np.broadcast_to(radius, shape).reshape(-1)
    tolerances = np.broadcast_to(tolerance, shape).reshape(-1)
    centers = np.empty((len(flat), 2, 3))
    valid, double = np.empty(len(flat), dtype=bool), np.empty(len(flat), dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore"):
        for start in range(0, len(flat), _CACHED_CHUNK):
            part = slice(start, start + _CACHED_CHUNK)
            valid[part], double[part] = _solve_chunk(flat[part], radii[part], tolerances[part], centers[part])
    return SphereCenters(centers.reshape(*shape, 2, 3), valid.reshape(shape), double.reshape(shape))


def _solve_chunk(flat: Floats, radius: Floats, tolerance: Floats, centers: Floats) -> tuple[Bools, Bools]:
    """Write centers (m, 2, 3) for contacts (m, 9); returns valid (m,) and double (m,)."""
    x = np.ascontiguousarray(flat.T)  # step 1
    v1, v2 = x[3:6] - x[0:3], x[6:9] - x[0:3]
    normal = cross_columns(v1, v2)
    a, b, d = dot_columns(v1, v1), dot_columns(v2, v2), dot_columns(v1, v2)
    area = dot_columns(normal, normal)
    half = 0.5 / area
    # Step 2: circumcentre relative to the first contact: coordinates of the two perpendicular bisectors in v1, v2.
    alpha, beta = b * (a - d) * half, a * (b - d) * half
    m = alpha * v1 + beta * v2
    rho_squared = dot_columns(m, m)
    height_squared = radius * radius - rho_squared  # step 3
    # The rounding of the circumradius of a thin triangle is always part of the tolerance.
    granted = tolerance + _RADIUS_ROUNDING * radius * (1.0 + (a + b) / np.sqrt(area))
    # circumradius - radius <= granted, squared: no square root of the circumradius is needed.
    double = (height_squared < 0) & (height_squared >= -granted * (2 * radius + granted))
    h = np.sqrt(np.where(double, 0.0, height_squared)) / np.sqrt(area)
    m += x[0:3]  # step 4
    for k, component in enumerate(normal):
        lift = h * component
        np.add(m[k], lift, out=centers[:, 0, k])
        np.subtract(m[k], lift, out=centers[:, 1, k])
    return np.isfinite(centers[:, 0, 0]), double
