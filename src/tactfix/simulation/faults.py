"""The mistakes that a cell makes, one of each kind, done to contacts that were right: for simulate and for the blind
spots of design_check.
"""

from dataclasses import replace
from typing import Final, Literal, TypeAlias, get_args

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.geometry.arrays import Floats
from tactfix.values import frozen_value
from tactfix.wording import did_you_mean

FaultKind: TypeAlias = Literal[
    "outlier",
    "reversed-approach",
    "swapped-labels",
    "wrong-unit",
    "forgotten-tip",
    "late-trigger",
    "thermal-growth",
]
FAULT_KINDS: Final[tuple[FaultKind, ...]] = get_args(FaultKind)

# Far enough outside the noise that a consistent set of contacts must notice it.
_SIGMAS_OFF = 20.0
# Aluminium, 10 K warmer than when the fixture was measured.
_GROWTH = 23e-6 * 10
_INCH = 25.4


@frozen_value(eq=True)
class Fault:
    """One mistake. value, where given, says how large (lengths in fixture units), else a typical size is taken.

    outlier: one contact is off by value along the normal (default 20 sigma). reversed-approach: the contact in row
    value (default: any) says the opposite of how the probe came. swapped-labels: two contacts exchange their features.
    wrong-unit: coordinates are numbers of a unit value times as large as the file says (default 25.4). forgotten-tip:
    a tip of radius value (default: the probe's) touched, and the file says 0. late-trigger: every contact is reported
    value (default 20 sigma) further along the approach. thermal-growth: the fixture is larger than its file says, by
    the share value about its origin (default 2.3e-4: aluminium, 10 K).
    """

    kind: FaultKind
    value: float | None = None


def parse_fault(text: str) -> Fault:
    """The fault that NAME or NAME:VALUE asks for. Raises UsageError for an unknown name or a value that is none."""
    name, colon, number = text.partition(":")
    kinds = {kind: kind for kind in FAULT_KINDS}
    if name not in kinds:
        raise UsageError(f"no fault is called {name!r}; {did_you_mean(name, FAULT_KINDS)}")
    if not colon:
        return Fault(kinds[name])
    try:
        value = float(number)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise UsageError(f"the value of fault {name} must be a number, not {number!r}; write {name} or {name}:VALUE")
    return Fault(kinds[name], value)


def growth(fault: Fault | None) -> float:
    """What every length of the fixture is multiplied by, about its origin."""
    if fault is None or fault.kind != "thermal-growth":
        return 1.0
    return 1.0 + (_GROWTH if fault.value is None else fault.value)


def touching_radius(fault: Fault | None, tip_radius: float) -> float:
    """The radius of the tip that really touches, where the file says tip_radius.

    Raises UsageError for a forgotten tip of no size.
    """
    if fault is None or fault.kind != "forgotten-tip":
        return tip_radius
    radius = tip_radius if fault.value is None else fault.value
    if radius <= 0:
        raise UsageError("a tip without a radius cannot be forgotten; give its radius: forgotten-tip:RADIUS")
    return radius


def mistaken(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    """The contacts with the fault in them, and what was done in words; normals (n, 3) are outward, in base.

    thermal-growth and forgotten-tip are mistakes of the touching (growth, touching_radius): only said here. Raises
    UsageError where the contacts do not allow the fault.
    """
    match fault.kind:
        case "outlier":
            return _outlier(fault, contacts, normals, rng)
        case "reversed-approach":
            return _reversed(fault, contacts, rng)
        case "swapped-labels":
            return _swapped(contacts, rng)
        case "wrong-unit":
            return _rescaled(fault, contacts)
        case "late-trigger":
            return _late(fault, contacts)
        case "forgotten-tip":
            touched = touching_radius(fault, contacts.tip_radius)
            mistake = replace(contacts, tip_radius=0.0), f"a tip of radius {touched:g} touched, the file says 0"
        case "thermal-growth":
            mistake = contacts, f"the fixture is {growth(fault):.9g} times as large as its file says"
    return mistake


def _rescaled(fault: Fault, contacts: Contacts) -> tuple[Contacts, str]:
    factor = _INCH if fault.value is None else fault.value
    if factor <= 0:
        raise UsageError(f"a unit cannot be {factor:g} times as large; give a positive factor: wrong-unit:25.4")
    return replace(contacts, points=contacts.points / factor), f"coordinates are divided by {factor:g}"


def _late(fault: Fault, contacts: Contacts) -> tuple[Contacts, str]:
    late = _SIGMAS_OFF * contacts.sigmas if fault.value is None else np.full(len(contacts), fault.value)
    if not contacts.has_approach.any():
        return contacts, "no contact has an approach along which it could be late"
    points = contacts.points + late[:, None] * np.where(contacts.has_approach[:, None], contacts.approaches, 0.0)
    return replace(contacts, points=points), f"every contact is {late.max():g} too far along its approach"


def _outlier(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    i = int(rng.integers(len(contacts)))
    off = _SIGMAS_OFF * contacts.sigmas[i] if fault.value is None else fault.value
    points = contacts.points.copy()
    points[i] += off * normals[i]
    return replace(contacts, points=points), f"{contacts.label(i)} is off by {off:g} along the normal"


def _reversed(fault: Fault, contacts: Contacts, rng: np.random.Generator) -> tuple[Contacts, str]:
    known = np.flatnonzero(contacts.has_approach)
    if not len(known):
        raise UsageError("no contact says how the probe came, so none can be reversed")
    i = int(known[rng.integers(len(known))])
    if fault.value is not None:
        if fault.value not in contacts.rows:
            raise UsageError(f"there is no row {fault.value:g} to reverse; rows run from 1 to {len(contacts)}")
        i = contacts.rows.index(int(fault.value))
    approaches = contacts.approaches.copy()
    approaches[i] *= -1
    return replace(contacts, approaches=approaches), f"the approach of {contacts.label(i)} is reversed"


def _swapped(contacts: Contacts, rng: np.random.Generator) -> tuple[Contacts, str]:
    pairs = [(i, j) for i in range(len(contacts)) for j in range(i) if contacts.features[i] != contacts.features[j]]
    if not pairs:
        raise UsageError("labels can only be swapped between contacts on two features")
    i, j = pairs[int(rng.integers(len(pairs)))]
    names = list(contacts.features)
    names[i], names[j] = names[j], names[i]
    return replace(
        contacts, features=tuple(names)
    ), f"{contacts.label(j)} and {contacts.label(i)} exchange their features"
