"""All cylinders through five contacts each, for whole stacks of problems (eqs. 16-45 and fig. 5).

In the basis of three contacts seen from a fourth, s = sum of sigma_i p_i, the numbers n_i . s of eq. 41 are sigma_i
times the volume, and |p_1 x s|^2 has no sigma_1: eq. 41 becomes a cubic of seven terms. Eq. 43 is |p_4 x s|^2 = sum
of c_i |p_i x s|^2 with p_4 = sum of c_i p_i.

1. The contact left out as the fifth is the one whose absence leaves the tetrahedron of largest volume, and each p_i is
   brought to unit length u_i.
2. The conic of eq. 43 and the cubic of eq. 41 follow; their common zeros are the directions (`conic_cubic`), and each
   gives point and radius of its axis (eq. 38).
3. Cylinders from thin tetrahedra are polished by least squares.
4. Problems for which the fast method is not certainly complete, such as layouts in special position, are solved by the
   null space of the Macaulay matrix and least squares instead.
"""

import numpy as np

from tactfix.geometry.arrays import Bools, Floats, cross_columns, dot_columns
from tactfix.localizers.axis_directions import MOST_DIRECTIONS, direction_zeros
from tactfix.localizers.cylinder_refinement import CylinderProblem, circle_states, distinct_roots, refined_roots
from tactfix.localizers.cylinder_search import real_directions
from tactfix.localizers.unit_contacts import ROUNDING
from tactfix.stacks.conic_cubic import real_common_zeros
from tactfix.stacks.sphere_centers import stack_shape
from tactfix.stacks.trigonometric_zeros import SLOTS
from tactfix.values import frozen_value

_PLAIN_CHUNK, _SPECIAL_CHUNK = 4096, 512
"""Problems that are solved at once, so that memory is bounded: by the fast method, and by the null space, which needs
more for each."""
_LEAST_VOLUME, _THIN_VOLUME = 1e-4, 0.03
"""Volume of the tetrahedron of unit vectors. Rounding grows with its inverse square: 1e-8 at the first value, below
which problems are left to the other method, and 2e-13 at the second, below which cylinders are refined by least
squares."""

_ORDERS = np.array([[4, 1, 2, 0, 3], [0, 4, 2, 1, 3], [0, 1, 4, 2, 3], [0, 1, 2, 3, 4], [0, 1, 2, 4, 3]])
"""Row i: the order of the contacts if contact i is left out of the tetrahedron: it comes fourth, the origin last."""


@frozen_value
class CylinderStack:
    """The cylinders through each of a stack of five contacts, up to six each; nan where not valid.

    Attributes
    ----------
    points : (..., 6, 3) array
        On the axes.
    directions : (..., 6, 3) array
        Unit vectors along the axes, of either sign.
    radii : (..., 6) array
        In the contacts' unit.
    valid : (..., 6) array of bool
        Where there is one.

    Examples
    --------
    >>> bool(tactfix.cylinders_through_five(np.zeros((2, 5, 3))).valid.any())
    False
    """

    points: Floats
    directions: Floats
    radii: Floats
    valid: Bools


def cylinders_through_five(points: Floats, tolerance: float = 0.0) -> CylinderStack:
    """Find all real cylinders through five contacts, up to six, for a stack of problems.

    Parameters
    ----------
    points : (..., 5, 3) array
        Five contacts for each problem.
    tolerance : float
        By so much, in the contacts' unit, a contact may miss a cylinder at which two roots have merged: a double root
        that noise has made complex is returned once.

    Returns
    -------
    CylinderStack
        A layout with no finite number of cylinders has whatever isolated ones were found, or none: nothing is raised,
        so that one bad problem does not stop a stack.

    Raises
    ------
    UsageError
        Points of another shape.

    Notes
    -----
    Solves |(x_i - p) x s| = r, |s| = 1, i = 1..5, for the point p and direction s of the axis and the radius r. Memory
    beyond the answer does not grow with the stack.

    References
    ----------
    .. [1] Eqs. 37-45 and fig. 5 of the paper of the README.

    Examples
    --------
    >>> angle = np.array([0.0, 1.0, 2.5, 4.0, 5.0])
    >>> points = np.column_stack([2 * np.cos(angle), 2 * np.sin(angle), [0.0, 1.0, -1.0, 2.0, 0.5]])
    >>> stack = tactfix.cylinders_through_five(points)
    >>> bool(np.isclose(stack.radii[stack.valid], 2.0).any())
    True
    """
    shape = stack_shape(points, 5)
    flat = np.asarray(points, dtype=np.float64).reshape(-1, 15)
    answers = np.empty((7, SLOTS, len(flat)))
    complete, flatness = np.empty(len(flat), dtype=bool), np.empty(len(flat))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for start in range(0, len(flat), _PLAIN_CHUNK):
            part = slice(start, start + _PLAIN_CHUNK)
            # Steps 1 and 2.
            complete[part], flatness[part] = _solve_chunk(flat[part], answers[:, :, part], tolerance)
    # Step 3.
    thin = np.flatnonzero(complete & (flatness < _THIN_VOLUME))
    answers[:, :, thin] = _polished(flat[thin].reshape(-1, 5, 3), answers[:, :, thin])
    special = np.flatnonzero(~complete)  # step 4
    for start in range(0, len(special), _SPECIAL_CHUNK):
        index = special[start : start + _SPECIAL_CHUNK]
        contacts = flat[index].reshape(-1, 5, 3)
        granted = tolerance + 16 * ROUNDING * np.abs(contacts).max(axis=(1, 2))
        answers[:, :, index] = _by_null_space(contacts, granted).transpose(2, 1, 0)
    answers = answers.transpose(2, 1, 0).reshape(*shape, SLOTS, 7)
    return CylinderStack(answers[..., :3], answers[..., 3:6], answers[..., 6], np.isfinite(answers[..., 6]))


def _solve_chunk(flat: Floats, answers: Floats, tolerance: float) -> tuple[Bools, Floats]:
    """Write answers (7, 6, m) for contacts (m, 15); returns which problems (m,) are complete, and the volumes (m,)."""
    p, origin = _largest_tetrahedron(np.ascontiguousarray(flat.T).reshape(5, 3, -1))
    length = np.sqrt(np.sum(p[:3] ** 2, axis=1))
    u = p[:3] / length[:, None]
    normals = np.stack([cross_columns(u[1], u[2]), cross_columns(u[2], u[0]), cross_columns(u[0], u[1])])
    volume = dot_columns(u[0], normals[0])
    extent = np.sqrt(np.mean(length**2, axis=0))
    size = length / extent
    fourth = np.stack([dot_columns(p[3], n) for n in normals]) / (volume * extent)
    h = [dot_columns(normals[i], normals[j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    conic, cubic = _conic(h, fourth, size), _cubic(h, size)
    found = real_common_zeros(conic, cubic, 1e2 * tolerance / float(extent.min() or 1.0) if tolerance else 0.0)
    _axes(found.zeros, u, normals / volume, h, size, extent, origin, answers)
    return found.complete & (np.abs(volume) > _LEAST_VOLUME), np.abs(volume)


def _largest_tetrahedron(x: Floats) -> tuple[Floats, Floats]:
    """Four vectors (4, 3, m) from an origin (3, m), of contacts (5, 3, m): the first three span the largest volume."""
    p = x[:4] - x[4]
    n12, n34 = cross_columns(p[0], p[1]), cross_columns(p[2], p[3])
    without = np.stack(
        [dot_columns(p[1], n34), -dot_columns(p[0], n34), dot_columns(n12, p[3]), -dot_columns(n12, p[2])]
    )
    volumes = np.abs(np.concatenate([without, np.sum(without, axis=0)[None]]))
    order = _ORDERS[np.argmax(volumes, axis=0)]
    chosen = x[order.T[:, None], np.arange(3)[:, None], np.arange(x.shape[2])]
    return chosen[:4] - chosen[4], chosen[4]


def _cubic(h: list[Floats], size: Floats) -> Floats:
    """Eq. 41 (7, m) in the coordinates of s along the unit vectors u_i; h: products of their normals."""
    h11, h22, h33, h12, h13, h23 = h
    a, b, c = size
    return np.stack([h33 * b, h33 * a, h22 * c, h22 * a, h11 * c, h11 * b, -2 * (a * h23 + b * h13 + c * h12)])


def _conic(h: list[Floats], fourth: Floats, size: Floats) -> Floats:
    """Eq. 43 (6, m) in the same coordinates, |p_4 x s|^2 - sum of c_i l_i |u_i x s|^2, of unit size."""
    h11, h22, h33, h12, h13, h23 = h
    x, y, z = fourth
    wx, wy, wz = fourth * size
    conic = np.stack(
        [
            h22 * (z * z - wz) + h33 * (y * y - wy) - 2 * h23 * y * z,
            h11 * (z * z - wz) + h33 * (x * x - wx) - 2 * h13 * x * z,
            h11 * (y * y - wy) + h22 * (x * x - wx) - 2 * h12 * x * y,
            2 * (h12 * (wz - z * z) - h33 * x * y + h13 * y * z + h23 * x * z),
            2 * (h13 * (wy - y * y) - h22 * x * z + h12 * y * z + h23 * x * y),
            2 * (h23 * (wx - x * x) - h11 * y * z + h12 * x * z + h13 * x * y),
        ]
    )
    return np.asarray(conic / np.sqrt(np.sum(conic**2, axis=0)))


def _axes(
    zeros: Floats, u: Floats, duals: Floats, h: list[Floats], size: Floats, extent: Floats, origin: Floats, out: Floats
) -> None:
    """Write points, directions and radii of the axes with coordinates zeros (3, 6, m) into out (7, 6, m) (eq. 38)."""
    h11, h22, h33, h12, h13, h23 = h
    x, y, z = zeros
    s = u[0][:, None] * x + u[1][:, None] * y + u[2][:, None] * z
    scale = 1.0 / np.sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2])
    s *= scale
    half = 0.5 * extent * scale * scale
    a = half * size[0] * (y * y * h33 + z * z * h22 - 2 * y * z * h23)
    b = half * size[1] * (x * x * h33 + z * z * h11 - 2 * x * z * h13)
    c = half * size[2] * (x * x * h22 + y * y * h11 - 2 * x * y * h12)
    foot = duals[0][:, None] * a + duals[1][:, None] * b + duals[2][:, None] * c
    np.sqrt(foot[0] * foot[0] + foot[1] * foot[1] + foot[2] * foot[2], out=out[6])
    np.add(foot, origin[:, None], out=out[:3])
    out[3:6] = s


def _by_null_space(points: Floats, tolerance: Floats) -> Floats:
    """The cylinders (m, 6, 7: point, direction, radius) within tolerance (m,) of five contacts (m, 5, 3).

    Empty slots are nan. Double roots are given once.
    """
    origin = points.mean(axis=1, keepdims=True)
    scale = np.sqrt(np.mean(np.sum((points - origin) ** 2, axis=2), axis=1))
    scale[scale == 0] = 1.0
    unit_points = (points - origin) / scale[:, None, None]
    directions, owner = real_directions(lambda x, _: direction_zeros(x), unit_points)
    contacts = unit_points[owner]
    states = circle_states(directions, contacts, np.ones(5))
    usable = np.isfinite(states).all(axis=1)
    states, owner, contacts = states[usable], owner[usable], contacts[usable]
    granted = tolerance / scale
    states, index = refined_roots(CylinderProblem(contacts, np.ones(5), radius_known=False), states, granted[owner])
    owner = owner[index]
    problem = CylinderProblem(contacts[index], np.ones(5), radius_known=False)
    misses = np.abs(problem.evaluate(states, np.arange(len(states)))[0]).max(axis=1)
    good = misses <= granted[owner]
    found = np.full((len(points), MOST_DIRECTIONS, 7), np.nan)
    for k in np.unique(owner[good]):
        mine = np.flatnonzero(good & (owner == k))
        own = CylinderProblem(unit_points[k], np.ones(5), radius_known=False)
        kept = states[mine[distinct_roots(own, states[mine], misses[mine], float(granted[k]))[:MOST_DIRECTIONS]]]
        found[k, : len(kept)] = kept
        found[k, : len(kept), :3] = kept[:, :3] * scale[k] + origin[k]
        found[k, : len(kept), 6] *= scale[k]
    return found


def _polished(points: Floats, answers: Floats) -> Floats:
    """The cylinders (7, 6, m: point, direction, radius) through five contacts (m, 5, 3) after two Newton steps."""
    slot, owner = np.nonzero(np.isfinite(answers[6]))
    middle = points.mean(axis=1)[owner]
    scale = np.linalg.norm(points - points.mean(axis=1, keepdims=True), axis=2).max(axis=1)[owner]
    contacts = (points[owner] - middle[:, None]) / scale[:, None, None]
    states = answers[:, slot, owner].T
    foot, direction = (states[:, :3] - middle) / scale[:, None], states[:, 3:6]
    foot -= np.sum(foot * direction, axis=1, keepdims=True) * direction
    problem = CylinderProblem(contacts, np.ones(5), radius_known=False)
    states = problem.polished(np.column_stack([foot, direction, states[:, 6] / scale]), 2)
    better = answers.copy()
    better[:3, slot, owner] = (states[:, :3] * scale[:, None] + middle).T
    better[3:6, slot, owner] = states[:, 3:6].T
    better[6, slot, owner] = states[:, 6] * scale
    return better
