"""Which of several cylinders are one root reached more than once."""

import numpy as np

from tactfix.geometry.arrays import TINY, Floats
from tactfix.localizers.cylinder_refinement import CylinderProblem

_SAME = 1e-6
"""Axes nearer than this, in rad and in units of the contacts' extent, are one root."""

_NEAR = 1e-2
"""Axes farther apart than this are never one root."""

_FEW = 24
"""More contacts leave no multiple root to worry about."""

_LARGEST_RADIUS = 1e5
"""In units of the contacts' extent: beyond, the contacts lie on a plane as far as doubles can tell."""


def distinct(states: Floats, cost: Floats) -> list[int]:
    """The indices of states (B, 7) that differ as surfaces, cheapest first."""
    same = _distances(states) < _SAME
    passed = ~np.isfinite(cost) | (np.abs(states[:, 6]) >= _LARGEST_RADIUS)
    kept: list[int] = []
    for i in np.argsort(cost, kind="stable").tolist():
        if not passed[i]:
            kept.append(i)
            passed |= same[i]
    return kept


def distinct_roots(problem: CylinderProblem, states: Floats, cost: Floats, rounding: float) -> list[int]:
    """The same for refined states, of which those scattered by rounding about one multiple root count once.

    At a distance d from a root of order k the residuals are like d^k and the smallest singular value of their Jacobian
    like d^(k-1): rounding divided by it is how far such a root is scattered. For single roots, and for two that are
    only close, that is next to nothing. rounding: of a residual, in the problem's unit; problem: one set of contacts.
    """
    index = np.arange(len(states))
    if len(states) < 2 or problem.points.shape[-2] > _FEW:
        return distinct(states, cost)
    weakest = np.linalg.svd(problem.evaluate(states, index)[1], compute_uv=False)[:, -1]
    scatter = np.minimum(2 * rounding / np.maximum(weakest, TINY), _NEAR / 2)
    distance = _distances(states)
    kept: list[int] = []
    for i in distinct(states, cost):
        if not (distance[i, kept] < scatter[i] + scatter[kept]).any():
            kept.append(i)
    return kept


def _distances(states: Floats) -> Floats:
    """The larger of tilt (sine) and shift between all pairs of states: (B, B)."""
    direction, place = states[:, 3:6], states[:, [0, 1, 2, 6]]
    tilt = np.sqrt(np.maximum(1.0 - (direction @ direction.T) ** 2, 0.0))
    return np.asarray(np.maximum(tilt, np.linalg.norm(place[:, None] - place, axis=-1)))
