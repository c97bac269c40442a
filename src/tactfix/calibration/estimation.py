"""Weighted least squares over robot and places, with the prior of the robot.

    minimise  sum |r / sigma|^2  +  sum (p / s)^2

over the parameters p (s: the sigma of the prior) and the poses of all places. The six unknowns of a place occur in its
own rows only, so they are eliminated place by place: with an orthonormal basis Q of the columns of a place's block,
rows become r - Q Q^T r and A - Q Q^T A, which is the Schur complement without squared condition numbers. A motion that
the touches of a place leave free is no column of Q.

1. The equations of all places are linearised, and each place is eliminated from its own.
2. A Gauss-Newton step changes p by the rows of touches and prior; the places follow from it.
3. If the cost would grow, the step is repeated with more damping; if no damping helps, the estimate is reached.
4. It is reached too if a step lowers the cost by no more than 1e-9 of itself.

J. M. Hollerbach, C. W. Wampler: The calibration index and taxonomy for robot kinematic calibration methods, 1996.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np

from tactfix.calibration.cell import Cell
from tactfix.calibration.equations import Block, Group, block, moved_place, residuals, tip_places
from tactfix.geometry.arrays import TINY, Bools, Floats, frozen
from tactfix.values import frozen_value

_PLACE_FREE_RATIO: Final = 1e-9
"""Ratio of singular values of a place's block below which a motion is free: far above rounding. On
samples/robot-calibration, whose places are determined in all six motions, it is 0.46 or more."""
_MOST_STEPS: Final = 40
"""Most Gauss-Newton steps of one fit. The 58 fits of samples/robot-calibration take four at most."""
_DAMPINGS: Final = 10
"""Number of dampings, from 1e-6 by factors of ten, or of halvings, that are tried for one step. On
samples/robot-calibration 23 of 194 steps are damped, by 100 at most."""


@frozen_value
class State:
    """Values (m,) of the parameters and the pose base_from_root (4, 4) of each group."""

    values: Floats
    poses: Mapping[str, Floats]


@frozen_value
class Eliminated:
    """A block with its place eliminated: rows (r,), robot (r, m), and the projection of the place.

    The step (k,) of the place, in the columns of the block's motions, is -steps @ basis^T @ (residuals + robot change).
    """

    block: Block
    rows: Floats
    robot: Floats
    basis: Floats
    steps: Floats

    @property
    def rank(self) -> int:
        """The number of motions of the place that its touches determine."""
        return int(self.basis.shape[1])

    @property
    def is_located(self) -> bool:
        """Whether the touches and the placement leave no motion of the place free."""
        return self.rank == int(self.block.motions.shape[1])


def eliminated(found: Block) -> Eliminated:
    """The block with its place eliminated."""
    basis, values, motions = np.linalg.svd(found.place, full_matrices=False)
    determined = values > _PLACE_FREE_RATIO * max(float(values[:1].max(initial=0.0)), TINY)
    basis, steps = basis[:, determined], motions[determined].T / values[determined]
    rows = found.residuals - basis @ (basis.T @ found.residuals)
    robot = found.robot - basis @ (basis.T @ found.robot)
    return Eliminated(found, rows, robot, basis, steps)


def reduced(cell: Cell, groups: tuple[Group, ...], state: State) -> tuple[Eliminated, ...]:
    """The linearised equations of all groups, places eliminated."""
    return tuple(eliminated(block(cell, group, state.poses[group.root], state.values)) for group in groups)


def cost(cell: Cell, groups: tuple[Group, ...], state: State, weights: Floats) -> float:
    """The sum of squares of all residuals and of the prior's, with weights (m,) = 1 / s."""
    parts = [residuals(cell, group, state.poses[group.root], state.values) for group in groups]
    return float(sum(part @ part for part in parts) + ((state.values * weights) ** 2).sum())


def estimated(
    cell: Cell, groups: tuple[Group, ...], start: State, weights: Floats, free: Bools, steps: int = _MOST_STEPS
) -> State:
    """The state of least cost near start over the free parameters (m,) and the places."""
    state, now, damping = start, cost(cell, groups, start, weights), 0.0
    for _ in range(steps):
        parts = reduced(cell, groups, state)  # step 1
        for _attempt in range(_DAMPINGS):
            tried = _stepped(state, groups, parts, weights, free, damping)  # step 2
            then = cost(cell, groups, tried, weights)
            if then <= now:
                break
            damping = max(10 * damping, 1e-6)  # step 3
        else:
            return state
        gain, state, now = now - then, tried, then
        damping /= 10
        if gain <= 1e-9 * (now + TINY):  # step 4
            break
    return state


def located(cell: Cell, group: Group, start: Floats, values: Floats, steps: int = 25) -> tuple[Floats, float]:
    """The pose base_from_root (4, 4) of least cost near start for the robot at values (m,), and its cost."""
    tips = tip_places(cell, group, values)
    pose, rows = start, residuals(cell, group, start, values, tips)
    for _ in range(steps):
        part = eliminated(block(cell, group, pose, values, tips))
        step = -part.steps @ (part.basis.T @ part.block.residuals)
        for halving in range(_DAMPINGS):
            tried = moved_place(group, pose, step * 0.5**halving, part.block)
            then = residuals(cell, group, tried, values, tips)
            if then @ then <= rows @ rows:
                break
        else:
            break
        gain, pose, rows = rows @ rows - then @ then, tried, then
        if gain <= 1e-10 * (rows @ rows + TINY):
            break
    return pose, float(rows @ rows)


def _stepped(
    state: State, groups: tuple[Group, ...], parts: tuple[Eliminated, ...], weights: Floats, free: Bools, damping: float
) -> State:
    """The state after one Gauss-Newton step of the free parameters, then of the places."""
    change = np.zeros(len(state.values))
    if free.any():
        matrix = np.concatenate([*(part.robot[:, free] for part in parts), np.diag(weights[free])])
        right = np.concatenate([*(part.rows for part in parts), (state.values * weights)[free]])
        sizes = np.linalg.norm(matrix, axis=0)
        sizes[sizes == 0] = 1.0
        normal = (matrix / sizes).T @ (matrix / sizes)
        normal[np.diag_indices(len(normal))] += damping + 1e-13
        change[free] = np.linalg.solve(normal, -(matrix / sizes).T @ right) / sizes
    poses = dict(state.poses)
    for group, part in zip(groups, parts, strict=True):
        ahead = part.block.residuals + part.block.robot @ change
        poses[group.root] = moved_place(group, poses[group.root], -part.steps @ (part.basis.T @ ahead), part.block)
    return State(frozen(state.values + change), poses)
