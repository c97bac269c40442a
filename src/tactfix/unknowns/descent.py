"""Levenberg-Marquardt from many trials at once to the least squares of pose, tip and radius together.

1. Residuals over sigma and their Jacobian are evaluated at the trials (`equations`).
2. Damped normal equations give each trial a step, no longer than half a radian or half a length of the problem.
3. A step that lowers chi-square is taken and the damping divided by ten; else the damping is multiplied by ten.
4. The descent ends when every trial has a short step, a small gain, or a damping with which no step lowers chi-square.
"""

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.unknowns.equations import PosesWithTip, TipEquations

MOST_TIP_STEPS = 80
"""Steps of one descent at most: weakly determined tips converge linearly."""
TIP_REACHED = 1e-10
"""Length of a step (rad, lengths of the problem) below which a trial has converged: far above rounding, far below
sigma."""
TIP_GAIN = 1e-13
"""Relative gain of chi-square below which a trial has converged: near the rounding of a sum of squares."""


def descend(equations: TipEquations, trials: PosesWithTip) -> tuple[PosesWithTip, Floats]:
    """The ends of the trials, and their chi-square (S,)."""
    residuals, jacobian = equations.evaluate(trials)  # step 1
    cost = (residuals**2).sum(axis=1)
    damping = np.full(len(cost), 1e-4)
    for _ in range(MOST_TIP_STEPS):
        step = _step(residuals, jacobian, damping)  # step 2
        ahead = equations.stepped(trials, step)
        new_residuals, new_jacobian = equations.evaluate(ahead)
        new_cost = (new_residuals**2).sum(axis=1)
        better = new_cost < cost  # step 3
        gain = np.where(better, cost - new_cost, 0.0)
        small = np.abs(step).max(axis=1) < TIP_REACHED
        trials = _chosen(better, ahead, trials)
        residuals = np.where(better[:, None], new_residuals, residuals)
        jacobian = np.where(better[:, None, None], new_jacobian, jacobian)
        cost = np.where(better, new_cost, cost)
        damping = np.where(better, 0.1 * damping, 10 * damping)
        # Step 4.
        if (small | (damping > 1e8) | (better & (gain <= TIP_GAIN * cost))).all():
            break
    return trials, cost


def _step(residuals: Floats, jacobian: Floats, damping: Floats) -> Floats:
    """The damped steps (S, u), none longer than half a radian or half a length of the problem."""
    normal = np.swapaxes(jacobian, 1, 2) @ jacobian
    diagonal = np.einsum("sii->si", normal)
    # A free motion has no curvature: a share of the mean of the others keeps the matrix regular.
    diagonal += damping[:, None] * diagonal + 1e-12 * diagonal.mean(axis=1, keepdims=True)
    gradient = (np.swapaxes(jacobian, 1, 2) @ residuals[:, :, None])[:, :, 0]
    step = -np.linalg.solve(normal, gradient[:, :, None])[:, :, 0]
    size = np.sqrt((step**2).sum(axis=1, keepdims=True))
    return np.asarray(step * np.minimum(1.0, 0.5 / np.maximum(size, 0.5)))


def _chosen(better: Floats, ahead: PosesWithTip, before: PosesWithTip) -> PosesWithTip:
    which = better[:, None]
    return PosesWithTip(
        np.where(which[:, :, None], ahead.rotations, before.rotations),
        np.where(which, ahead.origins, before.origins),
        np.where(which, ahead.tips, before.tips),
        np.where(better, ahead.radii, before.radii),
    )
