"""Mistakes made in right contacts, for simulate and for the blind spots of design_check.

Mistakes in the fixture file are in `fixture_faults`.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.decimal_text import number_of
from tactfix.errors import UsageError
from tactfix.geometry.arrays import Floats
from tactfix.mistakes import FAULT_KINDS, FaultKind
from tactfix.settings import Setting
from tactfix.units import LEAST_LENGTH, MOST_LENGTH
from tactfix.values import frozen_value
from tactfix.wording import did_you_mean, listed

FAULT_SIGMAS = 20.0
"""Displacement of a contact by a fault, in sigma: four times the five of locate's limits, so that it is detected."""
_GROWTH = 23e-6 * 10
"""Growth of a fixture that is 10 K warmer than when it was measured: aluminium, 23e-6 of its length for each kelvin."""
_INCH = 25.4
"""Millimetres."""
NOISIER = 10.0
"""Ratio of the noise to sigma if sigma is too small."""


@frozen_value(eq=True)
class Fault:
    """One mistake that `simulate` makes.

    Parameters
    ----------
    kind : str
        outlier: one contact is displaced along the normal. reversed-approach: one contact has the opposite approach.
        swapped-labels: two contacts exchange their features. wrong-unit: the unit of the coordinates is value times
        that of the file. forgotten-tip: the tip has a radius, and the file gives 0. late-trigger: every contact is
        displaced along its approach. thermal-growth: the fixture is larger than in its file, by the share value about
        its origin. wrong-tip: the tip is displaced sideways in the flange frame. Further mistakes in contacts and in
        the fixture file are in `tactfix.mistakes`.
    value : float, optional
        Size (lengths in fixture units), or the row of the reversed approach. None: a typical size: 20 sigma for an
        outlier and a late trigger, 25.4 for a unit, the probe's own radius, a growth of 2.3e-4 (aluminium, 10 K), and
        any row.

    Raises
    ------
    UsageError
        When simulated, for an impossible value.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> tactfix.simulate(fixture, count=9, fault=tactfix.Fault("wrong-unit", 25.4)).mistake
    'coordinates are divided by 25.4'
    """

    kind: FaultKind
    value: float | None = None


def parse_fault(text: str) -> Fault:
    """The fault of NAME or NAME:VALUE. Raises UsageError for an unknown name and a value that is no number."""
    name, colon, number = text.partition(":")
    kinds = {kind: kind for kind in FAULT_KINDS}
    if name not in kinds:
        raise UsageError(f"no fault is called {name!r}; {did_you_mean(name, FAULT_KINDS)}")
    if not colon:
        return Fault(kinds[name])
    value = number_of(number)
    if value is None:
        shown = number if len(number) <= 40 else f"{number[:40]}..."
        raise UsageError(f"the value of fault {name} must be a number, not {shown!r}; write {name} or {name}:VALUE")
    return Fault(kinds[name], value)


def check_fault(fault: Fault | None) -> None:
    """Raise UsageError for a value that is not finite, or too large or small to compute with."""
    if fault is None or fault.value is None:
        return
    if not abs(fault.value) <= MOST_LENGTH or (fault.kind == "wrong-unit" and 0 < fault.value < LEAST_LENGTH):
        raise UsageError(f"the value {fault.value:g} of fault {fault.kind} is out of range; give a realistic number")


def growth(fault: Fault | None) -> float:
    """The factor on every length of the fixture, about its origin."""
    if fault is None or fault.kind != "thermal-growth":
        return 1.0
    return 1.0 + (_GROWTH if fault.value is None else fault.value)


def touching_radius(fault: Fault | None, tip_radius: float) -> float:
    """The true radius of the tip; tip_radius: that of the file.

    Raises UsageError for a forgotten tip without a radius.
    """
    if fault is None or fault.kind != "forgotten-tip":
        return tip_radius
    radius = tip_radius if fault.value is None else fault.value
    if radius <= 0:
        raise UsageError("a tip without a radius cannot be forgotten; give its radius: forgotten-tip:RADIUS")
    return radius


def scatter(fault: Fault | None) -> float:
    """The factor on the noise. Raises UsageError for a negative one."""
    if fault is None or fault.kind != "wrong-sigma":
        return 1.0
    times = NOISIER if fault.value is None else fault.value
    if times < 0:
        raise UsageError(f"contacts cannot scatter {times:g} times as much; give a positive factor: wrong-sigma:10")
    return times


def mistaken(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    """The contacts with the fault, and the fault in words; normals (n, 3) are outward, in base.

    thermal-growth, forgotten-tip and wrong-sigma change the touches (growth, touching_radius, scatter), and are only
    described here. Raises UsageError if the contacts do not allow the fault.
    """
    return CONTACT_FAULTS[fault.kind](fault, contacts, normals, rng)


def _forgotten(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    touched = touching_radius(fault, contacts.tip_radius)
    return replace(contacts, tip_radius=0.0), f"a tip of radius {touched:g} touched, the file gives 0"


def _wrong_side(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    tip = contacts.tip_radius if fault.value is None else fault.value
    if tip <= 0:
        raise UsageError("a tip without a radius has no wrong side; give its radius: tip-sign:RADIUS")
    # A point determines the tip's centre, whatever its radius.
    points = contacts.points + np.where(contacts.has_approach[:, None], tip * normals, 0.0)
    return replace(contacts, points=points, tip_radius=0.0), (
        f"the tip's radius {tip:g} was compensated out of the material instead of into it, the file gives 0"
    )


def _grown(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    return contacts, f"the fixture is {growth(fault):.9g} times as large as its file says"


def _noisy(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    return contacts, f"contacts scatter {scatter(fault):g} times as much as sigma says"


def _wrong_tip(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    if contacts.flange_rotations is None:
        raise UsageError("a wrong tip needs tool orientations; give " + Setting.ORIENTATIONS.to(4))
    off = FAULT_SIGMAS * float(contacts.sigmas.max()) if fault.value is None else fault.value
    angle = rng.uniform(0.0, 2 * np.pi)
    change = off * np.array([np.cos(angle), np.sin(angle), 0.0])
    # The reported points are those of the tip that the file assumes.
    points = contacts.points - contacts.flange_rotations @ change
    shown = ", ".join(f"{value:.6g}" for value in change)
    return replace(contacts, points=points), f"the tip is off by {shown} in the flange frame from where the file says"


def _rescaled(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    factor = _INCH if fault.value is None else fault.value
    if factor <= 0:
        raise UsageError(f"a unit cannot be {factor:g} times as large; give a positive factor: wrong-unit:25.4")
    return replace(contacts, points=contacts.points / factor), f"coordinates are divided by {factor:g}"


def _late(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    late = FAULT_SIGMAS * contacts.sigmas if fault.value is None else np.full(len(contacts), fault.value)
    if not contacts.has_approach.any():
        return contacts, "no contact has an approach along which it could be late"
    points = contacts.points + late[:, None] * np.where(contacts.has_approach[:, None], contacts.approaches, 0.0)
    return replace(contacts, points=points), f"every contact is {late.max():g} too far along its approach"


def _outlier(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    i = int(rng.integers(len(contacts)))
    off = FAULT_SIGMAS * contacts.sigmas[i] if fault.value is None else fault.value
    points = contacts.points.copy()
    points[i] += off * normals[i]
    return replace(contacts, points=points), f"{contacts.label(i)} is off by {off:g} along the normal"


def _outliers(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    count = 2.0 if fault.value is None else fault.value
    if count != int(count) or not 1 < count < len(contacts):
        raise UsageError(f"{count:g} of {len(contacts)} contacts cannot be off; give a whole number: outliers:2")
    index = np.sort(rng.choice(len(contacts), int(count), replace=False))
    off = FAULT_SIGMAS * contacts.sigmas[index] * rng.choice([-1.0, 1.0], len(index))
    points = contacts.points.copy()
    points[index] += off[:, None] * normals[index]
    displaced = listed([f"{contacts.label(int(i))} by {by:g}" for i, by in zip(index, off, strict=True)])
    return replace(contacts, points=points), f"displaced along the normal are {displaced}"


def _reversed(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    known = np.flatnonzero(contacts.has_approach)
    if not len(known):
        raise UsageError("no contact has an approach, so none can be reversed")
    i = int(known[rng.integers(len(known))])
    if fault.value is not None:
        if fault.value not in contacts.rows:
            raise UsageError(f"there is no row {fault.value:g} to reverse; rows run from 1 to {len(contacts)}")
        i = contacts.rows.index(int(fault.value))
    approaches = contacts.approaches.copy()
    approaches[i] *= -1
    return replace(contacts, approaches=approaches), f"the approach of {contacts.label(i)} is reversed"


def _swapped(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    pairs = [(i, j) for i in range(len(contacts)) for j in range(i) if contacts.features[i] != contacts.features[j]]
    if not pairs:
        raise UsageError("labels can only be swapped between contacts on two features")
    i, j = pairs[int(rng.integers(len(pairs)))]
    names = list(contacts.features)
    names[i], names[j] = names[j], names[i]
    return replace(
        contacts, features=tuple(names)
    ), f"{contacts.label(j)} and {contacts.label(i)} exchange their features"


def _all_reversed(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    return replace(contacts, approaches=-contacts.approaches), "all approaches are reversed"


def _relabelled(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    names, i = list(contacts.features), int(rng.integers(len(contacts)))
    others = [name for name in contacts.by_feature if name != names[i]]
    if not others:
        raise UsageError("a contact can only be on another feature if two features are touched")
    right, names[i] = names[i], others[int(rng.integers(len(others)))]
    return replace(contacts, features=tuple(names)), f"{contacts.label(i)} is on {right}, the file says {names[i]}"


def _exchanged(fault: Fault, contacts: Contacts, normals: Floats, rng: np.random.Generator) -> tuple[Contacts, str]:
    touched = list(contacts.by_feature)
    if len(touched) < 2:
        raise UsageError("features can only be exchanged if two are touched")
    a, b = (touched[int(i)] for i in rng.choice(len(touched), 2, replace=False))
    other = {a: b, b: a}
    names = tuple(other.get(name, name) for name in contacts.features)
    return replace(contacts, features=names), f"the contacts on {a} are labelled {b}, and those on {b} are labelled {a}"


_Maker: TypeAlias = Callable[[Fault, Contacts, Floats, np.random.Generator], tuple[Contacts, str]]
CONTACT_FAULTS: Final[Mapping[FaultKind, _Maker]] = {
    "outlier": _outlier,
    "outliers": _outliers,
    "reversed-approach": _reversed,
    "reversed-approaches": _all_reversed,
    "swapped-labels": _swapped,
    "wrong-label": _relabelled,
    "exchanged-features": _exchanged,
    "wrong-unit": _rescaled,
    "forgotten-tip": _forgotten,
    "tip-sign": _wrong_side,
    "late-trigger": _late,
    "thermal-growth": _grown,
    "wrong-sigma": _noisy,
    "wrong-tip": _wrong_tip,
}
