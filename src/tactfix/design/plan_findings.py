"""Findings of design-check on contacts: accuracy, margins, blind spots, layouts."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from tactfix.design.accuracy import Certainty
from tactfix.design.blind_spot import BlindSpot
from tactfix.design.cylinder_layouts import CylinderLayout
from tactfix.design.findings import Finding, Severity
from tactfix.design.margins import Margins, Rival
from tactfix.design.nominal_contacts import Source, Touched
from tactfix.design.random_layouts import LayoutStudy
from tactfix.design.symmetries import Symmetry
from tactfix.geometry.rigid import rotation_angle
from tactfix.localization.free_motions import UNDERDETERMINED_ANGLE
from tactfix.localization.motion_words import vector
from tactfix.results import FreeMotion
from tactfix.wording import listed

ENOUGH_BEHIND: Final = 10.0
"""Least root of chi-square of the nearest wrong pose, in sigma. locate accepts poses within some five; noise changes
this root by one, so twice five leave a margin of five."""
_WEAKLY_DETERMINED: Final = 10.0
"""Ratio of the worst sigma of an extreme point to that of one contact above which there is a warning: the pose is then
less than a tenth as accurate as the probe."""
_STRAGGLERS: Final = 0.25
"""Share of the random layouts with the most contacts tried that may be left with several poses, or a motion free.
With DEFAULT_LAYOUTS (8) that is two of them; a true share of a twentieth gives more than that in six studies of a
thousand."""
_HARMLESS: Final = 3.0
"""Shift of the pose, over the worst sigma of an extreme point, up to which a mistake is harmless: noise alone moves it
so far once in 370 times."""
_SOURCES: Final[dict[Source, str]] = {
    "plan": "the plan",
    "contacts": "the contacts",
    "spread": "well spread contacts",
}

_BLIND_SPOT_REMEDIES: Final = {
    "tip_radius": "add an opposite face, a bore or a sphere touched from several sides: a wrong tip radius then shows",
    "tip_sign": "add an opposite face, a bore or a sphere touched from several sides: a wrong tip radius then shows",
    "tip_offset": "touch in three tool orientations or more, tilted to different sides: a wrong tip offset then shows",
    "pretravel": "add an opposite face or a sphere touched from several sides, and calibrate the probe's pretravel",
    "scale": "add a known length, such as a second sphere or an opposite face, along the direction that grows",
    "unit": "state the unit in the contact file; a sphere or cylinder of known radius shows a wrong one",
    "sigma": "add three contacts or more, so that their residuals show how much they scatter",
    "one_approach": "add a contact where the two poses differ: plan, asked to add 1, proposes one",
    "wrong_label": "touch each feature more often: a contact with a wrong label then leaves residuals",
    "contacts": "touch each of those features once more: more good contacts then contradict the two bad ones",
    "diameter": "add contacts around the feature, on opposite sides of it",
    "side": "give approaches in the contact file (ax, ay, az): a bore is touched outwards, a boss inwards",
    "axes": "add contacts, or a feature, from which the place of this one is measured; have the fixture measured",
    "mirrored": "add a feature off the plane of symmetry, or touch boxes that distinguish the two sides",
    "approach": "give approaches in the contact file (ax, ay, az)",
    "labels": "make the features differ in type, radius or distance, or check the labels on the first part",
    "swapped_contacts": "touch each feature more often, all its contacts in sequence: labels are then hard to exchange",
    "contact": "touch that feature once more, near the contact without redundancy",
    "distance": "add contacts or a feature that measures this distance too, and have the fixture measured",
    "radius": "add contacts around the feature, and have its radius measured",
}


def contact_findings(
    touched: Touched, free: Sequence[FreeMotion], found: Sequence[Symmetry], source: Source
) -> Iterator[Finding]:
    """Contacts that leave a motion free, without redundancy, or without the approaches that are needed."""
    who = _SOURCES[source]
    for motion in free:
        yield Finding(
            "plan_free_motion",
            "error",
            f"{who} leave{_s(source)} a motion free: the fixture {motion.message}",
            "add a contact that this motion would push into or out of a surface",
        )
    if not free and touched.dof == 0:
        yield Finding(
            "no_redundancy",
            "warning",
            f"{who} determine{_s(source)} the pose with {_counted(touched)}: without redundancy no mistake can show",
            "make two or three contacts more than the fewest",
        )
    by_approach = any(symmetry.broken_by == "approach" for symmetry in found)
    if by_approach and not touched.contacts[~touched.on_points].has_approach.all():
        yield Finding(
            "approach_needed",
            "warning",
            "only approaches distinguish the sides of this fixture's planes, and "
            f"{who} do{'es' if _s(source) else ''} not give one for every contact",
            "give ax, ay, az (or nx, ny, nz) in every row",
        )


def _counted(touched: Touched) -> str:
    count = len(touched.contacts)
    if touched.on_points.any():
        return f"{count} contacts, of which those on points count threefold"
    return "six contacts" if count == 6 else f"{count} contacts"


def _s(source: Source) -> str:
    return "s" if source == "plan" else ""


def certainty_findings(certainty: Certainty, sigma: float, max_sigma: float | None, units: str) -> Iterator[Finding]:
    """The worst sigma of an extreme point. sigma: root mean square of those of the contacts."""
    at_worst = certainty.worst
    ratio = at_worst.sigma / sigma
    where = f"the worst extreme point {vector(at_worst.point)} is known to {at_worst.sigma:.3g} {units} (1 sigma)"
    turn = certainty.turn_sigma
    if turn > UNDERDETERMINED_ANGLE:
        status: Severity = "error"
        message = f"{where}, and its direction to {np.degrees(turn):.3g} deg: locate will call that underdetermined"
    elif max_sigma is not None and at_worst.sigma > max_sigma:
        status = "error"
        message = f"{where}, above the limit of {max_sigma:g} {units}"
    else:
        status = "warning" if ratio > _WEAKLY_DETERMINED else "ok"
        message = f"{where}, {ratio:.2g} times a contact's sigma"
    hint = "" if status == "ok" else f"add a contact that constrains the weakest motion ({certainty.weakest.message})"
    yield Finding("accuracy", status, message, hint)


def margin_findings(margins: Margins, source: Source, is_symmetric: bool, units: str) -> Iterator[Finding]:
    """The nearest wrong pose, unless an unbroken symmetry explains it, and contacts that must not be lost."""
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
                "add a contact, so that any single one may be missing or discarded",
            )


_SEPARATE: Final = "add a contact where the two poses differ: plan, asked to add 1, proposes one"


def _of(rival: Rival, units: str) -> str:
    turned = np.degrees(rotation_angle(rival.image_from_fixture[:3, :3]))
    return f"{rival.words} the right one, {rival.shift:.3g} {units} away and turned by {turned:.3g} deg"


def blind_spot_findings(
    spots: Sequence[BlindSpot], spread_shows_tip: bool, certainty: Certainty, source: Source, units: str
) -> Iterator[Finding]:
    """Undetectable mistakes with a large shift. spread_shows_tip: well spread contacts would show a forgotten tip."""
    for spot in spots:
        matters = spot.pose_shift is not None and spot.pose_shift > _HARMLESS * certainty.worst.sigma
        # Contacts other than the spread ones will be made: a bad one among these is of no interest.
        if spot.detectable or not matters or (source == "spread" and spot.error in ("contact", "contacts")):
            if spot.error == "tip_radius":
                harm = "is detected" if spot.detectable else "does no harm"
                yield Finding("blind_tip_radius", "ok", f"a forgotten tip radius {harm}: {spot.message} {units}")
            continue
        is_error = spot.error == "tip_radius" and not spread_shows_tip
        hint = _BLIND_SPOT_REMEDIES[spot.error]
        if spot.error == "tip_radius" and spread_shows_tip:
            hint = "the features would show it, these contacts do not: touch a sphere or cylinder from more sides"
        yield Finding(f"blind_{spot.error}", "error" if is_error else "warning", f"{spot.message} {units}", hint)


def layout_findings(layouts: Sequence[CylinderLayout], source: Source) -> Iterator[Finding]:
    """Cylinders whose contacts lie on several cylinders though so many contacts should leave one.

    Spread contacts, which nobody has to make, count only if they are ambiguous with the known radius too.
    """
    for layout in layouts:
        if layout.is_ambiguous or (layout.is_tidy and source != "spread"):
            own = "" if layout.own_radius is None else f", {layout.own_radius} of its radius"
            alone = "alone it is ambiguous" if layout.is_ambiguous else "without the known radius it would be ambiguous"
            yield Finding(
                "tidy_layout",
                "warning",
                f"the {layout.contacts} contacts on {layout.feature} are so regular that they lie on "
                f"{_many(layout)} cylinders at once{own}: {alone}",
                "space them unevenly, such as 0, 90, 180, 270 degrees at one height and 45, 135 at another",
            )


def _many(layout: CylinderLayout) -> str:
    most = layout.any_radius if layout.is_tidy else layout.own_radius
    return "infinitely many" if most is None else str(most)


def study_findings(study: LayoutStudy, is_symmetric: bool) -> Iterator[Finding]:
    """How many contacts make the pose unique in practice; no finding if an unbroken symmetry excludes that."""
    if not study.shares or is_symmetric:
        return
    first, last = study.shares[0], study.shares[-1]
    open_ = ", ".join(f"{round(100 * (s.ambiguous + s.underdetermined))} % with {s.contacts}" for s in study.shares)
    message = f"of {first.layouts} random layouts {open_} contacts leave more than one pose, or a motion free"
    if last.ambiguous + last.underdetermined <= _STRAGGLERS:
        yield Finding("uniqueness", "ok", message)
    else:
        yield Finding("uniqueness", "warning", message, "let tactfix plan choose the contacts, or add a feature")


def not_studied(why: str) -> Finding:
    """Random layouts that cannot be made."""
    return Finding(
        "uniqueness",
        "warning",
        f"random layouts could not be tried: {why}",
        "make the features easier to touch, or leave the study out (0 layouts)",
    )
