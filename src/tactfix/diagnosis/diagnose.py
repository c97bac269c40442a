"""Why no pose explains the contacts: mistakes that, once corrected, make them consistent.

1. If the fixture has many shapes, or an open one, corrections of the contacts are tried in stages (`staged`).
2. If it has few, all mistakes are fitted at once in each shape (`hypothesis_tests`), and those in the shape with the
   best explanation are reported.
3. Of many contacts a few wrong ones are looked for in stages first. All other mistakes are searched for with a part of
   the contacts, and fitted to all.

Mistakes that concern all of many contacts (`_mistakes_of_all`):

1. A well spread part of the contacts is taken. While it fits the unchanged fixture, and all contacts do not, it is
   doubled: such a part shows no mistake.
2. The mistakes that explain the part are searched for (`hypothesis_tests`), but for those in single contacts.
3. Each is fitted to all contacts, from its poses with the part.
4. Those whose chi-square of all contacts is within its limit, and that no other test rejects, are ranked.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.hypotheses import Explanation, Hypothesis, Problem
from tactfix.diagnosis.hypothesis_tests import Accepts, accepted_explanations, ranked_diagnoses, tested
from tactfix.diagnosis.residual_mistakes import AT_POSES
from tactfix.diagnosis.staged import MANY
from tactfix.diagnosis.trial_search import NO_CHANGE, TrialSearch
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.mistakes import CAUSES, DiagnosisCode
from tactfix.noise import chi_square_limit
from tactfix.poses.all_poses import spread_indices
from tactfix.poses.rigid import solution_at
from tactfix.poses.solution import Solution
from tactfix.probe import residual_sigmas
from tactfix.relations.realization import few_shapes, shape_sigma
from tactfix.results import Diagnosis

MOST_SHAPES = 2
"""Shapes of a fixture by relations that are diagnosed: the two mirror images that most relations allow, or one body
in two frames. `few_shapes` returns the shapes of at most two bodies."""
PART = 30
"""Well spread contacts of many with which mistakes in the fixture or the whole file are searched for. The time of a
diagnosis is published for 30 contacts (`tests.benchmarks.bench_diagnosis`), and grows with their number."""
MOST_DOUBLED = 4
"""How often the part is doubled at most, to 480 contacts. Of 3,000 contacts with a tip radius 0.6 sigma off, all take
26 s and give the same diagnosis."""
IN_SINGLE_CONTACTS: tuple[DiagnosisCode, ...] = ("outlier", "relabel", "swapped_labels")
"""Codes of the mistakes in single contacts. Their number grows with the contacts, that of pairs with its square."""

NOTHING_EXPLAINS = (
    "no single bad contact, label, approach, unit or tip radius explains it: is this the right fixture file?"
)


def diagnosed(
    fixture: Fixture,
    contacts: Contacts,
    solutions: Sequence[Solution],
    accepts: Accepts,
    staged: Callable[[], tuple[Diagnosis, ...]],
) -> tuple[Diagnosis, ...]:
    """The mistakes that explain the contacts, most plausible first; empty if none does.

    solutions: poses that fit, or nearly. staged: the staged diagnosis, for a fixture with an open shape or many shapes,
    and for a few wrong contacts of many.
    """
    shapes = few_shapes(fixture)
    if not shapes:  # step 1
        return staged()
    if len(contacts) >= MANY and (few := staged()):  # step 3
        return few
    sigmas = np.hypot(residual_sigmas(fixture, contacts), shape_sigma(fixture))
    problems = [Problem(shape, contacts, sigmas) for shape in shapes[:MOST_SHAPES]]
    explain = _mistakes_of_few if len(contacts) < MANY else _mistakes_of_all
    found = [explain(fixture, problem, solutions, accepts) for problem in problems]  # steps 2 and 3
    return min((one for one in found if one), key=lambda one: one[0].chi2 or 0.0, default=())


def _mistakes_of_few(
    fixture: Fixture, problem: Problem, solutions: Sequence[Solution], accepts: Accepts
) -> tuple[Diagnosis, ...]:
    """The mistakes that explain the contacts, most plausible first; solutions: poses that nearly fit without any."""
    return ranked_diagnoses(fixture, problem, dict(accepted_explanations(fixture, problem, solutions, accepts)))


def _mistakes_of_all(
    fixture: Fixture, problem: Problem, solutions: Sequence[Solution], accepts: Accepts
) -> tuple[Diagnosis, ...]:
    """The mistakes that explain many contacts, most plausible first, without those in single contacts."""
    part, index = _telling_part(problem, [one.base_from_fixture for one in solutions])  # step 1
    known = [solution_at(s.base_from_fixture, part.surfaces, part.contacts, part.sigmas) for s in solutions]
    codes = [code for code in CAUSES if code not in IN_SINGLE_CONTACTS]
    found = [one for one, _ in accepted_explanations(fixture, part, known, accepts, codes)]  # step 2
    of_all = [fit for one in found for fit in _fitted_to_all(problem, index, one)]  # step 3
    return ranked_diagnoses(fixture, problem, dict(tested(fixture, problem, of_all, accepts)))  # step 4


def _telling_part(problem: Problem, poses: Sequence[Floats]) -> tuple[Problem, list[int]]:
    """The smallest part that the poses do not fit, or the first if they fit all contacts; and its indices."""
    shows_nothing = not poses or _fits(problem, poses)
    for doubling in range(MOST_DOUBLED + 1):
        index = spread_indices(problem.contacts, PART * 2**doubling)
        part = Problem(problem.surfaces, problem.contacts.subset(index), problem.sigmas[index])
        if shows_nothing or not _fits(part, poses):
            break
    return part, index


def _fits(problem: Problem, poses: Sequence[Floats]) -> bool:
    """Whether the problem without a correction fits at the best pose near these."""
    return _search(problem, poses).explanations([NO_CHANGE])[0].chi2 <= chi_square_limit(problem.dof)


def _search(problem: Problem, poses: Sequence[Floats]) -> TrialSearch:
    return TrialSearch(problem, poses, most_robust=0)


def _fitted_to_all(problem: Problem, index: Sequence[int], one: Explanation) -> list[Explanation]:
    """The explanation of the contacts of this index, fitted to all contacts: one, or none if it has no meaning there.

    What is no free number is corrected first, so that only the free numbers are left to fit.
    """
    hypothesis = _concerning_all(problem.contacts, index, one.hypothesis)
    poses = [way.base_from_fixture for way in one.ways]
    if hypothesis is None:
        return []
    if hypothesis.code == "sigma":
        return AT_POSES["sigma"](problem, _search(problem, poses), ())
    try:
        corrected = replace(hypothesis, free=None).corrected(problem, np.zeros(0))
        free = Hypothesis(hypothesis.code, features=hypothesis.features, free=hypothesis.free)
        fit = _search(corrected, poses).explanations([free])[0]
    except TactfixError:  # a tip that does not fit into a bore
        return []
    penalty = hypothesis.penalty(problem)
    ways = [replace(w, hypothesis=hypothesis, score=w.chi2 + penalty, others=()) for w in fit.ways]
    return [replace(ways[0], others=tuple(ways[1:]))]


def _concerning_all(contacts: Contacts, index: Sequence[int], hypothesis: Hypothesis) -> Hypothesis | None:
    """The hypothesis on the contacts of this index as one on all; None for single ones and blocks."""
    if hypothesis.index:
        return None
    if hypothesis.reversed:
        return replace(hypothesis, reversed=tuple(np.flatnonzero(contacts.has_approach).tolist()))
    if hypothesis.labels is None:
        return hypothesis
    pairs = {(contacts.features[i], label) for i, label in zip(index, hypothesis.labels, strict=True)}
    other = dict(pairs)
    if len(other) < len(pairs):  # blocks of contacts: contacts of one feature are taken for those of several
        return None
    return replace(hypothesis, labels=tuple(other.get(name, name) for name in contacts.features))
