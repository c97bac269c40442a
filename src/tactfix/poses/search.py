"""All zeros of the pose equations: damped descents from coverings of the poses, repeated around every zero found.

1. A covering of all rotations starts one descent from each (`starts`, `descent`). Each start has a translation that is
   off the best one by START_OFFSET.
2. Further coverings follow, each rotated differently, until every zero has been met OFTEN.
3. Every zero is a centre of new starts, at all scales from 0.05 to 1.2 (rad, fixture sizes), until a round finds
   nothing new.
4. The zeros of six equations have to balance (`zeros`). If they do not, one is missing, and more coverings follow.
5. `complete` is true if all of these criteria were met.

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
from tactfix.poses.starts import SIDES, FeatureRotations, around, covering
from tactfix.poses.zeros import Zeros, are_balanced, together
from tactfix.values import frozen_value

OFTEN = 6
"""Number of times that coverings must meet each zero for it to count as found. One as rare as the rarest known zero
is then missed once in 400 problems (e^-6)."""
MOST_COVERINGS = 6
"""Most coverings until every zero was met OFTEN. 3 and 12 give the same poses of the trial problems."""
MORE_COVERINGS = 24
"""Further coverings while a zero is known to be missing. 12 and 48 give the same poses of the trial problems."""
MOST_ROUNDS = 12
"""Most rounds of starts around new zeros. 6 are enough for all trial problems."""
NEAR_LOOK = 7
"""`descent.FIRST_LOOK` for descents that start near the rotation of a zero: half of it."""
MISSES_LOOKED_AT = 8
"""Number of nearest misses that are refined."""


def find_zeros(
    equations: PoseEquations,
    cost_limit: float,
    starts: int,
    turns: Sequence[Floats] = (),
    coverings: int = 1,
    thorough: bool = True,
) -> Zeros:
    """Every pose where the equations hold to within cost_limit (sum of squared weighted residuals).

    starts: rotations in a covering of the domain; coverings: their least number. Lengths must be scaled: contacts and
    fixture have size about 1. turns: rotations (3, 3) about the fixture's origin that map each surface onto itself.
    Deterministic: the same call gives the same poses in the same order. Without thorough: the zeros that one covering
    meets, complete if it met each OFTEN.
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
    rotations: FeatureRotations,
    turns: Sequence[Floats] = (),
    thorough: bool = True,
) -> Zeros:
    """The same with known rotations near that of every zero; new starts only around zeros that were met once.

    Rotations that are samples of a set have new starts around all zeros. Without thorough: no new starts; for samples
    the result is then never complete. A zero counts as found if it was met twice, not OFTEN: the rotations are those of
    all zeros, not chosen at random.

    Each rotation starts with its best translation, and from START_OFFSET to all sides of it: if the other features
    leave the centre of a ball or bar on a line, both of its places on the line are found. If the features fix the
    place, and a placement gives it, that is the only other start. Beyond the limits of a placement only the best
    translation starts, unless nothing is found within.
    """
    search = _Search(equations, cost_limit, turns)
    is_near = equations.domain.may_lead_into(rotations.matrices)
    zeros = search.met_near(rotations, is_near)
    if not is_near.all() and not search.wanted(zeros).any():
        zeros = search.met_near(rotations, np.ones_like(is_near))
    if thorough:
        return search.with_neighbours(zeros, rotations.are_samples)
    zeros = zeros.merged(equations)
    is_open = rotations.are_samples or zeros.continuum or search.met_once(zeros).any()
    return replace(zeros, complete=not is_open)


def nearest_misses(equations: PoseEquations, rotations: Floats, turns: Sequence[Floats] = ()) -> Zeros:
    """Minima of the residuals that the most promising descents lead to, best first, for searches that met no zero.

    One may be within the limit: if a motion is weakly determined, descents may need more steps than a search allows.
    """
    begun = descend(equations, rotations, centred_offsets(equations, rotations), np.inf, most_steps=FIRST_LOOK)
    promising = begun.best(4 * MISSES_LOOKED_AT)
    found = _Search(equations, np.inf, turns).met_from(promising.rotations, promising.offsets)
    return Zeros.none().joined(found).best(MISSES_LOOKED_AT)


def polish(
    equations: PoseEquations, zeros: Zeros, cost_limit: float = np.inf, most_steps: int = MOST_DESCENT_STEPS
) -> Zeros:
    """The local minima of the geometric residuals that the zeros lead to, equal ones merged.

    Only those below cost_limit; without a limit all, as they are after most_steps.
    """
    found = descend(equations, zeros.rotations, zeros.offsets, cost_limit, geometric=True, most_steps=most_steps)
    return replace(Zeros.none().joined(found), complete=zeros.complete, continuum=zeros.continuum)


@frozen_value
class _Search:
    """The arguments of a search: equations, cost limit, and symmetries of the fixture."""

    equations: PoseEquations
    cost_limit: float
    turns: Sequence[Floats]

    def met_from(self, rotations: Floats, offsets: Floats, first_look: int = FIRST_LOOK) -> Zeros:
        """The ends of descents from rotations (3, 3, N), offsets (3, N), and their twins."""
        found = descend(self.equations, rotations, offsets, self.cost_limit, first_look=first_look)
        return found.with_twins(self.turns)

    def met_near(self, rotations: FeatureRotations, is_near: Bools) -> Zeros:
        """The ends of descents from rotations with their best translations, and from others for those that are near."""
        domain, near = self.equations.domain, rotations.matrices[..., is_near]
        offsets = centred_offsets(self.equations, rotations.matrices)
        if domain.is_limited and rotations.fix_place and not rotations.are_samples:
            again, around = near, domain.offsets_at_place(near)
        else:
            again = np.repeat(near[:, :, None], SIDES.shape[1] - 1, axis=2).reshape(3, 3, -1)
            around = (offsets[:, None, is_near] + SIDES[:, 1:, None]).reshape(3, -1)
        starts = np.concatenate([rotations.matrices, again], axis=2)
        offsets = np.concatenate([offsets, around], axis=1)
        return Zeros.none().joined(self.met_from(starts, offsets, NEAR_LOOK))

    def of_coverings(self, starts: int, least: int) -> Zeros:
        """The zeros that coverings meet: at least so many, until each was met OFTEN; one covering if least is 0."""
        zeros = Zeros.none()
        for number in range(MOST_COVERINGS):
            zeros = zeros.joined(self.met_from(*covering(self.equations, starts, number))).merged(self.equations)
            if zeros.continuum or not least:
                break
            if number + 1 >= least and not self.seldom(zeros).any():
                break
        return zeros

    def seldom(self, zeros: Zeros) -> Bools:
        """Which zeros of the domain were met less than OFTEN."""
        return self.wanted(zeros) & (zeros.met_nearby() < OFTEN * (1 + len(self.turns)))

    def with_neighbours(self, zeros: Zeros, around_all: bool = True) -> Zeros:
        """The zeros and those found around them: around all, or those met once; then around new ones."""
        zeros = zeros.merged(self.equations)
        fresh = zeros if around_all else zeros.best(0)
        for number in range(MOST_ROUNDS):
            centres = together([fresh.subset(self.wanted(fresh)), zeros.subset(self.met_once(zeros))])
            if not len(centres) or zeros.continuum:
                break
            before = len(zeros)
            found = self.met_from(*around(self.equations.domain, centres, number))
            zeros = zeros.joined(found).merged(self.equations)
            fresh = zeros.since(before)
        are_settled = not self.wanted(fresh).any() and not self.met_once(zeros).any()
        return replace(zeros, complete=are_settled and not zeros.continuum)

    def balanced(self, zeros: Zeros, starts: int) -> Zeros:
        """The zeros, and those that more coverings meet while the zeros do not balance."""
        for number in range(MOST_COVERINGS, MOST_COVERINGS + MORE_COVERINGS):
            if zeros.continuum or are_balanced(self.equations, zeros):
                break
            known = replace(zeros, counts=np.full(len(zeros), 2))
            more = known.joined(self.met_from(*covering(self.equations, starts, number)))
            if len(more) > len(zeros):
                zeros = self.with_neighbours(more)
        return zeros

    def met_once(self, zeros: Zeros) -> Bools:
        """Which were met only once, of those that are searched for."""
        once = zeros.counts < 2
        return once & self.wanted(zeros) if once.any() else once

    def wanted(self, zeros: Zeros) -> Bools:
        """Which zeros are in the domain; descents may find others, which are kept."""
        return self.equations.domain.has(zeros.rotations, zeros.offsets)
