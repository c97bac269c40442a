"""From a subset of the contacts to all: poses that most contacts agree on, and the best poses of all contacts.

The search uses contacts that lie far from the others of their feature. A contact with a wrong label is one of these,
and then no pose explains the subset. Subsets chosen without regard to place mostly contain none of a few wrong
contacts. A pose that explains such a subset is near the pose that explains all good contacts.

1. A subset is chosen, with equal shares of the features.
2. Its poses are searched, near the rotations of features located alone if these are known.
3. Descents lead from these poses to the minima of all contacts (`best_poses`), for very many contacts by way of those
   of a thousand.
4. Minima within the limit of chi-square are kept; if there is none, the nearest misses.
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
"""Contacts in a subset: with two wrong ones among forty every other subset is free of them. Of 42 contact sets of 56
to 120 contacts with wrong ones (1 to 8 off, labels wrong or swapped) 8 and 24 give the same diagnosis, in 1.3 and
1.0 times the time."""
PARTS_SEARCHED = 6
"""Subsets that are searched: if every other one is free of wrong contacts, none of six is once in 64 times. 3 and 12
give the same 42 diagnoses as above."""
THINNED = 1000
"""Contacts that decide which minima are followed on all contacts: their poses are known to a thirtieth of sigma, and
the time of a descent grows with the contacts."""
MISS_STEPS = 60
"""Steps of a descent to a miss: its minimum is flat, and only its chi-square is reported."""
MISSES_FOLLOWED = 2
"""Misses that are followed on all of very many contacts: one is reported, and a second one may be nearer."""


def agreed_poses(
    surfaces: Mapping[str, SidedSurface],
    contacts: Contacts,
    sigmas: Floats,
    equations: PoseEquations,
    cost_limit: float,
    starts: int,
    turns: Sequence[Floats],
) -> Iterator[Zeros]:
    """The zeros of each subset of the contacts that has some (`search.find_zeros`).

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
    """Indices of count contacts, equal shares of the features, chosen without regard to place; others by number."""
    shuffled = [_shuffled(index, number)[:count] for index in contacts.by_feature.values()]
    # If there are more features than count, each number begins with other features.
    first = number * count % len(shuffled)
    shuffled = shuffled[first:] + shuffled[:first]
    longest = max(len(index) for index in shuffled)
    by_turns = [int(index[turn]) for turn in range(longest) for index in shuffled if turn < len(index)]
    return np.sort(np.array(by_turns[:count], dtype=np.intp))


def _shuffled(index: Ints, number: int) -> Ints:
    # Pseudo-random, but without numpy.random, whose import takes longer than the search.
    key = (np.arange(1, len(index) + 1) + 7919 * number) ** 2 * 40503 % 65537
    return np.asarray(index[np.argsort(key, kind="stable")])


def best_poses(equations: PoseEquations, contacts: Contacts, zeros: Zeros, unit: float) -> Zeros:
    """The minima of all contacts that zeros lead to and that explain them; if there is none, the nearest misses.

    Of very many contacts, THINNED ones are fitted first: most zeros of the few are no minima of these, and the others
    are then close to the minima of all.

    equations: scaled, of all contacts; unit: the cost of chi-square 1.
    """
    if len(contacts) <= THINNED:
        return _settled(equations, zeros, unit)
    few = equations.subset(blind_part(contacts, THINNED, 0).tolist())  # step 3
    zeros = _settled(few, zeros, unit)
    if not zeros.costs.min(initial=np.inf) <= acceptance_cost(few.dof, unit):
        zeros = zeros.best(MISSES_FOLLOWED)
    # One at a time: residuals and Jacobian of a million contacts take some hundred megabytes for each zero.
    each = [zeros.subset(np.array([number])) for number in range(len(zeros))]
    return together([_settled(equations, zero, unit) for zero in each])


def _settled(equations: PoseEquations, zeros: Zeros, unit: float) -> Zeros:
    """The minima within the limit, or those near the misses."""
    found = polish(equations, zeros, acceptance_cost(equations.dof, unit))  # step 4
    return found if len(found) else polish(equations, zeros, most_steps=MISS_STEPS)


def acceptance_cost(dof: int, unit: float) -> float:
    """The cost up to which a pose with dof degrees of freedom explains the contacts; unit: the cost of chi-square 1.

    The constant is rounding: residuals of 1e-11 of the size of the fixture.
    """
    return float(chi_square_limit(dof) * unit + 1e-22)
