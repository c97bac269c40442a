"""Mistakes that a whole contact file shares: its unit, its tip radius, the sense of its approaches.

The tip radius is estimated: at the best pose the residuals that no motion of the fixture explains are projected on what
a change of the tip radius does (the same shift along every outward normal), and the fixture is solved again, a few
times.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.deletion import LEAST_REDUNDANCY, CaseDeletion
from tactfix.diagnosis.hypotheses import CONTACTS_DOUBTED, Hypothesis, Solve, Stage
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture

TIP_STEPS = 6
"""Linear corrections of the tip radius."""
LEAST_GAIN = 0.5
"""Share of chi-square that another tip radius must make up for, as far as the linear model tells, to be looked into:
the true one makes up for nearly all."""
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


def approaches(contacts: Contacts, against: Sequence[int]) -> Stage:
    """All approaches reversed, or one of the first of against, indices of those that come out of the material most."""
    if not against:
        return
    message = "with all approaches reversed the contacts are consistent: are these outward normals (nx, ny, nz)?"
    yield Hypothesis("approach", message, replace(contacts, approaches=-contacts.approaches))
    for i in against[:CONTACTS_DOUBTED]:
        approaches = contacts.approaches.copy()
        approaches[i] *= -1
        message = f"with the approach of {contacts.label(i)} reversed the contacts are consistent"
        rows, features = (contacts.rows[i],), (contacts.features[i],)
        yield Hypothesis("approach", message, replace(contacts, approaches=approaches), rows, features)


def tip_radii(fixture: Fixture, contacts: Contacts, solve: Solve) -> Stage:
    """Another tip radius than the file says: none, or the one that fits best."""
    given = f"{contacts.tip_radius:g} {fixture.units}"
    if contacts.tip_radius > 0:
        message = f"with tip radius 0 instead of {given} the contacts are consistent: are they corrected for the tip?"
        yield Hypothesis("tip_radius", message, replace(contacts, tip_radius=0.0), value=0.0)
    try:
        corrected = _with_estimated_tip(contacts, solve)
    except TactfixError:
        return
    if corrected is not None and corrected.tip_radius > 0:
        value = f"{corrected.tip_radius:.4g} {fixture.units}"
        message = f"with a tip radius of {value} instead of {given} the contacts are consistent"
        yield Hypothesis("tip_radius", message, corrected, value=corrected.tip_radius)


def _with_estimated_tip(contacts: Contacts, solve: Solve) -> Contacts | None:
    """The contacts with the tip radius that fits best, None where it cannot be told."""
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


def coordinates(contacts: Contacts) -> Stage:
    """The coordinates alone in another unit than the file says."""
    for factor, meant in UNITS_MEANT.items():
        message = f"multiplied by {factor:.10g} the coordinates are consistent: are they {meant}?"
        yield Hypothesis("unit", message, replace(contacts, points=contacts.points * factor), value=factor)


def whole_files(contacts: Contacts) -> Stage:
    """All lengths in another unit: a file whose units are wrong, or were taken for another's."""
    for factor, meant in UNITS_MEANT.items():
        scaled = replace(
            contacts,
            points=contacts.points * factor,
            sigmas=contacts.sigmas * factor,
            tip_radius=contacts.tip_radius * factor,
            tip_offset=None if contacts.tip_offset is None else contacts.tip_offset * factor,
        )
        message = f"multiplied by {factor:.10g} all lengths of the contacts are consistent: are they {meant}?"
        yield Hypothesis("unit", message, scaled, value=factor)
