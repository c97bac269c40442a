"""Geometric least squares for cylinders: from a stack of axes to the nearest local minima.

A state is (foot (3,), direction (3,), radius): foot is the point of the axis nearest to the origin, which should be
near the contacts' mean. Parameters: two shifts of the foot and two tilts in a basis square to the axis, and the radius
unless it is known.
"""

from dataclasses import field, replace

import numpy as np

from tactfix.geometry.arrays import TINY, Floats, Ints, basis_across, unit
from tactfix.localizers.candidate import ONE_ROOT
from tactfix.localizers.least_squares import polished, refined
from tactfix.values import frozen_value

CYLINDER_PARAMETERS = 5
"""Two shifts and two tilts of the axis, and the radius."""

_CYLINDER_SIGHT_STEPS, _CYLINDER_IN_SIGHT = 8, 1e-3
"""After so many steps the residuals of a start that leads to a root are below this, even if the root is multiple."""


@frozen_value
class CylinderProblem:
    """Contacts (n, 3), or (B, n, 3) with one set per state, with weights (n,) or (B, n); is the radius known?

    Residuals are weight * (distance from the axis - radius - extra), where extra (n,) is what one contact lies farther
    out than the others, zero for contacts with one tip.
    """

    points: Floats
    weights: Floats
    radius_known: bool
    extra: Floats = field(default_factory=lambda: np.zeros(1))

    def evaluate(self, states: Floats, index: Ints) -> tuple[Floats, Floats]:
        """Residuals (B, n) and Jacobians (B, n, 4 or 5) of the states (B, 7)."""
        foot, direction, radius = states[:, :3], states[:, 3:6], states[:, 6]
        across = basis_across(direction)
        points = self.points[index] if self.points.ndim == 3 else self.points
        weights = self.weights[index] if self.weights.ndim == 2 else self.weights
        along = points @ direction[..., None]
        flat = points @ np.swapaxes(across, -1, -2) - (across @ foot[..., None])[:, None, :, 0]
        distance = np.sqrt(np.einsum("bni,bni->bn", flat, flat))
        # A contact on the axis itself has no radial direction; any will do to leave the place.
        normal = flat / np.maximum(distance, 1e-300)[..., None]
        columns = [-normal, -along * normal]
        if not self.radius_known:
            columns.append(np.full((*distance.shape, 1), -1.0))
        jacobian = np.concatenate(columns, axis=-1) * weights[..., None]
        return weights * (distance - radius[:, None] - self.extra), jacobian

    def step(self, states: Floats, change: Floats) -> Floats:
        """The states (B, 7) after shifts, tilts and a change of radius (B, 4 or 5)."""
        foot, direction, radius = states[:, :3], states[:, 3:6], states[:, 6].copy()
        across = basis_across(direction)
        shifted = foot + np.einsum("bi,bij->bj", change[:, :2], across)
        tilted = unit(direction + np.einsum("bi,bij->bj", change[:, 2:4], across))
        if not self.radius_known:
            radius += change[:, 4]
        feet = shifted - np.sum(shifted * tilted, axis=-1, keepdims=True) * tilted
        return np.concatenate([feet, tilted, radius[:, None]], axis=-1)

    def refined(self, states: Floats, iterations: int = 60) -> Floats:
        """The local minima (B, 7) that the states lead to."""
        return refined(self.evaluate, self.step, states, iterations)

    def polished(self, states: Floats, steps: int) -> Floats:
        """The states (B, 7), next to single roots of as many contacts as parameters, so many Newton steps nearer."""
        return polished(self.evaluate, self.step, states, steps)


def refined_roots(problem: CylinderProblem, states: Floats, slack: Floats | float) -> tuple[Floats, Ints]:
    """Of starts (B, 7) for problems with as many contacts as parameters those that come near a root, refined.

    A zero of the algebraic equations is near one; the real part of a complex pair may lead nowhere, and is dropped as
    soon as that shows. slack, a number or (B,): by so much a contact may miss the surface in the end, in problems of
    unit size. Returns states (k, 7) and their numbers (k,) among the starts.
    """
    states = problem.refined(states, _CYLINDER_SIGHT_STEPS)
    misses = np.abs(problem.evaluate(states, np.arange(len(states)))[0]).max(axis=1, initial=0.0)
    near = np.flatnonzero(misses <= np.maximum(_CYLINDER_IN_SIGHT, 30 * slack))
    points = problem.points[near] if problem.points.ndim == 3 else problem.points
    return replace(problem, points=points).refined(states[near]), near


def circle_states(directions: Floats, points: Floats, weights: Floats) -> Floats:
    """For each direction (B, 3) the state of the circle that fits the projected contacts best (fig. 5).

    All contacts are used, not only three: |x x s|^2 - 2 f . x is made as constant as can be (linear least squares).
    points (n, 3) or (B, n, 3), weights (n,). A direction along which the contacts fall on one line gives nan.
    """
    across = basis_across(directions)
    flat = points @ np.swapaxes(across, -1, -2)
    share = weights**2 / np.sum(weights**2)
    middle = np.einsum("n,bni->bi", share, flat)
    flat = flat - middle[:, None]
    squared = np.sum(flat**2, axis=-1)
    mean_square = squared @ share
    moments = np.einsum("n,bni,bnj->bij", share, flat, flat)
    right = np.einsum("n,bni,bn->bi", share, flat, squared)
    det = moments[:, 0, 0] * moments[:, 1, 1] - moments[:, 0, 1] ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (moments[:, 1, 1] * right[:, 0] - moments[:, 0, 1] * right[:, 1]) / (2 * det)
        v = (moments[:, 0, 0] * right[:, 1] - moments[:, 0, 1] * right[:, 0]) / (2 * det)
        radius = np.sqrt(mean_square + u**2 + v**2)
        centre = middle + np.stack([u, v], axis=-1)
        foot = np.einsum("bi,bij->bj", centre, across)
    return np.concatenate([foot, directions, radius[:, None]], axis=-1)


_NEVER_ONE_ROOT = 1e-2
"""Axes farther apart than this are never one root."""

_MULTIPLE_ROOT_CONTACTS = 24
"""More contacts leave no multiple root to worry about."""

_LARGEST_RADIUS = 1e5
"""In units of the contacts' extent: beyond, the contacts lie on a plane as far as doubles can tell."""


def distinct(states: Floats, cost: Floats) -> list[int]:
    """The indices of states (B, 7) that differ as surfaces, cheapest first."""
    same = _distances(states) < ONE_ROOT
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
    if len(states) < 2 or problem.points.shape[-2] > _MULTIPLE_ROOT_CONTACTS:
        return distinct(states, cost)
    weakest = np.linalg.svd(problem.evaluate(states, index)[1], compute_uv=False)[:, -1]
    scatter = np.minimum(2 * rounding / np.maximum(weakest, TINY), _NEVER_ONE_ROOT / 2)
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
