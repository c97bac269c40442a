"""What may be wrong with contacts that no pose explains, in words, and the contacts without that mistake."""

from collections.abc import Callable, Iterator
from typing import TypeAlias

from tactfix.contacts import Contacts
from tactfix.mistakes import DiagnosisCode
from tactfix.poses.solution import Solutions
from tactfix.results import Diagnosis
from tactfix.values import frozen_value

CONTACTS_DOUBTED = 12
"""Contacts that are doubted one by one, those that gain most by it first."""


@frozen_value
class Hypothesis:
    """A mistake in words, and the contacts as they would be without it; rows, features and value as in Diagnosis."""

    code: DiagnosisCode
    message: str
    contacts: Contacts
    rows: tuple[int, ...] = ()
    features: tuple[str, ...] = ()
    value: float | None = None

    def explains(self, chi2: float, remark: str) -> Diagnosis:
        """What is told where it leaves so much of chi-square; remark: what else is to be said of what it leaves."""
        return Diagnosis(self.code, self.rows, self.features, self.value, chi2, self.message + remark)


Stage: TypeAlias = Iterator[Hypothesis]
"""What is asked together: where one of them explains the contacts, nothing after them is asked."""
Solve: TypeAlias = Callable[[Contacts], Solutions]
