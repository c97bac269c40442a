"""Poses that most contacts agree on, whatever the others say: robust least squares from all over the rotations.

1. Descents start all over the rotations, since the fixture may stand anyhow (`starts`).
2. A residual r counts as r^2 / (r^2 + m^2), the loss of Geman and McClure, with a scale m that shrinks from the size of
   the largest residual to a few sigma: a contact that is far off then no longer pulls. Each step is one of reweighted
   least squares, damped where the loss would grow.
3. The ends are told apart, and the best are kept: those of the least chi-square with no contact counted as more than
   BOUND sigma off.

Graduated non-convexity: A. Blake, A. Zisserman: Visual Reconstruction, 1987; H. Yang and others, 2020.
"""

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.poses.descent import damped_step, turned
from tactfix.poses.equations import PoseEquations, evaluate
from tactfix.poses.starts import covering
from tactfix.values import frozen_value

ROBUST_STARTS = 600
"""Rotations from which robust fits start."""
ROBUST_STEPS = 30
"""Reweighted steps of each: with SHRINKS the scale falls to a millionth in 27."""
SHRINKS = 0.6
"""By so much the scale shrinks with each step: slower ones settled where the bad contacts pull."""
BOUND = 5.0
"""Sigmas beyond which a contact does not agree."""
ONE_POSE = 1e-3
"""Rad, and sizes of the fixture, within which two poses are one."""


@frozen_value
class RobustPoses:
    """Poses, best first: rotations (k, 3, 3), offsets (k, 3) of fixture_from_base in the units of the equations.

    costs (k,): chi-square with no contact counted as more than BOUND sigma off.
    """

    rotations: Floats
    offsets: Floats
    costs: Floats


def robust_poses(equations: PoseEquations, unit: float, most: int, starts: int = ROBUST_STARTS) -> RobustPoses:
    """At most so many poses; unit: the weighted residual that is one sigma."""
    rotations, offsets = covering(equations, starts, 0)  # step 1
    least = BOUND * unit
    residual, jacobian = evaluate(equations, rotations, offsets, geometric=True)
    damping = np.full(starts, 1e-2)
    scale = np.maximum(np.abs(residual).max(axis=0) / 2, least)
    for _ in range(ROBUST_STEPS):  # step 2
        scale = np.maximum(SHRINKS * scale, least)
        weight = scale**2 / (residual**2 + scale**2)
        # A start in a singular place may step to infinity: nan is never better.
        with np.errstate(over="ignore", invalid="ignore"):
            step = damped_step(weight * residual, weight * jacobian, damping)
            ahead = turned(step[:3], rotations), offsets + step[3:]
            new_residual, new_jacobian = evaluate(equations, *ahead, geometric=True)
            better = _loss(new_residual, scale) < _loss(residual, scale)
        damping = np.where(better, 0.2 * damping, np.minimum(5 * damping, 1e3))
        for old, new in zip(
            (rotations, offsets, residual, jacobian), (*ahead, new_residual, new_jacobian), strict=True
        ):
            np.copyto(old, new, where=better)
    # Step 3.
    cost = np.minimum((residual / unit) ** 2, BOUND**2).sum(axis=0)
    kept = _distinct(np.moveaxis(rotations, -1, 0), offsets.T, np.argsort(cost, kind="stable").tolist(), most)
    return RobustPoses(np.moveaxis(rotations, -1, 0)[kept], offsets.T[kept], cost[kept])


def _loss(residual: Floats, scale: Floats) -> Floats:
    square = residual**2
    return np.asarray((square / (square + scale**2)).sum(axis=0))


def _distinct(rotations: Floats, offsets: Floats, order: list[int], most: int) -> list[int]:
    kept: list[int] = []
    for number in order:
        if len(kept) == most:
            break
        apart = [
            max(np.abs(rotations[number] - rotations[k]).max(), np.abs(offsets[number] - offsets[k]).max())
            for k in kept
        ]
        if min(apart, default=1.0) > ONE_POSE:
            kept.append(number)
    return kept
