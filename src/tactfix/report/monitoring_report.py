"""A check, and a step of guidance: as lines for people and as JSON."""

import json
from typing import Final

import numpy as np

from tactfix.acceptance import sigma_at
from tactfix.geometry.arrays import Floats
from tactfix.localization.motion_words import vector
from tactfix.monitoring.check import CheckResult
from tactfix.monitoring.drift import Drift
from tactfix.monitoring.guide import GuideStep
from tactfix.report.compare_report import compare_json, compare_lines
from tactfix.report.json_report import Json, array, locate_json, number
from tactfix.report.text_report import status_lines
from tactfix.version import VERSION

CHECK_SCHEMA: Final = "tactfix/check/1"
_OF_COMPARE: Final = (
    *("distance", "distance_sigma", "angle_deg", "angle_sigma_deg", "base", "fixture", "covariance", "chance"),
    *("limit_translation", "limit_rotation_deg"),
)


def check_lines(check: CheckResult) -> list[str]:
    """Whether it has moved, then by how much in both frames, then the drift; why not, where it is not located."""
    if check.movement is None:
        return [f"not checked: {line}" if k == 0 else line for k, line in enumerate(status_lines(check.result))]
    drift = [] if check.drift is None else [drift_words(check.drift, check.result.units)]
    return [verdict(check), *compare_lines(check.movement), *drift]


def verdict(check: CheckResult) -> str:
    """Whether it has moved, how far at most, and where most, in one line."""
    movement, worst, units = check.movement, check.worst, check.result.units
    if movement is None or worst is None:
        return f"not checked: {check.result.status}"
    if not check.has_moved and (movement.chance is None or movement.chance >= 1e-3):
        return f"has not moved: less than {check.bound:.2g} {units} anywhere on it, 95 %"
    sigmas = f", {worst.displacement / worst.sigma:.2g} sigma" if worst.sigma > 0 else ""
    most = f"most at {_place(worst.point)} of the fixture, {worst.displacement:.2g} {units}{sigmas}"
    if not check.has_moved:
        return f"has moved within the limits: {movement.distance:.2g} {units} at its origin; {most}"
    turned = f"turned {np.rad2deg(movement.angle):.2g} deg"
    return f"HAS MOVED: {movement.distance:.2g} {units} at its origin, {turned}; {most}"


def drift_words(drift: Drift, units: str) -> str:
    """What the checks tell together, in one line."""
    distance, angle = np.linalg.norm(drift.per_check[3:]), np.rad2deg(np.linalg.norm(drift.per_check[:3]))
    slope = f"{distance:.2g} {units} and {angle:.2g} deg a check over {drift.checks} checks"
    if drift.chance is None:
        return f"drift: {slope}; how sure that is is not known"
    word = "DRIFTS" if drift.detected else "none beyond chance"
    return f"drift: {word}: {slope} (chance {drift.chance:.2g})"


def check_json(check: CheckResult) -> Json:
    """The check with lengths in units and angles in degrees; "locate" is the JSON of locate of today's contacts."""
    movement = {} if check.movement is None else compare_json(check.movement, check.limits)
    worst = check.worst
    return {
        "schema": CHECK_SCHEMA,
        "tactfix_version": VERSION,
        "units": check.result.units,
        "status": _status(check),
        "verdict": verdict(check),
        **{name: movement.get(name) for name in _OF_COMPARE},
        "bound_95": number(check.bound),
        "worst_point": None
        if worst is None
        else {"point": array(worst.point), "displacement": number(worst.displacement), "sigma": number(worst.sigma)},
        "drift": None if check.drift is None else _drift(check.drift),
        "locate": locate_json(check.result),
        "warnings": list(check.warnings),
    }


def _status(check: CheckResult) -> str:
    if check.has_moved is None:
        return check.result.status
    return "moved" if check.has_moved else "not_moved"


def _drift(drift: Drift) -> Json:
    return {
        "checks": drift.checks,
        "detected": drift.detected,
        "chance": number(drift.chance),
        "translation_per_check": array(drift.per_check[3:]),
        "rotation_per_check_deg": array(np.rad2deg(drift.per_check[:3])),
        "covariance": array(drift.covariance),
    }


def _place(point: Floats) -> str:
    return vector(np.array(point))


GUIDE_SCHEMA: Final = "tactfix/guide/1"
_OF_LOCATE: Final = (
    *("tactfix_version", "fixture", "units", "status", "transform", "covariance", "rms"),
    *("free_motions", "next_contact", "diagnosis", "warnings"),
)


def guide_line(step: GuideStep) -> str:
    """Touches, what is open, what to do."""
    touches = "1 touch" if step.touches == 1 else f"{step.touches} touches"
    return f"{touches}: {step.state}; {step.advice}"


def guide_json(step: GuideStep) -> Json:
    """What is known after so many touches."""
    located = locate_json(step.result)
    return {
        "schema": GUIDE_SCHEMA,
        "touches": step.touches,
        "done": step.is_done,
        **{name: located[name] for name in _OF_LOCATE},
        "sigma": number(sigma_at(step.result)),
        "exceeded": list(step.exceeded),
        "state": step.state,
        "advice": step.advice,
    }


def guide_json_line(step: GuideStep) -> str:
    """The same in one line."""
    return json.dumps(guide_json(step), allow_nan=False) + "\n"
