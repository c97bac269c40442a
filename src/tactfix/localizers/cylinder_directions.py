"""All axis directions of the cylinders through five contacts: eqs. 41 and 43 of the paper, with no preferred axis.

Eq. 33 for each contact is linear in the foot f of the axis and a constant. With the contacts centred on their mean and
X = U S V^T their 5x3 matrix, the one combination w of contacts that cancels all three columns gives the quadric
(eq. 43)  sum w_i |x_i x s|^2 = 0, and f . s = 0 gives the cubic (eq. 41)  s . X^+ [|x_i x s|^2] = 0.
Departures from the paper: all five contacts enter alike instead of three and an origin, so that nothing is divided by
the volume of p1, p2, p3; and the cubic is multiplied by the smallest singular value of X, so that it turns into a
product of a line and a quadric, not into a pole, when the five contacts approach one plane. s is not normalised by
sz = 1: the six zeros are sought in the projective plane by the null space of the Macaulay matrix of degree four.
"""

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.localizers.homogeneous_forms import Complexes, common_zeros, macaulay_rows, product, quadratic

MOST_DIRECTIONS = 6
"""Zeros common to a cubic and a quadric (Bezout)."""


def direction_forms(points: Floats) -> tuple[Floats, Floats]:
    """The quadric (..., 6) of eq. 43 and the cubic (..., 10) of eq. 41 for contacts (..., 5, 3), up to a factor.

    Coefficients over `exponents(3, 2)` and `exponents(3, 3)`. Contacts should be of unit size.
    """
    centred = points - points.mean(axis=-2, keepdims=True)
    # A column of ones keeps the combination free of translation; its singular vector is split off by the centring.
    ones = np.ones((*centred.shape[:-1], 1))
    u, singular, vh = np.linalg.svd(np.concatenate([centred, ones], axis=-1))
    squares = _cross_squares(centred)
    quadric = quadratic(np.einsum("...i,...iab->...ab", u[..., :, 4], squares))
    weights = _pseudo_inverse(u, singular, vh)
    feet = quadratic(np.einsum("...ji,...iab->...jab", weights, squares))
    return quadric, _contracted(feet)


def _cross_squares(points: Floats) -> Floats:
    """The matrices (..., n, 3, 3) of the quadratic forms |x x s|^2 in s."""
    squared = np.sum(points**2, axis=-1)[..., None, None]
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
