"""All lines at four given distances from four points: the axes of known radius through four contacts.

1. Linear equations. For a line with unit direction s and m its point nearest to the origin, |c_i x s|^2 - 2 c_i . m +
   |m|^2 = rho_i^2. With the origin at the mean of the centres these four equations are linear in m and |m|^2.

2. Solution by singular values. Let n be the direction in which
the centres spread least, h their spread (singular value) there; then m |s|^2 = m0(s) + n g(s) / h with m0 and g
quadratic in s and m0 perpendicular to n.

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

MOST_TANGENTS = 12
"""Common tangents of four spheres, real or complex (Macdonald, Pach and Theobald 2001)."""
_MACAULAY_DEGREE = 7
"""Degree of the Macaulay matrix whose null space has dimension twelve, also for coplanar centres."""
_CONTRASTS = np.array([[1.0, 1, -1, -1], [1, -1, 1, -1], [1, -1, -1, 1]]) / 2
"""An orthonormal basis of the vectors of four numbers with sum zero."""


def tangent_zeros(centers: Floats, radii: Floats) -> tuple[Complexes, Floats]:
    """The directions (..., 12, 3), real or complex, of lines at distances radii (..., 4) from centers (..., 4, 3).

    Both should be of unit size. Returns also the gap (...) of `common_zeros`.
    """
    centred = centers - centers.mean(axis=-2, keepdims=True)
    constants, spread = _linear_solution(centred, radii)  # steps 1 and 2
    normal, least = spread
    square = quadratic(np.eye(3))
    in_plane, g, power = constants
    a = product(np.eye(3), 1, in_plane, 2).sum(axis=-2)
    e = product(in_plane, 2, in_plane, 2).sum(axis=-2) - product(power, 2, square, 2)
    h = least[..., None]
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


def _linear_solution(centred: Floats, radii: Floats) -> tuple[tuple[Floats, Floats, Floats], tuple[Floats, Floats]]:
    """The quadratic forms m0 (..., 3, 6), g and |m|^2 |s|^2 (..., 6); the normal n (..., 3) and the spread h (...)."""
    squared = np.sum(centred**2, axis=-1) - radii**2
    squares = squared[..., None, None] * np.eye(3) - centred[..., :, None] * centred[..., None, :]
    u, singular, vh = np.linalg.svd(_CONTRASTS @ centred)
    rotated = 0.5 * np.einsum("...ik,...iab->...kab", _CONTRASTS.T @ u, squares)
    g = quadratic(rotated[..., 2, :, :])
    planar = np.einsum("...kab,...kj->...jab", rotated[..., :2, :, :] / singular[..., :2, None, None], vh[..., :2, :])
    power = -quadratic(squares.sum(axis=-3)) / 4.0
    return (quadratic(planar), g, power), (vh[..., 2, :], singular[..., 2])
