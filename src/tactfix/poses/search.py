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
complex zeros stands in tests/README.md.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.poses.balance import are_balanced
from tactfix.poses.descent import FIRST_LOOK, MOST_STEPS, descend
from tactfix.poses.equations import PoseEquations, centred_offsets
from tactfix.poses.starts import SIDES, around, covering
from tactfix.poses.zeros import Zeros, distinct, gathered, met_nearby, split, with_twins

OFTEN = 6
MOST_COVERINGS = 6
MORE_COVERINGS = 24
"""Coverings after those, while a zero is known to be missing."""
MOST_ROUNDS = 12
NEAR_LOOK = 7
"""Steps after which a descent that began near the rotation of a zero is in sight of one."""
MISSES = 8
"""Nearest misses that are looked at again with all contacts."""


def find_zeros(
    equations: PoseEquations,
    cost_limit: float,
    starts: int,
    turns: Sequence[Floats] = (),
    coverings: int = 1,
    thorough: bool = True,
) -> Zeros:
    """Every pose where the equations hold to within cost_limit (sum of squared weighted residuals).

    starts: how many rotations cover those of the domain; coverings: at least so many. Lengths must be scaled so that
    contacts and fixture have size about 1. turns: rotations (3, 3) about the fixture's origin that lay each surface on
    itself. Deterministic: the same call gives the same poses in the same order. Without thorough only what one covering
    meets.
    """
    kept, counts = np.zeros((0, 13)), np.zeros(0, dtype=np.intp)
    often = OFTEN * (1 + len(turns))
    for number in range(MOST_COVERINGS):
        found = descend(equations, *covering(equations, starts, number), cost_limit)
        kept, counts = distinct(with_twins(found, turns), kept, counts)
        kept, counts, continuum = gathered(equations, kept, counts)
        seldom = _within(equations, kept) & (met_nearby(kept, counts) < often)
        if continuum or not thorough or (number + 1 >= coverings and not seldom.any()):
            break
    if not thorough:
        return Zeros(*split(kept), complete=False, continuum=continuum)
    zeros = _with_neighbours(equations, cost_limit, turns, kept, counts)
    for number in range(MOST_COVERINGS, MOST_COVERINGS + MORE_COVERINGS):
        if zeros.continuum or _are_all(equations, zeros):
            break
        found = with_twins(descend(equations, *covering(equations, starts, number), cost_limit), turns)
        poses, met = zeros.poses, np.full(len(zeros.costs), 2)
        kept, counts = distinct(found, poses, met)
        if len(kept) > len(poses):
            zeros = _with_neighbours(equations, cost_limit, turns, kept, counts)
    return replace(zeros, complete=zeros.complete and _are_all(equations, zeros))


def _within(equations: PoseEquations, poses: Floats) -> Bools:
    """Which poses (k, 13) are looked for; others within reach of the descents are taken as they come."""
    rotations, offsets, _ = split(poses)
    return equations.domain.has(rotations, offsets)


def _are_all(equations: PoseEquations, zeros: Zeros) -> bool:
    return are_balanced(equations, zeros.rotations, zeros.offsets, zeros.costs)


def find_zeros_near(
    equations: PoseEquations,
    cost_limit: float,
    rotations: Floats,
    turns: Sequence[Floats] = (),
    around_all: bool = False,
    thorough: bool = True,
) -> Zeros:
    """The same where rotations (3, 3, N) near that of every zero are known: only zeros met once are looked around.

    around_all: around all of them, for rotations that are samples of more; without thorough around none.

    Each rotation starts with the translation that is best for it, and off that to all sides: a ball or bar whose centre
    the other features leave on a line is met from either end of it, and so both places where it may be are found.
    """
    offsets = centred_offsets(equations, rotations)[:, None] + SIDES[:, :, None]
    starts = np.repeat(rotations[:, :, None], SIDES.shape[1], axis=2).reshape(3, 3, -1)
    found = descend(equations, starts, offsets.reshape(3, -1), cost_limit, first_look=NEAR_LOOK)
    kept, counts = distinct(with_twins(found, turns), np.zeros((0, 13)), np.zeros(0, dtype=np.intp))
    if not thorough:
        kept, counts, continuum = gathered(equations, kept, counts)
        return Zeros(*split(kept), complete=False, continuum=continuum)
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
    kept, counts, continuum = gathered(equations, kept, counts)
    fresh = kept if around_all else kept[:0]
    for number in range(MOST_ROUNDS):
        fresh = fresh[_within(equations, fresh)]
        centres = np.concatenate([fresh, kept[(counts < 2) & _within(equations, kept)]])
        if not len(centres) or continuum:
            break
        before = len(kept)
        found = with_twins(descend(equations, *around(equations.domain, centres, number), cost_limit), turns)
        kept, counts = distinct(found, kept, counts)
        kept, counts, continuum = gathered(equations, kept, counts)
        fresh = kept[before:]
    complete = not len(fresh) and bool((counts >= 2)[_within(equations, kept)].all())
    return Zeros(*split(kept), complete=complete and not continuum, continuum=continuum)


def nearest_misses(equations: PoseEquations, rotations: Floats, turns: Sequence[Floats] = ()) -> Zeros:
    """Minima of the residuals where descents met no zero, best first: what the most promising lead to, not all.

    One within the limit may be among them, where a weak motion makes the descents creep for longer than they may.
    """
    begun = descend(equations, rotations, centred_offsets(equations, rotations), np.inf, most_steps=FIRST_LOOK)
    promising = begun[np.argsort(begun[:, 12])[: 4 * MISSES]]
    found = with_twins(descend(equations, *split(promising)[:2], np.inf), turns)
    kept, _ = distinct(found, np.zeros((0, 13)), np.zeros(0, dtype=np.intp))
    return Zeros(*split(kept[np.argsort(kept[:, 12])[:MISSES]]), complete=False, continuum=False)


def polish(equations: PoseEquations, zeros: Zeros, cost_limit: float = np.inf, most_steps: int = MOST_STEPS) -> Zeros:
    """The local minima of the geometric residuals that each zero leads to, those that meet as one.

    Only those below cost_limit; without one every zero counts, wherever most_steps bring it.
    """
    found = descend(equations, zeros.rotations, zeros.offsets, cost_limit, geometric=True, most_steps=most_steps)
    kept, _ = distinct(found, np.zeros((0, 13)), np.zeros(0, dtype=np.intp))
    return Zeros(*split(kept), complete=zeros.complete, continuum=zeros.continuum)
