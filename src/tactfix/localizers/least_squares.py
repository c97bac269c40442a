"""Stacks of small nonlinear least-squares problems: Levenberg-Marquardt steps, then Newton steps.

1. Each problem takes damped Gauss-Newton steps (Levenberg-Marquardt) until it has converged.
2. After _GAUSS_NEWTON_STEPS the second derivatives of the residuals, by differences, are added: Gauss-Newton converges
   slowly if large residuals contribute as much to the Hessian as the Jacobian does, as for short arcs with noise.
3. A problem with as many residuals as parameters may have a multiple root. Near one, damped steps are too short: it
   takes undamped steps by singular values, and the well determined parameters are corrected after each.
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from tactfix.geometry.arrays import EPS, TINY, Bools, Floats, Ints

Evaluate: TypeAlias = Callable[[Floats, Ints], tuple[Floats, Floats]]
"""States (B, q) of the problems with these indices (B,) -> residuals (B, n) and Jacobians (B, n, p)."""
Step: TypeAlias = Callable[[Floats, Floats], Floats]
"""States (B, q) and parameter changes (B, p) -> new states (B, q)."""

_FIRST_DAMPING, _LEAST_DAMPING, _MOST_DAMPING = 1e-3, 1e-15, 1e8
"""Damping of the normal equations as a share of their diagonal: of the first step; the least that still changes a
double; and the value at which a problem is abandoned, with steps of 1e-8 of a Gauss-Newton step."""
_GAUSS_NEWTON_STEPS = 15
"""Steps after which second derivatives are added. These take as many evaluations as there are parameters, and
problems with small residuals have converged quadratically before."""
_JACOBIAN_STEP = 1e-6
"""Change of a parameter, in problems of unit size, for differences of the Jacobians: between the root of rounding,
1.5e-8, and the size of the problem."""
_NEARLY_A_ROOT = 1e-8
"""Sum of squared residuals, in problems of unit size, below which a multiple root may be near: residuals of 1e-4, as
at a distance of 0.05 from a root of order three."""

_UNDAMPED_STEPS = 25
"""Undamped steps near a multiple root at most. A root of order three comes nearer by a third with each: 25 steps reduce
the distance by (2/3)^25 = 4e-5."""

_SHORTEST_STEP = 4 * EPS
"""Length of a step, in problems of unit size, below which a problem has converged. For contacts a thousand sizes from
the origin, the rounding of the coordinates exceeds that of the residuals, and `_exact` never stops the steps."""

_PREDICTED_GAIN = 1e-17
"""A problem has converged if the predicted gain is below this share of its cost: such a step moves a parameter by
the root of it, 3e-9 of the residuals."""


def refined(evaluate: Evaluate, step: Step, states: Floats, iterations: int = 60) -> Floats:
    """The local minima (B, q) of the sum of squared residuals that the given states (B, q) lead to.

    Problems should be of unit size. A problem that has not converged after the iterations is returned as it is then.
    """
    found = states.copy()
    active: Ints = np.arange(len(states))
    damping = np.full(len(states), _FIRST_DAMPING)
    residuals, jacobians = evaluate(states, active)
    cost = _square(residuals)
    for number in range(iterations if len(states) else 0):
        # Steps 1 and 2.
        bend = (
            _curvature(evaluate, step, states, active, residuals, jacobians) if number >= _GAUSS_NEWTON_STEPS else 0.0
        )
        change, predicted = _damped_step(residuals, jacobians, damping, bend)
        trial = step(states, change)
        new_residuals, new_jacobians = evaluate(trial, active)
        new_cost = _square(new_residuals)
        # Near the minimum a gain may be lost in the rounding of the residuals: steps of equal cost are taken too.
        better = new_cost <= cost + 8 * EPS * (cost + np.sqrt(residuals.shape[-1] * cost))
        if better.all():
            states, residuals, jacobians, cost = trial, new_residuals, new_jacobians, new_cost
        else:
            states = np.where(better[:, None], trial, states)
            residuals = np.where(better[:, None], new_residuals, residuals)
            jacobians = np.where(better[:, None, None], new_jacobians, jacobians)
            cost = np.where(better, new_cost, cost)
        damping = np.where(better, np.maximum(damping * 0.05, _LEAST_DAMPING), damping * 8.0)
        keep = (predicted > _PREDICTED_GAIN * cost) & (damping < _MOST_DAMPING) & ~_exact(states, residuals, cost)
        keep &= np.abs(change).max(axis=-1) > _SHORTEST_STEP
        if not keep.all():
            found[active] = states
            active, damping, states = active[keep], damping[keep], states[keep]
            residuals, jacobians, cost = residuals[keep], jacobians[keep], cost[keep]
            if not len(active):
                break
    found[active] = states
    is_square = jacobians.shape[-1] == jacobians.shape[-2]  # step 3
    return _finished(evaluate, step, found) if is_square else found


def polished(evaluate: Evaluate, step: Step, states: Floats, steps: int) -> Floats:
    """The states (B, q) after so many Newton steps, for problems with as many parameters as residuals.

    A step that raises the cost is not taken, and none at all if any Jacobian is singular.
    """
    index: Ints = np.arange(len(states))
    residuals, jacobians = evaluate(states, index)
    for _ in range(steps):
        try:
            change = -np.linalg.solve(jacobians, residuals[..., None])[..., 0]
        except np.linalg.LinAlgError:
            return states
        trial = step(states, np.asarray(change, dtype=np.float64))
        new_residuals, new_jacobians = evaluate(trial, index)
        better = _square(new_residuals) < _square(residuals)
        states = np.where(better[:, None], trial, states)
        residuals = np.where(better[:, None], new_residuals, residuals)
        jacobians = np.where(better[:, None, None], new_jacobians, jacobians)
    return states


def _finished(evaluate: Evaluate, step: Step, states: Floats) -> Floats:
    """The states after undamped steps towards a root, if the residuals are small (step 3)."""
    active: Ints = np.arange(len(states))
    residuals, jacobians = evaluate(states, active)
    cost = _square(residuals)
    for _ in range(_UNDAMPED_STEPS):
        keep = ~_exact(states[active], residuals, cost) & (cost < _NEARLY_A_ROOT)
        active, residuals, jacobians, cost = active[keep], residuals[keep], jacobians[keep], cost[keep]
        if not active.size:
            break
        trial = step(states[active], _undamped_step(residuals, jacobians))
        new_residuals, new_jacobians = evaluate(trial, active)
        # Along the weak parameter the residuals are curved: correct the well determined ones.
        for _ in range(2):
            trial = step(trial, _undamped_step(new_residuals, new_jacobians, weakest=False))
            new_residuals, new_jacobians = evaluate(trial, active)
        new_cost = _square(new_residuals)
        better = new_cost < cost
        active, residuals, jacobians, cost = (
            active[better],
            new_residuals[better],
            new_jacobians[better],
            new_cost[better],
        )
        states[active] = trial[better]
    return states


def _square(residuals: Floats) -> Floats:
    """Sums of squares (B,) of residuals (B, n)."""
    return np.asarray(np.einsum("bn,bn->b", residuals, residuals))


def _exact(states: Floats, residuals: Floats, cost: Floats) -> Bools:
    """Which problems (B,) have residuals (B, n) no larger than rounding."""
    size = np.maximum(1.0, np.abs(states).max(axis=-1))
    return np.asarray(cost <= residuals.shape[-1] * (EPS * size) ** 2)


def _curvature(
    evaluate: Evaluate, step: Step, states: Floats, active: Ints, residuals: Floats, jacobians: Floats
) -> Floats:
    """The term (B, p, p) to add to J^T J for a Newton step: the residuals times their second derivatives.

    It makes the eigenvalues of the Hessian positive, so that the step leads away from a saddle.
    """
    width = jacobians.shape[-1]
    bend = np.empty((len(states), width, width))
    for k in range(width):
        change = np.zeros((len(states), width))
        change[:, k] = _JACOBIAN_STEP
        _, ahead = evaluate(step(states, change), active)
        bend[:, k] = np.einsum("bnp,bn->bp", ahead - jacobians, residuals) / _JACOBIAN_STEP
    normal = np.swapaxes(jacobians, -1, -2) @ jacobians
    values, vectors = np.linalg.eigh(normal + (bend + np.swapaxes(bend, -1, -2)) / 2)
    bowl = vectors * np.abs(values)[:, None] @ np.swapaxes(vectors, -1, -2)
    return np.asarray(bowl - normal)


def _damped_step(
    residuals: Floats, jacobians: Floats, damping: Floats, curvature: Floats | float
) -> tuple[Floats, Floats]:
    """The changes (B, p) with (J^T J + damping diag + curvature) change = -J^T r, and the predicted gains (B,).

    curvature (B, p, p), or 0 for Gauss-Newton steps.
    """
    transposed = np.swapaxes(jacobians, -1, -2)
    normal = transposed @ jacobians
    gradient = (transposed @ residuals[..., None])[..., 0]
    diagonal = np.einsum("...ii->...i", normal)
    # A floor for parameters that the residuals hardly depend on.
    floor = 1e-12 * diagonal.max(axis=-1, keepdims=True) + TINY
    # einsum's view of the diagonal is writable: this damps normal itself.
    diagonal += damping[:, None] * np.maximum(diagonal, floor)
    normal += curvature
    change = -_solved(normal, gradient)
    return change, np.asarray(-np.einsum("bp,bp->b", change, gradient))


def _solved(matrices: Floats, vectors: Floats) -> Floats:
    """The solutions (B, p) of symmetric systems; of least norm if one is singular: a sphere that is nearly a plane."""
    try:
        return np.asarray(np.linalg.solve(matrices, vectors[..., None])[..., 0])
    except np.linalg.LinAlgError:
        return np.asarray((np.linalg.pinv(matrices, hermitian=True) @ vectors[..., None])[..., 0])


def _undamped_step(residuals: Floats, jacobians: Floats, weakest: bool = True) -> Floats:
    """The Gauss-Newton steps (B, p) by singular values, of which J^T J would lose those below the root of the rounding.

    weakest: whether the step has a component along the right singular vector of the smallest singular value.
    """
    u, singular, vh = np.linalg.svd(jacobians, full_matrices=False)
    along = np.einsum("bnk,bn->bk", u, residuals)
    seen = singular > 8 * EPS * singular[:, :1]
    seen[:, -1] &= weakest
    return np.asarray(-np.einsum("bkp,bk->bp", vh, np.divide(along, singular, out=np.zeros_like(along), where=seen)))
