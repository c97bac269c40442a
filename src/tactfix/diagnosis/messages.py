"""Explanations as diagnoses: code, rows, features, value and message."""

from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.contact_mistakes import UNITS_MEANT
from tactfix.diagnosis.hypotheses import Explanation, Hypothesis, Problem
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface, moved, reference_point
from tactfix.poses.pose_fit import contact_residuals
from tactfix.probe import implied_probe_sigma
from tactfix.results import Diagnosis
from tactfix.wording import decimals, fixed, listed

CONSISTENT = "the contacts are consistent"


def diagnosis_of(problem: Problem, units: str, explanation: Explanation, remark: str = "") -> Diagnosis:
    """The diagnosis of an explanation; remark: what to say of the pose that remains."""
    value, message = _value_and_message(problem, units, explanation)
    return _diagnosis(problem.contacts, explanation.hypothesis, value, explanation.chi2, message + remark)


def diagnosis_of_correction(
    contacts: Contacts, units: str, hypothesis: Hypothesis, chi2: float, remark: str
) -> Diagnosis:
    """The diagnosis of a correction of the contacts alone; chi2: that of the corrected ones; remark as above."""
    value, message = _contact_file(
        contacts, units, hypothesis, hypothesis.tip or 0.0, float(np.median(contacts.sigmas))
    )
    return _diagnosis(contacts, hypothesis, value, chi2, message + remark)


def _diagnosis(
    contacts: Contacts, hypothesis: Hypothesis, value: float | tuple[float, ...] | None, chi2: float, message: str
) -> Diagnosis:
    rows = tuple(sorted(contacts.rows[i] for i in hypothesis.index))
    return Diagnosis(hypothesis.code, rows, hypothesis.features, value, chi2, message)


def one_of(causes: list[Diagnosis]) -> Diagnosis:
    """Indistinct causes as one entry: the most plausible one, with the rows and features of all."""
    if len(causes) == 1:
        return causes[0]
    return replace(
        causes[0],
        rows=tuple(sorted({row for cause in causes for row in cause.rows})),
        features=tuple(dict.fromkeys(name for cause in causes for name in cause.features)),
        message="one of these, which the contacts do not distinguish: " + "; or ".join(c.message for c in causes),
        one_of=True,
        causes=tuple(causes),
    )


ValueAndMessage = tuple[float | tuple[float, ...] | None, str]


def _value_and_message(problem: Problem, units: str, explanation: Explanation) -> ValueAndMessage:
    hypothesis, contacts, sigma = explanation.hypothesis, problem.contacts, float(np.median(problem.sigmas))
    match hypothesis.code:
        case "outlier":
            return _off(problem, explanation), _contact_file(contacts, units, hypothesis, 0.0, sigma)[1]
        case "approach" | "swapped_labels" | "relabel" | "feature_exchange" | "unit" | "tip_radius":
            radius = hypothesis.corrected_contacts(contacts, explanation.values).tip_radius
            return _contact_file(contacts, units, hypothesis, radius, sigma)
        case "tip_offset":
            return tip_offset_message(contacts, explanation.values, units, CONSISTENT, sigma)
        case "sigma":
            return _sigma(problem, units, hypothesis.sigmas)
        case _:
            return _fixture_file(problem, units, explanation)


def _off(problem: Problem, explanation: Explanation) -> float | tuple[float, ...]:
    """How far the deleted contacts are off their surfaces at the pose of the others."""
    in_base = {name: moved(explanation.base_from_fixture, s) for name, s in problem.surfaces.items()}
    off = contact_residuals(in_base, problem.contacts.subset(explanation.hypothesis.index))[0]
    return float(off[0]) if len(off) == 1 else tuple(off.tolist())


def _contact_file(
    contacts: Contacts, units: str, hypothesis: Hypothesis, tip_radius: float, sigma: float
) -> ValueAndMessage:
    """Mistakes in the contact file; tip_radius: the right one, shown with the digits that sigma leaves."""
    match hypothesis.code:
        case "unit":
            return hypothesis.points, _unit(hypothesis)
        case "tip_radius":
            return tip_radius, _tip_radius(contacts, units, tip_radius, sigma)
        case "approach" | "outlier":
            return None, _approach_or_outlier(contacts, hypothesis)
        case _:
            return None, _labels(contacts, hypothesis)


def _labels(contacts: Contacts, hypothesis: Hypothesis) -> str:
    labels = [contacts.label(i) for i in hypothesis.index]
    match hypothesis.code:
        case "swapped_labels":
            return f"with the labels of {labels[0]} and {labels[1]} swapped {CONSISTENT}"
        case "relabel":
            named = contacts.features[hypothesis.index[0]]
            return f"{labels[0]} is labelled {named}; on {hypothesis.features[0]} it fits, and {CONSISTENT}"
        case _:
            return f"with the contacts of {listed(hypothesis.features)} exchanged {CONSISTENT}"


def _approach_or_outlier(contacts: Contacts, hypothesis: Hypothesis) -> str:
    labels = [contacts.label(i) for i in hypothesis.index]
    if hypothesis.code == "outlier":
        if len(labels) == 1:
            return without_message(contacts, hypothesis.index[0])
        return f"without {listed(labels)} the others are consistent: touch these again"
    if labels:
        return f"with the approach of {listed(labels)} reversed {CONSISTENT}"
    return f"with all approaches reversed {CONSISTENT}: are these outward normals (nx, ny, nz)?"


def without_message(contacts: Contacts, i: int) -> str:
    """The message that one contact is wrong."""
    return f"without {contacts.label(i)} ({contacts.features[i]}) the others are consistent: touch it again"


def _unit(hypothesis: Hypothesis) -> str:
    factor, meant = hypothesis.points, UNITS_MEANT[hypothesis.points]
    subject, remedy = "the coordinates", "write them in the unit of the other lengths"
    if hypothesis.note == "whole":
        subject, remedy = "all lengths of the contacts", "give that unit for the contacts"
    return f"multiplied by {factor:.10g} {subject} are consistent: are they {meant}? If so, {remedy}"


def _tip_radius(contacts: Contacts, units: str, right: float, sigma: float) -> str:
    given = f"{contacts.tip_radius:g} {units}"
    if right == 0:
        return f"with tip radius 0 instead of {given} {CONSISTENT}: are they corrected for the tip?"
    shown = f"{fixed(abs(right), decimals(sigma))} {units}"
    if right < 0:
        return f"with every contact {shown} farther out of the material {CONSISTENT}: does the probe trigger late?"
    return f"with a tip radius of {shown} instead of {given} {CONSISTENT}"


def tip_offset_message(contacts: Contacts, change: Floats, units: str, then: str, sigma: float) -> ValueAndMessage:
    """The right place of the tip in the flange frame, or its displacement if the file gives none; and the message."""
    off = f"{float(np.linalg.norm(change)):.3g} {units}"
    if contacts.tip_offset is None:
        by = ", ".join(fixed(value, decimals(sigma)) for value in change)
        return tuple(change.tolist()), f"with the tip {off} elsewhere in the flange frame, by ({by}), {then}"
    place = contacts.tip_offset + change
    now, given = (", ".join(fixed(value, decimals(sigma)) for value in one) for one in (place, contacts.tip_offset))
    return tuple(place.tolist()), (
        f"with the tip at ({now}) in the flange frame instead of ({given}), {off} from there, {then}"
    )


def _sigma(problem: Problem, units: str, factor: float) -> ValueAndMessage:
    given = float(np.median(problem.contacts.sigmas))
    right = implied_probe_sigma(problem.contacts, problem.sigmas, factor)
    return right, (
        f"no contact stands out, and all agree to {factor * float(np.median(problem.sigmas)):.2g} {units}: "
        f"is sigma {right:.2g} instead of {given:.2g}?"
    )


def _fixture_file(problem: Problem, units: str, explanation: Explanation) -> ValueAndMessage:
    """Mistakes in the fixture file."""
    hypothesis = explanation.hypothesis
    if hypothesis.code == "diameter":
        return _diameter(problem, units, hypothesis)
    if hypothesis.code == "side":
        return None, _side(hypothesis)
    if hypothesis.code in ("axes", "mirrored"):
        return None, _coordinates(hypothesis)
    (name,) = hypothesis.features
    surface = hypothesis.corrected(problem, explanation.values).surfaces[name]
    given = problem.surfaces[name]
    digits = decimals(float(np.median(problem.sigmas)))
    if hypothesis.code == "radius":
        assert isinstance(surface, Sphere | Cylinder)
        assert isinstance(given, Sphere | Cylinder)
        return surface.radius, (
            f"with radius {fixed(surface.radius, digits)} instead of {given.radius:g} {units} of {name} {CONSISTENT}"
        )
    place = tuple(reference_point(surface).tolist())
    return place, (
        f"without {name} the others are consistent; its contacts put it at {_coordinates_of(surface, digits)}, "
        f"the file at {_coordinates_of(given, digits)} {units}"
    )


def _diameter(problem: Problem, units: str, hypothesis: Hypothesis) -> ValueAndMessage:
    radii = []
    for surface in hypothesis.surfaces.values():
        assert isinstance(surface, Sphere | Cylinder)
        radii.append(surface.radius)
    if len(radii) > 1:
        return None, f"with half the radii of {listed(hypothesis.features)} {CONSISTENT}: are these diameters?"
    (name,) = hypothesis.features
    return radii[0], f"with half the radius of {name}, {radii[0]:g} {units}, {CONSISTENT}: is it a diameter?"


def _side(hypothesis: Hypothesis) -> str:
    ((name, surface),) = hypothesis.surfaces.items()
    assert isinstance(surface, Sphere | Cylinder)
    given, subject = ("inner", "boss") if surface.side == "outer" else ("outer", "bore")
    return f"with side {surface.side} instead of {given} of {name} {CONSISTENT}: is it a {subject}?"


def _coordinates(hypothesis: Hypothesis) -> str:
    subject = listed(hypothesis.features) if hypothesis.features else "the whole fixture"
    if hypothesis.code == "axes":
        one, other = hypothesis.note[0], hypothesis.note[1]
        return f"with {one} and {other} of {subject} exchanged in the fixture file {CONSISTENT}"
    return f"with the sign of {hypothesis.note} of {subject} changed in the fixture file {CONSISTENT}: is it mirrored?"


def _coordinates_of(surface: Surface, digits: int) -> str:
    """The coordinates of its place, without those along an axis or in a plane that is parallel to x, y or z."""
    direction = surface.direction if isinstance(surface, Cylinder) else np.zeros(3)
    shown = np.abs(direction) < 1 - 1e-9
    if isinstance(surface, Plane):
        shown = np.abs(surface.normal) > 1e-9
    pairs = zip("xyz", reference_point(surface).tolist(), shown.tolist(), strict=True)
    return ", ".join(f"{axis} {fixed(value, digits)}" for axis, value, is_shown in pairs if is_shown)
