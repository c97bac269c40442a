"""Why no pose explains the contacts: single mistakes that would make them consistent.

Each hypothesis corrects one mistake in the contacts and locates again; those after which a pose is left are
reported. A cell makes these mistakes: all or one approach reversed, a forgotten or wrong tip radius, a wrong unit,
one bad contact, two labels swapped. Only approaches are doubted where a pose fits but for them; what is rarer or would
explain more is asked only where nothing before it explains the contacts, labels last.

The tip radius is estimated: at the best pose the residuals that no motion of the fixture explains are projected on what
a change of the tip radius does (the same shift along every outward normal), and the fixture is solved again, a few
times.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture
from tactfix.refinement import SMALLEST_RATIO, sensitivity
from tactfix.solution import Solution, Solutions

MOST_CONTACTS = 12
"""Contacts that are doubted one by one, those that gain most by it first."""
MOST_LABELS = 6
"""Contacts, the same first, of which each two labels are swapped."""
TIP_STEPS = 6
SEEN = 1e-3
"""Share of a change of the tip radius that some residual must show: three faces of a cube do not show any."""
UNIT_FACTORS = {25.4: "inches", 1 / 25.4: "mm read as inches", 1000.0: "metres", 1e-3: "micrometres"}


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
    singles = _single_contacts(contacts, doubtful)
    if fits:
        stages = [_approaches(contacts, against), singles]
    else:
        stages = [_units(contacts), chain(_tip_radii(fixture, contacts, solve), singles)]
    for stage in (*stages, _labels(contacts, doubtful)):
        found = tuple(hypothesis.message for hypothesis in stage if _holds(hypothesis.contacts, is_consistent))
        if found:
            return found
    return (NOTHING_EXPLAINS,)


def _holds(contacts: Contacts, is_consistent: IsConsistent) -> bool:
    try:
        return is_consistent(contacts)
    except TactfixError:
        return False


def _doubtful(contacts: Contacts, solution: Solution) -> list[int]:
    """Indices of the contacts, those first without which chi-square would fall most: r^2 / (1 - leverage)."""
    span, values, _ = np.linalg.svd(
        sensitivity(contacts.points, solution.normals, contacts.sigmas).jacobian, full_matrices=False
    )
    leverage = (span[:, values > SMALLEST_RATIO * values[0]] ** 2).sum(axis=1)
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
        jacobian = sensitivity(contacts.points, solution.normals, contacts.sigmas).jacobian
        span, values, _ = np.linalg.svd(jacobian, full_matrices=False)
        span = span[:, values > SMALLEST_RATIO * values[0]]
        shift = 1 / contacts.sigmas
        unexplained = shift - span @ (span.T @ shift)
        if np.linalg.norm(unexplained) < SEEN * np.linalg.norm(shift):
            return None
        change = float(unexplained @ (solution.residuals / contacts.sigmas) / (unexplained @ unexplained))
        contacts = replace(contacts, tip_radius=contacts.tip_radius + change)
        if abs(change) < 0.1 * contacts.sigmas.min():
            break
    return contacts


def _units(contacts: Contacts) -> Iterator[Hypothesis]:
    for factor, name in UNIT_FACTORS.items():
        message = f"multiplied by {factor:g} the contacts are consistent: are they {name}?"
        yield Hypothesis(message, replace(contacts, points=contacts.points * factor))


def _labels(contacts: Contacts, doubtful: Sequence[int]) -> Iterator[Hypothesis]:
    for i, k in combinations(sorted(doubtful[:MOST_LABELS]), 2):
        if contacts.features[i] != contacts.features[k]:
            features = list(contacts.features)
            features[i], features[k] = features[k], features[i]
            message = (
                f"with the labels of {contacts.label(i)} and {contacts.label(k)} swapped the contacts are consistent"
            )
            yield Hypothesis(message, replace(contacts, features=tuple(features)))
