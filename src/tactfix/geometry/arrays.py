"""Read-only arrays for frozen values, and the type names that say what is in them."""

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats: TypeAlias = NDArray[np.float64]
"""Any array of doubles; the docstring gives its shape, unit and frame."""
Bools: TypeAlias = NDArray[np.bool_]
Ints: TypeAlias = NDArray[np.intp]

EPS = float(np.finfo(np.float64).eps)
"""The rounding of a number of size one."""
TINY = float(np.finfo(np.float64).tiny)
"""The least that a divisor may be: anything else over it is merely large."""


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


def dot(a: Floats, b: Floats) -> Floats:
    """a . b of vectors (..., 3) as (..., 1), which may multiply vectors; of two single vectors a number."""
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


_AXES = np.eye(3)


def perpendicular(direction: Floats) -> Floats:
    """One unit vector (..., 3) square to the unit vector direction (..., 3); no coordinate axis is preferred for long.

    The axis least aligned with direction is crossed with it, so the result is well conditioned for every direction.
    """
    least = _AXES[np.argmin(np.abs(direction), axis=-1)]
    return unit(cross(direction, least))
