"""Mistakes in the contacts, each as a correction that is located again: of a few contacts, or of the whole file.

Few of many contacts (`few_of_many`):

1. Each contact whose deletion alone makes the others consistent (`deletion`) is tried on other features and deleted.
2. Else more and more contacts are deleted together, in the order of stepwise deletion, as long as that removes nearly
   all of chi-square; the others are located.
3. At the pose that is found, wrong contacts have residuals above SURE sigma: they are reported, or their labels
   swapped.

The tip radius (`tip_radii`):

1. The fixture is located with the tip radius as it is.
2. A change of the tip radius shifts every contact along its outward normal. This column is projected onto the
   complement of the motions of the fixture, and least squares give the change.
3. Steps 1 and 2 are repeated until the change is below a tenth of sigma.

Constants for many contacts, here, in `deletion` and in `diagnose`, were halved and doubled on 42 sets of 56 to 120
contacts: 1, 2, 3, 5 or 8 of them 0.3 to 3 mm off, one label wrong, or two swapped (mistakes of
`tests.validation.made_mistakes`).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.deletion import LEAST_REDUNDANCY, CaseDeletion
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture
from tactfix.mistakes import DiagnosisCode
from tactfix.noise import SURE
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.solution import Solutions
from tactfix.probe import residual_sigmas
from tactfix.results import Diagnosis
from tactfix.values import frozen_value
from tactfix.wording import listed

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
LATEST = 0.01
"""Share of the contacts' spread: a probe that reports points of the surface may trigger late by this much at most.
Overtravel is a length of the probe, whatever the fixture's size, but no contact file bounds it. So the share is a
choice without a source, which holds in every unit: 1 mm on 100 mm. On a fixture of 10 mm it leaves out a trigger
0.2 mm late; on one of several metres it admits tens of millimetres."""
UNITS_MEANT = {
    25.4: "inches where mm is said",
    1 / 25.4: "mm where inches are said",
    1e3: "metres where mm is said, or mm where micrometres are",
    1e-3: "mm where metres are said, or micrometres where mm is",
    1e3 / 25.4: "metres where inches are said",
    25.4e-3: "inches where metres are said",
    1e6: "metres where micrometres are said",
    1e-6: "micrometres where metres are said",
    25.4e3: "inches where micrometres are said",
    1 / 25.4e3: "micrometres where inches are said",
}
"""Factors between any two units that a contact file may have (mm, m, um, inch), each with the mistake that it
undoes."""


@frozen_value
class Correction:
    """A mistake in words, and the contacts without it; rows, features and value as in Diagnosis."""

    code: DiagnosisCode
    message: str
    contacts: Contacts
    rows: tuple[int, ...] = ()
    features: tuple[str, ...] = ()
    value: float | None = None

    def explains(self, chi2: float, remark: str) -> Diagnosis:
        """The diagnosis if the corrected contacts have this chi-square; remark: what to say of their pose."""
        return Diagnosis(self.code, self.rows, self.features, self.value, chi2, self.message + remark)


Stage: TypeAlias = Iterator[Correction]
"""Corrections that are tried together. If one of them explains the contacts, no later stage is tried."""
Solve: TypeAlias = Callable[[Contacts], Solutions]
"""Every pose that explains corrected contacts, or the nearest one if there is none."""


def few_of_many(fixture: Fixture, contacts: Contacts, deletion: CaseDeletion, solve: Solve) -> Iterator[Stage]:
    """The corrections of a few of many contacts. A scanning probe makes thousands, and more than one may be wrong."""
    if len(contacts) >= CONTACTS_PER_FAULT:  # step 1
        alone = [i for i in deletion.singly[:SINGLE_DELETIONS] if deletion.is_explained_without([i])]
        yield relabelled(contacts, alone[:1])
        yield without_each(contacts, alone)
    wrong = _wrong_ones(fixture, contacts, deletion, solve)  # steps 2 and 3
    if len(wrong) == 2 and contacts.features[wrong[0]] != contacts.features[wrong[1]]:
        yield swapped_labels(contacts, [(wrong[0], wrong[1])])
    if len(wrong) > 1:
        yield _without_all(contacts, wrong)
    else:
        yield relabelled(contacts, wrong)
        yield without_each(contacts, wrong)


def _wrong_ones(fixture: Fixture, contacts: Contacts, deletion: CaseDeletion, solve: Solve) -> list[int]:
    """Indices of the contacts above SURE sigma at a pose that explains all others; empty if no such pose is found."""
    for count in JOINT_DELETIONS:
        suspects = deletion.order[:count]
        if count > len(contacts) // CONTACTS_PER_FAULT or deletion.remaining_share(suspects) > MOST_REMAINING:
            continue
        try:
            solutions = solve(_without(contacts, suspects))
        except TactfixError:
            continue
        best = next(iter(solutions.found), None)
        if best is not None and best.chi2 <= solutions.limit:
            residuals, _ = contact_residuals(best.surfaces, contacts)
            return [int(i) for i in np.flatnonzero(np.abs(residuals) > SURE * residual_sigmas(fixture, contacts))]
    return []


def relabelled(contacts: Contacts, index: Sequence[int]) -> Stage:
    """Each of these contacts on each other feature that is touched."""
    for i in index:
        for feature in contacts.by_feature:
            if feature == contacts.features[i]:
                continue
            features = (*contacts.features[:i], feature, *contacts.features[i + 1 :])
            message = (
                f"{contacts.label(i)} is labelled {contacts.features[i]}; on {feature} it fits, and the contacts are "
                "consistent"
            )
            other = replace(contacts, features=features)
            yield Correction("relabel", message, other, (contacts.rows[i],), (feature,))


def without_each(contacts: Contacts, index: Sequence[int]) -> Stage:
    """Each of these contacts deleted alone."""
    for i in index if len(contacts) > 6 else ():
        label = f"{contacts.label(i)} ({contacts.features[i]})"
        message = f"without {label} the others are consistent: touch it again"
        rows, features = _rows_and_features(contacts, [i])
        yield Correction("outlier", message, _without(contacts, [i]), rows, features)


def _without_all(contacts: Contacts, index: Sequence[int]) -> Stage:
    labels = listed([contacts.label(i) for i in index])
    message = f"without {labels} the others are consistent: touch these again"
    yield Correction("outlier", message, _without(contacts, index), *_rows_and_features(contacts, index))


def _rows_and_features(contacts: Contacts, index: Sequence[int]) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """The rows of these contacts and their features, as a Diagnosis has them."""
    return tuple(contacts.rows[i] for i in index), tuple(dict.fromkeys(contacts.features[i] for i in index))


def _without(contacts: Contacts, index: Sequence[int]) -> Contacts:
    return contacts.subset(np.delete(np.arange(len(contacts)), index))


def likely_pairs(contacts: Contacts, order: Sequence[int], deletion: CaseDeletion | None) -> list[tuple[int, int]]:
    """Pairs of contacts on different features, in decreasing order of the fall of chi-square when both are deleted."""
    names = contacts.features
    pairs = [(i, k) for i, k in combinations(sorted(order[:MOST_SUSPECTS]), 2) if names[i] != names[k]]
    if deletion is None:
        return pairs
    gains = np.array([deletion.gain(pair) for pair in pairs])
    return [pairs[int(p)] for p in np.argsort(-gains, kind="stable")]


def swapped_labels(contacts: Contacts, pairs: Sequence[tuple[int, int]]) -> Stage:
    """The labels of each of these pairs of contacts swapped."""
    for i, k in pairs:
        features = list(contacts.features)
        features[i], features[k] = features[k], features[i]
        message = f"with the labels of {contacts.label(i)} and {contacts.label(k)} swapped the contacts are consistent"
        swapped = replace(contacts, features=tuple(features))
        yield Correction("swapped_labels", message, swapped, *_rows_and_features(contacts, [i, k]))


def approaches(contacts: Contacts, against: Sequence[int]) -> Stage:
    """All approaches reversed, or one of them; against: indices, the contact that is most clearly reversed first."""
    if not against:
        return
    message = "with all approaches reversed the contacts are consistent: are these outward normals (nx, ny, nz)?"
    yield Correction("approach", message, replace(contacts, approaches=-contacts.approaches))
    for i in against[:SINGLE_DELETIONS]:
        approaches = contacts.approaches.copy()
        approaches[i] *= -1
        message = f"with the approach of {contacts.label(i)} reversed the contacts are consistent"
        rows, features = (contacts.rows[i],), (contacts.features[i],)
        yield Correction("approach", message, replace(contacts, approaches=approaches), rows, features)


def tip_radii(fixture: Fixture, contacts: Contacts, solve: Solve) -> Stage:
    """Another tip radius than that of the file: zero, or the one that fits best."""
    given = f"{contacts.tip_radius:g} {fixture.units}"
    if contacts.tip_radius > 0:
        message = f"with tip radius 0 instead of {given} the contacts are consistent: are they corrected for the tip?"
        yield Correction("tip_radius", message, replace(contacts, tip_radius=0.0), value=0.0)
    try:
        corrected = _with_estimated_tip(contacts, solve)
    except TactfixError:
        return
    if corrected is not None and is_possible_tip(contacts, corrected.tip_radius):
        value = corrected.tip_radius
        words = tip_words(value, f"{abs(value):.4g} {fixture.units}", given)
        message = f"with {words} the contacts are consistent{late_question(value)}"
        yield Correction("tip_radius", message, corrected, value=value)


def is_possible_tip(contacts: Contacts, radius: float) -> bool:
    """Whether an effective tip radius is possible: below 0, by LATEST at most, for points of the surface only."""
    return radius >= 0 or (contacts.tip_radius == 0 and -radius <= LATEST * contacts.spread)


def tip_words(radius: float, shown: str, given: str) -> str:
    """What an effective tip radius is; shown: its size with its unit, given: that of the file."""
    if radius < 0:
        return f"every contact {shown} farther out of the material"
    return f"a tip radius of {shown} instead of {given}"


def late_question(radius: float) -> str:
    """What is asked about an effective tip radius below 0."""
    return ": does the probe trigger late?" if radius < 0 else ""


def _with_estimated_tip(contacts: Contacts, solve: Solve) -> Contacts | None:
    """The contacts with the tip radius that fits best; None if undetermined, or if chi-square hardly falls."""
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
    return contacts


def unit_question(factor: float, *, all_lengths: bool = False) -> str:
    """What is asked where a factor makes the coordinates, or all lengths, consistent, and what to do about it."""
    remedy = "give that unit for the contacts" if all_lengths else "write them in the unit of the other lengths"
    return f"are they {UNITS_MEANT[factor]}? If so, {remedy}"


def coordinates(contacts: Contacts) -> Stage:
    """The coordinates alone in another unit than that of the file."""
    for factor in UNITS_MEANT:
        message = f"multiplied by {factor:.10g} the coordinates are consistent: {unit_question(factor)}"
        yield Correction("unit", message, replace(contacts, points=contacts.points * factor), value=factor)


def whole_files(contacts: Contacts) -> Stage:
    """All lengths in another unit than that of the file."""
    for factor in UNITS_MEANT:
        scaled = replace(
            contacts,
            points=contacts.points * factor,
            sigmas=contacts.sigmas * factor,
            tip_radius=contacts.tip_radius * factor,
            tip_offset=None if contacts.tip_offset is None else contacts.tip_offset * factor,
        )
        question = unit_question(factor, all_lengths=True)
        message = f"multiplied by {factor:.10g} all lengths of the contacts are consistent: {question}"
        yield Correction("unit", message, scaled, value=factor)
