"""Why no pose explains the contacts: single mistakes that would make them consistent.

Each hypothesis corrects one mistake in the contacts and locates again; those after which a pose is left are
reported. A cell makes these mistakes: all or one approach reversed, a forgotten or wrong tip radius, a wrong unit,
one bad contact, two labels swapped. Approaches are doubted first where a pose fits but for them; what is rarer or would
explain more is asked only where nothing before it explains the contacts, labels last.

Locating again costs a tenth of a second or more, so that a hypothesis is first asked whether a few of its contacts rule
it out (`impossible_contacts`): that leaves few of the units, and of the pairs whose labels may be swapped.

The tip radius is estimated: at the best pose the residuals that no motion of the fixture explains are projected on what
a change of the tip radius does (the same shift along every outward normal), and the fixture is solved again, a few
times.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations, islice
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.doubts import SEEN, Doubts
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.impossible_contacts import are_beyond_boxes, least_chi_square
from tactfix.motion_words import listed
from tactfix.noise import SURE, chi_square_limit
from tactfix.realization import fixture_scale, realize
from tactfix.refinement import contact_residuals, contact_sigmas
from tactfix.solution import Solution, Solutions

MOST_CONTACTS = 12
"""Contacts that are doubted one by one, those that gain most by it first."""
MOST_ASKED = 40
"""Contacts, the same first, that are asked whether they rule a hypothesis out, and of which each two labels are
swapped: the cost grows with the square of their number."""
MOST_SWAPS = 24
"""Swaps that are located, those first without whose two contacts chi-square would fall most."""
SEVERAL = (1, 2, 3, 5, 8, 12, 20)
LEFT = 8
"""Contacts, those that are doubted most, left out together, where they are no more than one of so many."""
MUCH = 0.1
"""Share of chi-square that is not left, as far as residuals near the best pose tell, where those left out are wrong."""
MANY = 48
"""Contacts of which parts without any wrong one have been searched (`pose_consensus`): beyond few of many there is none
to find."""
TIP_STEPS = 6
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
"""What the numbers are where a factor makes them right: all pairs of the units that a contact file may have."""


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """A mistake in words, and the contacts as they would be without it."""

    message: str
    contacts: Contacts


Stage: TypeAlias = Iterator[Hypothesis]
"""What is asked together: where one of them explains the contacts, nothing after them is asked."""
Solve: TypeAlias = Callable[[Contacts], Solutions]
IsConsistent: TypeAlias = Callable[[Contacts], bool]

NOTHING_EXPLAINS = (
    "no single bad contact, label, approach, unit or tip radius explains it: is this the right fixture file?"
)


def suspicions(
    fixture: Fixture,
    contacts: Contacts,
    best: Solution | None,
    fits: bool,
    solve: Solve,
    is_consistent: IsConsistent,
) -> tuple[str, ...]:
    """What would make the contacts consistent, in words; says so where no single mistake explains them.

    best: the pose that explains them best. fits: whether a pose fits the points, and only approach, touch box or path
    speak against it. solve gives the solutions for corrected contacts, is_consistent says whether a pose is left for
    them.
    """
    doubts = Doubts.of(contacts, _sigmas(fixture, contacts), best) if best else None
    order = doubts.order if doubts else list(range(len(contacts)))
    screen = _Screen(fixture, frozenset(contacts.rows[i] for i in order[:MOST_ASKED]))
    pairs = _pairs(contacts, order, doubts)
    swaps = (hypothesis for hypothesis in _labels(contacts, pairs) if screen.lets_pass(hypothesis.contacts))
    if fits:
        against = _against(contacts, best) if best else order
        # A wrong unit leaves a fixture of planes its shape: only the touch boxes show it.
        stages = [_approaches(contacts, against), _coordinates(contacts), _whole_files(contacts)]
    else:
        stages = [_coordinates(contacts), _whole_files(contacts), _tip_radii(fixture, contacts, solve)]
    if fits or len(contacts) < MANY:
        alone = doubts.singly if doubts else order
        stages[-1] = chain(stages[-1], _without_each(contacts, alone[:MOST_CONTACTS]))
        stages.append(islice(swaps, MOST_SWAPS))
    few = _few_of_many(fixture, contacts, doubts, solve) if doubts and not fits else ()
    for stage in chain(few, stages):
        found = tuple(
            hypothesis.message
            for hypothesis in stage
            if screen.lets_pass(hypothesis.contacts) and _holds(hypothesis.contacts, is_consistent)
        )
        if found:
            return found
    return (NOTHING_EXPLAINS,)


def _holds(contacts: Contacts, is_consistent: IsConsistent) -> bool:
    try:
        return is_consistent(contacts)
    except TactfixError:
        return False


def _sigmas(fixture: Fixture, contacts: Contacts) -> Floats:
    return contact_sigmas(contacts, {name: feature.sigma for name, feature in fixture.features.items()})


class _Screen:
    """Rules out at little cost what no pose explains, whatever the shape that the relations leave the fixture."""

    def __init__(self, fixture: Fixture, rows: frozenset[int]) -> None:
        self.fixture, self.rows = fixture, rows
        self.shapes = realize(fixture)
        scale = fixture_scale(fixture)
        slack = [r.sigma * (1.0 if r.kind == "distance" else scale) for r in fixture.relations]
        self.slack = SURE * float(np.linalg.norm(slack))

    def lets_pass(self, contacts: Contacts) -> bool:
        """Whether the contacts of these rows do not rule every pose out."""
        asked = contacts.subset([i for i, row in enumerate(contacts.rows) if row in self.rows])
        sigmas = np.hypot(_sigmas(self.fixture, asked), self.slack)
        limit = chi_square_limit(len(contacts) - 6)
        try:
            return not self.shapes or any(
                least_chi_square(shape, asked, sigmas) <= limit
                and not are_beyond_boxes(shape, self.fixture.touch, asked)
                for shape in self.shapes
            )
        except TactfixError:  # a tip that does not fit into a bore
            return False


def _against(contacts: Contacts, solution: Solution) -> list[int]:
    """Indices of the contacts that say how the probe came, those first where it came most out of the material."""
    given = np.flatnonzero(contacts.has_approach)
    cosine = np.einsum("ij,ij->i", contacts.approaches[given], solution.normals[given])
    return [int(i) for i in given[np.argsort(-cosine)]]


def _few_of_many(fixture: Fixture, contacts: Contacts, doubts: Doubts, solve: Solve) -> Iterator[Stage]:
    """What explains all but a few of the contacts: a probe that scans makes thousands, and not one mistake at most."""
    if len(contacts) >= LEFT:
        yield _without_each(contacts, [i for i in doubts.singly[:MOST_CONTACTS] if doubts.are_all([i])])
    wrong = _wrong_ones(fixture, contacts, doubts, solve)
    if len(wrong) == 2 and contacts.features[wrong[0]] != contacts.features[wrong[1]]:
        yield _labels(contacts, [(wrong[0], wrong[1])])
    if len(wrong) > 1:
        yield _without_all(contacts, wrong)
    else:
        yield _without_each(contacts, wrong)


def _wrong_ones(fixture: Fixture, contacts: Contacts, doubts: Doubts, solve: Solve) -> list[int]:
    """Indices of a few contacts that a pose leaves out which explains all others; empty where there is none."""
    for count in SEVERAL:
        doubtful = doubts.order[:count]
        if count > len(contacts) // LEFT or doubts.share_left(doubtful) > MUCH:
            continue
        solutions = solve(_without(contacts, doubtful))
        best = next(iter(solutions.found), None)
        if best is not None and best.chi2 <= solutions.limit:
            residuals, _ = contact_residuals(best.surfaces, contacts)
            return [int(i) for i in np.flatnonzero(np.abs(residuals) > SURE * _sigmas(fixture, contacts))]
    return []


def _without_each(contacts: Contacts, index: Sequence[int]) -> Stage:
    for i in index if len(contacts) > 6 else ():
        label = f"{contacts.label(i)} ({contacts.features[i]})"
        yield Hypothesis(f"without {label} the others are consistent: touch it again", _without(contacts, [i]))


def _without_all(contacts: Contacts, index: Sequence[int]) -> Stage:
    labels = listed([contacts.label(i) for i in index])
    yield Hypothesis(f"without {labels} the others are consistent: touch these again", _without(contacts, index))


def _without(contacts: Contacts, index: Sequence[int]) -> Contacts:
    return contacts.subset(np.delete(np.arange(len(contacts)), index))


def _approaches(contacts: Contacts, against: Sequence[int]) -> Stage:
    if not against:
        return
    message = "with all approaches reversed the contacts are consistent: are these outward normals (nx, ny, nz)?"
    yield Hypothesis(message, replace(contacts, approaches=-contacts.approaches))
    for i in against[:MOST_CONTACTS]:
        approaches = contacts.approaches.copy()
        approaches[i] *= -1
        message = f"with the approach of {contacts.label(i)} reversed the contacts are consistent"
        yield Hypothesis(message, replace(contacts, approaches=approaches))


def _tip_radii(fixture: Fixture, contacts: Contacts, solve: Solve) -> Stage:
    given = f"{contacts.tip_radius:g} {fixture.units}"
    if contacts.tip_radius > 0:
        message = f"with tip radius 0 instead of {given} the contacts are consistent: are they corrected for the tip?"
        yield Hypothesis(message, replace(contacts, tip_radius=0.0))
    try:
        corrected = _with_estimated_tip(contacts, solve)
    except TactfixError:
        return
    if corrected is not None and corrected.tip_radius > 0:
        value = f"{corrected.tip_radius:.4g} {fixture.units}"
        yield Hypothesis(f"with a tip radius of {value} instead of {given} the contacts are consistent", corrected)


def _with_estimated_tip(contacts: Contacts, solve: Solve) -> Contacts | None:
    """The contacts with the tip radius that fits best, None where it cannot be told."""
    for _ in range(TIP_STEPS):
        solution = next(iter(solve(contacts).found), None)
        if solution is None:
            return None
        span = Doubts.of(contacts, contacts.sigmas, solution).span
        shift = 1 / contacts.sigmas
        unexplained = shift - span @ (span.T @ shift)
        if np.linalg.norm(unexplained) < SEEN * np.linalg.norm(shift):
            return None
        change = float(unexplained @ (solution.residuals / contacts.sigmas) / (unexplained @ unexplained))
        contacts = replace(contacts, tip_radius=contacts.tip_radius + change)
        if abs(change) < 0.1 * contacts.sigmas.min():
            break
    return contacts


def _coordinates(contacts: Contacts) -> Stage:
    """The coordinates alone in another unit than the file says."""
    for factor, meant in UNITS_MEANT.items():
        message = f"multiplied by {factor:.10g} the coordinates are consistent: are they {meant}?"
        yield Hypothesis(message, replace(contacts, points=contacts.points * factor))


def _whole_files(contacts: Contacts) -> Stage:
    """All lengths in another unit: a file whose units are wrong, or were taken for another's."""
    for factor, meant in UNITS_MEANT.items():
        scaled = replace(
            contacts,
            points=contacts.points * factor,
            sigmas=contacts.sigmas * factor,
            tip_radius=contacts.tip_radius * factor,
        )
        message = f"multiplied by {factor:.10g} all lengths of the contacts are consistent: are they {meant}?"
        yield Hypothesis(message, scaled)


def _pairs(contacts: Contacts, order: Sequence[int], doubts: Doubts | None) -> list[tuple[int, int]]:
    """Pairs of contacts on different features, those first without which chi-square would fall most."""
    names = contacts.features
    pairs = [(i, k) for i, k in combinations(sorted(order[:MOST_ASKED]), 2) if names[i] != names[k]]
    if doubts is None:
        return pairs
    gains = np.array([doubts.gain(pair) for pair in pairs])
    return [pairs[int(p)] for p in np.argsort(-gains, kind="stable")]


def _labels(contacts: Contacts, pairs: Sequence[tuple[int, int]]) -> Stage:
    for i, k in pairs:
        features = list(contacts.features)
        features[i], features[k] = features[k], features[i]
        message = f"with the labels of {contacts.label(i)} and {contacts.label(k)} swapped the contacts are consistent"
        yield Hypothesis(message, replace(contacts, features=tuple(features)))
