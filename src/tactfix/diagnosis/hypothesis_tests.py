"""Which mistakes explain contacts on a rigid fixture: all hypotheses are fitted, tested and ranked.

1. Mistakes in a few contacts or one feature are fitted from the poses that the other contacts agree on
   (`trial_search`).
2. Mistakes that concern all contacts are searched for from all rotations.
3. Reversed approaches, a larger sigma and a displaced tip follow from the residuals at the known poses
   (`residual_mistakes`).
4. An explanation is kept if its chi-square is within its limit, and approaches, touch boxes and paths allow its pose.
5. If one feature may be displaced, exchanged coordinates and wrong signs that step 1 did not find are searched for
   from all rotations: those of points, and those whose pose is far from the known ones.
6. If none explains the contacts well, permutations of more than two features are searched for, then the deletion of two
   or three contacts together.
7. The most plausible are reported, those as one entry that the contacts cannot distinguish (`hypotheses`).
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from typing import Final, TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.contact_mistakes import (
    is_possible_tip,
    outliers,
    relabels,
    relabels_of_points,
    single_outliers,
    swaps,
    swaps_with_points,
    tips,
    units,
)
from tactfix.diagnosis.fixture_mistakes import (
    all_diameters,
    coordinates_of_each,
    diameters,
    exchanged_axes,
    exchanged_coordinates,
    exchanges,
    is_same,
    places,
    radii,
    reflections,
    reorderings,
    sides,
    signs,
)
from tactfix.diagnosis.hypotheses import (
    Explanation,
    Hypothesis,
    Problem,
    says_more,
    split_by_plausibility,
    without_generalizations,
)
from tactfix.diagnosis.messages import diagnosis_of, one_of
from tactfix.diagnosis.residual_mistakes import AT_POSES
from tactfix.diagnosis.trial_search import TrialSearch, searched_anew
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import inverse, transform_points
from tactfix.geometry.surfaces import moved
from tactfix.mistakes import CAUSES, DiagnosisCode
from tactfix.noise import SUSPICIOUS, chi_square_limit
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.rigid import solution_at
from tactfix.poses.solution import Solution
from tactfix.results import Diagnosis

Accepts: TypeAlias = Callable[[Fixture, Contacts, Solution], str | None]
"""None if a test rejects the pose; else a remark on it, which may be empty."""

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
"""Mistakes in a few contacts or one feature: the other contacts fix the pose."""
FROM_ALL_ROTATIONS: Final[Mapping[DiagnosisCode, FromProblem]] = {
    "feature_exchange": exchanges,
    "relabel": relabels_of_points,
    "swapped_labels": swaps_with_points,
    "axes": exchanged_axes,
    "mirrored": reflections,
    "unit": units,
    "diameter": all_diameters,
}
"""Mistakes that concern all contacts, so that no known pose is near."""

PLAINLY_OUT = 0.5
"""Cosine of approach and outward normal above which the probe came out of the material, whatever the covariance is:
five times 0.1 rad, the worst sigma of rotation that a pose may have (`localization.free_motions`)."""
ELSEWHERE = 0.01
"""Share of the contacts' spread: two poses of one hypothesis are distinct if a contact lies this far apart on the
fixture. Far more than sigma, so that one pose reached twice is not called ambiguous."""
ELSEWHERE_CODES: Final[tuple[DiagnosisCode, ...]] = ("feature_place", "axes", "mirrored")
"""Codes of the mistakes that displace one feature in the fixture file."""
AMBIGUOUS = " (the result is then ambiguous)"
FEW_EQUATIONS = 2
"""Equations beyond the six of a pose with which most single mistakes explain the contacts: of eight contacts, three on
a plate, three on a pin and two on a ball, one that is 1 mm off leaves eight explanations in one entry. The message then
says that more touches are needed to distinguish them."""
MOST_ENTRIES = 8
"""Entries of a diagnosis at most, the most plausible first: what a person reads."""
MOST_TESTED = 40
"""Number of explanations, in order of plausibility, that are tested against approaches, touch boxes and paths. Each
test takes about as long as the report of a pose, and MOST_ENTRIES are reported."""
MOST_LEFT_OUT = 3
"""Contacts deleted together at most. Of 30 contacts there are 4,060 sets of three and 27,405 of four; four wrong
contacts were not studied (`tests.validation.diagnosis` has three)."""


def accepted_explanations(
    fixture: Fixture,
    problem: Problem,
    solutions: Sequence[Solution],
    accepts: Accepts,
    codes: Collection[DiagnosisCode] = CAUSES,
) -> list[tuple[Explanation, str]]:
    """The mistakes of these codes that explain the contacts, each with its remark.

    solutions: poses that nearly fit without any mistake.
    """
    search = TrialSearch(problem, [solution.base_from_fixture for solution in solutions])
    found = search.explanations(_all(FROM_KNOWN_POSES, problem, codes))  # step 1
    found += searched_anew(problem, _all(FROM_ALL_ROTATIONS, problem, codes))  # step 2
    # Step 3.
    found += [one for code in codes if code in AT_POSES for one in AT_POSES[code](problem, search, solutions)]
    accepted = tested(fixture, problem, found, accepts)  # step 4
    accepted += tested(fixture, problem, other_coordinates(problem, accepted), accepts)  # step 5
    if not any(_is_enough(problem, one) for one, _ in accepted):  # step 6
        # There are many of them, each takes a search, and they are rare.
        accepted += tested(fixture, problem, searched_anew(problem, reorderings(problem)), accepts)
    for size in range(2, MOST_LEFT_OUT + 1) if "outlier" in codes else ():
        if problem.dof < size or _is_settled(problem, [one for one, _ in accepted], size):
            break
        sets = outliers(problem, search.sets_to_leave_out(size))
        accepted += tested(fixture, problem, search.explanations(sets), accepts)
    return accepted


def _all(
    makers: Mapping[DiagnosisCode, FromProblem], problem: Problem, codes: Collection[DiagnosisCode]
) -> list[Hypothesis]:
    return [hypothesis for code in codes if code in makers for hypothesis in makers[code](problem)]


def other_coordinates(problem: Problem, accepted: Sequence[tuple[Explanation, str]]) -> list[Explanation]:
    """The exchanged coordinates and wrong signs of one feature that are not accepted yet, if a feature is displaced.

    If the coordinates of one of two pins are exchanged, exchanging those of the other leaves the same residuals, at
    another pose.
    """
    displaced = [
        one.hypothesis for one, _ in accepted if one.hypothesis.code in ELSEWHERE_CODES and one.hypothesis.features
    ]
    if not displaced:
        return []
    others = [h for h in coordinates_of_each(problem) if not any(_is_same_correction(h, one) for one in displaced)]
    return searched_anew(problem, others)


def _is_same_correction(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether two corrections of one feature's coordinates are one: those of its place alone are another."""
    if (one.code, one.features, one.note) != (other.code, other.features, other.note):
        return False
    return all(is_same(surface, other.surfaces[name]) for name, surface in one.surfaces.items())


def _is_settled(problem: Problem, accepted: Sequence[Explanation], size: int) -> bool:
    """Whether sets of so many contacts need not be deleted: a hypothesis explains all, and it is no set with one less.

    If a set with one contact less explains the others, that may be chance, and the true set fits better.
    """
    enough = [one.hypothesis for one in accepted if _is_enough(problem, one)]
    return bool(enough) and all(len(hypothesis.deleted) != size - 1 for hypothesis in enough)


def _is_enough(problem: Problem, one: Explanation) -> bool:
    """Whether no combination of mistakes need be looked for. A larger sigma does not count: it explains anything."""
    return not one.hypothesis.allows_more and one.chi2 <= _limit(problem, one, SUSPICIOUS)


def _limit(problem: Problem, one: Explanation, probability: float) -> float:
    return chi_square_limit(problem.dof - one.hypothesis.numbers(problem), probability)


def tested(
    fixture: Fixture, problem: Problem, found: Sequence[Explanation], accepts: Accepts
) -> list[tuple[Explanation, str]]:
    """Those within their limit of chi-square that no other test rejects, each with its remark."""
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
    """Whether a contact lies elsewhere on the fixture, by more than ELSEWHERE."""
    points = problem.contacts.points
    first, second = (transform_points(inverse(way.base_from_fixture), points) for way in (one, other))
    return bool(np.abs(first - second).max() > ELSEWHERE * problem.contacts.spread)


def _remark(fixture: Fixture, problem: Problem, one: Explanation, accepts: Accepts) -> str | None:
    hypothesis = one.hypothesis
    corrected = hypothesis.corrected(problem, one.values)
    if not is_possible_tip(problem.contacts, corrected.contacts.tip_radius):
        return None
    if not hypothesis.deleted and _comes_out(corrected, one.base_from_fixture):
        return None
    moved = set(hypothesis.surfaces) | (set(hypothesis.features) if hypothesis.free == "place" else set())
    # The touch box of a feature that is displaced does not apply.
    touch = {name: box for name, box in fixture.touch.items() if name not in moved}
    solution = solution_at(one.base_from_fixture, corrected.surfaces, corrected.contacts, corrected.sigmas)
    remark = accepts(replace(fixture, touch=touch), corrected.contacts, solution)
    # A weakly determined pose is accepted after a deletion only: contacts in a wrong unit may shrink to a point.
    return remark if not remark or hypothesis.deleted else None


def _comes_out(corrected: Problem, base_from_fixture: Floats) -> bool:
    """Whether a contact came out of the material by more than PLAINLY_OUT.

    No covariance is needed: a pose with such uncertain normals would be too weakly determined to be accepted.
    """
    surfaces = {name: moved(base_from_fixture, surface) for name, surface in corrected.surfaces.items()}
    _, normals = contact_residuals(surfaces, corrected.contacts)
    return bool((np.einsum("ij,ij->i", corrected.contacts.approaches, normals) > PLAINLY_OUT).any())


def ranked_diagnoses(fixture: Fixture, problem: Problem, accepted: dict[Explanation, str]) -> tuple[Diagnosis, ...]:
    """The most plausible of them, those as one entry that the contacts cannot distinguish (step 7)."""
    if not accepted:
        return ()
    alike, others = split_by_plausibility(without_generalizations(problem, list(accepted)))
    first = [diagnosis_of(problem, fixture.units, one, accepted[one]) for one in alike[:MOST_ENTRIES]]
    rest = [diagnosis_of(problem, fixture.units, one, accepted[one]) for one in others[: MOST_ENTRIES - len(first)]]
    entry = one_of(first)
    if entry.one_of and problem.dof <= FEW_EQUATIONS:
        count = f"{problem.dof} equation{'s' if problem.dof > 1 else ''} more than a pose needs"
        entry = replace(entry, message=f"{entry.message}. These contacts give only {count}: make more contacts")
    return (entry, *rest)
