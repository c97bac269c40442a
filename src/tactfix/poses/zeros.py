"""Zeros of the pose equations as descents meet them: which are the same, how often each was met, what is a free motion.

Poses are rows (k, 13) here: rotation and offset of fixture_from_base, and the cost.
"""

from collections.abc import Sequence

import numpy as np

from tactfix.geometry.arrays import TINY, Bools, Floats, Ints
from tactfix.poses.equations import PoseEquations, evaluate
from tactfix.values import frozen_value

MOST_ZEROS = 600
"""More zeros than any minimal problem has (512 complex ones for six cylinders): a continuum, not a set of poses."""
SAME_POSE = 1e-5
"""Largest entry by which two meetings of one zero differ: far above what convergence leaves, far below two zeros."""
NEARBY = 0.05
"""The same for zeros that noise, or rounding at a multiple one, may have made of one."""
SINGULAR = 1e-5
"""Ratio of singular values below which a pose is a double root or one of a continuum, ..."""
SCATTER = 0.02
"""Largest entry by which the ends of descents to one multiple zero differ: at one of order four, a few thousandths."""
MOST_SINGULAR = 12
"""... which it is when there are more of them than double roots in any problem."""
MOST_FIRM = 128
"""Poses that are held beside a continuum; more of them are samples of one that is not quite free."""


@frozen_value
class Zeros:
    """fixture_from_base poses: rotations (3, 3, k), offsets (3, k), costs (k,): sums of squared weighted residuals.

    complete: the last round found nothing new, every pose was met at least twice, and those of six equations balance.
    continuum: so many that they are samples of a free motion.
    """

    rotations: Floats
    offsets: Floats
    costs: Floats
    complete: bool
    continuum: bool

    @property
    def poses(self) -> Floats:
        """Rotation, offset and cost of each (k, 13)."""
        return np.concatenate([self.rotations.reshape(9, -1), self.offsets, self.costs[None]]).T

    def best(self, most: int) -> "Zeros":
        """At most so many of them, those of the lowest costs."""
        return self.subset(np.argsort(self.costs, kind="stable")[:most])

    def subset(self, index: Ints) -> "Zeros":
        """Those with these numbers."""
        return Zeros(
            self.rotations[..., index], self.offsets[:, index], self.costs[index], self.complete, self.continuum
        )


def together(parts: Sequence[Zeros]) -> Zeros:
    """All of them in one; complete and continuum as of the first."""
    rotations, offsets, costs = (
        np.concatenate([getattr(part, name) for part in parts], axis=-1) for name in ("rotations", "offsets", "costs")
    )
    return Zeros(rotations, offsets, costs, parts[0].complete, parts[0].continuum)


def split(poses: Floats) -> tuple[Floats, Floats, Floats]:
    """Rotations (3, 3, k), offsets (3, k), costs (k,) of poses (k, 13)."""
    return poses[:, :9].T.reshape(3, 3, -1), poses[:, 9:12].T, poses[:, 12]


def with_twins(poses: Floats, turns: Sequence[Floats]) -> Floats:
    """The poses (k, 13), and behind them those that each symmetry of the fixture makes of them."""
    rotations, offsets, costs = split(poses)
    twins = [
        np.concatenate([np.einsum("ab,bcN->acN", turn, rotations).reshape(9, -1), turn @ offsets, costs[None]]).T
        for turn in turns
    ]
    return np.concatenate([poses, *twins])


def distinct(found: Floats, kept: Floats, counts: Ints) -> tuple[Floats, Ints]:
    """kept (k, 13) with the new ones of found (m, 13) behind, and how often each was met."""
    counts = counts.copy()
    for number, pose in enumerate(kept):
        same = _same(found, pose)
        counts[number] += int(same.sum())
        found = found[~same]
    fresh, met = [kept], [counts]
    for _ in range(MOST_ZEROS + 1 - len(kept)):
        if not len(found):
            break
        same = _same(found, found[0])
        fresh.append(found[:1])
        met.append(np.array([same.sum()]))
        found = found[~same]
    return np.concatenate(fresh), np.concatenate(met)


def met_nearby(kept: Floats, counts: Ints) -> Ints:
    """How often zeros next to each were met: the ends at a nearly multiple one scatter."""
    gaps = np.abs(kept[:, None, :12] - kept[None, :, :12]).max(axis=2)
    return np.asarray((gaps < NEARBY) @ counts)


def _same(poses: Floats, pose: Floats) -> Bools:
    return np.asarray(np.abs(poses[:, :12] - pose[:12]).max(axis=1) < SAME_POSE)


def gathered(equations: PoseEquations, poses: Floats, counts: Ints) -> tuple[Floats, Ints, bool]:
    """The poses (k, 13), met counts (k,) times, and whether they are samples of a free motion.

    They are where they are too many, or those with a singular Jacobian are too many and stretch on and on. Around a
    multiple zero the ends of descents scatter: those with a singular Jacobian that lie close together become one, the
    first one met.
    """
    if equations.dof < 0 or len(poses) > MOST_ZEROS:
        return poses, counts, True
    rotations, offsets, _ = split(poses)
    loose = np.flatnonzero(_held(equations, rotations, offsets) < SINGULAR)
    centres: list[int] = []
    stays, counts = np.ones(len(poses), dtype=bool), counts.copy()
    for number in loose.tolist():
        gaps = np.abs(poses[centres, :12] - poses[number, :12]).max(axis=1)
        if gaps.min(initial=np.inf) > SCATTER:
            centres.append(number)
        else:
            stays[number] = False
            counts[centres[int(np.argmin(gaps))]] += counts[number]
    if len(centres) > MOST_SINGULAR:
        return poses, counts, True
    return poses[stays], counts[stays], False


def sampled(equations: PoseEquations, zeros: Zeros, most: int) -> Zeros:
    """Of a continuum at most so many, spread over the list, and beside it the poses that are held.

    Contacts in a special position may leave a motion free in some poses and not in others: the true one is any of them.
    """
    held = _held(equations, zeros.rotations, zeros.offsets)
    count = int((held >= SINGULAR).sum())
    firm = np.argsort(-held, kind="stable")[: count if count <= MOST_FIRM else most]
    loose = np.flatnonzero(held < SINGULAR)
    spread = np.linspace(0, len(loose) - 1, min(most, len(loose))).astype(np.intp)
    return zeros.subset(np.concatenate([firm, loose[spread]]))


def _held(equations: PoseEquations, rotations: Floats, offsets: Floats) -> Floats:
    """How well poses are held (k,): the smallest singular value of the Jacobian over the largest.

    Where directions are held it may be the only one, and the contacts' weights say how large it should be.
    """
    if equations.dof < 0:
        return np.zeros(rotations.shape[-1])
    _, jacobian = evaluate(equations, rotations, offsets, geometric=False)
    values = np.linalg.svd(np.moveaxis(jacobian, -1, 0), compute_uv=False)
    least = TINY if equations.domain.is_free else np.linalg.norm(equations.weights)
    return np.asarray(values[:, -1] / np.maximum(values[:, 0], least))
