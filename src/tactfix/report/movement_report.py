"""The results of compare, check and guide as lines for people, as JSON, and as JUnit XML."""

import json
from collections.abc import Sequence
from typing import Final
from xml.etree import ElementTree

import numpy as np

from tactfix.acceptance import sigma_at
from tactfix.geometry.arrays import Floats
from tactfix.localization.motion_words import vector
from tactfix.monitoring.check import CheckResult
from tactfix.monitoring.drift import Drift
from tactfix.monitoring.guide import GuideStep
from tactfix.pose_formats.comparison import Limits, Movement, exceeded
from tactfix.report.json_report import Json, document, locate_json, picked, plain
from tactfix.report.text_report import status_lines
from tactfix.wording import borne

_MOVED: Final = (
    *("distance", "distance_sigma", "angle_deg", "angle_sigma_deg", "base", "fixture", "covariance", "chance"),
    *("limit_translation", "limit_rotation_deg"),
)


def compare_json(movement: Movement, limits: Limits) -> Json:
    """The movement with lengths in units and angles in degrees; covariance rx ry rz (rad) tx ty tz, base axes."""
    return document(
        "tactfix/compare/1",
        units=movement.units,
        status="exceeded" if exceeded(movement, limits) else "ok",
        **_moved(movement, limits),
    )


def _moved(movement: Movement, limits: Limits) -> Json:
    """The part that the JSON of compare and of check have in common."""
    return {
        "distance": movement.distance,
        "distance_sigma": movement.distance_sigma,
        "angle_deg": _degrees(movement.angle),
        "angle_sigma_deg": _degrees(movement.angle_sigma),
        "base": {"translation": movement.translation, "rotation_deg": np.rad2deg(movement.rotation)},
        "fixture": {
            "translation": movement.translation_in_fixture,
            "rotation_deg": np.rad2deg(movement.rotation_in_fixture),
        },
        "covariance": movement.covariance,
        "chance": movement.chance,
        "limit_translation": limits.translation,
        "limit_rotation_deg": _degrees(limits.rotation),
    }


def compare_lines(movement: Movement) -> list[str]:
    """The movement in words, in both frames."""
    unit = f" {movement.units}" if movement.units else ""
    shift, turn = movement.distance_sigma, _degrees(movement.angle_sigma)
    lines = [
        f"moved {borne(movement.distance, shift)}{unit}{_sigma(shift, unit)}, "
        f"turned {borne(float(np.rad2deg(movement.angle)), turn)} deg{_sigma(turn, ' deg')}",
        f"in base:    {_triple(movement.translation, shift, unit)}; "
        f"{_triple(np.rad2deg(movement.rotation), turn, ' deg')}",
        f"in fixture: {_triple(movement.translation_in_fixture, shift, unit)}; "
        f"{_triple(np.rad2deg(movement.rotation_in_fixture), turn, ' deg')}",
    ]
    if movement.chance is not None:
        lines.append(f"chance: if nothing moved, this or a larger movement has probability {_p(movement)}")
    return lines


def compare_junit(movement: Movement, limits: Limits) -> str:
    """A test suite of two cases, translation and rotation; a case without a limit is skipped."""
    beyond = exceeded(movement, limits)
    cases = {"translation": limits.translation, "rotation": limits.rotation}
    suite = ElementTree.Element(
        "testsuite",
        name="tactfix compare",
        tests=str(len(cases)),
        failures=str(len(beyond)),
        errors="0",
        skipped=str(sum(limit is None for limit in cases.values())),
    )
    for name, limit in cases.items():
        case = ElementTree.SubElement(suite, "testcase", classname="tactfix.pose_formats.comparison", name=name)
        if limit is None:
            ElementTree.SubElement(case, "skipped", message=f"no limit of the {name} is set")
        elif name in beyond:
            ElementTree.SubElement(case, "failure", message=beyond[name])
        ElementTree.SubElement(case, "system-out").text = "\n".join(compare_lines(movement))
    ElementTree.indent(suite)
    return ElementTree.tostring(suite, encoding="unicode", xml_declaration=True) + "\n"


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else float(np.rad2deg(angle))


def _sigma(sigma: float | None, unit: str) -> str:
    return "" if sigma is None else f" (sigma {sigma:.2g}{unit})"


def _triple(values: Sequence[float] | Floats, sigma: float | None, unit: str) -> str:
    components = [f"{axis} {borne(float(value), sigma, '+')}" for axis, value in zip("xyz", values, strict=True)]
    return ", ".join(components) + unit


def _p(movement: Movement) -> str:
    return f"{movement.chance:.2g}"


def check_lines(check: CheckResult) -> list[str]:
    """Whether it has moved, the movement in both frames, and the drift; if it is not located, the reason."""
    if check.movement is None:
        return [f"not checked: {line}" if k == 0 else line for k, line in enumerate(status_lines(check.result))]
    drift = [] if check.drift is None else [_drift_words(check.drift, check.result.units)]
    return [verdict(check), *compare_lines(check.movement), *drift]


def verdict(check: CheckResult) -> str:
    """Whether it has moved, and the largest displacement with its point, in one line."""
    movement, worst, units = check.movement, check.worst, check.result.units
    if movement is None or worst is None:
        return f"not checked: {check.result.status}"
    if not check.has_moved and (movement.chance is None or movement.chance >= 1e-3):
        return f"has not moved: less than {check.bound:.2g} {units} anywhere on it, 95 %"
    sigmas = f", {worst.displacement / worst.sigma:.2g} sigma" if worst.sigma > 0 else ""
    most = f"most at {vector(worst.point)} of the fixture, {worst.displacement:.2g} {units}{sigmas}"
    if not check.has_moved:
        return f"has moved within the limits: {movement.distance:.2g} {units} at its origin; {most}"
    turned = f"turned {np.rad2deg(movement.angle):.2g} deg"
    return f"HAS MOVED: {movement.distance:.2g} {units} at its origin, {turned}; {most}"


def _drift_words(drift: Drift, units: str) -> str:
    """The drift over all checks, in one line."""
    distance, angle = np.linalg.norm(drift.per_check[3:]), np.rad2deg(np.linalg.norm(drift.per_check[:3]))
    slope = f"{distance:.2g} {units} and {angle:.2g} deg a check over {drift.checks} checks"
    if drift.chance is None:
        return f"drift: {slope}; its uncertainty is not known"
    word = "DRIFTS" if drift.detected else "not significant"
    return f"drift: {word}: {slope} (chance {drift.chance:.2g})"


def check_json(check: CheckResult) -> Json:
    """The check with lengths in units and angles in degrees; "locate" is the JSON of locate of today's contacts."""
    moved = dict.fromkeys(_MOVED) if check.movement is None else _moved(check.movement, check.limits)
    moved_or_not = "moved" if check.has_moved else "not_moved"
    return document(
        "tactfix/check/1",
        units=check.result.units,
        status=check.result.status if check.has_moved is None else moved_or_not,
        verdict=verdict(check),
        **moved,
        bound_95=check.bound,
        worst_point=check.worst,
        drift=None if check.drift is None else _drift(check.drift),
        locate=locate_json(check.result),
        warnings=check.warnings,
    )


def _drift(drift: Drift) -> Json:
    return {
        **picked(drift, "checks", "detected", "chance"),
        "translation_per_check": drift.per_check[3:],
        "rotation_per_check_deg": np.rad2deg(drift.per_check[:3]),
        "covariance": drift.covariance,
    }


_OF_LOCATE: Final = (
    *("tactfix_version", "fixture", "units", "status", "transform", "covariance", "rms"),
    *("free_motions", "next_contact", "diagnosis", "warnings"),
)


def guide_line(step: GuideStep) -> str:
    """The touches, the open question, and what to touch next."""
    touches = "1 touch" if step.touches == 1 else f"{step.touches} touches"
    return f"{touches}: {step.state}; {step.advice}"


def guide_json(step: GuideStep) -> Json:
    """The JSON of one line of guide: the state after the touches so far."""
    located = locate_json(step.result)
    return {
        "schema": "tactfix/guide/1",
        "touches": step.touches,
        "done": step.is_done,
        **{name: located[name] for name in _OF_LOCATE},
        "sigma": plain(sigma_at(step.result)),
        "exceeded": list(step.exceeded),
        "state": step.state,
        "advice": step.advice,
    }


def guide_json_line(step: GuideStep) -> str:
    """The same in one line."""
    return json.dumps(guide_json(step), allow_nan=False) + "\n"
