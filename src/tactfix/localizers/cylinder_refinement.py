"""Geometric least squares for cylinders: from a stack of axes to the nearest local minima.

A state is (foot (3,), direction (3,), radius): foot is the point of the axis nearest to the origin, which should be
near the contacts' mean. Parameters: two shifts of the foot and two tilts in a basis across the axis, and the radius
unless it is known.

Roots of minimal sets (`refined_roots`):

1. Every start takes a few steps of `least_squares.refined`.
2. Starts whose residuals are then larger than noise and _CYLINDER_IN_SIGHT allow are dropped: they are the real parts
   of complex zeros.
3. The others are refined to convergence. Roots within ONE_ROOT are one, and those that rounding scatters about one
   multiple root (`distinct_roots`).
"""

from dataclasses import field, replace

import numpy as np

from tactfix.geometry.arrays import TINY, Floats, Ints, basis_across, unit
from tactfix.localizers.candidate import ONE_ROOT
from tactfix.localizers.least_squares import polished, refined
from tactfix.values import frozen_value

_CYLINDER_SIGHT_STEPS, _CYLINDER_IN_SIGHT = 8, 1e-3
"""Residual (unit size) below which a start near a root is after _CYLINDER_SIGHT_STEPS: even at a triple root, where
each step reduces the distance by a third, 8 steps reduce the cubic residuals by (2/3)^24 = 6e-5."""


@frozen_value
class CylinderProblem:
    """Contacts (n, 3) and weights (n,), or (B, n, 3) and (B, n) with one set per state.

    Residuals are weight * (distance from the axis - radius - extra); extra (n,): additional offset of each contact,
    zero if all have one tip.
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
        # A contact on the axis has no radial direction: its derivative is zero.
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
        """The states (B, 7) near simple roots after so many Newton steps, for as many contacts as parameters."""
        return polished(self.evaluate, self.step, states, steps)


def refined_roots(problem: CylinderProblem, states: Floats, slack: Floats | float) -> tuple[Floats, Ints]:
    """The roots that starts (B, 7) lead to, for problems with as many contacts as parameters.

    slack, a number or (B,): residual that noise may leave, in problems of unit size. Returns states (k, 7) and the
    indices (k,) of their starts.
    """
    # Steps 1 to 3.
    states = problem.refined(states, _CYLINDER_SIGHT_STEPS)
    misses = np.abs(problem.evaluate(states, np.arange(len(states)))[0]).max(axis=1, initial=0.0)
    near = np.flatnonzero(misses <= np.maximum(_CYLINDER_IN_SIGHT, 30 * slack))
    points = problem.points[near] if problem.points.ndim == 3 else problem.points
    return replace(problem, points=points).refined(states[near]), near


def circle_states(directions: Floats, points: Floats, weights: Floats) -> Floats:
    """The state (B, 7) of the best circle through the contacts projected along each direction (B, 3) (fig. 5).

    Linear least squares over all contacts: |x x s|^2 - 2 f . x = constant. points (n, 3) or (B, n, 3), weights (n,).
    nan for a direction along which the contacts fall on one line.
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
"""Distance of two axes (unit size, or sine) beyond which they are never taken for one scattered multiple root:
rounding of 1e-15 scatters even a root of order six by its sixth root, 3e-3, only."""

_MULTIPLE_ROOT_CONTACTS = 24
"""Contacts above which multiple roots are not considered: residuals of many well spread contacts do not vanish to
higher order together. As many as the search uses (`cylinder._SAMPLE`)."""

_LARGEST_RADIUS = 1e5
"""Largest radius in units of the contacts' extent. Contacts of extent 1 on a larger cylinder are 1 / (8 * 1e5) =
1e-6 from a plane, and rounding times the radius leaves no more than ten digits of it."""


def distinct(states: Floats, cost: Floats) -> list[int]:
    """The indices of states (B, 7) that are distinct surfaces, in order of cost."""
    same = _distances(states) < ONE_ROOT
    passed = ~np.isfinite(cost) | (np.abs(states[:, 6]) >= _LARGEST_RADIUS)
    kept: list[int] = []
    for i in np.argsort(cost, kind="stable").tolist():
        if not passed[i]:
            kept.append(i)
            passed |= same[i]
    return kept


def distinct_roots(problem: CylinderProblem, states: Floats, cost: Floats, rounding: float) -> list[int]:
    """The same for refined states; those that rounding scatters about one multiple root count once.

    At a distance d from a root of order k the residuals are of size d^k and the smallest singular value of their
    Jacobian is of size d^(k-1). So rounding divided by that singular value is the scatter of such a root. For simple
    roots, and for two that are merely close, it is negligible. rounding: of a residual, in the problem's unit; problem:
    one set of contacts.
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
