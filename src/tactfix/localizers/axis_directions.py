"""All axis directions of the cylinders through a minimal set of contacts: five, or four of known radius.

Five contacts (`direction_zeros`), eqs. 41 and 43 of the paper. Eq. 33 for each contact is linear in the foot f of the
axis and a constant. With the contacts centred on their mean and X = U S V^T their 5x3 matrix, the one combination w of
contacts that cancels all three columns gives the quadric (eq. 43)  sum w_i |x_i x s|^2 = 0, and f . s = 0 gives the
cubic (eq. 41)  s . X^+ [|x_i x s|^2] = 0. Departures from the paper: all five contacts enter alike instead of three and
an origin, so that nothing is divided by the volume of p1, p2, p3; and the cubic is multiplied by the smallest singular
value of X, so that it becomes a product of a line and a quadric, not a pole, as the five contacts approach one plane.
s is not normalised by sz = 1: the six zeros are points of the projective plane, from the null space of the Macaulay
matrix of degree four (`homogeneous_forms`).

Four contacts (`tangent_zeros`): the lines at distances rho_i from points c_i.

1. Linear equations. For a line with unit direction s and m its point nearest to the origin, |c_i x s|^2 - 2 c_i . m +
   |m|^2 = rho_i^2. With the origin at the mean of the centres these four equations are linear in m and |m|^2.
2. Solution by singular values. Let n be the direction in which the centres spread least, h their singular value there.
   Then m |s|^2 = m0(s) + n g(s) / h with m0 and g quadratic in s and m0 perpendicular to n.
3. Forms in s. The remaining conditions are m . s = 0 and that m has the length |m|:

    h a + l g = 0  (cubic)      a = s . m0,  l = n . s
    g^2 + h^2 e = 0  (quartic)  e = |m0|^2 - |m|^2 |s|^4

   They have 3 x 4 = 12 common zeros (Macdonald, Pach and Theobald 2001, for equal radii). For coplanar centres (h = 0)
   both become g = 0. The two combinations  g a - h l e = 0  and  a^2 + l^2 e = 0, which hold as well, keep all twelve
   zeros apart for every h, zero included.
4. Common zeros. They follow from the null space of the Macaulay matrix of all four forms at degree seven, which has the
   right dimension for coplanar centres too (a quadric and a sextic).
"""

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.localizers.homogeneous_forms import Complexes, common_zeros, macaulay_rows, product, quadratic

MOST_DIRECTIONS = 6
"""Zeros common to a cubic and a quadric (Bezout)."""
MOST_TANGENTS = 12
"""Common tangents of four spheres, real or complex (Macdonald, Pach and Theobald 2001)."""
_MACAULAY_DEGREE = 7
"""Degree of the Macaulay matrix whose null space has dimension twelve, also for coplanar centres."""
_CONTRASTS = np.array([[1.0, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]]) / 2
"""An orthonormal basis of the vectors of four numbers with sum zero."""


def direction_forms(points: Floats) -> tuple[Floats, Floats]:
    """The quadric (..., 6) of eq. 43 and the cubic (..., 10) of eq. 41 for contacts (..., 5, 3), up to a factor.

    Coefficients over `exponents(3, 2)` and `exponents(3, 3)`. Contacts should be of unit size.
    """
    centred = points - points.mean(axis=-2, keepdims=True)
    # With a column of ones the combination does not depend on the origin; centring separates its singular vector.
    ones = np.ones((*centred.shape[:-1], 1))
    u, singular, vh = np.linalg.svd(np.concatenate([centred, ones], axis=-1))
    squares = _cross_squares(centred, 0.0)
    quadric = quadratic(np.einsum("...i,...iab->...ab", u[..., :, 4], squares))
    weights = _pseudo_inverse(u, singular, vh)
    feet = quadratic(np.einsum("...ji,...iab->...jab", weights, squares))
    return quadric, _contracted(feet)


def _cross_squares(points: Floats, radii: Floats | float) -> Floats:
    """The matrices (..., n, 3, 3) of the quadratic forms |x x s|^2 - radius^2 |s|^2 in s."""
    squared = (np.sum(points**2, axis=-1) - radii**2)[..., None, None]
    return np.asarray(squared * np.eye(3) - points[..., :, None] * points[..., None, :])


def _pseudo_inverse(u: Floats, singular: Floats, vh: Floats) -> Floats:
    """The first three rows (..., 3, 5) of the pseudo-inverse, times the smallest singular value."""
    smallest = singular[..., -1:]
    ratio = np.divide(smallest, singular, out=np.ones_like(singular), where=singular > 0)
    return np.asarray(np.swapaxes(vh, -1, -2)[..., :3, :] * ratio[..., None, :] @ np.swapaxes(u[..., :, :4], -1, -2))


def _contracted(feet: Floats) -> Floats:
    """The cubic sum_j s_j F_j(s) (..., 10) of three quadratic forms (..., 3, 6)."""
    return np.asarray(product(np.eye(3), 1, feet, 2).sum(axis=-2))


def direction_zeros(points: Floats) -> tuple[Complexes, Floats]:
    """The six common zeros (..., 6, 3) of both forms, real or complex, and the gap (...) of `common_zeros`."""
    quadric, cubic = direction_forms(points)
    rows = np.concatenate([macaulay_rows(quadric, 2, 4), macaulay_rows(cubic, 3, 4)], axis=-2)
    return common_zeros(rows, 4, MOST_DIRECTIONS)


def tangent_zeros(centers: Floats, radii: Floats) -> tuple[Complexes, Floats]:
    """The directions (..., 12, 3), real or complex, of lines at distances radii (..., 4) from centers (..., 4, 3).

    Both should be of unit size. Returns also the gap (...) of `common_zeros`.
    """
    centred = centers - centers.mean(axis=-2, keepdims=True)
    m0, g, power, normal, h = _linear_solution(centred, radii)  # steps 1 and 2
    a = _contracted(m0)
    e = product(m0, 2, m0, 2).sum(axis=-2) - product(power, 2, quadratic(np.eye(3)), 2)
    forms = (  # step 3
        (h * a + product(normal, 1, g, 2), 3),
        (product(g, 2, g, 2) + h**2 * e, 4),
        (product(g, 2, a, 3) - h * product(normal, 1, e, 4), 5),
        (product(a, 3, a, 3) + product(product(normal, 1, normal, 1), 2, e, 4), 6),
    )
    rows = np.concatenate(
        [macaulay_rows(np.asarray(form), degree, _MACAULAY_DEGREE) for form, degree in forms], axis=-2
    )
    return common_zeros(rows, _MACAULAY_DEGREE, MOST_TANGENTS)  # step 4


def _linear_solution(centred: Floats, radii: Floats) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """The quadratic forms m0 (..., 3, 6), g and |m|^2 |s|^2 (..., 6), the normal n (..., 3) and h (..., 1)."""
    squares = _cross_squares(centred, radii)
    u, singular, vh = np.linalg.svd(_CONTRASTS @ centred)
    rotated = 0.5 * np.einsum("...ik,...iab->...kab", _CONTRASTS.T @ u, squares)
    g = quadratic(rotated[..., 2, :, :])
    planar = np.einsum("...kab,...kj->...jab", rotated[..., :2, :, :] / singular[..., :2, None, None], vh[..., :2, :])
    power = -quadratic(squares.sum(axis=-3)) / 4.0
    return quadratic(planar), g, power, vh[..., 2, :], singular[..., 2, None]
