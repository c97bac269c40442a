"""The staged diagnosis: corrections of the contacts are tried in stages, and each is located again.

1. Contacts are ordered by the fall of chi-square when they are deleted at the best pose (`deletion`).
2. The corrections are put in stages. If a pose fits and only approaches reject it, approaches come first, else units
   and tip radii. Single contacts follow, then a few of many contacts together, and swapped labels last. Of many
   contacts only the few are left to the stages, and all other mistakes to `diagnose`.
3. A correction that is not feasible (`feasibility`) is dropped: nearly all units and most swaps are.
4. The others are located again, which takes a tenth of a second or more each. The first stage that leaves a pose ends
   the search.
5. Its corrections are reported, the most plausible first.

Few of many contacts (`few_of_many`):

1. Each contact whose deletion alone makes the others consistent (`deletion`) is tried on other features and deleted.
2. Else more and more contacts are deleted together, in the order of stepwise deletion, as long as that removes nearly
   all of chi-square; the others are located.
3. At the pose that is found, wrong contacts have residuals above SURE sigma: they are reported, or their labels
   swapped.

The tip radius (`_tip_radii`):

1. The fixture is located with the given tip radius.
2. A change of the tip radius shifts every contact along its outward normal. This column is projected onto the
   complement of the motions of the fixture, and least squares give the change.
3. Steps 1 and 2 are repeated until the change is below a tenth of sigma.

Constants for many contacts, here, in `deletion` and in `diagnose`, were halved and doubled on the 42 sets: of 56 to 120
contacts 1, 2, 3, 5 or 8 are 0.3 to 3 mm off, one label is wrong, or two are swapped (mistakes of
`tests.validation.made_mistakes`).
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, combinations, islice
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.contact_mistakes import (
    all_reversed,
    deleted,
    is_possible_tip,
    relabelled,
    reversed_approaches,
    swapped,
    unit_changes,
)
from tactfix.diagnosis.deletion import LEAST_REDUNDANCY, CaseDeletion
from tactfix.diagnosis.feasibility import Feasibility
from tactfix.diagnosis.hypotheses import INDISTINCT, Hypothesis
from tactfix.diagnosis.messages import diagnosis_of_correction
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture
from tactfix.noise import SURE
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.solution import Solution, Solutions
from tactfix.probe import residual_sigmas
from tactfix.relations.trials import CorrectionTrials
from tactfix.results import Diagnosis

MANY = 48
"""Contacts from which on a few wrong ones are looked for by their residuals first (`few_of_many`), and mistakes that
concern all contacts are searched for with a part of them (`diagnose`). With 96, 3 of the 42 sets lose their diagnosis,
and all take 2.4 times as long; with 24 nothing changes."""
SINGLE_DELETIONS = 12
"""Contacts that are deleted or relabelled one by one, in decreasing order of the fall of chi-square: a wrong one is
nearly always the first. 6 and 24 give the same diagnoses of the 42 sets."""
MOST_SUSPECTS = 40
"""Contacts, first in the order of stepwise deletion, by which a correction is tested for feasibility, and of which
every pair of labels is swapped. The cost grows with the square of their number: 20 and 80 give the same diagnoses of
the 42 sets in 0.9 and 1.5 times the time."""
MOST_SWAPS = 24
"""Swaps of labels that are located again, in decreasing order of the fall of chi-square without the two contacts. Each
takes a search. 1, 12 and 48 give the same diagnoses of the 42 sets, where swaps are found by `few_of_many`."""
JOINT_DELETIONS = (1, 2, 3, 5, 8, 12, 20)
"""Numbers of contacts that are deleted together, one after the other: each is about 1.6 times the one before, so
that at most 0.6 times as many good contacts as bad ones are deleted with them. Afterwards only those above SURE
sigma count."""
CONTACTS_PER_FAULT = 8
"""Contacts for each one that may be deleted (no unit): of fewer, too few are left to call the deleted ones wrong.
With 16, 6 of the 42 sets lose their diagnosis (5 wrong of 56, 8 of 112); with 4, 3 more get one (8 wrong of 56)."""
MOST_REMAINING = 0.1
"""Share of chi-square that may remain, by the linear model, for the deletion to be located again. 0.05, 0.2 and 0.5
give the same diagnoses of the 42 sets; 0.5 takes 1.4 times the time."""
TIP_STEPS = 6
"""Linear corrections of the tip radius at most: the residuals are linear in it, and only the pose that moves with it
is not."""
LEAST_GAIN = 0.5
"""Share by which another tip radius must lower chi-square, by the linear model, to be located again: the true one
lowers it by nearly all, and each location costs a search."""

Stage: TypeAlias = Iterable[Hypothesis]
"""Corrections of the contacts that are tried together. If one explains the contacts, no later stage is tried."""
Correction: TypeAlias = tuple[Hypothesis, Contacts]
"""A correction, and the contacts corrected by it."""
Solve: TypeAlias = Callable[[Contacts], Solutions]
"""Every pose that explains corrected contacts, or the nearest one if there is none."""
Explained: TypeAlias = Callable[[Contacts], tuple[float, str] | None]
"""The chi-square of the pose of corrected contacts, and a remark if it is weakly determined; None if no pose is
left."""


def staged_diagnosis(
    fixture: Fixture,
    contacts: Contacts,
    best: Solution | None,
    fits: bool,
    solve: Solve,
    explained: Explained,
    trials: CorrectionTrials | None = None,
) -> tuple[Diagnosis, ...]:
    """The corrections of the first stage that explains the contacts, best first; empty if no single mistake does.

    best: the pose with the least chi-square. fits: whether a pose fits, and only approach, touch box or path reject it.
    solve: the solutions of corrected contacts. trials: for a fixture whose relations leave its shape open, or allow
    many shapes.
    """
    deletion = CaseDeletion.of(contacts, residual_sigmas(fixture, contacts), best, fixture.placement) if best else None
    order = deletion.order if deletion else _contradicted_first(contacts, trials)  # step 1
    feasibility = trials or Feasibility(fixture, frozenset(contacts.rows[i] for i in order[:MOST_SUSPECTS]))

    def feasible(stage: Stage) -> Iterator[Correction]:
        corrections = ((one, one.corrected_contacts(contacts)) for one in stage)
        return (correction for correction in corrections if feasibility.is_feasible(correction[1]))  # step 3

    # Step 2.
    units = unit_changes(contacts) if _has_lengths(fixture) else ()
    if fits:
        against = _against(contacts, best) if best else order
        # A wrong unit leaves a fixture of planes its shape: only the touch boxes show it.
        stages = [feasible(_approaches(contacts, against)), feasible(units)]
    elif trials is None and len(contacts) >= MANY:
        stages = []  # `diagnose` searches for them with a part of the contacts
    else:
        stages = [feasible(units), feasible(_tip_radii(contacts, solve))]
    if fits or len(contacts) < MANY:
        alone = deletion.singly if deletion else order
        stages[-1] = chain(stages[-1], feasible(_without_each(contacts, alone if trials else alone[:SINGLE_DELETIONS])))
        swaps = (swapped(contacts, i, k) for i, k in _likely_pairs(contacts, order, deletion))
        stages.append(islice(feasible(swaps), MOST_SWAPS))
    few = map(feasible, few_of_many(fixture, contacts, deletion, solve)) if deletion and not fits else iter(())
    # With trials single contacts are cheap to test, and come before several.
    for stage in chain(stages, few) if trials else chain(few, stages):
        asked = stage if trials is None else _promising(stage, trials)
        found = [(one, entry) for one in asked if (entry := _tried(fixture, contacts, one, explained))]  # step 4
        if found:
            return _ranked(contacts, [(hypothesis, entry) for (hypothesis, _), entry in found])  # step 5
    return ()


def _ranked(contacts: Contacts, found: Sequence[tuple[Hypothesis, Diagnosis]]) -> tuple[Diagnosis, ...]:
    """Most plausible first; of one factor on the coordinates alone and on all lengths only the more plausible.

    If sigma is scaled too, the density of a normal number changes by the same factor (as in `Hypothesis.penalty`);
    otherwise the larger sigma would always win.
    """

    def score(one: Hypothesis, entry: Diagnosis) -> float:
        return (entry.chi2 or 0.0) + 2 * len(contacts) * math.log(one.sigmas / one.points)

    ranked = []
    best: dict[float, float] = {}
    for own, one, entry in sorted(((score(*pair), *pair) for pair in found), key=lambda scored: scored[0]):
        if one.code != "unit" or own <= best.setdefault(one.points, own) + INDISTINCT:
            ranked.append(entry)
    return tuple(ranked)


def _has_lengths(fixture: Fixture) -> bool:
    """Whether the fixture has a length at all: planes known by angles alone fit contacts in any unit."""
    given = fixture.is_placed or fixture.touch or any(f.radius is not None for f in fixture.features.values())
    return bool(given) or any(relation.kind == "distance" for relation in fixture.relations)


def _contradicted_first(contacts: Contacts, trials: CorrectionTrials | None) -> list[int]:
    """Indices of the contacts, those on features first whose contacts no surface explains."""
    suspects = trials.contradicted() if trials else ()
    return sorted(range(len(contacts)), key=lambda i: contacts.features[i] not in suspects)


def _promising(stage: Iterable[Correction], trials: CorrectionTrials) -> Iterator[Correction]:
    """The corrections that the linear model does not exclude, in order of its chi-square: not all may be fitted."""
    ranked = [(trials.least_predicted(corrected), (one, corrected)) for one, corrected in stage]
    for chi2, correction in sorted(ranked, key=lambda pair: pair[0]):
        if chi2 < math.inf:
            yield correction


def _tried(fixture: Fixture, contacts: Contacts, correction: Correction, explained: Explained) -> Diagnosis | None:
    hypothesis, corrected = correction
    try:
        left = explained(corrected)
    except TactfixError:
        return None
    return None if left is None else diagnosis_of_correction(contacts, fixture.units, hypothesis, *left)


def _against(contacts: Contacts, solution: Solution) -> list[int]:
    """Indices of the contacts with an approach, the one that is most clearly out of the material first."""
    given = np.flatnonzero(contacts.has_approach)
    cosine = np.einsum("ij,ij->i", contacts.approaches[given], solution.normals[given])
    return [int(i) for i in given[np.argsort(-cosine)]]


def few_of_many(fixture: Fixture, contacts: Contacts, deletion: CaseDeletion, solve: Solve) -> Iterator[Stage]:
    """The corrections of a few of many contacts. A scanning probe makes thousands, and more than one may be wrong."""
    if len(contacts) >= CONTACTS_PER_FAULT:  # step 1
        alone = [i for i in deletion.singly[:SINGLE_DELETIONS] if deletion.is_explained_without([i])]
        yield _relabelled_each(contacts, alone[:1])
        yield _without_each(contacts, alone)
    wrong = _wrong_ones(fixture, contacts, deletion, solve)  # steps 2 and 3
    if len(wrong) == 2 and contacts.features[wrong[0]] != contacts.features[wrong[1]]:
        yield [swapped(contacts, *wrong)]
    if len(wrong) > 1:
        yield [deleted(contacts, wrong)]
    else:
        yield _relabelled_each(contacts, wrong)
        yield _without_each(contacts, wrong)


def _wrong_ones(fixture: Fixture, contacts: Contacts, deletion: CaseDeletion, solve: Solve) -> list[int]:
    """Indices of the contacts above SURE sigma at a pose that explains all others; empty if no such pose is found."""
    for count in JOINT_DELETIONS:
        suspects = deletion.order[:count]
        if count > len(contacts) // CONTACTS_PER_FAULT or deletion.remaining_share(suspects) > MOST_REMAINING:
            continue
        try:
            solutions = solve(deleted(contacts, suspects).corrected_contacts(contacts))
        except TactfixError:
            continue
        best = next(iter(solutions.found), None)
        if best is not None and best.chi2 <= solutions.limit:
            residuals, _ = contact_residuals(best.surfaces, contacts)
            return [int(i) for i in np.flatnonzero(np.abs(residuals) > SURE * residual_sigmas(fixture, contacts))]
    return []


def _relabelled_each(contacts: Contacts, index: Sequence[int]) -> Stage:
    """Each of these contacts on each other feature that is touched."""
    pairs = ((i, feature) for i in index for feature in contacts.by_feature if feature != contacts.features[i])
    return (relabelled(contacts, i, feature) for i, feature in pairs)


def _without_each(contacts: Contacts, index: Sequence[int]) -> Stage:
    """Each of these contacts deleted alone."""
    return (deleted(contacts, [i]) for i in index if len(contacts) > 6)


def _likely_pairs(contacts: Contacts, order: Sequence[int], deletion: CaseDeletion | None) -> list[tuple[int, int]]:
    """Pairs of contacts on different features, in decreasing order of the fall of chi-square when both are deleted."""
    names = contacts.features
    pairs = [(i, k) for i, k in combinations(sorted(order[:MOST_SUSPECTS]), 2) if names[i] != names[k]]
    if deletion is None:
        return pairs
    gains = np.array([deletion.gain(pair) for pair in pairs])
    return [pairs[int(p)] for p in np.argsort(-gains, kind="stable")]


def _approaches(contacts: Contacts, against: Sequence[int]) -> Stage:
    """All approaches reversed, or one of them; against: indices, the contact that is most clearly reversed first."""
    alone = [reversed_approaches(contacts, [i]) for i in against[:SINGLE_DELETIONS]]
    return [all_reversed(contacts), *alone] if alone else []


def _tip_radii(contacts: Contacts, solve: Solve) -> Stage:
    """Another tip radius than that of the file: zero, or the one that fits best."""
    if contacts.tip_radius > 0:
        yield Hypothesis("tip_radius", tip=0.0)
    try:
        radius = _estimated_tip(contacts, solve)
    except TactfixError:
        return
    if radius is not None and is_possible_tip(contacts, radius):
        yield Hypothesis("tip_radius", tip=radius)


def _estimated_tip(contacts: Contacts, solve: Solve) -> float | None:
    """The tip radius that fits best; None if it is not determined, or if chi-square is not clearly reduced."""
    for number in range(TIP_STEPS):
        solution = next(iter(solve(contacts).found), None)
        if solution is None:
            return None
        span = CaseDeletion.of(contacts, contacts.sigmas, solution).span
        shift = 1 / contacts.sigmas
        unexplained = shift - span @ (span.T @ shift)
        if np.linalg.norm(unexplained) < LEAST_REDUNDANCY * np.linalg.norm(shift):
            return None
        scaled = solution.residuals / contacts.sigmas
        change = float(unexplained @ scaled / (unexplained @ unexplained))
        if not number and change**2 * float(unexplained @ unexplained) < LEAST_GAIN * float(scaled @ scaled):
            return None
        contacts = replace(contacts, tip_radius=contacts.tip_radius + change)
        if abs(change) < 0.1 * contacts.sigmas.min():
            break
    return contacts.tip_radius
