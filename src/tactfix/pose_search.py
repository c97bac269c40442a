"""All zeros of the pose equations: damped Newton from a covering of the rotations, repeated around what it finds.

Why this finds all. The unknown rotation lives on a compact set, and for every rotation the translation follows from
a linear problem to within a few radii. A low-discrepancy covering of the rotations by START_ROTATIONS points starts
one damped Newton (Levenberg-Marquardt) descent each, so a zero is lost only if its basin falls through the
covering: the zeros of two or three cylinders with few contacts do, in about one of a hundred. Such zeros are never
alone: they lie close to others, beyond a fold of the equations. So every zero found is a centre for NEIGHBOURS new
starts at all scales from 0.05 to 1.2 (rad, and fixture sizes), rounds go on until one finds nothing new and every
zero has been met twice (the Good-Turing estimate of what has not been seen is the number met once). `complete` says
whether that was reached. The symmetries of the fixture add the twins of each zero by exact motions. The rate of
misses against an independent method that counts complex zeros stands in the README.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.pose_equations import PoseEquations, centred_offsets, evaluate

START_ROTATIONS = 1200
NEIGHBOURS = 32
MOST_ROUNDS = 12
MOST_ITERATIONS = 300
"""Nearly all descents end or are given up within 30; those towards a nearly singular pose creep along a valley."""
MOST_ZEROS = 600
"""More zeros than any minimal problem has (288 complex ones for two cylinders): a continuum, not a set of poses."""


@dataclass(frozen=True, slots=True, eq=False)
class Zeros:
    """fixture_from_base poses: rotations (3, 3, k), offsets (3, k), costs (k,): sums of squared weighted residuals.

    complete: the last round found nothing new and every pose was met at least twice. continuum: so many that they are
    samples of a free motion.
    """

    rotations: Floats
    offsets: Floats
    costs: Floats
    complete: bool
    continuum: bool

    def sample(self, most: int) -> "Zeros":
        """At most so many of them, spread over the list."""
        index = np.unique(np.linspace(0, len(self.costs) - 1, min(most, len(self.costs))).astype(np.intp))
        return Zeros(
            self.rotations[..., index], self.offsets[:, index], self.costs[index], self.complete, self.continuum
        )


def find_zeros(
    equations: PoseEquations, cost_limit: float, starts: int = START_ROTATIONS, turns: Sequence[Floats] = ()
) -> Zeros:
    """Every pose where the equations hold to within cost_limit (sum of squared weighted residuals).

    Lengths must be scaled so that contacts and fixture have size about 1. turns: rotations (3, 3) about the fixture's
    origin that lay each surface on itself. Deterministic: the same call gives the same poses in the same order.
    """
    rng = np.random.default_rng(20261122)
    rotations = rotations_from_quaternions(covering_quaternions(starts))
    found = _with_twins(descend(equations, rotations, centred_offsets(equations, rotations), cost_limit), turns)
    kept, counts = _distinct(found, np.zeros((0, 13)), np.zeros(0, dtype=np.intp))
    fresh = kept
    continuum = _is_continuum(equations, kept)
    for _ in range(MOST_ROUNDS):
        centres = np.concatenate([fresh, kept[counts < 2]])
        if not len(centres) or continuum:
            break
        before = len(kept)
        found = _with_twins(descend(equations, *_around(centres, rng), cost_limit), turns)
        kept, counts = _distinct(found, kept, counts)
        fresh = kept[before:]
        continuum = _is_continuum(equations, kept)
    complete = not len(fresh) and bool((counts >= 2).all())
    return Zeros(*_split(kept), complete=complete and not continuum, continuum=continuum)


def _with_twins(poses: Floats, turns: Sequence[Floats]) -> Floats:
    """The poses (k, 13), and behind them those that each symmetry of the fixture makes of them."""
    rotations, offsets, costs = _split(poses)
    twins = [
        np.concatenate([np.einsum("ab,bcN->acN", turn, rotations).reshape(9, -1), turn @ offsets, costs[None]]).T
        for turn in turns
    ]
    return np.concatenate([poses, *twins])


def nearest_misses(equations: PoseEquations, starts: int) -> Zeros:
    """Local minima of the residuals where there is no zero: one descent from each start, no claim to have all."""
    rotations = rotations_from_quaternions(covering_quaternions(starts))
    found = descend(equations, rotations, centred_offsets(equations, rotations), np.inf)
    best = found[np.argsort(found[:, 12])[:MISSES]]
    return Zeros(*_split(best), complete=True, continuum=False)


def _is_continuum(equations: PoseEquations, poses: Floats) -> bool:
    """Whether the poses (k, 13) are samples of a free motion: too many, or too many with a singular Jacobian."""
    if len(equations) < 6 or len(poses) > MOST_ZEROS:
        return True
    rotations, offsets, _ = _split(poses)
    _, jacobian = evaluate(equations, rotations, offsets, geometric=False)
    values = np.linalg.svd(np.moveaxis(jacobian, -1, 0), compute_uv=False)
    return int((values[:, -1] < SINGULAR * values[:, 0]).sum()) > MOST_SINGULAR


def polish(equations: PoseEquations, zeros: Zeros) -> Zeros:
    """The local minima of the geometric residuals that each zero leads to, those that meet as one."""
    found = descend(equations, zeros.rotations, zeros.offsets, np.inf, geometric=True)
    kept, _ = _distinct(found, np.zeros((0, 13)), np.zeros(0, dtype=np.intp))
    return Zeros(*_split(kept), complete=zeros.complete, continuum=zeros.continuum)


def _split(poses: Floats) -> tuple[Floats, Floats, Floats]:
    """Rotations (3, 3, k), offsets (3, k), costs (k,) of poses (k, 13)."""
    return poses[:, :9].T.reshape(3, 3, -1), poses[:, 9:12].T, poses[:, 12]


def covering_quaternions(count: int) -> Floats:
    """Unit quaternions (count, 4), scalar last, evenly spread (super-Fibonacci spiral, Alexa 2022)."""
    s = np.arange(count) + 0.5
    inner, outer = np.sqrt(s / count), np.sqrt(1 - s / count)
    # The two constants of the paper: sqrt 2 and the positive root of x^4 = x + 4.
    first, second = 2 * np.pi * s / np.sqrt(2.0), 2 * np.pi * s / 1.533751168755204288118041
    return np.stack([inner * np.sin(first), inner * np.cos(first), outer * np.sin(second), outer * np.cos(second)], 1)


def rotations_from_quaternions(quaternions: Floats) -> Floats:
    """Rotation matrices (3, 3, N) of unit quaternions (N, 4), scalar last, with the stack in the last place."""
    x, y, z, w = quaternions.T
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _turned(vectors: Floats, rotations: Floats) -> Floats:
    """Rotations (3, 3, N) turned by about the rotation vectors (3, N): Cayley's map, a rotation for any length."""
    quaternions = np.concatenate([vectors / 2, np.ones((1, vectors.shape[1]))])
    quaternions /= np.sqrt((quaternions**2).sum(axis=0))
    return np.asarray(np.einsum("ijN,jkN->ikN", rotations_from_quaternions(quaternions.T), rotations))


def _around(centres: Floats, rng: "np.random.Generator") -> tuple[Floats, Floats]:
    """NEIGHBOURS random poses around each of the centres (k, 13), at every scale."""
    poses = np.repeat(centres, NEIGHBOURS, axis=0).T
    step = rng.normal(size=(6, poses.shape[1]))
    step *= np.exp(rng.uniform(np.log(0.05), np.log(1.2), poses.shape[1])) / np.sqrt((step**2).sum(axis=0))
    return _turned(step[:3], poses[:9].reshape(3, 3, -1)), poses[9:12] + step[3:]


def _distinct(found: Floats, kept: Floats, counts: Ints) -> tuple[Floats, Ints]:
    """kept (k, 13) with the new ones of found (m, 13) behind, and how often each was met."""
    for pose in found:
        if len(kept):
            distance = np.abs(kept[:, :12] - pose[:12]).max(axis=1)
            nearest = int(np.argmin(distance))
            if distance[nearest] < SAME_POSE:
                counts[nearest] += 1
                continue
        if len(kept) > MOST_ZEROS:
            break
        kept, counts = np.concatenate([kept, pose[None]]), np.append(counts, 1)
    return kept, counts


MISSES = 8
"""Nearest misses that are looked at again with all contacts."""

SINGULAR = 1e-5
"""Ratio of singular values below which a pose is a double root or one of a continuum, ..."""
MOST_SINGULAR = 12
"""... which it is when there are more of them than double roots in any problem."""

SAME_POSE = 1e-5
"""Largest entry by which two meetings of one zero differ: far above what convergence leaves, far below two zeros."""


def descend(
    equations: PoseEquations, rotations: Floats, offsets: Floats, cost_limit: float, geometric: bool = False
) -> Floats:
    """Levenberg-Marquardt from each pose; those (k, 13) that end below cost_limit: rotation, offset, cost."""
    damping = np.full(offsets.shape[1], 1e-2)
    residual, jacobian = evaluate(equations, rotations, offsets, geometric)
    cost = (residual**2).sum(axis=0)
    ends = []
    for _ in range(MOST_ITERATIONS):
        with np.errstate(over="ignore", invalid="ignore"):
            step = _damped_step(residual, jacobian, damping)
            new_rotations, new_offsets = _turned(step[:3], rotations), offsets + step[3:]
            new_residual, new_jacobian = evaluate(equations, new_rotations, new_offsets, geometric)
            new_cost = (new_residual**2).sum(axis=0)
        # A start in a singular place may step to infinity: nan is never better.
        better = new_cost < cost
        gain = np.where(better, cost - new_cost, cost)
        rotations, offsets = np.where(better, new_rotations, rotations), np.where(better, new_offsets, offsets)
        residual, jacobian = np.where(better, new_residual, residual), np.where(better, new_jacobian, jacobian)
        small = np.abs(step).max(axis=0) < 1e-8
        damping = np.where(better, damping * 0.2, damping * 5)
        ended, stuck = _ends(np.where(better, new_cost, cost), gain, small, damping, cost_limit)
        cost = np.where(better, new_cost, cost)
        ends.append(np.concatenate([rotations[..., ended].reshape(9, -1), offsets[:, ended], cost[None, ended]]))
        go = ~(ended | stuck)
        if not go.any():
            break
        rotations, offsets, residual = rotations[..., go], offsets[:, go], residual[:, go]
        jacobian, cost, damping = jacobian[..., go], cost[go], damping[go]
    return np.concatenate(ends, axis=1).T


def _ends(cost: Floats, gain: Floats, small: Bools, damping: Floats, cost_limit: float) -> tuple[Bools, Bools]:
    """Which descents have arrived at a zero, and which are stuck above the limit."""
    # A zero of exact contacts ends at rounding level (1e-26), one of noisy contacts where the steps vanish.
    ended = (cost < 1e-26) | ((cost < cost_limit) & (small | (damping > 1e4)))
    stuck = (cost >= cost_limit) & ((damping > 1e4) | (gain < 1e-4 * cost))
    return ended, stuck


def _damped_step(residual: Floats, jacobian: Floats, damping: Floats) -> Floats:
    """The Levenberg-Marquardt steps (6, N), no longer than one radian or one fixture size."""
    normal = np.einsum("inN,jnN->ijN", jacobian, jacobian)
    gradient = np.einsum("inN,nN->iN", jacobian, residual)
    diagonal = np.einsum("iiN->iN", normal)
    diagonal += damping * (diagonal + 1e-9)
    step = -solve_positive(normal, gradient)
    return np.asarray(step / np.maximum(1.0, np.sqrt((step[:3] ** 2).sum(axis=0))))


def solve_positive(matrices: Floats, rhs: Floats) -> Floats:
    """x (m, N) with matrices x = rhs for positive definite matrices (m, m, N), rhs (m, N): Cholesky, all N at once.

    The loops run over the m rows; LAPACK's stack of small solves costs ten times as much at N = 1000.
    """
    m = len(rhs)
    factor = np.zeros_like(matrices)
    x = rhs.copy()
    for j in range(m):
        pivot = matrices[j, j] - (factor[j, :j] ** 2).sum(axis=0)
        factor[j, j] = np.sqrt(np.maximum(pivot, np.finfo(float).tiny))
        below = matrices[j + 1 :, j] - np.einsum("ikN,kN->iN", factor[j + 1 :, :j], factor[j, :j])
        factor[j + 1 :, j] = below / factor[j, j]
        x[j] = (x[j] - (factor[j, :j] * x[:j]).sum(axis=0)) / factor[j, j]
    for j in reversed(range(m)):
        x[j] = (x[j] - (factor[j + 1 :, j] * x[j + 1 :]).sum(axis=0)) / factor[j, j]
    return x
