"""From a few contacts to all: poses that most of many agree on where none explains them all, and the best for all.

The search looks at a few contacts, those far from the others of their feature first, and a contact with a wrong label
is just that: with one among them no pose explains the few, and the least of their residuals is nowhere near the truth.
Parts chosen blindly are free of a few wrong contacts, most of them, and a pose that explains a part without any is next
to the one that explains all but the wrong ones. These then stand out by their residuals.

1. A part is chosen blindly, fairly shared between the features.
2. It is searched, near the rotations that its features allow where these are known, and its poses are told.
3. From such poses descents lead to the minima for all contacts (`best_poses`); where contacts are very many, first for
   a thousand of them.
4. Minima within the limit of chi-square are kept; where there is none, the nearest misses.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats, Ints
from tactfix.geometry.surfaces import SidedSurface
from tactfix.noise import chi_square_limit
from tactfix.poses.equations import PoseEquations
from tactfix.poses.feature_rotations import rotations_in
from tactfix.poses.search import find_zeros, find_zeros_near, polish
from tactfix.poses.zeros import Zeros, together

PART_CONTACTS = 12
"""Contacts in a part: with two wrong ones among forty every other part is free of them."""
PARTS_SEARCHED = 6
"""Parts that are searched: with every other one free of wrong contacts, one of six is, but for once in 64 times."""
THINNED = 1000
"""Contacts that decide what is followed on all of them."""
MISS_STEPS = 60
"""Steps down to a miss: its minimum is flat, and no pose to within rounding is wanted."""
MISSES_FOLLOWED = 2
"""Misses that are followed on all of very many contacts."""


def agreed_poses(
    surfaces: Mapping[str, SidedSurface],
    contacts: Contacts,
    sigmas: Floats,
    equations: PoseEquations,
    cost_limit: float,
    starts: int,
    turns: Sequence[Floats],
) -> Iterator[Zeros]:
    """The zeros of blindly chosen parts of the contacts that have some; as in `search.find_zeros`.

    surfaces in the fixture frame, sigmas (n,) of the residuals, equations: scaled, of all contacts.
    """
    for number in range(PARTS_SEARCHED):
        index = blind_part(contacts, PART_CONTACTS, number)  # step 1
        part, searched = contacts.subset(index), equations.subset(index.tolist())
        # Step 2.
        rotations = rotations_in(equations.domain, surfaces, part, sigmas[index])
        if rotations is None:
            zeros = find_zeros(searched, cost_limit, starts, turns)
        else:
            zeros = find_zeros_near(searched, cost_limit, rotations, turns)
        if len(zeros) and not zeros.continuum:
            yield zeros


def blind_part(contacts: Contacts, count: int, number: int) -> Ints:
    """Indices of so many contacts, fairly shared between the features and chosen blindly, others for each number."""
    shuffled = [_shuffled(index, number)[:count] for index in contacts.by_feature.values()]
    # Of more features than contacts in a part, other features.
    first = number * count % len(shuffled)
    shuffled = shuffled[first:] + shuffled[:first]
    longest = max(len(index) for index in shuffled)
    by_turns = [int(index[turn]) for turn in range(longest) for index in shuffled if turn < len(index)]
    return np.sort(np.array(by_turns[:count], dtype=np.intp))


def _shuffled(index: Ints, number: int) -> Ints:
    # Blind enough, and without numpy.random, whose import takes longer than the search.
    key = (np.arange(1, len(index) + 1) + 7919 * number) ** 2 * 40503 % 65537
    return np.asarray(index[np.argsort(key, kind="stable")])


def best_poses(equations: PoseEquations, contacts: Contacts, zeros: Zeros, unit: float) -> Zeros:
    """The minima that zeros lead to and that explain the contacts; where there is none, the nearest misses.

    Where contacts are very many, the zeros are first brought to where a thousand of them want to be: most zeros of the
    few turn out to be none there, and what is left is next to where all contacts want it.

    equations: scaled, of all contacts; unit: the cost of a chi-square of one.
    """
    if len(contacts) <= THINNED:
        return _settled(equations, zeros, unit)
    few = equations.subset(blind_part(contacts, THINNED, 0).tolist())  # step 3
    zeros = _settled(few, zeros, unit)
    if not zeros.costs.min(initial=np.inf) <= _limit(few.dof, unit):
        zeros = zeros.best(MISSES_FOLLOWED)
    # One at a time: the residuals and Jacobians of a million contacts fill some hundred megabytes for each.
    each = [zeros.subset(np.array([number])) for number in range(len(zeros))]
    return together([_settled(equations, zero, unit) for zero in each])


def _settled(equations: PoseEquations, zeros: Zeros, unit: float) -> Zeros:
    """The minima within the limit, or those near the misses."""
    found = polish(equations, zeros, _limit(equations.dof, unit))  # step 4
    return found if len(found) else polish(equations, zeros, most_steps=MISS_STEPS)


def _limit(dof: int, unit: float) -> float:
    # What rounding makes of exact contacts is below 1e-11 of the size of the fixture.
    return float(chi_square_limit(dof) * unit + 1e-22)
