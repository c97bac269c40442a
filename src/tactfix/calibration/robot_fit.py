"""One robot fitted to touches: the nominal one, how much of the prior is believed, and the estimate with it.

1. The independent parameters are estimated, the others held at nominal (`independence`).
2. The nominal robot, its tip and places fitted, starts the estimate with the full prior (`robust_start`).
3. The residuals of that estimate show outliers, and how many times sigma the noise is (`snooping`); both robots are
   fitted again with that noise.
4. A factor on the prior is chosen by places left out (`shrinkage`). With one place there is nothing to choose by: the
   full prior where that is asked for (unchecked), else the nominal robot.
5. The robot is estimated with that factor.
"""

import numpy as np

from tactfix.calibration import robust_start, shrinkage
from tactfix.calibration.cell import Cell, Touches
from tactfix.calibration.equations import Group, groups_of
from tactfix.calibration.estimation import State, reduced
from tactfix.calibration.independence import Held, independent
from tactfix.calibration.snooping import outliers
from tactfix.geometry.arrays import Bools, Floats
from tactfix.values import frozen_value


@frozen_value
class RobotFit:
    """A robot fitted to touches.

    free (m,): which parameters are estimated, held: those that are not and why, prior (m,): sigmas. before, after: the
    nominal robot and the estimate. noise: how many times sigma the residuals are, 1 at least. room: the factor at which
    the prior alone would explain the nominal robot's residuals. suspicious: data rows.
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
    """Nominal robot, full prior, factor, estimate."""
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
