"""A comparison of two poses as lines for people, as JSON, and as JUnit XML for machines that watch a cell."""

from collections.abc import Sequence
from typing import Final
from xml.etree import ElementTree

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.pose_formats.comparison import Limits, Movement, exceeded
from tactfix.report.json_report import Json, array, number
from tactfix.version import VERSION
from tactfix.wording import borne

COMPARE_SCHEMA: Final = "tactfix/compare/1"


def compare_json(movement: Movement, limits: Limits) -> Json:
    """The movement with lengths in units and angles in degrees; covariance rx ry rz (rad) tx ty tz, base axes."""
    return {
        "schema": COMPARE_SCHEMA,
        "tactfix_version": VERSION,
        "units": movement.units,
        "status": "exceeded" if exceeded(movement, limits) else "ok",
        "distance": number(movement.distance),
        "distance_sigma": number(movement.distance_sigma),
        "angle_deg": number(np.rad2deg(movement.angle)),
        "angle_sigma_deg": number(_degrees(movement.angle_sigma)),
        "base": _moved(movement.translation, movement.rotation),
        "fixture": _moved(movement.translation_in_fixture, movement.rotation_in_fixture),
        "covariance": array(movement.covariance),
        "chance": number(movement.chance),
        "limit_translation": number(limits.translation),
        "limit_rotation_deg": number(_degrees(limits.rotation)),
    }


def compare_lines(movement: Movement) -> list[str]:
    """What moved, in words and both frames."""
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
        lines.append(f"chance: a fixture that stood still would show this much or more with probability {_p(movement)}")
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


def _moved(translation: Floats, rotation: Floats) -> Json:
    return {"translation": array(translation), "rotation_deg": array(np.rad2deg(rotation))}


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else float(np.rad2deg(angle))


def _sigma(sigma: float | None, unit: str) -> str:
    return "" if sigma is None else f" (sigma {sigma:.2g}{unit})"


def _triple(values: Sequence[float] | Floats, sigma: float | None, unit: str) -> str:
    told = [f"{axis} {borne(float(value), sigma, '+')}" for axis, value in zip("xyz", values, strict=True)]
    return ", ".join(told) + unit


def _p(movement: Movement) -> str:
    return f"{movement.chance:.2g}"
