"""Homogeneous polynomials in a few variables, and all common zeros of a system of them.

Common zeros (`common_zeros`):

1. The multiples of all forms by monomials, up to one degree, are the rows of a Macaulay matrix (`macaulay_rows`).
2. Its null space is spanned by the monomials evaluated at the zeros.
3. Multiplication by the ratio of two generic linear forms is a matrix on that space: its eigenvectors give the zeros.

A form of degree d is its coefficient array (..., count) over `exponents(variables, d)`. No variable is set to one: a
zero is a point of the projective plane (or space), so none is at infinity.
"""

from functools import cache
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from tactfix.geometry.arrays import TINY, Floats, Ints

Complexes = NDArray[np.complex128]


@cache
def exponents(variables: int, degree: int) -> Ints:
    """The exponents (count, variables) of all monomials of a degree, in the order of the coefficients."""
    picks = list(combinations_with_replacement(range(variables), degree))
    return np.array([np.bincount(p, minlength=variables) if p else np.zeros(variables, int) for p in picks], dtype=int)


@cache
def _position(variables: int, degree: int) -> dict[tuple[int, ...], int]:
    return {tuple(int(k) for k in e): i for i, e in enumerate(exponents(variables, degree))}


@cache
def _product_index(variables: int, degree_a: int, degree_b: int) -> Ints:
    """The index, among monomials of degree a + b, of the product of monomial i of degree a and j of degree b."""
    position = _position(variables, degree_a + degree_b)
    a, b = exponents(variables, degree_a), exponents(variables, degree_b)
    return np.array([[position[tuple(int(k) for k in ea + eb)] for eb in b] for ea in a], dtype=int)


def product(a: Floats, degree_a: int, b: Floats, degree_b: int, variables: int = 3) -> Floats:
    """The form a * b of degree a + b, for stacks of coefficients (..., count)."""
    outer = a[..., :, None] * b[..., None, :]
    return np.asarray(outer.reshape(*outer.shape[:-2], -1) @ _gather(variables, degree_a, degree_b))


@cache
def _gather(variables: int, degree_a: int, degree_b: int) -> Floats:
    """The matrix of ones and zeros that sums the coefficients of equal products of monomials."""
    index = _product_index(variables, degree_a, degree_b)
    gather = np.zeros((index.size, len(exponents(variables, degree_a + degree_b))))
    gather[np.arange(index.size), index.ravel()] = 1.0
    return gather


def quadratic(matrices: Floats) -> Floats:
    """The form s^T Q s of symmetric matrices Q (..., k, k)."""
    rows, columns, factors = _upper_triangle(matrices.shape[-1])
    return np.asarray(matrices[..., rows, columns] * factors)


@cache
def _upper_triangle(size: int) -> tuple[Ints, Ints, Floats]:
    """Rows and columns of the entries on and above the diagonal, and their multiplicity in the matrix."""
    rows, columns = np.triu_indices(size)
    return rows, columns, np.where(rows == columns, 1.0, 2.0)


def macaulay_rows(form: Floats, degree: int, total: int, variables: int = 3) -> Floats:
    """All multiples of a form (..., count) by monomials, up to degree total: (..., rows, monomials of that degree).

    The form is scaled to unit length, so that rows of different forms have equal weight.
    """
    index = _product_index(variables, total - degree, degree)
    scale = np.maximum(np.linalg.norm(form, axis=-1, keepdims=True), TINY)
    rows = np.zeros((*form.shape[:-1], len(index), len(exponents(variables, total))))
    np.put_along_axis(
        rows, np.broadcast_to(index, (*form.shape[:-1], *index.shape)), (form / scale)[..., None, :], axis=-1
    )
    return rows


def common_zeros(rows: Floats, degree: int, count: int, variables: int = 3) -> tuple[Complexes, Floats]:
    """The common zeros of the forms whose multiples of one degree are the rows (..., m, monomials).

    Condition: the null space at this degree and at the degree below has count dimensions, with multiplicity.

    Returns the zeros (..., count, variables), unit vectors with the phase of the largest real part, and the gap (...):
    the smallest nonzero singular value over the largest. A small gap means more zeros than count, for example a whole
    curve of them.
    """
    _, singular, vh = np.linalg.svd(rows)  # step 2, after step 1 by the caller
    null = np.swapaxes(vh[..., -count:, :], -1, -2)
    rank = rows.shape[-1] - count
    index = _product_index(variables, 1, degree - 1)
    shifted = null[..., index, :]
    bottom, top = np.einsum("aj,...jmk->a...mk", _generic_forms(variables), shifted)
    multiplication = np.linalg.pinv(bottom) @ top  # step 3
    _, vectors = np.linalg.eig(multiplication)
    largest = np.maximum(singular[..., 0], TINY)
    return _points(np.asarray(null @ vectors), index), np.asarray(singular[..., rank - 1] / largest)


_DRAWN = (
    *(-0.35966845567139044, 1.2036751014877107, 1.3968681196180939, 0.31723592758455404),
    *(0.41413419203577684, -0.4895498035052234, -0.9141207048308895, -0.9003606290309881),
)
"""Normal random numbers for forms in up to four variables, constant because importing numpy.random takes longer than
finding the zeros."""


@cache
def _generic_forms(variables: int) -> Floats:
    """Two orthonormal linear forms in general position."""
    q, _ = np.linalg.qr(np.reshape(_DRAWN[: 2 * variables], (variables, 2)))
    return np.asarray(q.T)


def _points(powers: Complexes, index: Ints) -> Complexes:
    """The points (..., count, variables) whose monomials are the columns of powers (..., monomials, count)."""
    slices = np.moveaxis(powers[..., index, :], -1, 0)
    size = np.linalg.norm(slices, axis=-2)
    best = np.argmax(size, axis=-1)
    points = np.take_along_axis(slices, best[..., None, None], axis=-1)[..., 0]
    points = points / np.linalg.norm(points, axis=-1, keepdims=True)
    # |Re|^2 - |Im|^2 is largest where the sum of squares is real and positive.
    phase = np.exp(-0.5j * np.angle(np.sum(points**2, axis=-1, keepdims=True)))
    return np.moveaxis(points * phase, 0, -2)
