"""All zeros of the pose equations: damped descents from coverings of the poses, repeated around what it finds.

Why this finds all. The unknown rotation lives on a compact set, and for every rotation the translation follows from
a linear problem to within a few radii. A low-discrepancy covering of the rotations, each with a translation off that
one by OFF_CENTRE, starts one damped descent each (`descent`), so a zero is lost only if its basin falls through
the covering. Basins differ: with two or three cylinders and few contacts the smallest hold one start in a
thousand. So coverings, each turned otherwise, follow one another until every zero found has been met OFTEN: one as rare
as the rarest then stays unmet once in some four hundred times. What is rarer still lies mostly beyond a fold of the
equations, close to others: every zero found is a centre for new starts at all scales from 0.05 to 1.2 (rad,
and fixture sizes), until a round finds nothing new. The zeros of six equations then have to balance (`balance`):
where they do not, one is missing, and coverings go on. `complete` says whether all that was reached. The symmetries of
the fixture add the twins of each zero by exact motions. The rate of misses against an independent method that counts
complex zeros stands in the README.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactfix.geometry.arrays import TINY, Bools, Floats, Ints
from tactfix.poses.balance import are_balanced
from tactfix.poses.descent import FIRST_LOOK, MOST_STEPS, descend
from tactfix.poses.equations import PoseEquations, centred_offsets, evaluate
from tactfix.poses.starts import SIDES, around, covering

OFTEN = 6
MOST_COVERINGS = 6
MORE_COVERINGS = 24
"""Coverings after those, while a zero is known to be missing."""
MOST_ROUNDS = 12
MOST_ZEROS = 600
"""More zeros than any minimal problem has (512 complex ones for six cylinders): a continuum, not a set of poses."""


@dataclass(frozen=True, slots=True, eq=False)
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


def find_zeros(
    equations: PoseEquations, cost_limit: float, starts: int, turns: Sequence[Floats] = (), coverings: int = 1
) -> Zeros:
    """Every pose where the equations hold to within cost_limit (sum of squared weighted residuals).

    starts: how many rotations cover all of them; coverings: at least so many. Lengths must be scaled so that contacts
    and fixture have size about 1. turns: rotations (3, 3) about the fixture's origin that lay each surface on itself.
    Deterministic: the same call gives the same poses in the same order.
    """
    kept, counts = np.zeros((0, 13)), np.zeros(0, dtype=np.intp)
    often = OFTEN * (1 + len(turns))
    for number in range(MOST_COVERINGS):
        found = descend(equations, *covering(equations, starts, number), cost_limit)
        kept, counts = _distinct(_with_twins(found, turns), kept, counts)
        kept, counts, continuum = _gathered(equations, kept, counts)
        if continuum or (number + 1 >= coverings and (_met_nearby(kept, counts) >= often).all()):
            break
    zeros = _with_neighbours(equations, cost_limit, turns, kept, counts)
    for number in range(MOST_COVERINGS, MOST_COVERINGS + MORE_COVERINGS):
        if zeros.continuum or _are_all(equations, zeros):
            break
        found = _with_twins(descend(equations, *covering(equations, starts, number), cost_limit), turns)
        poses, met = zeros.poses, np.full(len(zeros.costs), 2)
        kept, counts = _distinct(found, poses, met)
        if len(kept) > len(poses):
            zeros = _with_neighbours(equations, cost_limit, turns, kept, counts)
    return replace(zeros, complete=zeros.complete and _are_all(equations, zeros))


def _are_all(equations: PoseEquations, zeros: Zeros) -> bool:
    return are_balanced(equations, zeros.rotations, zeros.offsets, zeros.costs)


def find_zeros_near(
    equations: PoseEquations,
    cost_limit: float,
    rotations: Floats,
    turns: Sequence[Floats] = (),
    around_all: bool = False,
) -> Zeros:
    """The same where rotations (3, 3, N) near that of every zero are known: only zeros met once are looked around.

    around_all: around all of them, for rotations that are samples of more.

    Each rotation starts with the translation that is best for it, and off that to all sides: a ball or bar whose centre
    the other features leave on a line is met from either end of it, and so both places where it may be are found.
    """
    offsets = centred_offsets(equations, rotations)[:, None] + SIDES[:, :, None]
    starts = np.repeat(rotations[:, :, None], SIDES.shape[1], axis=2).reshape(3, 3, -1)
    found = descend(equations, starts, offsets.reshape(3, -1), cost_limit, first_look=NEAR_LOOK)
    kept, counts = _distinct(_with_twins(found, turns), np.zeros((0, 13)), np.zeros(0, dtype=np.intp))
    return _with_neighbours(equations, cost_limit, turns, kept, counts, around_all)


def _with_neighbours(
    equations: PoseEquations,
    cost_limit: float,
    turns: Sequence[Floats],
    kept: Floats,
    counts: Ints,
    around_all: bool = True,
) -> Zeros:
    """Those (k, 13), met counts (k,) times, and what is found around them."""
    kept, counts, continuum = _gathered(equations, kept, counts)
    fresh = kept if around_all else kept[:0]
    for number in range(MOST_ROUNDS):
        centres = np.concatenate([fresh, kept[counts < 2]])
        if not len(centres) or continuum:
            break
        before = len(kept)
        found = _with_twins(descend(equations, *around(centres, number), cost_limit), turns)
        kept, counts = _distinct(found, kept, counts)
        kept, counts, continuum = _gathered(equations, kept, counts)
        fresh = kept[before:]
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


def nearest_misses(equations: PoseEquations, rotations: Floats, turns: Sequence[Floats] = ()) -> Zeros:
    """Minima of the residuals where descents met no zero, best first: what the most promising lead to, not all.

    One within the limit may be among them, where a weak motion makes the descents creep for longer than they may.
    """
    begun = descend(equations, rotations, centred_offsets(equations, rotations), np.inf, most_steps=FIRST_LOOK)
    promising = begun[np.argsort(begun[:, 12])[: 4 * MISSES]]
    found = _with_twins(descend(equations, *_split(promising)[:2], np.inf), turns)
    kept, _ = _distinct(found, np.zeros((0, 13)), np.zeros(0, dtype=np.intp))
    return Zeros(*_split(kept[np.argsort(kept[:, 12])[:MISSES]]), complete=False, continuum=False)


def _gathered(equations: PoseEquations, poses: Floats, counts: Ints) -> tuple[Floats, Ints, bool]:
    """The poses (k, 13), met counts (k,) times, and whether they are samples of a free motion.

    They are where they are too many, or those with a singular Jacobian are too many and stretch on and on. Around a
    multiple zero the ends of descents scatter: those with a singular Jacobian that lie close together become one, the
    first one met.
    """
    if len(equations) < 6 or len(poses) > MOST_ZEROS:
        return poses, counts, True
    rotations, offsets, _ = _split(poses)
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


def _held(equations: PoseEquations, rotations: Floats, offsets: Floats) -> Floats:
    """How well poses are held (k,): the smallest singular value of the Jacobian over the largest."""
    if len(equations) < 6:
        return np.zeros(rotations.shape[-1])
    _, jacobian = evaluate(equations, rotations, offsets, geometric=False)
    values = np.linalg.svd(np.moveaxis(jacobian, -1, 0), compute_uv=False)
    return np.asarray(values[:, -1] / np.maximum(values[:, 0], TINY))


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


def together(parts: Sequence[Zeros]) -> Zeros:
    """All of them in one; complete and continuum as of the first."""
    rotations, offsets, costs = (
        np.concatenate([getattr(part, name) for part in parts], axis=-1) for name in ("rotations", "offsets", "costs")
    )
    return Zeros(rotations, offsets, costs, parts[0].complete, parts[0].continuum)


def polish(equations: PoseEquations, zeros: Zeros, cost_limit: float = np.inf, most_steps: int = MOST_STEPS) -> Zeros:
    """The local minima of the geometric residuals that each zero leads to, those that meet as one.

    Only those below cost_limit; without one every zero counts, wherever most_steps bring it.
    """
    found = descend(equations, zeros.rotations, zeros.offsets, cost_limit, geometric=True, most_steps=most_steps)
    kept, _ = _distinct(found, np.zeros((0, 13)), np.zeros(0, dtype=np.intp))
    return Zeros(*_split(kept), complete=zeros.complete, continuum=zeros.continuum)


def _split(poses: Floats) -> tuple[Floats, Floats, Floats]:
    """Rotations (3, 3, k), offsets (3, k), costs (k,) of poses (k, 13)."""
    return poses[:, :9].T.reshape(3, 3, -1), poses[:, 9:12].T, poses[:, 12]


def _distinct(found: Floats, kept: Floats, counts: Ints) -> tuple[Floats, Ints]:
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


def _met_nearby(kept: Floats, counts: Ints) -> Ints:
    """How often zeros next to each were met: the ends at a nearly multiple one scatter."""
    gaps = np.abs(kept[:, None, :12] - kept[None, :, :12]).max(axis=2)
    return np.asarray((gaps < NEARBY) @ counts)


def _same(poses: Floats, pose: Floats) -> Bools:
    return np.asarray(np.abs(poses[:, :12] - pose[:12]).max(axis=1) < SAME_POSE)


MOST_FIRM = 128
"""Poses that are held beside a continuum; more of them are samples of one that is not quite free."""

NEAR_LOOK = 7
"""Steps after which a descent that began near the rotation of a zero is in sight of one."""

MISSES = 8
"""Nearest misses that are looked at again with all contacts."""

SINGULAR = 1e-5
"""Ratio of singular values below which a pose is a double root or one of a continuum, ..."""
SCATTER = 0.02
"""Largest entry by which the ends of descents to one multiple zero differ: at one of order four, a few thousandths."""
MOST_SINGULAR = 12
"""... which it is when there are more of them than double roots in any problem."""

SAME_POSE = 1e-5
"""Largest entry by which two meetings of one zero differ: far above what convergence leaves, far below two zeros."""

NEARBY = 0.05
"""The same for zeros that noise, or rounding at a multiple one, may have made of one."""
