"""Poses by robust least squares from a covering of all rotations, also if some contacts are wrong.

1. Descents start from a covering of all rotations (`starts`).
2. A residual r has the loss r^2 / (r^2 + m^2) of Geman and McClure. The scale m shrinks from the size of the largest
   residual to a few sigma, so that a contact that is far off loses its influence. Each step is one of iteratively
   reweighted least squares, damped more if the loss would grow.
3. Of the distinct ends those with the least chi-square are kept, each residual truncated at BOUND sigma.

Graduated non-convexity: A. Blake, A. Zisserman: Visual Reconstruction, 1987; H. Yang and others, 2020.
"""

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.poses.descent import damped_step, turned
from tactfix.poses.equations import PoseEquations, evaluate
from tactfix.poses.starts import covering
from tactfix.values import frozen_value

ROBUST_STARTS = 600
"""Start rotations of robust fits: those of the search for cylinders with four or five contacts more than six
(`all_poses.STARTS`)."""
ROBUST_STEPS = 30
"""Reweighted steps of each start: 27 times SHRINKS reduces the scale to a millionth, from the size of the fixture to
sigma."""
SHRINKS = 0.6
"""Factor on the scale in each step. With factors nearer to 1, descents ended at minima of the wrong contacts."""
BOUND = 5.0
"""Residual in sigma beyond which a contact does not agree: good contacts exceed it once in two million cases
(`noise.SURE` is the same number for signs)."""
ONE_POSE = 1e-3
"""Largest difference (rad, fixture sizes) of two ends that are one pose: ends are converged to far less, and distinct
minima are farther apart than a thousandth of the fixture."""


@frozen_value
class RobustPoses:
    """Poses, best first: rotations (k, 3, 3), offsets (k, 3) of fixture_from_base in the units of the equations.

    costs (k,): chi-square with each residual truncated at BOUND sigma.
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
