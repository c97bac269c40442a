"""Which mistakes explain contacts on a rigid fixture: all hypotheses fitted, tested, and ranked.

1. Mistakes that leave the pose on which all else agrees are fitted from there (`trial_search`).
2. Mistakes that change everything are searched for anew.
3. Reversed approaches, a larger sigma and a tip elsewhere are read from the residuals at poses that are known.
4. Explanations are kept whose chi-square is within its limit, and that approach, touch boxes and paths allow.
5. Where none is enough, more than two features taken for each other are searched for; then two or three contacts are
   left out together.
6. The most plausible are told, those together that the contacts cannot tell apart (`ranking`).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from typing import Final, TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.contact_mistakes import (
    outliers,
    relabels,
    relabels_of_points,
    single_outliers,
    swaps,
    swaps_with_points,
)
from tactfix.diagnosis.corrections import Hypothesis, Problem
from tactfix.diagnosis.data_snooping import normalized_residuals
from tactfix.diagnosis.file_mistakes import tip_offsets, tips, units
from tactfix.diagnosis.fixture_mistakes import (
    diameters,
    exchanged_axes,
    exchanged_coordinates,
    exchanges,
    places,
    radii,
    reflections,
    reorderings,
    sides,
    signs,
)
from tactfix.diagnosis.ranking import says_more, told_apart, without_generalizations
from tactfix.diagnosis.telling import one_of, told
from tactfix.diagnosis.trial_search import NO_CHANGE, Explanation, TrialSearch, searched_anew
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import inverse, transform_points
from tactfix.geometry.surfaces import moved
from tactfix.mistakes import CAUSES, DiagnosisCode
from tactfix.noise import SURE, SUSPICIOUS, chi_square_limit
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.rigid import solution_at
from tactfix.poses.solution import Solution
from tactfix.results import Diagnosis

Accepts: TypeAlias = Callable[[Fixture, Contacts, Solution], str | None]
"""A remark on a pose that nothing speaks against, empty where there is none to make; None where something does."""

FromProblem: TypeAlias = Callable[[Problem], list[Hypothesis]]
FROM_KNOWN_POSES: Final[Mapping[DiagnosisCode, FromProblem]] = {
    "outlier": single_outliers,
    "relabel": relabels,
    "swapped_labels": swaps,
    "radius": radii,
    "diameter": diameters,
    "side": sides,
    "feature_place": places,
    "axes": exchanged_coordinates,
    "mirrored": signs,
    "tip_radius": tips,
}
"""Mistakes that leave the pose on which all else agrees where it is."""
ANEW: Final[Mapping[DiagnosisCode, FromProblem]] = {
    "feature_exchange": exchanges,
    "relabel": relabels_of_points,
    "swapped_labels": swaps_with_points,
    "axes": exchanged_axes,
    "mirrored": reflections,
    "unit": units,
}
"""Mistakes that change everything."""

PLAINLY_OUT = 0.5
"""Cosine of approach and normal, five times the 0.1 rad to which the direction of a pose must be known."""
ELSEWHERE = 0.01
"""Share of the contacts' spread by which contacts are in other places of the fixture at two poses that are two."""
AMBIGUOUS = " (what is left is ambiguous)"
MOST_ENTRIES = 8
"""Entries of a diagnosis at most, the most plausible first."""
MOST_TESTED = 40
"""Explanations, those most plausible, that are asked whether approach, touch boxes and paths allow them."""
MOST_LEFT_OUT = 3
"""Contacts left out together: beyond three there are too many sets, and a robust fit finds them first."""
COARSEST_SIGMA = 0.01
"""Share of the contacts' spread above which no larger sigma is offered: whatever does not fit would fit with it."""
MOST_TIMES = 30.0
"""Times the sigma of the file above which no larger one is offered, for the same reason."""


def mistakes_that_explain(
    fixture: Fixture, problem: Problem, solutions: Sequence[Solution], accepts: Accepts
) -> tuple[Diagnosis, ...]:
    """The mistakes after which a pose is left, most plausible first; solutions: those that fit as it is, or nearly."""
    known = [solution.base_from_fixture for solution in solutions]
    search = TrialSearch(problem, known)
    found = search.explanations(_all(FROM_KNOWN_POSES, problem))  # step 1
    found += searched_anew(problem, _all(ANEW, problem))  # step 2
    # Step 3.
    found += [one for code in CAUSES if code in AT_POSES for one in AT_POSES[code](problem, search, solutions)]
    accepted = _accepted(fixture, problem, found, accepts)  # step 4
    if not any(_is_enough(problem, one) for one, _ in accepted):  # step 5
        # There are many, each takes a search, and they are as rare as the mistakes before them are common.
        accepted += _accepted(fixture, problem, searched_anew(problem, reorderings(problem)), accepts)
    for size in range(2, MOST_LEFT_OUT + 1):
        if problem.dof < size or _is_settled(problem, [one for one, _ in accepted], size):
            break
        sets = outliers(problem, search.sets_to_leave_out(size))
        accepted += _accepted(fixture, problem, search.explanations(sets), accepts)
    return _ranked(fixture, problem, dict(accepted))  # step 6


def _all(makers: Mapping[DiagnosisCode, FromProblem], problem: Problem) -> list[Hypothesis]:
    return [hypothesis for code in CAUSES if code in makers for hypothesis in makers[code](problem)]


def _is_settled(problem: Problem, accepted: Sequence[Explanation], size: int) -> bool:
    """Whether sets of so many contacts need not be left out: something explains all, and no set that is smaller by one.

    Where fewer contacts explain others by chance, the bad ones together do so better.
    """
    enough = [one.hypothesis for one in accepted if _is_enough(problem, one)]
    return bool(enough) and all(len(hypothesis.deleted) != size - 1 for hypothesis in enough)


def _is_enough(problem: Problem, one: Explanation) -> bool:
    """Whether more mistakes at once need not be looked for; what allows larger residuals explains anything."""
    return not one.hypothesis.allows_more and one.chi2 <= _limit(problem, one, SUSPICIOUS)


def _limit(problem: Problem, one: Explanation, probability: float) -> float:
    return chi_square_limit(problem.dof - one.hypothesis.numbers(problem), probability)


def _accepted(
    fixture: Fixture, problem: Problem, found: Sequence[Explanation], accepts: Accepts
) -> list[tuple[Explanation, str]]:
    """Those that explain the contacts, and that nothing else speaks against, with what is to be remarked."""
    explaining = [one for one in found if one.chi2 <= _limit(problem, one, 1e-6)]
    accepted: list[tuple[Explanation, str]] = []
    for one in sorted(explaining, key=lambda one: one.score)[:MOST_TESTED]:
        if any(says_more(problem, special, one) for special, _ in accepted):
            continue
        asked = ((way, _remark(fixture, problem, way, accepts)) for way in one.ways)
        left = ((way, remark) for way, remark in asked if remark is not None)
        for way, remark in islice(left, 1):
            others = (other for other, _ in left if _is_elsewhere(problem, way, other))
            accepted.append((way, remark or (AMBIGUOUS if any(True for _ in others) else "")))
    return accepted


def _is_elsewhere(problem: Problem, one: Explanation, other: Explanation) -> bool:
    """Whether contacts are in plainly other places of the fixture."""
    points = problem.contacts.points
    here, there = (transform_points(inverse(way.base_from_fixture), points) for way in (one, other))
    return bool(np.abs(here - there).max() > ELSEWHERE * problem.contacts.spread)


def _remark(fixture: Fixture, problem: Problem, one: Explanation, accepts: Accepts) -> str | None:
    hypothesis = one.hypothesis
    corrected = hypothesis.corrected(problem, one.values)
    if corrected.contacts.tip_radius < 0 or (not hypothesis.deleted and _comes_out(corrected, one.base_from_fixture)):
        return None
    moved = set(hypothesis.surfaces) | (set(hypothesis.features) if hypothesis.free == "place" else set())
    # Touch boxes say where a feature is touched that stands where the file says.
    touch = {name: box for name, box in fixture.touch.items() if name not in moved}
    solution = solution_at(one.base_from_fixture, corrected.surfaces, corrected.contacts, corrected.sigmas)
    remark = accepts(replace(fixture, touch=touch), corrected.contacts, solution)
    # Contacts of a wrong unit may shrink to what tells nothing; what is left without one of them may just be weak.
    return remark if not remark or hypothesis.deleted else None


def _comes_out(corrected: Problem, base_from_fixture: Floats) -> bool:
    """Whether a contact came out of the material by so much that either the pose falls or its direction is unknown.

    A pose whose normals are less sure than that is worthless; so no covariance is needed to tell.
    """
    surfaces = {name: moved(base_from_fixture, surface) for name, surface in corrected.surfaces.items()}
    _, normals = contact_residuals(surfaces, corrected.contacts)
    return bool((np.einsum("ij,ij->i", corrected.contacts.approaches, normals) > PLAINLY_OUT).any())


def _ranked(fixture: Fixture, problem: Problem, accepted: dict[Explanation, str]) -> tuple[Diagnosis, ...]:
    if not accepted:
        return ()
    alike, others = told_apart(without_generalizations(problem, list(accepted)))
    say = [told(problem, fixture.units, one, accepted[one]) for one in alike[:MOST_ENTRIES]]
    rest = [told(problem, fixture.units, one, accepted[one]) for one in others[: MOST_ENTRIES - len(say)]]
    return (one_of(say), *rest)


def _sigma(problem: Problem, search: TrialSearch, solutions: Sequence[Solution]) -> list[Explanation]:
    """One factor on every sigma, where then no contact stands out."""
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
    """All approaches reversed, or those that come out of the material at a pose that fits."""
    contacts = problem.contacts
    cosine = np.where(contacts.has_approach, np.einsum("ij,ij->i", contacts.approaches, solution.normals), -1.0)
    against = tuple(np.flatnonzero(cosine > SURE * solution.normal_sigmas).tolist())
    if not against or solution.chi2 > chi_square_limit(problem.dof):
        return []
    given = tuple(np.flatnonzero(contacts.has_approach).tolist())
    names = tuple(dict.fromkeys(contacts.features[i] for i in against))
    ways = math.comb(len(given), len(against))
    hypotheses = [
        Hypothesis("approach", reversed=given),
        Hypothesis("approach", index=against, features=names, alternatives=ways, reversed=against),
    ]
    return [
        Explanation(h, np.zeros(0), solution.base_from_fixture, solution.chi2, solution.chi2 + h.penalty(problem))
        for h in hypotheses
        if len(against) < len(given) or not h.index
    ]


AtPoses: TypeAlias = Callable[[Problem, TrialSearch, Sequence[Solution]], list[Explanation]]
AT_POSES: Final[Mapping[DiagnosisCode, AtPoses]] = {
    "approach": _approaches,
    "sigma": _sigma,
    "tip_offset": _tip_offset,
}
"""Mistakes that are told from the residuals and sides at poses that are known, or from these alone."""
