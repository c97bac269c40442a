"""Arrays of vectors: types, read-only copies for frozen values, products, bases, and points far from each other."""

from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats: TypeAlias = NDArray[np.float64]
"""Any array of doubles; the docstring gives its shape, unit and frame."""
Bools: TypeAlias = NDArray[np.bool_]
Ints: TypeAlias = NDArray[np.intp]

EPS = float(np.finfo(np.float64).eps)
"""The spacing of doubles at 1, 2.2e-16: twice the largest relative rounding error."""
TINY = float(np.finfo(np.float64).tiny)
"""The smallest normal double, 2.2e-308: a divisor is at least this, so that no division is by zero."""


def frozen(values: ArrayLike) -> Floats:
    """A read-only copy of values as doubles, for the fields of frozen dataclasses."""
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def lengths(vectors: Floats) -> Floats:
    """The lengths (...) of vectors (..., 3), to the bit what np.linalg.norm gives, in half its time."""
    return np.asarray(np.sqrt(np.add.reduce(vectors * vectors, axis=-1)))


def unit(vectors: ArrayLike) -> Floats:
    """vectors (..., 3) divided by their lengths."""
    array = np.asarray(vectors, dtype=np.float64)
    return np.asarray(array / lengths(array)[..., None])


Frozen: TypeAlias = Annotated[Floats, frozen]
"""An array in a value (`values.frozen_value`), which keeps a read-only copy."""


def _frozen_unit(vectors: ArrayLike) -> Floats:
    """The unit vectors; vectors of length one are kept bit by bit, so that copies and JSON give the same value."""
    given = frozen(vectors)
    squares = np.add.reduce(given * given, axis=-1)
    return given if (np.abs(squares - 1.0) <= 4 * EPS).all() else frozen(unit(given))


UnitVector: TypeAlias = Annotated[Floats, _frozen_unit]
"""A vector (3,) in a value, or a stack of them (..., 3), which keeps them scaled to length one."""


def dot(a: Floats, b: Floats) -> Floats:
    """a . b of vectors (..., 3), with shape (..., 1) to multiply vectors; of two vectors (3,) a number."""
    return np.asarray(a @ b if a.ndim == b.ndim == 1 else np.einsum("...i,...i->...", a, b)[..., None])


def cross(a: Floats, b: Floats) -> Floats:
    """a x b of vectors (..., 3), to the bit what np.cross gives.

    np.cross takes up to ten times as long: most of it to find out along which axes its stacks of vectors lie.
    """
    if a.ndim == b.ndim == 1:
        ax, ay, az = a.tolist()
        bx, by, bz = b.tolist()
        return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
    product = np.empty(np.broadcast_shapes(a.shape, b.shape))
    ax, ay, az, bx, by, bz = a[..., 0], a[..., 1], a[..., 2], b[..., 0], b[..., 1], b[..., 2]
    product[..., 0], product[..., 1], product[..., 2] = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return product


def dot_columns(a: Floats, b: Floats) -> Floats:
    """a . b (...) of vectors whose components are the first axis (3, ...)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def cross_columns(a: Floats, b: Floats) -> Floats:
    """a x b (3, ...) of vectors whose components are the first axis (3, ...)."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


_OTHER_CAP = -0.913
"""z below which `basis_across` starts from -z: the basis is discontinuous on this circle of directions. No direction
along an axis, in a plane of axes in whole degrees, or of small whole numbers lies on it or within noise of it."""


def basis_across(directions: Floats) -> Floats:
    """Two orthonormal vectors (..., 2, 3) that are right-handed with unit vectors directions (..., 3).

    The axes x and y after the least rotation that takes z to the direction; near -z, that takes -z there. Exact for
    directions along the axes, smooth around them, and well conditioned everywhere; written out for speed, because
    every step of every refinement needs it.
    J. R. Frisvad, "Building an orthonormal basis from a 3D unit vector without normalization", Journal of Graphics
    Tools 16 (2012); T. Duff et al., "Building an orthonormal basis, revisited", JCGT 6 (2017).
    """
    if directions.ndim == 1:
        return _one_basis_across(*directions.tolist())
    x, y, z = directions[..., 0], directions[..., 1], directions[..., 2]
    sign = np.where(z > _OTHER_CAP, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    basis = np.empty((*directions.shape[:-1], 2, 3))
    basis[..., 0, 0], basis[..., 0, 1], basis[..., 0, 2] = 1.0 + sign * x * x * a, sign * b, -sign * x
    basis[..., 1, 0], basis[..., 1, 1], basis[..., 1, 2] = b, sign + y * y * a, -y
    return basis


def _one_basis_across(x: float, y: float, z: float) -> Floats:
    """The same of one direction, to the bit, in a tenth of the time."""
    sign = 1.0 if z > _OTHER_CAP else -1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    return np.array([[1.0 + sign * x * x * a, sign * b, -sign * x], [b, sign + y * y * a, -y]])


UNIT_AXES = np.eye(3)
"""The unit vectors along x, y and z, a row each."""


def circle_axes(directions: Floats) -> tuple[Floats, Floats]:
    """Two orthonormal vectors (..., 3), right-handed with unit vectors directions (..., 3), to sample circles.

    A point of the circle around a direction is u cos(angle) + v sin(angle). For sampling only: they are discontinuous
    where two components are equal, but kept, because equal seeds must give equal files. Else `basis_across`.
    """
    u = unit(cross(directions, UNIT_AXES[np.argmin(np.abs(directions), axis=-1)]))
    return u, cross(directions, u)


def farthest_first(points: Floats, count: int) -> list[int]:
    """Indices of at most count of points (n, 3): the farthest from the mean, then each the farthest from those before.

    Distances are compared to nine digits: equal ones are taken in the order of the points, in any unit of length.
    """
    if not len(points):
        return []
    arms = points - points.mean(axis=0)
    scaled = arms / (np.abs(arms).max() or 1.0)
    gaps = (scaled**2).sum(axis=1)
    chosen: list[int] = []
    while len(chosen) < min(count, len(points)):
        chosen.append(int(np.argmax(np.round(gaps, 9))))
        nearer = ((scaled - scaled[chosen[-1]]) ** 2).sum(axis=1)
        gaps = nearer if len(chosen) == 1 else np.minimum(gaps, nearer)
    return chosen
