"""The factor on the prior's sigmas, from 0 to 1, chosen by cross-validation over places.

The residuals of the touches of a fit do not show whether the robot is better than the nominal one: surfaces are not
flat, contacts deform, and the parameters absorb that. Residuals at another place do.

1. The largest factor is that at which the prior alone explains the nominal robot's residuals (`room`).
2. With each place left out in turn, the robot is fitted with each factor, from large to small.
3. The place left out is located with that robot; its mean squared residual over sigma is the score.
4. The factor with the smallest mean score is taken, or 0 if it is hardly better than the nominal robot.

If the residuals of the best fit exceed sigma, they replace it as the noise that is weighed against the prior.
"""

from typing import Final

import numpy as np

from tactfix.calibration.cell import Cell, Touches
from tactfix.calibration.equations import Group, groups_of, residuals
from tactfix.calibration.estimation import State, estimated, located, reduced
from tactfix.calibration.result import FactorScore
from tactfix.calibration.robust_start import tips
from tactfix.geometry.arrays import Bools, Floats
from tactfix.values import frozen_value

FACTORS: Final = (
    1.0,
    0.7,
    0.5,
    0.3,
    0.2,
    0.14,
    0.1,
    0.07,
    0.05,
    0.03,
    0.02,
    0.014,
    0.01,
    0.007,
    0.005,
    0.003,
    0.002,
    0.0,
)
"""Factors tried, each about 0.7 of the one before."""
_WORTH_SHRINKING: Final = 0.002
"""Least reduction of the score (mean squared residual) by the best factor, as a share of the nominal robot's. On
samples/robot-calibration 0.001 and 0.004 choose the same factor."""


@frozen_value
class Choice:
    """The factor, the rms residuals (lengths) at each place left out, before and after, and the scores by factor."""

    factor: float
    left_out: dict[str, tuple[float, float]]
    scores: tuple[FactorScore, ...]


def chosen_factor(
    cell: Cell, touches: Touches, start: State, prior: Floats, free: Bools, noise: float, most: float
) -> Choice:
    """The factor for touches at two places or more, none above most.

    start: the estimate with the full prior. prior (m,): its sigmas. noise: ratio of the residuals to sigma.
    """
    factors = [factor for factor in FACTORS if factor <= most] or [0.0]  # step 1
    names = touches.touched
    scores = np.empty((len(names), len(factors)))
    rms = np.empty_like(scores)
    for row, name in enumerate(names):
        train = groups_of(cell, touches.at([other for other in names if other != name]))
        (test,) = groups_of(cell, touches.at([name]))
        state = start
        for column, factor in enumerate(factors):
            state = shrunk(cell, train, state, prior, free, noise, factor)  # step 2
            scores[row, column], rms[row, column] = left_out(cell, test, start, state.values)  # step 3
    best = _best(scores)  # step 4
    by_place = {name: (float(rms[row, -1]), float(rms[row, best])) for row, name in enumerate(names)}
    overall = np.sqrt((rms**2).mean(axis=0)).tolist()
    return Choice(factors[best], by_place, tuple(map(FactorScore, factors, overall)))


def shrunk(
    cell: Cell, groups: tuple[Group, ...], near: State, prior: Floats, free: Bools, noise: float, factor: float
) -> State:
    """The estimate with factor times the prior, except for the tip's. Factor 0: the nominal robot."""
    own = tips(cell, free)
    width = believed(cell, prior, free, factor)
    weights = np.divide(noise, width, out=np.zeros_like(width), where=width > 0)
    if factor == 0:
        values = np.where(own, near.values, 0.0)
        return estimated(cell, groups, State(values, near.poses), weights, own)
    return estimated(cell, groups, near, weights, free, steps=6)


def believed(cell: Cell, prior: Floats, free: Bools, factor: float) -> Floats:
    """The sigmas (m,) of the prior times the factor; the tip's are unchanged."""
    return np.where(tips(cell, free), prior, prior * factor)


def left_out(cell: Cell, test: Group, near: State, values: Floats) -> tuple[float, float]:
    """Mean squared residual over sigma, and rms residual (length), of a group located with the robot at values."""
    pose, _ = located(cell, test, near.poses[test.root], values, 12)
    rows = residuals(cell, test, pose, values)
    count = len(test.touches)
    used = rows[: len(rows) - test.measured]
    sigma = float(np.sqrt((test.sigmas**2).mean()))
    return float(used @ used / count), float(sigma * np.sqrt(used @ used / count))


def _best(scores: Floats) -> int:
    """The column of the factor to take, scores (places, factors), factors from large to small, the last one 0."""
    mean = scores.mean(axis=0)
    best = int(np.argmin(mean))
    return best if mean[-1] - mean[best] > _WORTH_SHRINKING * mean[-1] else len(mean) - 1


def room(cell: Cell, groups: tuple[Group, ...], start: State, prior: Floats, free: Bools) -> float:
    """The factor at which the prior alone explains all of the nominal robot's residuals.

    start: the nominal robot, tip and places fitted. An upper limit, since the residuals contain noise and count as at
    least one sigma each. Above 1 if the robot's errors exceed its prior, or noise is large.
    """
    parts = reduced(cell, groups, start)
    own = tips(cell, free)
    robot = np.concatenate([part.robot for part in parts])
    rows = np.concatenate([part.rows for part in parts])
    basis, values, _ = np.linalg.svd(robot[:, own] * prior[own], full_matrices=False)
    basis = basis[:, values > 1.0]
    rest = robot[:, free & ~own] * prior[free & ~own]
    rest, rows = rest - basis @ (basis.T @ rest), rows - basis @ (basis.T @ rows)
    predicted = float((rest**2).sum())
    return 1.0 if predicted == 0 else float(np.sqrt(max(rows @ rows, len(rows)) / predicted))
