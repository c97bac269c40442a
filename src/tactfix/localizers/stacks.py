"""Stacks of problems: contacts as an array with any leading axes."""

import numpy as np

from tactfix.errors import UsageError
from tactfix.geometry.arrays import Floats


def stack_shape(points: Floats, contacts: int) -> tuple[int, ...]:
    """The leading axes of points (..., contacts, 3); UsageError where the last two are others."""
    shape = np.shape(points)
    if shape[-2:] != (contacts, 3):
        raise UsageError(f"points have the shape {shape}; give (..., {contacts}, 3)")
    return tuple(shape[:-2])
