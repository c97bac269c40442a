"""The limits between noise and contradiction, in sigma and in probability.

Contacts are independent and normal with their sigma along the surface normal, so the sum of squared residuals over
sigma is chi-square distributed with as many degrees of freedom as there are contacts beyond the minimum.
"""

import math
from functools import lru_cache

REJECTED_IN_ERROR = 1e-6
"""Probability that noise alone eliminates the true surface or pose. It is small because a wrong candidate that remained
would be reported: candidates are kept while they are barely plausible, and ambiguity is reported instead."""

SUSPICIOUS = 1e-3
"""Probability of larger residuals below which residuals are accepted with a warning that sigma may be too small."""

SURE = 5.0
"""A necessary condition (approach, touch box, path) eliminates a candidate only if violated by this many sigma."""


@lru_cache(maxsize=256)
def chi_square_limit(dof: int, probability: float = REJECTED_IN_ERROR) -> float:
    """The chi-square that dof degrees of freedom exceed with this probability; dof below 1 counts as 1.

    With no redundancy the residuals vanish, except next to a double root, where the contacts just miss the surface
    and one residual remains: the one degree of freedom allows for it.
    Bisection on the upper tail: importing scipy.special would cost as much as importing numpy.
    """
    shape = max(dof, 1) / 2
    low, high = shape, shape + 60 + 12 * math.sqrt(shape)
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if _upper_tail(shape, middle) > probability else (low, middle)
    return 2 * high


def normal_limit(count: int, probability: float = REJECTED_IN_ERROR, equations: int = 1) -> float:
    """The size, in sigma, that any of count normal numbers exceeds with at most this probability (Bonferroni).

    equations: numbers of each, where they are vectors and the size is their length.
    """
    return math.sqrt(chi_square_limit(equations, probability / count))


@lru_cache(maxsize=256)
def least_chi_square(dof: int, probability: float = SUSPICIOUS) -> float:
    """The chi-square that dof degrees of freedom fall below with this probability; 0 for none."""
    if dof < 1:
        return 0.0
    low, high = 0.0, float(dof)
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (low, middle) if _lower_tail(dof / 2, middle / 2) > probability else (middle, high)
    return low


def _lower_tail(shape: float, x: float) -> float:
    """The regularized lower incomplete gamma function P(shape, x) for x <= shape, by its series."""
    if x <= 0:
        return 0.0
    term = total = 1 / shape
    for k in range(1, 10_000):
        term *= x / (shape + k)
        total += term
        if term < 1e-16 * total:
            break
    return total * math.exp(-x + shape * math.log(x) - math.lgamma(shape))


def _upper_tail(shape: float, x: float) -> float:
    """The regularized upper incomplete gamma function Q(shape, x) for x >= shape, by its continued fraction (Lentz)."""
    b = x + 1 - shape
    c, d = math.inf, 1 / b
    value = d
    for k in range(1, 10_000):
        a = -k * (k - shape)
        b += 2
        d = 1 / (b + a * d)
        c = b + a / c
        value *= c * d
        if abs(c * d - 1) < 1e-14:
            break
    return value * math.exp(-x + shape * math.log(x) - math.lgamma(shape))
