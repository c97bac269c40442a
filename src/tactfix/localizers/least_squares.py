"""Many small nonlinear least-squares problems at once: Levenberg and Marquardt's method on stacks, Newton's at the end.

Gauss and Newton's steps creep towards a minimum where residuals are large and bend the sum of squares as much as the
Jacobian does: short arcs with much noise. What is under way after some steps takes Newton's, second derivatives by
differences.
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
"""Damping of the normal equations, in problems of unit size: to begin with, the least that still has an effect on
doubles, and that at which no step leads down."""
_GAUSS_NEWTON_STEPS = 15
"""Steps in which most problems settle, before Newton's, which take as many evaluations as there are parameters."""
_JACOBIAN_STEP = 1e-6
"""Change of a parameter, in problems of unit size, over which the Jacobians are differenced."""
_NEARLY_A_ROOT = 1e-8
"""Sum of squared residuals, in problems of unit size, below which a multiple root may be near."""

_UNDAMPED_STEPS = 25
"""Undamped steps near a multiple root: one of order three comes nearer by a third at each."""

_SHORTEST_STEP = 4 * EPS
"""A step this short changes nothing in problems of unit size: exact contacts a thousand sizes from the origin, whose
rounding is more than that of their residuals, would keep making such steps."""

_PROMISED_GAIN = 1e-17
"""A step that promises to lower the cost by less than this part of it moves a parameter by a few 1e-9 residuals; the
next one, which is not made, would move it by much less."""


def refined(evaluate: Evaluate, step: Step, states: Floats, iterations: int = 60) -> Floats:
    """The states (B, q) at a local minimum of the sum of squared residuals, each reached from the one given.

    Problems should be of unit size. A problem that does not settle within the iterations is returned as far as it got.
    """
    found = states.copy()
    active: Ints = np.arange(len(states))
    damping = np.full(len(states), _FIRST_DAMPING)
    residuals, jacobians = evaluate(states, active)
    cost = _square(residuals)
    for number in range(iterations if len(states) else 0):
        bend = (
            _curvature(evaluate, step, states, active, residuals, jacobians) if number >= _GAUSS_NEWTON_STEPS else 0.0
        )
        change, promised = _damped_step(residuals, jacobians, damping, bend)
        trial = step(states, change)
        new_residuals, new_jacobians = evaluate(trial, active)
        new_cost = _square(new_residuals)
        # Near the minimum rounding of residuals hides a gain that the gradient still sees: such steps are taken too.
        better = new_cost <= cost + 8 * EPS * (cost + np.sqrt(residuals.shape[-1] * cost))
        if better.all():
            states, residuals, jacobians, cost = trial, new_residuals, new_jacobians, new_cost
        else:
            states = np.where(better[:, None], trial, states)
            residuals = np.where(better[:, None], new_residuals, residuals)
            jacobians = np.where(better[:, None, None], new_jacobians, jacobians)
            cost = np.where(better, new_cost, cost)
        damping = np.where(better, np.maximum(damping * 0.05, _LEAST_DAMPING), damping * 8.0)
        keep = (promised > _PROMISED_GAIN * cost) & (damping < _MOST_DAMPING) & ~_exact(states, residuals, cost)
        keep &= np.abs(change).max(axis=-1) > _SHORTEST_STEP
        if not keep.all():
            found[active] = states
            active, damping, states = active[keep], damping[keep], states[keep]
            residuals, jacobians, cost = residuals[keep], jacobians[keep], cost[keep]
            if not len(active):
                break
    found[active] = states
    is_square = jacobians.shape[-1] == jacobians.shape[-2]
    return _finished(evaluate, step, found) if is_square else found


def polished(evaluate: Evaluate, step: Step, states: Floats, steps: int) -> Floats:
    """The states (B, q) next to roots of problems with as many parameters as residuals, so many Newton steps nearer.

    A step that leads away from the root is not taken; where any Jacobian is singular none is.
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
    """The states of problems with as many parameters as residuals, taken on to the root if there is one.

    Near a multiple root every damped step is short, whatever is left to go: here they are not damped.
    """
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
        # The valley of a multiple root is curved: the well determined parameters have to follow the weak one.
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
    """Where the residuals (B, n) are no more than the rounding of their own computation."""
    size = np.maximum(1.0, np.abs(states).max(axis=-1))
    return np.asarray(cost <= residuals.shape[-1] * (EPS * size) ** 2)


def _curvature(
    evaluate: Evaluate, step: Step, states: Floats, active: Ints, residuals: Floats, jacobians: Floats
) -> Floats:
    """What (B, p, p) to add to J^T J for Newton's steps: the residuals times their second derivatives.

    Where the sum of squares is a saddle, Newton's step would lead to it; with the signs of the directions in which it
    falls turned round the step leads away.
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
    """The changes (B, p) with (J^T J + damping diag + curvature) change = -J^T r, and the gains (B,) that they promise.

    curvature (B, p, p), or 0 for Gauss and Newton's steps.
    """
    transposed = np.swapaxes(jacobians, -1, -2)
    normal = transposed @ jacobians
    gradient = (transposed @ residuals[..., None])[..., 0]
    diagonal = np.einsum("...ii->...i", normal)
    # A floor for parameters that the contacts hardly see.
    floor = 1e-12 * diagonal.max(axis=-1, keepdims=True) + TINY
    # einsum's view of the diagonal is writable: this damps normal itself.
    diagonal += damping[:, None] * np.maximum(diagonal, floor)
    normal += curvature
    change = -_solved(normal, gradient)
    return change, np.asarray(-np.einsum("bp,bp->b", change, gradient))


def _solved(matrices: Floats, vectors: Floats) -> Floats:
    """The solutions (B, p) of symmetric systems; where rounding has made one singular, the shortest ones.

    A sphere that grows into a plane is hardly held any more, and hardly damped.
    """
    try:
        return np.asarray(np.linalg.solve(matrices, vectors[..., None])[..., 0])
    except np.linalg.LinAlgError:
        return np.asarray((np.linalg.pinv(matrices, hermitian=True) @ vectors[..., None])[..., 0])


def _undamped_step(residuals: Floats, jacobians: Floats, weakest: bool = True) -> Floats:
    """The Gauss-Newton steps (B, p) by singular values: J^T J would lose those below the root of the rounding.

    weakest: whether the step may go along the direction that the residuals see least.
    """
    u, singular, vh = np.linalg.svd(jacobians, full_matrices=False)
    along = np.einsum("bnk,bn->bk", u, residuals)
    seen = singular > 8 * EPS * singular[:, :1]
    seen[:, -1] &= weakest
    return np.asarray(-np.einsum("bkp,bk->bp", vh, np.divide(along, singular, out=np.zeros_like(along), where=seen)))
