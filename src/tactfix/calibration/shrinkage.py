"""The factor on the prior's sigmas, from 0 to 1, chosen by leaving out one place after the other.

The residuals of the touches to which a robot was fitted do not show whether it is better than the nominal one: surfaces
are not flat, contacts press, and the parameters absorb that. Residuals at another place do.

1. No factor is tried that the nominal robot's residuals leave no room for (`room`).
2. Without one place after the other, the robot is fitted with each factor, from large to small.
3. The place left out is located with the robot as fitted; its mean squared residual over sigma is the score.
4. The factor with the smallest mean score is taken, 0 where it is hardly better than the nominal robot.

Two limits keep a few places from having too much influence:
- sigma: where the residuals of the best fit are larger than sigma says, they and not sigma are weighed against the
prior;
- the factor is no larger than the nominal robot's residuals leave room for: a prior that alone would make them larger
  than they are is too wide, whatever the residuals at the places left out are.
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
"""Share of the nominal robot's score (mean squared residual), by which the best factor's must be smaller: less is
not worth a change of the robot. On samples/robot-calibration 0.001 and 0.004 choose the same factor."""


@frozen_value
class Choice:
    """The factor, the rms residual at each place left out, before and after (lengths), and the scores by factor."""

    factor: float
    left_out: dict[str, tuple[float, float]]
    scores: tuple[FactorScore, ...]


def chosen_factor(
    cell: Cell, touches: Touches, start: State, prior: Floats, free: Bools, noise: float, most: float
) -> Choice:
    """The factor for touches at two places or more, none above most.

    start: the estimate with the full prior. prior (m,): its sigmas. noise: how many times sigma the residuals are.
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
    """The estimate with factor times the prior; the tip keeps its own in full. Factor 0: the nominal robot."""
    own = tips(cell, free)
    width = believed(cell, prior, free, factor)
    weights = np.divide(noise, width, out=np.zeros_like(width), where=width > 0)
    if factor == 0:
        values = np.where(own, near.values, 0.0)
        return estimated(cell, groups, State(values, near.poses), weights, own)
    return estimated(cell, groups, near, weights, free, steps=6)


def believed(cell: Cell, prior: Floats, free: Bools, factor: float) -> Floats:
    """Sigmas (m,) with this factor on the prior (m,): the tip keeps its own in full."""
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

    start: the nominal robot, tip and places fitted. Its residuals hold noise besides, and count as one sigma each at
    least, so this is an upper limit. Above 1 where the robot is off by more than its prior says, or noise is large.
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
