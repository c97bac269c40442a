"""Why no pose explains the contacts: single mistakes that would make them consistent.

A cell makes these mistakes: all or one approach reversed, a forgotten or wrong tip radius, a wrong unit, one bad
contact, two labels swapped. Each hypothesis corrects one of them in the contacts.

1. Contacts are ordered by what leaving them out would gain at the best pose (`deletion`).
2. Hypotheses come in stages: approaches first where a pose fits but for them, else units and tip radii, and a few of
   many contacts where one fits all others; what is rarer or would explain more comes later, labels last.
3. Locating again costs a tenth of a second or more, so that each is first asked whether a few of its contacts rule it
   out (`screen`): that leaves few of the units, and of the pairs whose labels may be swapped.
4. The others are located again. The first stage after which a pose is left is the last.
5. Its hypotheses are reported, the most plausible first.

Where the fixture has few shapes all hypotheses are fitted at once instead (`hypothesis_tests`).
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, islice
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.contact_faults import (
    MOST_DOUBTED,
    MOST_SWAPS,
    few_of_many,
    likely_pairs,
    swapped_labels,
    without_each,
)
from tactfix.diagnosis.corrections import Problem
from tactfix.diagnosis.deletion import CaseDeletion
from tactfix.diagnosis.feasibility import Feasibility
from tactfix.diagnosis.file_faults import approaches, coordinates, tip_radii, whole_files
from tactfix.diagnosis.hypotheses import CONTACTS_DOUBTED, Hypothesis, Solve
from tactfix.diagnosis.hypothesis_tests import Accepts, mistakes_that_explain
from tactfix.diagnosis.ranking import INDISTINCT
from tactfix.diagnosis.telling import one_of
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture
from tactfix.poses.all_poses import spread_indices
from tactfix.poses.rigid import solution_at
from tactfix.poses.solution import Solution
from tactfix.probe import residual_sigmas
from tactfix.relations.realization import few_shapes, fixture_scale
from tactfix.relations.trials import Trials
from tactfix.results import Diagnosis

MOST_SHAPES = 2
"""Shapes of a fixture by relations that are asked: one of each body, or one body in two frames."""
MANY = 48
"""Contacts of which parts without any wrong one have been searched (`poses.subsets`): beyond few of many there is
none to find."""
PART = 30
"""Contacts of many, well spread, by which mistakes are told that concern all of them: as many as have been timed."""
Explained: TypeAlias = Callable[[Contacts], tuple[float, str] | None]
"""The chi-square of the pose that is left for corrected contacts, with a remark where it is weak; None for none."""

NOTHING_EXPLAINS = (
    "no single bad contact, label, approach, unit or tip radius explains it: is this the right fixture file?"
)


def diagnosed(
    fixture: Fixture,
    contacts: Contacts,
    solutions: Sequence[Solution],
    accepts: Accepts,
    suspicious: Callable[[], tuple[Diagnosis, ...]],
) -> tuple[Diagnosis, ...]:
    """The mistakes that explain the contacts, most plausible first; nothing where none does.

    solutions: what fits them, or nearly. suspicious: how the mistakes are looked for where the file leaves the shape of
    the fixture free or one of many, or contacts are many.
    """
    shapes = few_shapes(fixture)
    if not shapes:
        return suspicious()
    if len(contacts) >= MANY and (few := suspicious()):
        return few
    slack = float(
        np.linalg.norm([r.sigma * (fixture_scale(fixture) if r.kind == "angle" else 1.0) for r in fixture.relations])
    )
    sigmas = np.hypot(residual_sigmas(fixture, contacts), slack)
    problems = [Problem(shape, contacts, sigmas) for shape in shapes[:MOST_SHAPES]]
    explain = mistakes_that_explain if len(contacts) < MANY else _mistakes_of_all
    found = [explain(fixture, problem, solutions, accepts) for problem in problems]
    return min((one for one in found if one), key=lambda one: one[0].chi2 or 0.0, default=())


def _mistakes_of_all(
    fixture: Fixture, problem: Problem, solutions: Sequence[Solution], accepts: Accepts
) -> tuple[Diagnosis, ...]:
    """The mistakes that concern all contacts, or all on a feature, of many: those that explain a part of them."""
    index = spread_indices(problem.contacts, PART)
    part = Problem(problem.surfaces, problem.contacts.subset(index), problem.sigmas[index])
    there = [solution_at(s.base_from_fixture, part.surfaces, part.contacts, part.sigmas) for s in solutions]
    entries = mistakes_that_explain(fixture, part, there, accepts)
    kept = ([cause for cause in entry.causes or (entry,) if not cause.rows] for entry in entries)
    judged = f" (judged by {len(index)} contacts)"
    return tuple(
        one_of([replace(cause, message=cause.message + judged) for cause in causes]) for causes in kept if causes
    )


def suspicions(
    fixture: Fixture,
    contacts: Contacts,
    best: Solution | None,
    fits: bool,
    solve: Solve,
    explained: Explained,
    trials: Trials | None = None,
) -> tuple[Diagnosis, ...]:
    """What would make the contacts consistent, best first; nothing where no single mistake explains them.

    best: the pose that explains them best. fits: whether a pose fits the points, and only approach, touch box or path
    speak against it. solve gives the solutions for corrected contacts. trials: of a fixture by
    relations that leave its shape open, or one of many.
    """
    deletion = CaseDeletion.of(contacts, residual_sigmas(fixture, contacts), best, fixture.placement) if best else None
    order = deletion.order if deletion else _on_contradicted_first(contacts, trials)  # step 1
    feasibility = trials or Feasibility(fixture, frozenset(contacts.rows[i] for i in order[:MOST_DOUBTED]))
    pairs = likely_pairs(contacts, order, deletion)
    swaps = (
        hypothesis for hypothesis in swapped_labels(contacts, pairs) if feasibility.is_feasible(hypothesis.contacts)
    )
    # Step 2.
    units = chain(coordinates(contacts), whole_files(contacts)) if _has_lengths(fixture) else iter(())
    if fits:
        against = _against(contacts, best) if best else order
        # A wrong unit leaves a fixture of planes its shape: only the touch boxes show it.
        stages = [approaches(contacts, against), units]
    else:
        stages = [units, tip_radii(fixture, contacts, solve)]
    if fits or len(contacts) < MANY:
        alone = deletion.singly if deletion else order
        stages[-1] = chain(stages[-1], without_each(contacts, alone if trials else alone[:CONTACTS_DOUBTED]))
        stages.append(islice(swaps, MOST_SWAPS))
    few = few_of_many(fixture, contacts, deletion, solve) if deletion and not fits else ()
    # Where single contacts cost next to nothing to ask, none is taken for several.
    for stage in chain(stages, few) if trials else chain(few, stages):
        # Step 3.
        asked: Iterator[Hypothesis] = (
            hypothesis for hypothesis in stage if feasibility.is_feasible(hypothesis.contacts)
        )
        if trials is not None:
            asked = _promising(asked, trials)
        found = [(h, told) for h in asked if (told := _tried(h, explained)) is not None]  # step 4
        if found:
            return _ranked(contacts, found)  # step 5
    return ()


def _ranked(contacts: Contacts, found: Sequence[tuple[Hypothesis, Diagnosis]]) -> tuple[Diagnosis, ...]:
    """Most plausible first; of a unit of the coordinates alone and of all lengths the less plausible is left out.

    Another sigma beside the coordinates changes the density of a normal number by its factor (as in
    `corrections.Hypothesis.penalty`), without which the larger sigma would always win.
    """

    def score(hypothesis: Hypothesis, told: Diagnosis) -> float:
        if not isinstance(told.value, float) or told.code != "unit":
            return told.chi2 or 0.0
        factor = float(hypothesis.contacts.sigmas[0] / contacts.sigmas[0]) / told.value
        return (told.chi2 or 0.0) + 2 * len(contacts) * math.log(factor)

    ranked = []
    best: dict[object, float] = {}
    for own, told in sorted(((score(*one), one[1]) for one in found), key=lambda pair: pair[0]):
        if told.code != "unit" or own <= best.setdefault(told.value, own) + INDISTINCT:
            ranked.append(told)
    return tuple(ranked)


def _has_lengths(fixture: Fixture) -> bool:
    """Whether anything of a fixture is a length; faces at angles fit contacts in any unit."""
    given = fixture.is_placed or fixture.touch or any(f.radius is not None for f in fixture.features.values())
    return bool(given) or any(relation.kind == "distance" for relation in fixture.relations)


def _on_contradicted_first(contacts: Contacts, trials: Trials | None) -> list[int]:
    """Indices of the contacts, those first that are on a feature that no surface explains."""
    suspects = trials.contradicted() if trials else ()
    return sorted(range(len(contacts)), key=lambda i: contacts.features[i] not in suspects)


def _promising(asked: Iterable[Hypothesis], trials: Trials) -> Iterator[Hypothesis]:
    """Those that the linear model does not rule out, the most promising first, since not all may be fitted."""
    promises = [(trials.promise(hypothesis.contacts), hypothesis) for hypothesis in asked]
    for promise, hypothesis in sorted(promises, key=lambda pair: pair[0]):
        if promise < math.inf:
            yield hypothesis


def _tried(hypothesis: Hypothesis, explained: Explained) -> Diagnosis | None:
    try:
        left = explained(hypothesis.contacts)
    except TactfixError:
        return None
    return None if left is None else hypothesis.explains(*left)


def _against(contacts: Contacts, solution: Solution) -> list[int]:
    """Indices of the contacts that say how the probe came, those first where it came most out of the material."""
    given = np.flatnonzero(contacts.has_approach)
    cosine = np.einsum("ij,ij->i", contacts.approaches[given], solution.normals[given])
    return [int(i) for i in given[np.argsort(-cosine)]]
