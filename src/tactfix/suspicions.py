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
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.impossible_contacts import are_beyond_boxes, least_chi_square
from tactfix.noise import SURE, chi_square_limit
from tactfix.realization import fixture_scale, realize
from tactfix.refinement import SMALLEST_RATIO, contact_sigmas, sensitivity
from tactfix.solution import Solution, Solutions

MOST_CONTACTS = 12
"""Contacts that are doubted one by one, those that gain most by it first."""
MOST_ASKED = 40
"""Contacts, the same first, that are asked whether they rule a hypothesis out, and of which each two labels are
swapped: the cost grows with the square of their number."""
MOST_SWAPS = 24
"""Swaps that are located, those first without whose two contacts chi-square would fall most."""
TIP_STEPS = 6
SEEN = 1e-3
"""Share of a change of the tip radius that some residual must show: three faces of a cube do not show any."""
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


Solve: TypeAlias = Callable[[Contacts], Solutions]
IsConsistent: TypeAlias = Callable[[Contacts], bool]

NOTHING_EXPLAINS = (
    "no single bad contact, label, approach, unit or tip radius explains it: is this the right fixture file?"
)


def suspicions(
    fixture: Fixture, contacts: Contacts, fits: bool, solve: Solve, is_consistent: IsConsistent
) -> tuple[str, ...]:
    """What would make the contacts consistent, in words; says so where no single mistake explains them.

    fits: whether a pose fits the points, and only approach, touch box or path speak against it. solve gives the
    solutions for corrected contacts, is_consistent says whether a pose is left for them.
    """
    best = next(iter(solve(contacts).found), None)
    doubtful = _doubtful(contacts, best) if best else list(range(len(contacts)))
    against = _against(contacts, best) if best else doubtful
    screen = _Screen(fixture, frozenset(contacts.rows[i] for i in doubtful[:MOST_ASKED]))
    singles = _single_contacts(contacts, doubtful)
    if fits:
        # A wrong unit leaves a fixture of planes its shape: only the touch boxes show it.
        stages = [_approaches(contacts, against), _coordinates(contacts), _whole_files(contacts), singles]
    else:
        stages = [_coordinates(contacts), _whole_files(contacts), chain(_tip_radii(fixture, contacts, solve), singles)]
    possible = (hypothesis for hypothesis in _labels(contacts, doubtful, best) if screen.lets_pass(hypothesis.contacts))
    for stage in (*stages, islice(possible, MOST_SWAPS)):
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
        own = contact_sigmas(asked, {name: feature.sigma for name, feature in self.fixture.features.items()})
        sigmas = np.hypot(own, self.slack)
        limit = chi_square_limit(len(contacts) - 6)
        try:
            return not self.shapes or any(
                least_chi_square(shape, asked, sigmas) <= limit
                and not are_beyond_boxes(shape, self.fixture.touch, asked)
                for shape in self.shapes
            )
        except TactfixError:  # a tip that does not fit into a bore
            return False


def _doubtful(contacts: Contacts, solution: Solution) -> list[int]:
    """Indices of the contacts, those first without which chi-square would fall most: r^2 / (1 - leverage)."""
    leverage = (_span(contacts, solution) ** 2).sum(axis=1)
    gain = (solution.residuals / contacts.sigmas) ** 2 / np.maximum(1 - leverage, SEEN)
    return [int(i) for i in np.argsort(-gain)]


def _against(contacts: Contacts, solution: Solution) -> list[int]:
    """Indices of the contacts that say how the probe came, those first where it came most out of the material."""
    given = np.flatnonzero(contacts.has_approach)
    cosine = np.einsum("ij,ij->i", contacts.approaches[given], solution.normals[given])
    return [int(i) for i in given[np.argsort(-cosine)]]


def _single_contacts(contacts: Contacts, doubtful: Sequence[int]) -> Iterator[Hypothesis]:
    for i in doubtful[:MOST_CONTACTS] if len(contacts) > 6 else ():
        rest = contacts.subset([k for k in range(len(contacts)) if k != i])
        label = f"{contacts.label(i)} ({contacts.features[i]})"
        yield Hypothesis(f"without {label} the others are consistent: touch it again", rest)


def _approaches(contacts: Contacts, against: Sequence[int]) -> Iterator[Hypothesis]:
    if not against:
        return
    message = "with all approaches reversed the contacts are consistent: are these outward normals (nx, ny, nz)?"
    yield Hypothesis(message, replace(contacts, approaches=-contacts.approaches))
    for i in against[:MOST_CONTACTS]:
        approaches = contacts.approaches.copy()
        approaches[i] *= -1
        message = f"with the approach of {contacts.label(i)} reversed the contacts are consistent"
        yield Hypothesis(message, replace(contacts, approaches=approaches))


def _tip_radii(fixture: Fixture, contacts: Contacts, solve: Solve) -> Iterator[Hypothesis]:
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
        span = _span(contacts, solution)
        shift = 1 / contacts.sigmas
        unexplained = shift - span @ (span.T @ shift)
        if np.linalg.norm(unexplained) < SEEN * np.linalg.norm(shift):
            return None
        change = float(unexplained @ (solution.residuals / contacts.sigmas) / (unexplained @ unexplained))
        contacts = replace(contacts, tip_radius=contacts.tip_radius + change)
        if abs(change) < 0.1 * contacts.sigmas.min():
            break
    return contacts


def _coordinates(contacts: Contacts) -> Iterator[Hypothesis]:
    """The coordinates alone in another unit than the file says."""
    for factor, meant in UNITS_MEANT.items():
        message = f"multiplied by {factor:.10g} the coordinates are consistent: are they {meant}?"
        yield Hypothesis(message, replace(contacts, points=contacts.points * factor))


def _whole_files(contacts: Contacts) -> Iterator[Hypothesis]:
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


def _labels(contacts: Contacts, doubtful: Sequence[int], best: Solution | None) -> Iterator[Hypothesis]:
    """Each two labels swapped, those first without whose contacts chi-square would fall most."""
    names = contacts.features
    pairs = [(i, k) for i, k in combinations(sorted(doubtful[:MOST_ASKED]), 2) if names[i] != names[k]]
    if best is not None:
        gains = _gains_of_pairs(contacts, best, pairs)
        pairs = [pairs[int(p)] for p in np.argsort(-gains, kind="stable")]
    for i, k in pairs:
        features = list(names)
        features[i], features[k] = features[k], features[i]
        message = f"with the labels of {contacts.label(i)} and {contacts.label(k)} swapped the contacts are consistent"
        yield Hypothesis(message, replace(contacts, features=tuple(features)))


def _gains_of_pairs(contacts: Contacts, solution: Solution, pairs: Sequence[tuple[int, int]]) -> Floats:
    """How much chi-square (k,) would fall without both contacts of each pair: r' (I - H)^-1 r of these two."""
    span = _span(contacts, solution)
    scaled = solution.residuals / contacts.sigmas
    gains = []
    for pair in pairs:
        index = list(pair)
        left = np.eye(2) - span[index] @ span[index].T
        gains.append(float(scaled[index] @ np.linalg.pinv(left, rcond=SEEN, hermitian=True) @ scaled[index]))
    return np.array(gains)


def _span(contacts: Contacts, solution: Solution) -> Floats:
    """An orthonormal basis (n, k) of what motions of the fixture do to the residuals over sigma."""
    jacobian = sensitivity(contacts.points, solution.normals, contacts.sigmas).jacobian
    span, values, _ = np.linalg.svd(jacobian, full_matrices=False)
    return np.asarray(span[:, values > SMALLEST_RATIO * values[0]])
