"""Contacts scaled to unit size about their mean, so that tolerances apply in m, mm and um, near and far from the
origin.
"""

import numpy as np

from tactfix.geometry.arrays import EPS, TINY, Floats, Frozen
from tactfix.values import frozen_value

ROUNDING = 4 * EPS
"""Relative rounding of a coordinate after a few operations: each adds at most EPS / 2, and eight are few."""


def effective_sigmas(points: Floats, sigmas: Floats | float | None) -> Floats:
    """One standard deviation (n,) of each contact (n, 3), never below the rounding of its coordinates.

    sigmas: (n,), one number for all, or None for contacts that are exact but for rounding.
    """
    rounding = ROUNDING * float(np.max(np.abs(points)))
    given = np.broadcast_to(0.0 if sigmas is None else np.asarray(sigmas, dtype=float), (len(points),))
    return np.asarray(np.hypot(given, max(rounding, TINY)))


@frozen_value
class UnitContacts:
    """points (n, 3) = (contacts - origin) / scale, of unit rms size about their mean.

    weights (n,): 1 on average, inverse to sigma. sigma: one standard deviation of a weighted residual, in units of
    scale. rounding: of a residual, from that of the coordinates, in units of scale.
    """

    points: Frozen
    weights: Frozen
    sigma: float
    origin: Frozen
    scale: float
    rounding: float


def unit_contacts(points: Floats, sigmas: Floats | float | None) -> UnitContacts:
    """The contacts (n, 3) with sigmas (n,), one number or None, at unit size."""
    deviations = effective_sigmas(points, sigmas)
    origin = points.mean(axis=0)
    centred = points - origin
    scale = float(np.sqrt(np.mean(np.sum(centred**2, axis=1)))) or 1.0
    # The one sigma with which all contacts together would have the same information.
    common = float(1.0 / np.sqrt(np.mean(deviations**-2)))
    rounding = 16 * ROUNDING * float(np.max(np.abs(points))) / scale
    return UnitContacts(centred / scale, common / deviations, common / scale, origin, scale, rounding)
