"""The fit of a robot to touches: the nominal robot, the factor on the prior, and the estimate with it.

1. The independent parameters are estimated, the others held at nominal (`independence`).
2. The nominal robot, with fitted tip and places, starts the estimate with the full prior (`robust_start`).
3. The residuals of that estimate show outliers and the ratio of noise to sigma (data snooping: W. Baarda, A testing
   procedure for use in geodetic networks, 1968); both robots are fitted again with that noise.
   a. The design matrix has the columns of robot and places, and the rows of the touches and the prior.
   b. The kept rows are fitted by the linear model. Each residual is divided by its standard deviation after the fit.
   c. The search ends if the largest does not exceed what noise gives in one set of touches of a million, scaled by the
      variance factor of the kept rows, or if a tenth of the touches was removed.
   d. Else its touch is removed with all its rows, and the test is repeated.
4. A factor on the prior is chosen by leaving out places (`shrinkage`). With one place there is no choice: the full
   prior if unchecked, else the nominal robot.
5. The robot is estimated with that factor.
"""

from statistics import NormalDist
from typing import Final

import numpy as np

from tactfix.calibration import robust_start, shrinkage
from tactfix.calibration.cell import Cell, Touches
from tactfix.calibration.equations import Group, groups_of
from tactfix.calibration.estimation import Eliminated, State, reduced
from tactfix.calibration.independence import Held, independent
from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.noise import REJECTED_IN_ERROR
from tactfix.values import frozen_value


@frozen_value
class RobotFit:
    """A robot fitted to touches.

    free (m,): which parameters are estimated; held: the others, and why; prior (m,): sigmas. before, after: the nominal
    robot and the estimate. noise: ratio of the residuals to sigma, at least 1. room: the factor at which the prior
    alone would explain the nominal robot's residuals. suspicious: data rows of outliers.
    """

    cell: Cell
    touches: Touches
    free: Bools
    held: tuple[Held, ...]
    prior: Floats
    groups: tuple[Group, ...]
    before: State
    after: State
    noise: float
    room: float
    suspicious: tuple[int, ...]
    choice: shrinkage.Choice


def fitted(cell: Cell, touches: Touches, unchecked: bool) -> RobotFit:
    """Fit the robot of a cell; unchecked: with the full prior if there is only one place."""
    free, held = independent(cell, touches)  # step 1
    prior = np.array([cell.prior.sigma(parameter) for parameter in cell.parameters])
    groups = groups_of(cell, touches)
    weights = np.divide(1.0, prior, out=np.zeros_like(prior), where=prior > 0)
    # Step 2.
    before = robust_start.nominal(cell, groups, weights, free, prior)
    full = robust_start.full(cell, groups, before, weights, free)
    # Step 3.
    suspicious, variance = outliers(groups, reduced(cell, groups, full), full.values, prior, free)
    noise = float(np.sqrt(max(1.0, variance)))
    full = shrinkage.shrunk(cell, groups, full, prior, free, noise, 1.0)
    before = shrinkage.shrunk(cell, groups, before, prior, free, noise, 0.0)
    # Step 4.
    room = shrinkage.room(cell, groups, before, prior, free)
    if len(touches.touched) > 1:
        choice = shrinkage.chosen_factor(cell, touches, full, prior, free, noise, room)
    else:
        choice = shrinkage.Choice(1.0 if unchecked else 0.0, {}, ())
    # Step 5.
    near = full if choice.factor > 0 else before
    after = shrinkage.shrunk(cell, groups, near, prior, free, noise, choice.factor)
    after = shrinkage.shrunk(cell, groups, after, prior, free, noise, choice.factor)
    return RobotFit(cell, touches, free, held, prior, groups, before, after, noise, room, suspicious, choice)


_MOST_SET_ASIDE: Final = 0.1
"""Largest share of touches that are removed: beyond it the majority is not certain to be right."""


def outliers(
    groups: tuple[Group, ...], parts: tuple[Eliminated, ...], values: Floats, prior: Floats, free: Bools
) -> tuple[tuple[int, ...], float]:
    """The data rows of suspicious touches, the worst first, and the variance factor of the others.

    parts: linearised at values (m,). prior (m,): its sigmas.
    """
    rows, design, owner = _stacked(groups, parts, values, prior, free)  # step a
    kept = np.ones(len(rows), dtype=bool)
    named: list[int] = []
    count = sum(len(group.touches) for group in groups)
    limit = -NormalDist().inv_cdf(REJECTED_IN_ERROR / count / 2)
    while True:
        normalised, variance = _normalised(rows, design, kept)  # step b
        worst = int(np.argmax(np.where(kept & (owner >= 0), np.abs(normalised), -1.0)))
        scale = np.sqrt(max(variance, 1.0))
        if len(named) >= _MOST_SET_ASIDE * count or abs(normalised[worst]) <= limit * scale:
            return tuple(named), variance  # step c
        named.append(int(owner[worst]))  # step d
        kept &= owner != owner[worst]


def _stacked(
    groups: tuple[Group, ...], parts: tuple[Eliminated, ...], values: Floats, prior: Floats, free: Bools
) -> tuple[Floats, Floats, Ints]:
    """Residuals (r,), design matrix (r, c) of robot and places, and the data row of each (r,), -1 for the prior."""
    robot = np.concatenate([part.block.robot[:, free] for part in parts])
    places = np.zeros((len(robot), sum(part.block.place.shape[1] for part in parts)))
    first = column = 0
    owner = []
    for group, part in zip(groups, parts, strict=True):
        size, width = part.block.place.shape
        places[first : first + size, column : column + width] = part.block.place
        first, column = first + size, column + width
        rows = np.array([*group.touches.rows, -1])
        owner.append(rows[part.block.touch])
    believed = np.hstack([np.diag(1 / prior[free]), np.zeros((int(free.sum()), places.shape[1]))])
    design = np.vstack([np.hstack([robot, places]), believed])
    missed = [*(part.block.residuals for part in parts), values[free] / prior[free]]
    held = np.full(int(free.sum()), -1)
    return np.concatenate(missed), design, np.concatenate([*owner, held])


def _normalised(rows: Floats, design: Floats, kept: Bools) -> tuple[Floats, float]:
    """Residuals over their standard deviations after a linear fit of the kept rows, and the variance factor."""
    basis, values, _ = np.linalg.svd(design[kept], full_matrices=False)
    basis = basis[:, values > 1e-9 * values[0]]
    left = rows[kept] - basis @ (basis.T @ rows[kept])
    redundancy = np.maximum(1 - (basis**2).sum(axis=1), 1e-6)
    found = np.zeros(len(rows))
    found[kept] = left / np.sqrt(redundancy)
    freedom = max(float(redundancy.sum()), 1.0)
    return found, float(left @ left / freedom)
