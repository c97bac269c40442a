"""What may be wrong with contacts that no pose explains, in words, and the contacts without that mistake."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.poses.refinement import contact_sigmas
from tactfix.poses.solution import Solutions

MOST_CONTACTS = 12
"""Contacts that are doubted one by one, those that gain most by it first."""


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """A mistake in words, and the contacts as they would be without it."""

    message: str
    contacts: Contacts


Stage: TypeAlias = Iterator[Hypothesis]
"""What is asked together: where one of them explains the contacts, nothing after them is asked."""
Solve: TypeAlias = Callable[[Contacts], Solutions]


def residual_sigmas(fixture: Fixture, contacts: Contacts) -> Floats:
    """Standard deviation (n,) of each residual, the features' own included."""
    return contact_sigmas(contacts, {name: feature.sigma for name, feature in fixture.features.items()})
