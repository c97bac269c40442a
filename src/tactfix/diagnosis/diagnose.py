"""Why no pose explains the contacts: mistakes that, once corrected, make them consistent.

If the fixture has few shapes, all mistakes are fitted at once (`hypothesis_tests`). Otherwise, and for a few wrong
contacts of many, corrections are tried in stages (`staged_diagnosis`): approaches reversed, a wrong tip radius, a wrong
unit, wrong contacts, swapped labels.

1. Contacts are ordered by the fall of chi-square when they are deleted at the best pose (`deletion`).
2. The corrections are put in stages. If a pose fits and only approaches reject it, approaches come first, else units
   and tip radii. Single contacts follow, then a few of many contacts together, and swapped labels last. Of many
   contacts only the few are left to the stages, and all other mistakes to `many_contacts`.
3. A correction that is not feasible (`feasibility`) is dropped: nearly all units and most swaps are.
4. The others are located again, which takes a tenth of a second or more each. The first stage that leaves a pose ends
   the search.
5. Its corrections are reported, the most plausible first.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain, islice
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.contact_faults import (
    MOST_SUSPECTS,
    MOST_SWAPS,
    SINGLE_DELETIONS,
    Correction,
    Solve,
    approaches,
    coordinates,
    few_of_many,
    likely_pairs,
    swapped_labels,
    tip_radii,
    whole_files,
    without_each,
)
from tactfix.diagnosis.deletion import CaseDeletion
from tactfix.diagnosis.feasibility import Feasibility
from tactfix.diagnosis.hypotheses import Problem
from tactfix.diagnosis.hypothesis_tests import Accepts, mistakes_that_explain
from tactfix.diagnosis.many_contacts import mistakes_of_all
from tactfix.diagnosis.ranking import INDISTINCT
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture
from tactfix.poses.solution import Solution
from tactfix.probe import residual_sigmas
from tactfix.relations.realization import few_shapes, shape_sigma
from tactfix.relations.trials import Trials
from tactfix.results import Diagnosis

MOST_SHAPES = 2
"""Shapes of a fixture by relations that are diagnosed: the two mirror images that most relations allow, or one body
in two frames. `few_shapes` returns the shapes of at most two bodies."""
MANY = 48
"""Contacts from which on a few wrong ones are looked for by their residuals first (`few_of_many`), and mistakes that
concern all contacts are searched for with a part of them (`many_contacts`). With 96, 3 of the 42 sets of
`contact_faults` lose their diagnosis, and all take 2.4 times as long; with 24 nothing changes."""
Explained: TypeAlias = Callable[[Contacts], tuple[float, str] | None]
"""The chi-square of the pose of corrected contacts, and a remark if it is weakly determined; None if no pose is
left."""

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
    if not shapes:
        return staged()
    if len(contacts) >= MANY and (few := staged()):
        return few
    sigmas = np.hypot(residual_sigmas(fixture, contacts), shape_sigma(fixture))
    problems = [Problem(shape, contacts, sigmas) for shape in shapes[:MOST_SHAPES]]
    explain = mistakes_that_explain if len(contacts) < MANY else mistakes_of_all
    found = [explain(fixture, problem, solutions, accepts) for problem in problems]
    return min((one for one in found if one), key=lambda one: one[0].chi2 or 0.0, default=())


def staged_diagnosis(
    fixture: Fixture,
    contacts: Contacts,
    best: Solution | None,
    fits: bool,
    solve: Solve,
    explained: Explained,
    trials: Trials | None = None,
) -> tuple[Diagnosis, ...]:
    """The corrections of the first stage that explains the contacts, best first; empty if no single mistake does.

    best: the pose with the least chi-square. fits: whether a pose fits, and only approach, touch box or path reject it.
    solve: the solutions of corrected contacts. trials: for a fixture whose relations leave its shape open, or allow
    many shapes.
    """
    deletion = CaseDeletion.of(contacts, residual_sigmas(fixture, contacts), best, fixture.placement) if best else None
    order = deletion.order if deletion else _contradicted_first(contacts, trials)  # step 1
    feasibility = trials or Feasibility(fixture, frozenset(contacts.rows[i] for i in order[:MOST_SUSPECTS]))
    pairs = likely_pairs(contacts, order, deletion)
    swaps = (
        correction for correction in swapped_labels(contacts, pairs) if feasibility.is_feasible(correction.contacts)
    )
    # Step 2.
    units = chain(coordinates(contacts), whole_files(contacts)) if _has_lengths(fixture) else iter(())
    if fits:
        against = _against(contacts, best) if best else order
        # A wrong unit leaves a fixture of planes its shape: only the touch boxes show it.
        stages = [approaches(contacts, against), units]
    elif trials is None and len(contacts) >= MANY:
        stages = []  # `mistakes_of_all` searches for them with a part of the contacts
    else:
        stages = [units, tip_radii(fixture, contacts, solve)]
    if fits or len(contacts) < MANY:
        alone = deletion.singly if deletion else order
        stages[-1] = chain(stages[-1], without_each(contacts, alone if trials else alone[:SINGLE_DELETIONS]))
        stages.append(islice(swaps, MOST_SWAPS))
    few = few_of_many(fixture, contacts, deletion, solve) if deletion and not fits else ()
    # With trials single contacts are cheap to test, and come before several.
    for stage in chain(stages, few) if trials else chain(few, stages):
        # Step 3.
        asked: Iterator[Correction] = (
            correction for correction in stage if feasibility.is_feasible(correction.contacts)
        )
        if trials is not None:
            asked = _promising(asked, trials)
        found = [(h, entry) for h in asked if (entry := _tried(h, explained)) is not None]  # step 4
        if found:
            return _ranked(contacts, found)  # step 5
    return ()


def _ranked(contacts: Contacts, found: Sequence[tuple[Correction, Diagnosis]]) -> tuple[Diagnosis, ...]:
    """Most plausible first; of one factor on the coordinates alone and on all lengths only the more plausible.

    If sigma is scaled too, the density of a normal number changes by the same factor (as in
    `hypotheses.Hypothesis.penalty`); otherwise the larger sigma would always win.
    """

    def score(correction: Correction, entry: Diagnosis) -> float:
        if not isinstance(entry.value, float) or entry.code != "unit":
            return entry.chi2 or 0.0
        factor = float(correction.contacts.sigmas[0] / contacts.sigmas[0]) / entry.value
        return (entry.chi2 or 0.0) + 2 * len(contacts) * math.log(factor)

    ranked = []
    best: dict[object, float] = {}
    for own, entry in sorted(((score(*one), one[1]) for one in found), key=lambda pair: pair[0]):
        if entry.code != "unit" or own <= best.setdefault(entry.value, own) + INDISTINCT:
            ranked.append(entry)
    return tuple(ranked)


def _has_lengths(fixture: Fixture) -> bool:
    """Whether the fixture has a length at all: planes known by angles alone fit contacts in any unit."""
    given = fixture.is_placed or fixture.touch or any(f.radius is not None for f in fixture.features.values())
    return bool(given) or any(relation.kind == "distance" for relation in fixture.relations)


def _contradicted_first(contacts: Contacts, trials: Trials | None) -> list[int]:
    """Indices of the contacts, those on features first whose contacts no surface explains."""
    suspects = trials.contradicted() if trials else ()
    return sorted(range(len(contacts)), key=lambda i: contacts.features[i] not in suspects)


def _promising(asked: Iterable[Correction], trials: Trials) -> Iterator[Correction]:
    """The corrections that the linear model does not exclude, in order of its chi-square: not all may be fitted."""
    ranked = [(trials.least_predicted(correction.contacts), correction) for correction in asked]
    for chi2, correction in sorted(ranked, key=lambda pair: pair[0]):
        if chi2 < math.inf:
            yield correction


def _tried(correction: Correction, explained: Explained) -> Diagnosis | None:
    try:
        left = explained(correction.contacts)
    except TactfixError:
        return None
    return None if left is None else correction.explains(*left)


def _against(contacts: Contacts, solution: Solution) -> list[int]:
    """Indices of the contacts with an approach, the one that is most clearly out of the material first."""
    given = np.flatnonzero(contacts.has_approach)
    cosine = np.einsum("ij,ij->i", contacts.approaches[given], solution.normals[given])
    return [int(i) for i in given[np.argsort(-cosine)]]
