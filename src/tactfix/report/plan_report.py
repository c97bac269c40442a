"""Plans and simulations as contact files, which every command that takes contacts reads, and as JSON."""

import csv
import io
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats
from tactfix.localization.motion_words import vector
from tactfix.locate_result import LocateResult
from tactfix.planning.result import Plan
from tactfix.pose_formats import DIALECTS
from tactfix.report.json_report import Json, document, picked
from tactfix.report.text_report import decimal
from tactfix.simulation.simulate import Simulation
from tactfix.simulation.touches import CONE_DEG
from tactfix.wording import spreadsheet_cell

_BELOW_SIGMA = 3
"""Decimals of a length in a plan beyond the first digit of sigma: a thousandth of sigma is below what a contact
resolves. Rounding also hides the last bits, in which platforms differ: one seed gives the same file everywhere."""
_DIRECTION = 9
"""Decimals of a direction: nine are a nanoradian, below the resolution of any machine."""
_TRUTH = 12
"""Decimals of the true pose: it is a reference for comparison, not a measurement."""


def contact_csv(contacts: Contacts, units: str, comments: Iterable[str]) -> str:
    """The text of a contact file: comments, settings, header, rows."""
    sigma = float(contacts.sigmas.max())
    settings: tuple[str, ...] = (
        f"units: {units}",
        f"tip_radius: {decimal(contacts.tip_radius)}",
        f"sigma: {decimal(sigma)}",
    )
    own = bool((contacts.sigmas != sigma).any())
    named = any(contacts.ids)
    columns = [
        ["feature", *map(spreadsheet_cell, contacts.features)],
        *_columns("x y z", np.round(contacts.points, _digits(float(contacts.sigmas.min())))),
        *_columns("ax ay az", np.round(contacts.approaches, _DIRECTION)),
        *_flange(contacts),
        *([["sigma", *map(decimal, contacts.sigmas)]] if own else []),
        *([["id", *(spreadsheet_cell(name or "") for name in contacts.ids)]] if named else []),
    ]
    if contacts.flange_rotations is not None and contacts.tip_offset is not None:
        settings = (*settings, f"tip_offset: {', '.join(map(decimal, contacts.tip_offset))}")
    text = io.StringIO()
    text.writelines(f"# {line}\n" for line in (*comments, *settings))
    csv.writer(text, lineterminator="\n").writerows(zip(*columns, strict=True))
    return text.getvalue()


def _flange(contacts: Contacts) -> Iterator[list[str]]:
    """The flange orientations of the contacts, if known, as unit quaternions."""
    quaternion = DIALECTS["abb"].numbers
    if contacts.flange_rotations is None or quaternion is None:
        return
    numbers = np.array([quaternion.orientation.numbers(rotation) for rotation in contacts.flange_rotations])
    yield from _columns("qw qx qy qz", np.round(numbers, _DIRECTION))


def _digits(sigma: float) -> int:
    """Decimals of a length with this sigma."""
    return int(np.ceil(-np.log10(sigma))) + _BELOW_SIGMA


def _columns(names: str, values: Floats) -> Iterator[list[str]]:
    for name, column in zip(names.split(), values.T, strict=True):
        yield [name, *("" if np.isnan(value) else decimal(value) for value in column)]


def simulation_csv(simulation: Simulation) -> str:
    """A simulated contact file, the truth in its first comments."""
    return contact_csv(simulation.contacts, simulation.units, _truth(simulation))


def _truth(simulation: Simulation) -> Iterator[str]:
    yield f"simulated contacts on {simulation.fixture}"
    yield "truth: base_from_fixture, x_base = R x_fixture + t, row by row:"
    for row in np.round(simulation.base_from_fixture, _TRUTH):
        yield f"truth: {' '.join(map(decimal, row))}"
    yield f"truth: seed {simulation.seed}"
    yield f"truth: {simulation.mistake or 'no fault'}"
    if not simulation.planned:
        yield f"truth: random touches, approached from within {CONE_DEG:g} degrees of the normal"


def plan_csv(plan: Plan) -> str:
    """A plan as a contact file of nominal contacts, its predicted accuracy in the first comments."""
    return contact_csv(plan.contacts, plan.units, _worth(plan))


def _worth(plan: Plan) -> Iterator[str]:
    frame = "fixture frame" if plan.frame == "fixture" else "base, the frame of the contacts already made"
    yield f"plan for {plan.fixture}: nominal contacts in the {frame}"
    yield from plan_lines(plan)
    yield from _targets(plan)


def _targets(plan: Plan) -> Iterator[str]:
    """Targets in base, one line for each contact of a plan in the fixture frame, if the placement is known."""
    targets = plan.in_base if plan.frame == "fixture" else None
    if targets is None:
        return
    yield "plan: the same in base, according to the placement: row, feature, x y z, and the approach"
    digits = _digits(float(targets.sigmas.min()))
    for i, (row, feature) in enumerate(zip(targets.rows, targets.features, strict=True)):
        place = " ".join(map(decimal, np.round(targets.points[i], digits)))
        way = " ".join(map(decimal, np.round(targets.approaches[i], _DIRECTION)))
        yield f"plan: in base: {row}, {spreadsheet_cell(feature)}, {place}, {way}"


def next_contact_csv(result: LocateResult, tip_radius: float, sigma: float) -> str | None:
    """The contacts to make next as a contact file like that of a plan: tip centres; None if there are none."""
    first = result.next_contact
    if first is None:
        return None
    is_in_base = first.point is not None
    touches = (first, *first.further)
    point, approach = ("point", "approach") if is_in_base else ("point_in_fixture", "approach_in_fixture")
    points = np.array([getattr(touch, point) for touch in touches])
    given = [getattr(touch, approach) for touch in touches]
    ways = np.array([np.full(3, np.nan) if way is None else way for way in given])  # None on a point
    contacts = Contacts(
        features=tuple(touch.feature for touch in touches),
        points=points - np.where(np.isnan(ways), 0.0, tip_radius * ways),
        approaches=ways,
        sigmas=np.full(len(touches), sigma),
        tip_radius=tip_radius,
        rows=tuple(range(1, len(touches) + 1)),
        ids=(None,) * len(touches),
    )
    frame = "base, the frame of the contacts already made" if is_in_base else "fixture frame"
    return contact_csv(contacts, result.units, [f"next contacts on {result.fixture}: nominal, in the {frame}"])


def plan_lines(plan: Plan) -> Iterator[str]:
    """The predicted accuracy of a plan, and its table, as text."""
    at = vector(plan.worst_point).strip("()")
    yield f"plan: worst sigma {plan.worst_sigma:.3g} {plan.units}, at {at} of the fixture frame"
    yield f"plan: {_outcome(plan)}"
    yield f"plan: {plan.agreeing} of {plan.starts} starts of the search led to within one per cent of the best"
    if plan.tip_sigma is not None:
        yield f"plan: {_tip_accuracy(plan)}"
    for step in plan.steps:
        gain = "" if step.gain is None else f", {100 * step.gain:.0f} per cent less"
        unique = "unique" if step.unique else "not unique"
        yield f"plan: {step.count} contacts: worst sigma {step.worst_sigma:.3g} {plan.units}{gain}, {unique}"


def _tip_accuracy(plan: Plan) -> str:
    if plan.tip_sigma is None or not np.isfinite(plan.tip_sigma):
        return "these contacts and tool orientations do not determine the tip: use three orientations or more"
    return f"an unknown tip is determined by locate to {plan.tip_sigma:.2g} {plan.units} (worst sigma)"


def _outcome(plan: Plan) -> str:
    if plan.unique:
        return "unique: no second pose within ten sigma"
    if not plan.located:
        return "not located: the contacts do not determine the pose"
    return f"not unique: {plan.rivals} other {'pose is' if plan.rivals == 1 else 'poses are'} within ten sigma"


def plan_json(plan: Plan) -> Json:
    """The JSON of plan: contacts in the frame that "frame" names, and in base where "transform" is known."""
    in_base = plan.in_base
    contacts = [
        {
            **contact,
            "point_in_base": None if in_base is None else in_base.points[i],
            "approach_in_base": None if in_base is None else in_base.approaches[i],
            "flange_in_fixture": _flange_in_fixture(plan, i),
        }
        for i, contact in enumerate(_contacts(plan.contacts))
    ]
    return document(
        "tactfix/plan/1",
        **picked(plan, "fixture", "units", "frame"),
        transform=plan.base_from_fixture,
        **picked(plan, "criterion", "unique", "located", "rivals", "starts", "agreeing"),
        **picked(plan, "worst_sigma", "worst_point", "covariance"),
        tip_radius=plan.contacts.tip_radius,
        tip_sigma=plan.tip_sigma,
        contacts=contacts,
        steps=[{"contacts": step.count, **picked(step, "worst_sigma", "gain", "unique")} for step in plan.steps],
    )


def simulation_json(simulation: Simulation) -> Json:
    """The JSON of simulate: contacts in base, and the truth."""
    return document(
        "tactfix/simulate/1",
        **picked(simulation, "fixture", "units"),
        transform=simulation.base_from_fixture,
        seed=simulation.seed,
        fault=None if simulation.fault is None else simulation.fault.kind,
        mistake=simulation.mistake,
        tip_radius=simulation.contacts.tip_radius,
        contacts=_contacts(simulation.contacts),
    )


def _flange_in_fixture(plan: Plan, i: int) -> Floats | None:
    """The flange's rotation in the fixture frame (3, 3); None if no orientations were planned."""
    rotations = plan.contacts.flange_rotations
    if rotations is None:
        return None
    pose = plan.base_from_fixture
    turned = rotations[i] if plan.frame == "fixture" or pose is None else pose[:3, :3].T @ rotations[i]
    return np.asarray(turned)


def _contacts(contacts: Contacts) -> list[dict[str, Any]]:
    return [
        {
            "row": contacts.rows[i],
            "feature": contacts.features[i],
            "point": contacts.points[i],
            "approach": contacts.approaches[i] if contacts.has_approach[i] else None,
            "sigma": contacts.sigmas[i],
        }
        for i in range(len(contacts))
    ]
