"""The smallest sigma that doubles allow."""

import numpy as np

from tactfix.geometry.arrays import EPS, TINY, Floats

ROUNDING = 4 * EPS
"""Relative rounding of a coordinate that has gone through a few operations."""


def effective_sigmas(points: Floats, sigmas: Floats | float | None) -> Floats:
    """One standard deviation (n,) of each contact (n, 3), never below the rounding of its coordinates.

    sigmas: (n,), one number for all, or None for contacts that are exact but for rounding.
    """
    rounding = ROUNDING * float(np.max(np.abs(points)))
    given = np.broadcast_to(0.0 if sigmas is None else np.asarray(sigmas, dtype=float), (len(points),))
    return np.asarray(np.hypot(given, max(rounding, TINY)))
