"""What noise can explain: the smallest sigma that doubles allow, and the limit that chi-square is held against."""

import math
from functools import lru_cache

import numpy as np

from tactfix.geometry.arrays import Floats

TAIL = 1e-6
"""Share of sound contact sets that the limit refuses: one in a million."""

ROUNDING = 4 * float(np.finfo(np.float64).eps)
"""Relative rounding of a coordinate that has gone through a few operations."""


def effective_sigmas(points: Floats, sigmas: Floats | float | None) -> Floats:
    """One standard deviation (n,) of each contact (n, 3), never below the rounding of its coordinates.

    sigmas: (n,), one number for all, or None for contacts that are exact but for rounding.
    """
    rounding = ROUNDING * float(np.max(np.abs(points)))
    given = (
        np.zeros(len(points)) if sigmas is None else np.broadcast_to(np.asarray(sigmas, dtype=float), (len(points),))
    )
    return np.asarray(np.hypot(given, max(rounding, np.finfo(float).tiny)))


@lru_cache(maxsize=256)
def chi_square_limit(dof: int) -> float:
    """The quantile 1 - 1e-6 of chi-square with max(dof, 1) degrees of freedom.

    A minimal set has none: there a residual only measures how far noise has pushed a double root into the complex
    plane, and one degree of freedom is granted. Bisection on the upper tail, so that scipy need not be imported.
    """
    shape = max(dof, 1) / 2.0
    low, high = shape, shape + 60.0 + 12.0 * math.sqrt(shape)
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _upper_tail(shape, middle) > TAIL else (low, middle)
    return 2.0 * high


def _upper_tail(shape: float, x: float) -> float:
    """The regularized upper incomplete gamma function Q(shape, x) for x > shape, by its continued fraction (Lentz)."""
    b = x + 1.0 - shape
    c, d = math.inf, 1.0 / b
    value = d
    for k in range(1, 10_000):
        a = -k * (k - shape)
        b += 2.0
        d = 1.0 / (b + a * d)
        c = b + a / c
        factor = c * d
        value *= factor
        if abs(factor - 1.0) < 1e-14:
            break
    return value * math.exp(-x + shape * math.log(x) - math.lgamma(shape))
