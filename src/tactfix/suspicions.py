"""Why no pose explains the contacts: single mistakes that would make them consistent.

Each hypothesis corrects one mistake in the contacts and locates again; those after which a pose is left are reported, the
most telling first. A cell makes these mistakes: one bad contact, two labels swapped, one or all approaches reversed, a
wrong unit, a forgotten or wrong tip radius.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture

MOST_CONTACTS = 12
"""Contacts that are doubted one by one, those with the largest residuals first."""
UNIT_FACTORS = {25.4: "inches", 1 / 25.4: "mm read as inches", 1000.0: "metres", 1e-3: "micrometres"}


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """A mistake in words, and the contacts as they would be without it."""

    message: str
    contacts: Contacts


def suspicions(fixture: Fixture, contacts: Contacts) -> tuple[str, ...]:
    """What would make the contacts consistent, in words; says so where no single mistake explains them."""
    found = tuple(h.message for h in _hypotheses(fixture, contacts) if _is_consistent(fixture, h.contacts))
    return found or (
        "no single bad contact, label, approach, unit or tip radius explains it: is this the right fixture file?",
    )


def _is_consistent(fixture: Fixture, contacts: Contacts) -> bool:
    from tactfix.locate import locate

    try:
        return locate(fixture, contacts, explain=False).status in ("located", "ambiguous")
    except TactfixError:
        return False


def _hypotheses(fixture: Fixture, contacts: Contacts) -> Iterator[Hypothesis]:
    yield from _approaches(contacts)
    yield from _tip_radii(contacts)
    yield from _units(contacts)
    yield from _labels(contacts)
    if len(contacts) > 6:
        yield from _single_contacts(contacts)


def _single_contacts(contacts: Contacts) -> Iterator[Hypothesis]:
    for i in range(min(len(contacts), MOST_CONTACTS)):
        rest = contacts.subset([k for k in range(len(contacts)) if k != i])
        label = f"{contacts.label(i)} ({contacts.features[i]})"
        yield Hypothesis(f"without {label} the others are consistent: touch it again", rest)


def _approaches(contacts: Contacts) -> Iterator[Hypothesis]:
    given = np.flatnonzero(contacts.has_approach)
    if not len(given):
        return
    message = "with all approaches reversed the contacts are consistent: are these outward normals (nx, ny, nz)?"
    yield Hypothesis(message, replace(contacts, approaches=-contacts.approaches))
    for i in given[:MOST_CONTACTS]:
        approaches = contacts.approaches.copy()
        approaches[i] *= -1
        message = f"with the approach of {contacts.label(int(i))} reversed the contacts are consistent"
        yield Hypothesis(message, replace(contacts, approaches=approaches))


def _tip_radii(contacts: Contacts) -> Iterator[Hypothesis]:
    if contacts.tip_radius > 0:
        message = f"with tip radius 0 instead of {contacts.tip_radius:g} the contacts are consistent: are they corrected for the tip?"
        yield Hypothesis(message, replace(contacts, tip_radius=0.0))


def _units(contacts: Contacts) -> Iterator[Hypothesis]:
    for factor, name in UNIT_FACTORS.items():
        message = f"multiplied by {factor:g} the contacts are consistent: are they {name}?"
        yield Hypothesis(message, replace(contacts, points=contacts.points * factor))


def _labels(contacts: Contacts) -> Iterator[Hypothesis]:
    pairs = [(i, k) for i, k in combinations(range(min(len(contacts), MOST_CONTACTS)), 2)]
    for i, k in pairs:
        if contacts.features[i] != contacts.features[k]:
            features = list(contacts.features)
            features[i], features[k] = features[k], features[i]
            message = (
                f"with the labels of {contacts.label(i)} and {contacts.label(k)} swapped the contacts are consistent"
            )
            yield Hypothesis(message, replace(contacts, features=tuple(features)))
