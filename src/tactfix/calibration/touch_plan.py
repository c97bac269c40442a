"""Plans of touches: how well they would determine the robot, and which others to add.

At the nominal robot the planned touches have rows J = [robot, places] over sigma. With the priors W (almost zero for a
place without placement) the covariance of all unknowns would be

    C = (J^T J + W^2)^-1,

and an additional touch with rows a (k, m) would reduce it by G S^-1 G^T, where G = C a^T and S = 1 + a C a^T.

1. Dependent parameters are held at nominal (`independence`).
2. The pose of a place is that of its placement, else of the touches planned there.
3. A random pool is made: touches of every feature of every such place, from random postures (`touch_pool`).
4. Touches to add are chosen from it one after the other, then exchanged for better ones (`touch_choice`, Fedorov 1972):
   each minimises the worst sigma of the tip over the joint ranges, or the determinant of the covariance of the robot's
   parameters. Places take turns, since each will be left out.
5. Sigmas are given by the prior, after the planned touches, and with those added; the share of the robot's errors that
   they leave over the joint ranges predicts whether a calibration from them would be refused (`status`).

V. V. Fedorov: Theory of optimal experiments, 1972.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from tactfix.calibration import accuracy
from tactfix.calibration.cell import Cell, Touches
from tactfix.calibration.equations import groups_of
from tactfix.calibration.estimation import State, reduced
from tactfix.calibration.independence import independent
from tactfix.calibration.robust_start import placed, tips
from tactfix.calibration.shrinkage import believed
from tactfix.calibration.touch_choice import Criterion, chosen_touches
from tactfix.calibration.touch_pool import joined, no_touches, touch_pool
from tactfix.errors import UsageError
from tactfix.geometry.arrays import Bools, Floats
from tactfix.values import frozen_value
from tactfix.wording import listed

EXPECTED_ERRORS: Final = 0.1
"""Assumed errors of the robot as a share of the prior's sigmas, which are upper limits.

For the real robots it predicts the undetermined share to 0.09: 0.56 to 0.62 for 0.57 to 0.62 by calibrate, which
refuses these, and 0.03 to 0.30 for 0.02 to 0.26 (`pytest -m slow tests/calibration -k foretells`)."""


@frozen_value
class PlannedParameter:
    """Sigma (deg, units) of a parameter by the prior, after the planned touches, and with those added."""

    name: str
    unit: str
    prior: float
    planned: float
    with_added: float
    identified: bool


@frozen_value
class TouchPlan:
    """The accuracy of planned touches, and the touches to add.

    prediction, worst: the rms and the largest sigma of the tip's place over the joint ranges, by the prior, after the
    planned touches, and with those added. undetermined: the share, from 0 to 1, of errors as large as `EXPECTED_ERRORS`
    that the planned touches, and with those added, leave. not_identified, observability: with those added. unplaced:
    places of unknown pose, to which none could be added; out_of_reach: features, as "feature at place", that no posture
    reached.
    """

    units: str
    joints: tuple[bool, ...]
    parameters: tuple[PlannedParameter, ...]
    not_identified: tuple[str, ...]
    prediction: tuple[float, float, float]
    worst: tuple[float, float, float]
    undetermined: tuple[float, float]
    observability: Mapping[str, float]
    planned: int
    added: Touches
    unplaced: tuple[str, ...]
    out_of_reach: tuple[str, ...]


def plan_touches(
    cell: Cell, planned: Touches | None, add: int, sigma: float, criterion: Criterion = "worst", seed: int = 0
) -> TouchPlan:
    """Evaluate planned touches, and choose so many to add.

    planned: touches at joints that reach their features roughly, if any. sigma: of an added touch.
    Raises UsageError if there are no touches and no place to add them.
    """
    free, held = independent(cell, planned)  # step 1
    poses = _poses(cell, planned)  # step 2
    # Step 3.
    pool, out_of_reach = touch_pool(cell, planned, poses, sigma, seed) if add else (no_touches(cell), ())
    unplaced = tuple(name for name in cell.places if cell.root(name)[0] not in poses)
    start = no_touches(cell) if planned is None else replace(planned, rows=tuple(range(1, len(planned) + 1)))
    if not len(start) and not len(pool):
        remedy = "give planned touches, or placement: {near: ...} for each place in the cell file"
        raise UsageError(
            f"there is nothing to plan with: the pose of {listed(unplaced or ('a place',))} is not known; {remedy}"
        )
    # Step 4.
    _, moves = accuracy.workspace_points(cell, planned, np.zeros(len(cell.parameters)))
    prior = np.array([cell.prior.sigma(parameter) for parameter in cell.parameters])
    chosen = chosen_touches(cell, start, pool, poses, free, prior, moves, add, criterion)
    added = pool.subset(chosen)
    names = tuple(p.name for p, is_free in zip(cell.parameters, free, strict=True) if is_free)
    # Step 5.
    planned_rows, all_rows = (_matrix(cell, touches, poses, free) for touches in (start, joined(start, added)))
    certainties = [accuracy.certainty(rows, prior[free], prior[free], 1.0, names) for rows in (planned_rows, all_rows)]
    spreads = [np.diag(prior[free] ** 2), certainties[0].covariance, certainties[1].covariance]
    sigmas = [accuracy.tip_sigmas(moves[:, :, free], spread) for spread in spreads]
    return TouchPlan(
        units=cell.units,
        joints=tuple(joint.is_prismatic for joint in cell.chain.joints),
        parameters=_parameters(cell, free, spreads, certainties[1].identified),
        not_identified=(*(item.message for item in held), *certainties[1].unknown),
        prediction=_three([float(np.sqrt((s**2).mean())) for s in sigmas]),
        worst=_three([float(s.max()) for s in sigmas]),
        undetermined=(
            _undetermined(cell, planned_rows, moves, free, prior),
            _undetermined(cell, all_rows, moves, free, prior),
        ),
        observability=accuracy.observability(all_rows, prior[free], len(start) + len(added)),
        planned=len(start),
        added=added,
        unplaced=unplaced,
        out_of_reach=out_of_reach,
    )


def _three(values: Sequence[float]) -> tuple[float, float, float]:
    first, second, third = values
    return first, second, third


def _poses(cell: Cell, planned: Touches | None) -> dict[str, Floats]:
    """base_from_root (4, 4) of places: of their placements, else of the touches planned there."""
    roots = {cell.root(name)[0] for name in cell.places}
    poses = {root: item.near for root in roots if (item := cell.places[root].placement) is not None}
    if planned is not None:
        groups = tuple(group for group in groups_of(cell, planned) if group.root not in poses)
        zero = np.zeros(len(cell.parameters))
        poses |= placed(cell, groups, zero, zero).poses
    return poses


def _matrix(cell: Cell, touches: Touches, poses: Mapping[str, Floats], free: Bools) -> Floats:
    """The rows of touches by the free parameters over sigma, places eliminated."""
    if not len(touches):
        return np.zeros((1, int(free.sum())))
    groups = groups_of(cell, touches)
    return accuracy.information(reduced(cell, groups, State(np.zeros(len(free)), poses)), free)


def _undetermined(cell: Cell, rows: Floats, moves: Floats, free: Bools, prior: Floats) -> float:
    """The share (0 to 1) of the robot's expected errors that touches with these rows would leave."""
    expected = believed(cell, prior, free, EXPECTED_ERRORS)[free]
    return accuracy.undetermined(rows, expected, tips(cell, free)[free], moves[:, :, free], 1.0)


def _parameters(cell: Cell, free: Bools, spreads: Sequence[Floats], identified: Bools) -> tuple[PlannedParameter, ...]:
    sigmas = np.sqrt([np.diag(spread) for spread in spreads])
    found = []
    for number, index in enumerate(np.flatnonzero(free).tolist()):
        parameter = cell.parameters[index]
        scale = float(np.rad2deg(1.0)) if parameter.is_angle else 1.0
        unit = "deg" if parameter.is_angle else cell.units
        found.append(
            PlannedParameter(
                parameter.name, unit, *_three((scale * sigmas[:, number]).tolist()), bool(identified[number])
            )
        )
    return tuple(found)
