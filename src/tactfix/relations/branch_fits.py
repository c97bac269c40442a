"""The joint fits of combinations of features, one for each branch of relations that the contacts do not exclude.

1. Every branch of every combination that may explain the contacts is a start. Its cost is the chi-square of the
   features alone plus that of the relations by the linear model (`branches`). The cheapest starts are fitted.
2. The joint least squares start there (`joint`), with relations near coincidence widened (`equations`).
3. If the fit shows that the contacts resolve the circle of a widened relation, the relation itself replaces it and the
   fit goes on, until no relation changes any more.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats
from tactfix.geometry.nearest import anchored
from tactfix.geometry.surfaces import Surface
from tactfix.relations.branches import BRANCH_FITS, branches, least_cost, nearest_branch
from tactfix.relations.equations import Equation, linear_equations
from tactfix.relations.joint import MOST_JOINT_STEPS, joint_fit
from tactfix.relations.joint_problem import JointFit, JointProblem, contact_observations
from tactfix.relations.unresolved import DISTINCT_PLACES, FOLD
from tactfix.values import frozen_value

MISS_FITS = 2
"""Starts that are fitted if none is predicted to explain the contacts: one is reported as the nearest miss, and the
linear cost may order two wrongly. 1 changes none of every tenth of the 200 contact sets of
`tests.benchmarks.bench_relations`."""
RESOLVED = 10.0
"""Radius of a circle, in standard deviations across it (of contacts and of its own value), above which contacts
resolve it: the position on it is then known to 0.1 rad, within which it is straight."""


@frozen_value
class Start:
    """The start of a fit: surfaces in base, the branch of each relation, and the chi-square that is predicted.

    number: of the combination of surfaces.
    """

    number: int
    surfaces: Mapping[str, Surface]
    equations: tuple[Equation, ...]
    cost: float


@frozen_value
class Starts:
    """The starts that are followed, best first, and the least cost of those left out (infinite if there are none).

    Of starts near one place the cost is that of the relations alone.
    """

    followed: tuple[Start, ...]
    left_out: float


def starts_from(
    problem: JointProblem, combinations: Sequence[Mapping[str, Surface]], with_misses: bool = True
) -> Starts:
    """The branches of all combinations of surfaces that may explain the contacts, best first.

    If there are none, the nearest misses; with_misses False: nothing.
    """
    found, missed, left_out = [], [], np.inf  # step 1
    for number, located in enumerate(combinations):
        surfaces = _anchored(located, problem.contacts)
        values, _ = contact_observations(problem.contacts, problem.sigmas, surfaces)
        own = float(values @ values)
        open_ones = branches(problem, surfaces)
        found += [Start(number, surfaces, equations, own + cost) for cost, equations in open_ones.found]
        left_out = min(left_out, own + open_ones.left_out)
        if with_misses and not open_ones.found and not found:
            missed.append(nearest_start(problem, surfaces, number, own + least_cost(problem, surfaces)))
    found.sort(key=lambda start: start.cost)
    left_out = min([left_out, *(start.cost for start in found[BRANCH_FITS:])])
    missed = sorted(missed, key=lambda start: start.cost)[:MISS_FITS] if not found else []
    return Starts(tuple(found[:BRANCH_FITS] or missed), left_out)


def near_starts(problem: JointProblem, surfaces: Mapping[str, Surface]) -> Starts:
    """The starts on the nearest branches, and on those that surfaces indistinct from these may be on, nearest first.

    A change of branch within FOLD sigma of the relation makes no other solution.
    """
    nearest = nearest_start(problem, surfaces)
    starts, open_ones = [nearest], branches(problem, _anchored(surfaces, problem.contacts))
    for cost, equations in open_ones.found:
        changed = [new for old, new in zip(nearest.equations, equations, strict=True) if new.sign != old.sign]
        missing = [float(np.abs(e.linear(surfaces)[0]).max()) for e in changed]
        if changed and all(
            FOLD * e.spread < m < 2 * DISTINCT_PLACES * e.unit(problem.scale)
            for e, m in zip(changed, missing, strict=True)
        ):
            starts.append(Start(0, surfaces, equations, cost))
    return Starts(tuple(starts), open_ones.left_out)


def nearest_start(problem: JointProblem, surfaces: Mapping[str, Surface], number: int = 0, cost: float = 0.0) -> Start:
    """The start on the branches nearest to the surfaces."""
    return Start(number, surfaces, nearest_branch(problem.relations, surfaces, problem.scale), cost)


def branch_fit(problem: JointProblem, start: Start, most_steps: int = MOST_JOINT_STEPS) -> JointFit:
    """The fit of one branch."""
    fit = joint_fit(problem, start.surfaces, start.equations, most_steps)  # step 2
    while True:
        narrowed = _narrowed(problem, fit)  # step 3
        if narrowed is None:
            return fit
        fit = joint_fit(problem, fit.surfaces, narrowed, most_steps)


def _narrowed(problem: JointProblem, fit: JointFit) -> list[Equation] | None:
    """The equations, widened ones replaced by their relations if contacts resolve their circles; None: no change."""
    if not any(equation.is_widened for equation in fit.equations):
        return None
    factor, free = fit.spread()
    if len(free):
        return None
    linear = linear_equations(fit.equations, fit.surfaces)
    given = nearest_branch(problem.relations, fit.surfaces)
    seen = [
        equation.is_widened and _is_seen(equation, jacobian * fit.lengths @ factor)
        for equation, (_, jacobian) in zip(fit.equations, linear, strict=True)
    ]
    if not any(seen):
        return None
    return [plain if see else widened for see, plain, widened in zip(seen, given, fit.equations, strict=True)]


def _is_seen(equation: Equation, factor: Floats) -> bool:
    """Whether the circle's radius exceeds RESOLVED sigma across it; factor (k, m) of its components' covariance."""
    across = float(np.linalg.norm(factor, 2))
    return equation.coincidence > RESOLVED * max(across, equation.relation.sigma)


def _anchored(surfaces: Mapping[str, Surface], contacts: Contacts) -> dict[str, Surface]:
    """The surfaces with their given points next to their contacts, so that tilts and shifts are independent."""
    own = {name: contacts.points[index].mean(axis=0) for name, index in contacts.by_feature.items()}
    return {name: anchored(surface, own.get(name, contacts.centre)) for name, surface in surfaces.items()}
