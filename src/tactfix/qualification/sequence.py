"""Tests of a sequence of readings for outliers, a drift and a step.

Readings (n, k) are deviations from the means of their places, along k directions. Each test has an error probability of
one in a thousand for readings that only scatter.

1. Outliers: the farthest reading is removed, one after the other, each studentized by the scatter of those left about
   their own mean and by its own redundancy (generalized extreme studentized deviate; B. Rosner, Technometrics 25,
   1983).
2. A drift: the least-squares slope over the sequence, against its standard deviation (F test).
3. A step: the change of the mean that lowers the sum of squares most, by Student's t; the probability is multiplied by
   the number of places where it could be (Bonferroni).
"""

from collections.abc import Callable, Sequence

import numpy as np

from tactfix.geometry.arrays import Floats, Ints
from tactfix.qualification.result import Drift, Step

AboutRest = Callable[[Ints], tuple[Floats, Floats]]
"""Indices (m,) of touches -> their readings (m, k) about their own means or ball, and the share (m,) of a touch's
variance that is left in its reading (redundancy)."""
SEQUENCE_ERROR = 1e-3
"""Probability of an outlier, a drift or a step in readings that only scatter, as SUSPICIOUS."""
LEAST_SHARE = 1e-6
"""Redundancy below which a reading is independent of its touch: a touch alone at its place has 0."""
MOST_OUTLIERS = 10
"""Most outliers that are removed one after the other."""
LEAST_SIDE = 3
"""Fewest touches on either side of a step. Of 2,000 simulated sequences of 40 readings that only scatter, 0.10 to 0.15
per cent show a step with 1, 2, 3 or 6 here. If the second reading alone is off by six sigma, 8, 8, 0.8 and 0.2 per
cent show one; of steps of three sigma after the third reading 61, 66, 61 and 5 per cent are found (500 sequences
each)."""


def interval(sigma: float, dof: int) -> tuple[float, float]:
    """The 95 per cent interval of the true sigma: sigma^2 dof over the quantiles of chi-square."""
    from scipy.special import chdtri

    return tuple(float(sigma * np.sqrt(dof / chdtri(dof, tail))) for tail in (0.025, 0.975))  # type: ignore[return-value]


def outliers(about_rest: AboutRest, touches: int, dof: int) -> list[int]:
    """The indices of outliers by the generalized extreme studentized deviate (step 1).

    All readings removed up to the last one beyond its limit are outliers: two of them do not mask each other.
    """
    from scipy.special import stdtrit

    left = np.arange(touches)
    taken: list[int] = []
    last = 0
    for number in range(min(MOST_OUTLIERS, touches // 4)):
        readings, shares = about_rest(left)
        directions = readings.shape[1]
        rest = dof - number * directions
        if rest < max(3, directions + 1):
            break
        scale = float(np.sqrt((readings**2).sum() / rest))
        size = np.sqrt((readings**2).sum(axis=1) / np.maximum(shares, LEAST_SHARE))
        worst = int(np.argmax(size))
        quantile = float(stdtrit(rest - 1, 1 - SEQUENCE_ERROR / (2 * len(left) * directions)))
        limit = quantile * np.sqrt(rest / (rest - 1 + quantile**2))
        taken.append(int(left[worst]))
        left = np.delete(left, worst)
        if scale > 0 and size[worst] > limit * scale * np.sqrt(directions):
            last = number + 1
    return sorted(taken[:last])


def drift(readings: Floats, places: Sequence[Ints], dof: int) -> Drift | None:
    """The least-squares slope of the readings over the sequence (step 2), the same at all places; None for too few.

    places: indices of the readings of each place. For several directions the norm of the slopes.
    """
    order = np.arange(len(readings), dtype=np.float64)
    for place in places:
        order[place] -= order[place].mean()
    weight = float(order @ order)
    if dof < 2 * readings.shape[1] or weight == 0:
        return None
    slopes = order @ readings / weight
    left = readings - order[:, None] * slopes
    sigma = float(np.sqrt((left**2).sum() / (dof - readings.shape[1]) / weight))
    size = float(np.linalg.norm(slopes)) if readings.shape[1] > 1 else float(slopes[0])
    return Drift(size, sigma)


def is_significant(found: Drift, dof: int, directions: int) -> bool:
    """Whether the probability of such a drift in readings that only scatter is below SEQUENCE_ERROR (F test)."""
    from scipy.special import fdtrc

    if found.sigma == 0:
        return found.per_touch != 0
    return bool(fdtrc(directions, dof - directions, (found.per_touch / found.sigma) ** 2 / directions) < SEQUENCE_ERROR)


def step(readings: Floats, rows: Sequence[int], dof: int) -> Step | None:
    """The largest step along the first direction (step 3); None if scatter explains it."""
    from scipy.special import stdtr

    values = readings[:, 0]
    count = len(values)
    if count < 2 * LEAST_SIDE or dof < 3:
        return None
    before = np.arange(LEAST_SIDE, count - LEAST_SIDE + 1)
    total = np.cumsum(values)
    change = (total[-1] - total[before - 1]) / (count - before) - total[before - 1] / before
    gain = change**2 * before * (count - before) / count
    at = int(np.argmax(gain))
    rest = float((values @ values) - gain[at])
    if rest <= 0:
        return None
    t = float(np.sqrt(gain[at] * (dof - 1) / rest))
    p_value = 2 * float(stdtr(dof - 1, -t)) * len(before)
    return Step(rows[int(before[at])], float(change[at])) if p_value < SEQUENCE_ERROR else None
