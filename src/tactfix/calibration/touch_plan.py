"""Touches before they are made: how well they would determine the robot, and which others to add.

At the nominal robot the planned touches have rows J = [robot, places] over sigma. With the priors W (the robot's, and
next to nothing for a place of which nothing is known) all that is unknown would have the covariance

    C = (J^T J + W^2)^-1,

and a touch more, with rows a (k, m), would take G S^-1 G^T away from it, where G = C a^T and S = 1 + a C a^T.

1. Parameters that no touch could tell apart are held at nominal (`independence`).
2. Places are taken where they are known to be, else where the touches planned there say.
3. A random pool is made: touches of every feature of every such place, from random postures (`touch_pool`).
4. Touches to add are taken from it one after the other, then exchanged for better ones (`touch_choice`, Fedorov 1972):
   each is the one after which the worst place of the tip over the joint ranges is known best, or after which the
   determinant of the covariance of the robot's parameters is smallest. Places take turns, for each will be left out.
5. Sigmas by the prior, after the touches planned, and with those added say what they tell, and what they leave of the
   robot's errors over the joint ranges foretells whether a calibration from them would be refused (`status`).

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
"""Of the prior, an upper limit, as large as the robot's errors are taken to be before any touch shows how large.

For the real robots it foretells what is left undetermined to 0.09: 0.56 to 0.62 where calibrate finds 0.57 to 0.62 and
refuses, 0.03 to 0.30 where it finds 0.02 to 0.26 (`pytest -m slow tests/calibration -k foretells`)."""


@frozen_value
class PlannedParameter:
    """Sigma of a parameter by the prior, after the touches planned, and with those added; deg, units."""

    name: str
    unit: str
    prior: float
    planned: float
    with_added: float
    identified: bool


@frozen_value
class TouchPlan:
    """What planned touches would tell, and which others would tell more.

    prediction, worst: the rms and the largest sigma of the tip's place over the joint ranges, by the prior, after the
    touches planned, and with those added. undetermined: what the touches planned, and with those added, leave of errors
    of the robot as large as `EXPECTED_ERRORS`, from 0 to 1. not_identified, observability: with those added. unplaced:
    places to which none could be added, since nothing says where they are; out_of_reach: features, as "feature at
    place", that no posture reached.
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
    """Judge planned touches, and add so many to them.

    planned: touches at joints that reach their features roughly; None: none. sigma: of a touch that is added.
    Raises UsageError where there is nothing to judge and no place to add touches at.
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
            f"there is nothing to plan with: nothing says where {listed(unplaced or ('a place',))} is; {remedy}"
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
    """base_from_root (4, 4) of places: as known beforehand, else as the touches planned there say."""
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
    """What touches with these rows would leave of the robot's errors: 0 to 1."""
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
