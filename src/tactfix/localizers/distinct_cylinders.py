"""Which of several cylinders are one root reached more than once."""

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.localizers.cylinder_refinement import CylinderProblem

_SAME = 1e-6
"""Axes nearer than this, in rad and in units of the contacts' extent, are one root."""

_NEAR = 1e-2
"""Axes nearer than this are one multiple root if the axis half-way between them fits as well as they do."""

_STEPS = 3

_LARGEST_RADIUS = 1e5
"""In units of the contacts' extent: beyond, the contacts lie on a plane as far as doubles can tell."""


def distinct(states: Floats, cost: Floats) -> list[int]:
    """The indices of states (B, 7) that differ as surfaces, cheapest first."""
    distance = _distances(states)
    kept: list[int] = []
    for i in np.argsort(cost, kind="stable"):
        sound = np.isfinite(cost[i]) and abs(states[i, 6]) < _LARGEST_RADIUS
        if sound and not (distance[i, kept] < _SAME).any():
            kept.append(int(i))
    return kept


def distinct_roots(problem: CylinderProblem, states: Floats, cost: Floats, rounding: float) -> list[int]:
    """The same for refined states, of which those scattered by rounding about one multiple root count once.

    A root of order k is known to the k-th root of the rounding only, so nearness alone cannot tell. rounding: of a
    residual, in the problem's unit. problem holds one set of contacts.
    """
    distance = _distances(states)
    kept: list[int] = []
    for i in distinct(states, cost):
        near = [k for k in kept if distance[i, k] < _NEAR]
        if not (near and _halfway_fits(problem, states[i], states[near], rounding)):
            kept.append(i)
    return kept


def _distances(states: Floats) -> Floats:
    """The larger of tilt (sine) and shift between all pairs of states: (B, B)."""
    direction, place = states[:, 3:6], states[:, [0, 1, 2, 6]]
    tilt = np.sqrt(np.maximum(1.0 - (direction @ direction.T) ** 2, 0.0))
    return np.asarray(np.maximum(tilt, np.linalg.norm(place[:, None] - place, axis=-1)))


def _halfway_fits(problem: CylinderProblem, state: Floats, others: Floats, rounding: float) -> bool:
    """Whether the direction between state (7,) and one of others (k, 7) misses no contact by more than rounding."""
    signs = np.where(others[:, 3:6] @ state[3:6] >= 0, 1.0, -1.0)[:, None]
    middle = 0.5 * (others + state)
    direction = others[:, 3:6] * signs + state[3:6]
    middle[:, 3:6] = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    middle = _circles_refitted(problem, middle)
    misses = np.abs(problem.evaluate(middle, np.arange(len(middle)))[0]).max(axis=1)
    own = np.abs(problem.evaluate(state[None], np.zeros(1, dtype=np.intp))[0]).max()
    return bool(np.any(misses <= own + rounding))


def _circles_refitted(problem: CylinderProblem, states: Floats) -> Floats:
    """The states (k, 7) with foot and radius fitted anew, the directions kept: a multiple root is no straight line."""
    index = np.arange(len(states))
    for _ in range(_STEPS):
        residuals, jacobians = problem.evaluate(states, index)
        columns = [c for c in range(jacobians.shape[-1]) if c not in (2, 3)]
        change = np.zeros((len(states), jacobians.shape[-1]))
        change[:, columns] = -(np.linalg.pinv(jacobians[:, :, columns]) @ residuals[..., None])[..., 0]
        states = problem.step(states, change)
    return states
