"""Mistakes that follow from residuals and approaches at known poses: another sigma, another tip, reversed approaches.

1. Sigma: one factor on every sigma brings chi-square to its degrees of freedom, and no contact stands out after it.
2. Tip offset: the tip's centre in the flange frame is fitted along with the pose.
3. Approaches: at a pose that fits, the probe came out of the material; reversed it goes in.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np

from tactfix.diagnosis.contact_mistakes import all_reversed, reversed_approaches, tip_offsets
from tactfix.diagnosis.data_snooping import normalized_residuals
from tactfix.diagnosis.hypotheses import Explanation, Hypothesis, Problem
from tactfix.diagnosis.trial_search import NO_CHANGE, TrialSearch
from tactfix.mistakes import DiagnosisCode
from tactfix.noise import SURE, SUSPICIOUS, chi_square_limit
from tactfix.poses.rigid import solution_at
from tactfix.poses.solution import Solution

COARSEST_SIGMA = 0.01
"""Share of the contacts' spread above which no larger sigma is offered: with noise of a hundredth of the fixture
nearly any pose fits."""
MOST_TIMES = 30.0
"""Largest factor on the sigma of the file that is offered: twice the largest of the mistakes that are studied, 15
(`tests.validation.made_mistakes`); with 50 times sigma contacts on another fixture are explained."""


def _sigma(problem: Problem, search: TrialSearch, solutions: Sequence[Solution]) -> list[Explanation]:
    """One factor on every sigma, if no normalised residual is an outlier after it."""
    best = search.explanations([NO_CHANGE])[0]
    factor = math.sqrt(best.chi2 / max(problem.dof, 1))
    coarse = factor * float(problem.sigmas.max()) > COARSEST_SIGMA * problem.contacts.spread
    if problem.dof < 2 or not 1 < factor < MOST_TIMES or coarse:
        return []
    solution = solution_at(best.base_from_fixture, problem.surfaces, problem.contacts, problem.sigmas)
    found = normalized_residuals(problem.contacts, problem.sigmas, solution)
    if (found.sizes > factor * found.limits(SUSPICIOUS)).any():
        return []
    hypothesis = Hypothesis("sigma", sigmas=factor)
    score = problem.dof + hypothesis.penalty(problem) + math.log(len(problem.single.contacts))
    ways = [replace(w, hypothesis=hypothesis, chi2=float(problem.dof), score=score, others=()) for w in best.ways]
    return [replace(ways[0], others=tuple(ways[1:]))]


def _tip_offset(problem: Problem, search: TrialSearch, solutions: Sequence[Solution]) -> list[Explanation]:
    return search.explanations(tip_offsets(problem))


def _approaches(problem: Problem, search: TrialSearch, solutions: Sequence[Solution]) -> list[Explanation]:
    found: dict[tuple[int, ...], list[Explanation]] = {}
    for solution in solutions:
        for one in _approaches_at(problem, solution):
            found.setdefault(one.hypothesis.reversed, []).append(one)
    return [replace(first, others=tuple(others)) for first, *others in found.values()]


def _approaches_at(problem: Problem, solution: Solution) -> list[Explanation]:
    """At a pose that fits: all approaches reversed, or those that come out of the material there."""
    contacts = problem.contacts
    cosine = np.where(contacts.has_approach, np.einsum("ij,ij->i", contacts.approaches, solution.normals), -1.0)
    against = tuple(np.flatnonzero(cosine > SURE * solution.normal_sigmas).tolist())
    if not against or solution.chi2 > chi_square_limit(problem.dof):
        return []
    given = int(contacts.has_approach.sum())
    hypotheses = [all_reversed(contacts)]
    if len(against) < given:
        hypotheses.append(reversed_approaches(contacts, against, math.comb(given, len(against))))
    return [
        Explanation(h, np.zeros(0), solution.base_from_fixture, solution.chi2, solution.chi2 + h.penalty(problem))
        for h in hypotheses
    ]


AtPoses: TypeAlias = Callable[[Problem, TrialSearch, Sequence[Solution]], list[Explanation]]
AT_POSES: Final[Mapping[DiagnosisCode, AtPoses]] = {
    "approach": _approaches,
    "sigma": _sigma,
    "tip_offset": _tip_offset,
}
"""Mistakes that follow from residuals and approaches at the known poses."""
