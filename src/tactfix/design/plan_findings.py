"""What design-check has to say of contacts on a fixture: their accuracy, margins and blind spots."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from tactfix.contacts import Contacts
from tactfix.design.blind_spots import BlindSpot
from tactfix.design.certainty import Certainty
from tactfix.design.findings import Finding, Severity
from tactfix.design.layout import Source
from tactfix.design.margins import Margins, Rival
from tactfix.design.symmetries import Symmetry
from tactfix.geometry.arrays import Floats, perpendicular
from tactfix.geometry.surfaces import Cylinder, Surface, radial
from tactfix.motion_words import listed, vector
from tactfix.results import FreeMotion

# The nearest wrong pose should lie this many sigma behind the right one.
ENOUGH_BEHIND: Final = 10.0
# A point known this many times worse than one contact is weakly held.
_WEAK: Final = 10.0
# A mistake that moves the pose by less than this many of its own sigma does no harm.
_HARMLESS: Final = 3.0
_SOURCES: Final[dict[Source, str]] = {
    "plan": "the plan",
    "contacts": "the contacts",
    "spread": "well spread contacts",
}

_REMEDIES: Final = {
    "tip_radius": "add an opposite face, a bore or a sphere touched from several sides: a tip radius then shows",
    "tip_sign": "add an opposite face, a bore or a sphere touched from several sides: a tip radius then shows",
    "pretravel": "add an opposite face or a sphere touched from several sides, and calibrate the probe's pretravel",
    "scale": "add a known length, such as a second sphere or an opposite face, along the direction that grows",
    "unit": "say the unit in the contact file; a sphere or cylinder of known radius makes a wrong one show",
    "approach": "let the contact file say how the probe came (ax, ay, az)",
    "labels": "make the features differ in type, radius or distance, or check the labels on the first part",
    "contact": "touch that feature once more, near the contact that stands alone",
    "distance": "add contacts or a feature that measures this distance too, and have the fixture measured",
    "radius": "add contacts around the feature, and have its radius measured",
}


def contact_findings(
    contacts: Contacts, free: Sequence[FreeMotion], found: Sequence[Symmetry], source: Source
) -> Iterator[Finding]:
    """Contacts that leave a motion free, that nothing checks, or that do not say how the probe came."""
    who = _SOURCES[source]
    for motion in free:
        yield Finding(
            "plan_free_motion",
            "error",
            f"{who} leave{_s(source)} a motion free: the fixture {motion.message}",
            "add a contact that this motion would push into or out of a surface",
        )
    if not free and len(contacts) == 6:
        yield Finding(
            "no_redundancy",
            "warning",
            f"{who} hold{_s(source)} the pose with six contacts: no mistake can ever show",
            "make two or three contacts more than the fewest",
        )
    by_approach = any(symmetry.broken_by == "approach" for symmetry in found)
    if by_approach and not contacts.has_approach.all():
        yield Finding(
            "approach_needed",
            "warning",
            "only the approach tells the sides of this fixture's planes apart, and "
            f"{who} do{'es' if _s(source) else ''} not give it everywhere",
            "give ax, ay, az (or nx, ny, nz) in every row",
        )


def _s(source: Source) -> str:
    return "s" if source == "plan" else ""


def certainty_findings(certainty: Certainty, sigma: float, max_sigma: float | None, units: str) -> Iterator[Finding]:
    """How sure the pose is, at its worst. sigma: rms of the contacts' own."""
    at_worst = certainty.worst
    ratio = at_worst.sigma / sigma
    where = f"the worst extreme point {vector(at_worst.point)} is known to {at_worst.sigma:.3g} {units} (1 sigma)"
    if max_sigma is not None and at_worst.sigma > max_sigma:
        status: Severity = "error"
        what = f"{where}, above --max-sigma {max_sigma:g}"
    else:
        status = "warning" if ratio > _WEAK else "ok"
        what = f"{where}, {ratio:.2g} times a contact's sigma"
    hint = "" if status == "ok" else f"add a contact that resists the weakest motion ({certainty.weakest.message})"
    yield Finding("accuracy", status, what, hint)


def margin_findings(margins: Margins, source: Source, is_symmetric: bool, units: str) -> Iterator[Finding]:
    """The nearest wrong pose, and contacts that must not be lost. is_symmetric: that finding stands already."""
    who, rival = _SOURCES[source], margins.rival
    if rival is None:
        yield Finding("margin", "ok", f"no wrong pose lies within {margins.reach:.0f} sigma of the right one")
    elif not margins.is_unique:
        if not is_symmetric:
            yield Finding(
                "plan_ambiguous", "error", f"{who} leave{_s(source)} a second pose: {_of(rival, units)}", _SEPARATE
            )
    else:
        status: Severity = "warning" if rival.sigmas_behind < ENOUGH_BEHIND else "ok"
        hint = _SEPARATE if status == "warning" else ""
        yield Finding("margin", status, f"the nearest wrong pose: {_of(rival, units)}", hint)
    for outcome, words in (("free", "leaves a motion free"), ("ambiguous", "leaves a second pose")):
        labels = [f"{f.label} on {f.feature}" for f in margins.fragile if f.outcome == outcome]
        if labels and source != "spread":
            yield Finding(
                "fragile_contact",
                "warning",
                f"the loss of one contact {words}: {listed(labels)}",
                "add a contact, so that any one may be missed or thrown away",
            )


_SEPARATE: Final = "add a contact where the two poses differ: tactfix plan --add 1 proposes one"


def _of(rival: Rival, units: str) -> str:
    return f"{rival.sigmas_behind:.2g} sigma behind the right one and {rival.shift:.3g} {units} away"


def blind_spot_findings(
    spots: Sequence[BlindSpot], spread_sees_tip: bool, certainty: Certainty, source: Source, units: str
) -> Iterator[Finding]:
    """Mistakes that stay unseen and matter. spread_sees_tip: well spread contacts would show a forgotten tip."""
    for spot in spots:
        matters = spot.pose_shift is not None and spot.pose_shift > _HARMLESS * certainty.worst.sigma
        # One bad contact among the spread ones says nothing of the contacts that will be made.
        if spot.detectable or not matters or (source == "spread" and spot.error == "contact"):
            if spot.error == "tip_radius":
                yield Finding("blind_tip_radius", "ok", f"a forgotten tip radius shows: {spot.message} {units}")
            continue
        is_error = spot.error == "tip_radius" and not spread_sees_tip
        hint = _REMEDIES[spot.error]
        if spot.error == "tip_radius" and spread_sees_tip:
            hint = "the features would show it, these contacts do not: touch a sphere or cylinder from more sides"
        yield Finding(f"blind_{spot.error}", "error" if is_error else "warning", f"{spot.message} {units}", hint)


# Evenly spaced to within this many degrees; at one height to within this share of the radius.
_EVEN_DEG: Final = 2.0
_LEVEL: Final = 0.05


def tidy_cylinders(contacts: Contacts, surfaces: Mapping[str, Surface]) -> list[str]:
    """Cylinders with six contacts that stand evenly by threes at two heights.

    Such six lie on four cylinders at once, whatever the stagger: the cylinder alone stays ambiguous.
    """
    cylinders = [(name, s) for name, s in surfaces.items() if isinstance(s, Cylinder)]
    return [name for name, cylinder in cylinders if _is_tidy(cylinder, contacts.on(name).points)]


def _is_tidy(cylinder: Cylinder, points: Floats) -> bool:
    if len(points) != 6:
        return False
    along, arms = (points - cylinder.point) @ cylinder.direction, radial(cylinder, points)
    order = np.argsort(along)
    return all(
        bool(np.ptp(along[ring]) <= _LEVEL * cylinder.radius) and _is_even(cylinder, arms[ring])
        for ring in (order[:3], order[3:])
    )


def _is_even(cylinder: Cylinder, arms: Floats) -> bool:
    """Whether three arms (3, 3) from the axis stand 120 degrees apart."""
    u = perpendicular(cylinder.direction)
    angles = np.sort(np.degrees(np.arctan2(arms @ np.cross(cylinder.direction, u), arms @ u)))
    gaps = np.diff(angles, append=angles[0] + 360)
    return bool(np.abs(gaps - 120).max() <= _EVEN_DEG)


def tidy_findings(names: Sequence[str]) -> Iterator[Finding]:
    """Cylinders whose contacts stand too regularly."""
    for name in names:
        yield Finding(
            "tidy_layout",
            "warning",
            f"the six contacts on {name} stand evenly by threes at two heights: they lie on four cylinders at once",
            "use 0, 90, 180, 270 degrees at one height and 45, 135 at another",
        )
