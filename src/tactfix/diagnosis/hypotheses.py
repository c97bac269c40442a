"""What may be wrong with contacts that no pose explains, in words, and the contacts without that mistake."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

from tactfix.contacts import Contacts
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
