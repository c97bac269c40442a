"""From the zeros of a few contacts to the best poses for all of them: geometric least squares.

Where contacts are very many, the poses are first brought to where a thousand of them want to be: most zeros of the few
turn out to be none there, and what is left is next to where all contacts want it.
"""

import numpy as np

from tactfix.contacts import Contacts
from tactfix.noise import chi_square_limit
from tactfix.poses.equations import PoseEquations
from tactfix.poses.search import polish
from tactfix.poses.subsets import blind_part
from tactfix.poses.zeros import Zeros, together

THINNED = 1000
"""Contacts that decide what is followed on all of them."""
MISS_STEPS = 60
"""Steps down to a miss: its minimum is flat, and no pose to within rounding is wanted."""
MISSES_FOLLOWED = 2
"""Misses that are followed on all of very many contacts."""


def best_poses(equations: PoseEquations, contacts: Contacts, zeros: Zeros, unit: float) -> Zeros:
    """The minima that zeros lead to and that explain the contacts; where there is none, the nearest misses.

    equations: scaled, of all contacts; unit: the cost of a chi-square of one.
    """
    if len(contacts) <= THINNED:
        return _settled(equations, zeros, unit)
    few = equations.subset(blind_part(contacts, THINNED, 0).tolist())
    zeros = _settled(few, zeros, unit)
    if not zeros.costs.min(initial=np.inf) <= _limit(few.dof, unit):
        zeros = zeros.best(MISSES_FOLLOWED)
    # One at a time: the residuals and Jacobians of a million contacts fill some hundred megabytes for each.
    each = [zeros.subset(np.array([number])) for number in range(len(zeros))]
    return together([_settled(equations, zero, unit) for zero in each])


def _settled(equations: PoseEquations, zeros: Zeros, unit: float) -> Zeros:
    """The minima within the limit, or those near the misses."""
    found = polish(equations, zeros, _limit(equations.dof, unit))
    return found if len(found) else polish(equations, zeros, most_steps=MISS_STEPS)


def _limit(dof: int, unit: float) -> float:
    # What rounding makes of exact contacts is below 1e-11 of the size of the fixture.
    return float(chi_square_limit(dof) * unit + 1e-22)
