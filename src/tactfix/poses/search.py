"""All zeros of the pose equations: damped descents from coverings of the poses, repeated around every zero found.

1. A covering of all rotations starts one descent from each (`starts`, `descent`). Each start has a translation that is
   off the best one by START_OFFSET.
2. Further coverings follow, each turned otherwise, until every zero has been met OFTEN.
3. Every zero is a centre of new starts, at all scales from 0.05 to 1.2 (rad, fixture sizes), until a round finds
   nothing new.
4. The zeros of six equations have to balance (`zeros`). If they do not, one is missing, and more coverings follow.
5. `complete` says whether all of that was reached.

Why this finds all. The rotations are a compact set, and for every rotation the translation follows from a linear
problem to within a few radii. So a zero is lost only if its basin of attraction lies between the starts. Basins differ:
with two or three cylinders and few contacts the smallest hold one start in a thousand, and a zero as rare as the rarest
known one is missed by step 2 once in some four hundred times. Zeros with still smaller basins mostly lie beyond a fold
of the equations, close to others, where step 3 starts. The symmetries of the fixture add the twins of each zero. The
rate of misses against an independent method that counts complex zeros is published in tests/README.md.

Constants of the search (here, and in `descent`, `starts` and `zeros`) were halved and doubled, tolerances changed by
ten, on trial problems: 168 with six exact contacts, two of each kind and layout of `tests.validation.pose_problems`.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.geometry.arrays import Bools, Floats
from tactfix.poses.descent import FIRST_LOOK, MOST_DESCENT_STEPS, descend
from tactfix.poses.equations import PoseEquations, centred_offsets
from tactfix.poses.starts import SIDES, around, covering
from tactfix.poses.zeros import Zeros, are_balanced, together
from tactfix.values import frozen_value

OFTEN = 6
"""Number of times that coverings must meet each zero for it to count as found. One as rare as the rarest known zero
is then missed once in 400 problems (e^-6)."""
MOST_COVERINGS = 6
"""Coverings, at most, in which every zero has to be met OFTEN. 3 and 12 give the same poses of the trial problems."""
MORE_COVERINGS = 24
"""Further coverings while a zero is known to be missing. 12 and 48 give the same poses of the trial problems."""
MOST_ROUNDS = 12
"""Rounds of starts around new zeros at most. 6 are enough for all trial problems."""
NEAR_LOOK = 7
"""Steps after which a descent that began near the rotation of a zero is abandoned if it is not in sight of one: half of
`descent.FIRST_LOOK`, since it starts nearer."""
MISSES_LOOKED_AT = 8
"""Nearest misses that are followed with all contacts."""


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
    meets, complete where it met each zero OFTEN.
    """
    search = _Search(equations, cost_limit, turns)
    zeros = search.of_coverings(starts, coverings if thorough else 0)  # steps 1 and 2
    if not thorough:
        return replace(zeros, complete=not zeros.continuum and not search.seldom(zeros).any())
    zeros = search.with_neighbours(zeros)  # step 3
    zeros = search.balanced(zeros, starts)  # step 4
    return replace(zeros, complete=zeros.complete and are_balanced(equations, zeros))  # step 5


def find_zeros_near(
    equations: PoseEquations,
    cost_limit: float,
    rotations: Floats,
    turns: Sequence[Floats] = (),
    around_all: bool = False,
    thorough: bool = True,
) -> Zeros:
    """The same where rotations (3, 3, N) near that of every zero are known: only zeros met once are looked around.

    around_all: around all of them, for rotations that are samples of more; without thorough around none, and samples of
    more are then never complete. Here a zero counts as found where it was met twice, not OFTEN: the rotations are those
    of all zeros, not chosen by chance.

    Each rotation starts with the translation that is best for it, and off that to all sides: a ball or bar whose centre
    the other features leave on a line is met from either end of it, and so both places where it may be are found.
    Beyond the limits of what is known beforehand the best translation alone starts, unless nothing is found within.
    """
    search = _Search(equations, cost_limit, turns)
    is_near = equations.domain.may_lead_into(rotations)
    zeros = search.met_near(rotations, is_near)
    if not is_near.all() and not search.wanted(zeros).any():
        zeros = search.met_near(rotations, np.ones_like(is_near))
    if thorough:
        return search.with_neighbours(zeros, around_all)
    zeros = zeros.merged(equations)
    met_once = search.wanted(zeros) & (zeros.counts < 2)
    return replace(zeros, complete=not (around_all or zeros.continuum or met_once.any()))


def nearest_misses(equations: PoseEquations, rotations: Floats, turns: Sequence[Floats] = ()) -> Zeros:
    """Minima of the residuals where descents met no zero, best first: what the most promising lead to, not all.

    One within the limit may be among them, where a weak motion makes the descents creep for longer than they may.
    """
    begun = descend(equations, rotations, centred_offsets(equations, rotations), np.inf, most_steps=FIRST_LOOK)
    promising = begun.best(4 * MISSES_LOOKED_AT)
    found = _Search(equations, np.inf, turns).met_from(promising.rotations, promising.offsets)
    return Zeros.none().joined(found).best(MISSES_LOOKED_AT)


def polish(
    equations: PoseEquations, zeros: Zeros, cost_limit: float = np.inf, most_steps: int = MOST_DESCENT_STEPS
) -> Zeros:
    """The local minima of the geometric residuals that each zero leads to, those that meet as one.

    Only those below cost_limit; without one every zero counts, wherever most_steps bring it.
    """
    found = descend(equations, zeros.rotations, zeros.offsets, cost_limit, geometric=True, most_steps=most_steps)
    return replace(Zeros.none().joined(found), complete=zeros.complete, continuum=zeros.continuum)


@frozen_value
class _Search:
    """What is searched: the equations, the cost up to which they hold, and the symmetries of the fixture."""

    equations: PoseEquations
    cost_limit: float
    turns: Sequence[Floats]

    def met_from(self, rotations: Floats, offsets: Floats, first_look: int = FIRST_LOOK) -> Zeros:
        """The ends of descents from rotations (3, 3, N), offsets (3, N), and their twins."""
        found = descend(self.equations, rotations, offsets, self.cost_limit, first_look=first_look)
        return found.with_twins(self.turns)

    def met_near(self, rotations: Floats, to_all_sides: Bools) -> Zeros:
        """What descents meet from rotations (3, 3, N) and the translation that is best; from all SIDES of those."""
        offsets = centred_offsets(self.equations, rotations)
        around = offsets[:, None, to_all_sides] + SIDES[:, 1:, None]
        aside = np.repeat(rotations[:, :, None, to_all_sides], SIDES.shape[1] - 1, axis=2)
        starts = np.concatenate([rotations, aside.reshape(3, 3, -1)], axis=2)
        offsets = np.concatenate([offsets, around.reshape(3, -1)], axis=1)
        return Zeros.none().joined(self.met_from(starts, offsets, NEAR_LOOK))

    def of_coverings(self, starts: int, least: int) -> Zeros:
        """What coverings meet: at least so many, until each zero has been met OFTEN; one where least is 0."""
        zeros = Zeros.none()
        for number in range(MOST_COVERINGS):
            zeros = zeros.joined(self.met_from(*covering(self.equations, starts, number))).merged(self.equations)
            if zeros.continuum or not least:
                break
            if number + 1 >= least and not self.seldom(zeros).any():
                break
        return zeros

    def seldom(self, zeros: Zeros) -> Bools:
        """Which were met less than OFTEN, of those that are looked for."""
        return self.wanted(zeros) & (zeros.met_nearby() < OFTEN * (1 + len(self.turns)))

    def with_neighbours(self, zeros: Zeros, around_all: bool = True) -> Zeros:
        """The zeros and what is found around them: around all, or those met once; then around what is new."""
        zeros = zeros.merged(self.equations)
        fresh = zeros if around_all else zeros.best(0)
        for number in range(MOST_ROUNDS):
            fresh = fresh.subset(self.wanted(fresh))
            centres = together([fresh, zeros.subset((zeros.counts < 2) & self.wanted(zeros))])
            if not len(centres) or zeros.continuum:
                break
            before = len(zeros)
            found = self.met_from(*around(self.equations.domain, centres, number))
            zeros = zeros.joined(found).merged(self.equations)
            fresh = zeros.since(before)
        are_settled = not len(fresh) and bool((zeros.counts >= 2)[self.wanted(zeros)].all())
        return replace(zeros, complete=are_settled and not zeros.continuum)

    def balanced(self, zeros: Zeros, starts: int) -> Zeros:
        """The zeros, and what more coverings meet as long as one is known to be missing."""
        for number in range(MOST_COVERINGS, MOST_COVERINGS + MORE_COVERINGS):
            if zeros.continuum or are_balanced(self.equations, zeros):
                break
            known = replace(zeros, counts=np.full(len(zeros), 2))
            more = known.joined(self.met_from(*covering(self.equations, starts, number)))
            if len(more) > len(zeros):
                zeros = self.with_neighbours(more)
        return zeros

    def wanted(self, zeros: Zeros) -> Bools:
        """Which zeros are searched for; descents may find others, which are kept."""
        return self.equations.domain.has(zeros.rotations, zeros.offsets)
