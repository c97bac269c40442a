"""Touch files: reads CSV of places, features and joint coordinates as touches, or reports every problem."""

import re
from collections.abc import Sequence
from dataclasses import replace
from difflib import get_close_matches
from typing import Final

import numpy as np

from tactfix.calibration.cell import Cell, Touches
from tactfix.decimal_text import number_of
from tactfix.errors import FileError, Problem
from tactfix.files.contact_header import Header, split_header
from tactfix.files.contact_options import ContactOptions
from tactfix.files.contact_table import Table, decimal_mark, directions, numbers, own_sigmas, read_table
from tactfix.files.reading import Source, lines_of, read_source
from tactfix.geometry.arrays import Floats
from tactfix.kinematics.chain import Joint
from tactfix.units import UNITS, factor, which_unit
from tactfix.values import frozen_value
from tactfix.wording import did_you_mean, listed

_TOUCH_APPROACHES: Final = (("ax", "ay", "az"), ("fx", "fy", "fz"))
_LIMIT_SLACK: Final = 0.002
"""Tolerance of joint limits (rad), for rounding of limit and coordinate."""
_LARGEST_JOINT_ANGLE: Final = 4 * np.pi
"""Largest angle (rad) of a joint without limits: two turns."""
_TIMES: Final = 2 * np.pi
"""If no joint angle given in degrees exceeds this, the angles were probably written in rad."""
_SETTINGS: Final = ("joints", "sigma", "units")
_OF_THE_CELL: Final = ("tip_radius", "tip_offset")
_NEARLY: Final = re.compile(r"#[#\s]*(joints|sigma|units)\W+([\w.+-]+)\W*", re.IGNORECASE)
_SETTING: Final = re.compile(r"#\s*(\w+)\s*[:=]\s*(.*?)[\s,;]*", re.IGNORECASE)


@frozen_value(eq=True)
class _Settings:
    """Settings above the header: the unit of joint angles, of lengths, and sigma as text."""

    joints: str | None = None
    units: str | None = None
    sigma: str | None = None


def load_touches(source: Source, cell: Cell, sigma: float | None) -> Touches:
    """The touches of a CSV file: place, feature, q1 to qk, perhaps an approach and a sigma, in rad and the cell's
    units.

    sigma: default for touches without one in the file. Raises FileError with every problem, by row and line.
    """
    name, text = read_source(source)
    problems: list[Problem] = []
    touches = _read(text, cell, sigma, problems)
    if touches is None or problems:
        raise FileError(name, sorted(problems, key=lambda problem: problem.line or 0))
    return touches


def _read(text: str, cell: Cell, sigma: float | None, problems: list[Problem]) -> Touches | None:
    lines = lines_of(text)
    first = next((i for i, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")), None)
    if first is None:
        problems.append(Problem("there is no header row", "begin with place,feature,q1,q2,..."))
        return None
    settings = _read_settings(lines[:first], problems)
    header = _header(lines[first], first, len(cell.chain.joints), problems)
    table = None if header is None else read_table(lines, header, problems)
    if header is None or table is None:
        return None
    table = replace(table, decimal=decimal_mark(table, [c for c in header.columns if c not in _TEXT_COLUMNS], problems))
    places, features = tuple(table.columns["place"]), tuple(table.columns["feature"])
    _check_names(table, cell, problems)
    raw = numbers(table, [f"q{k + 1}" for k in range(len(cell.chain.joints))], problems)
    names, approaches = directions(table, _TOUCH_APPROACHES, problems)
    if settings.units not in (None, *UNITS):
        return None
    sigmas = _sigmas(table, cell, settings, sigma, problems)
    if problems or settings.joints is None:
        return None
    joints = _joints(raw, cell, settings)
    _check_limits(table, joints, cell.chain.joints, settings.joints, problems)
    return Touches(places, features, joints, approaches, names[:1] == ("fx",), sigmas, tuple(table.rows))


_TEXT_COLUMNS: Final = ("place", "feature", "id")


def _read_settings(lines: Sequence[str], problems: list[Problem]) -> _Settings:
    found: dict[str, str] = {}
    for number, line in enumerate(lines, 1):
        match = _SETTING.fullmatch(line.strip())
        key = match[1].lower() if match else ""
        if key not in _SETTINGS:
            problems += _nearly_setting(line.strip(), key, number)
            continue
        assert match is not None  # since key is not empty
        if key in found:
            problems.append(Problem(f"{key} is given twice", "keep one of the lines", line=number))
        found[key] = match[2].strip().lower()
        if key == "joints" and found["joints"] not in ("deg", "rad"):
            problems.append(Problem(f"joints is {match[2]!r}", "write '# joints: deg' or '# joints: rad'", line=number))
    if "joints" not in found:
        remedy = "write '# joints: deg' or '# joints: rad' above the header"
        problems.append(Problem("the unit of the joints, degrees or rad, is not given", remedy))
    if found.get("units", "mm") not in UNITS:
        problems.append(Problem(f"units is {found['units']!r}", which_unit(found["units"])))
    return _Settings(**found)


def _nearly_setting(line: str, key: str, number: int) -> list[Problem]:
    """The problem of a misspelt setting; key: its key, "" if it has none."""
    if key in _OF_THE_CELL:
        message = f"{key} belongs in the cell file, not in its touch file"
        return [Problem(message, "remove the line, and write it under probe: in the cell file", line=number)]
    if not key and (nearly := _NEARLY.fullmatch(line)):
        return [Problem(f"{line!r} looks like a setting", f"write '# {nearly[1].lower()}: {nearly[2]}'", line=number)]
    near = get_close_matches(key, _SETTINGS, n=1, cutoff=0.7)
    return [Problem(f"unknown setting {key!r}", f"write '# {near[0]}: ...'", line=number)] if near else []


def _header(line: str, index: int, count: int, problems: list[Problem]) -> Header | None:
    """The columns, each known and none missing; as many q as the robot has joints."""
    wanted = [f"q{k + 1}" for k in range(count)]
    known = {"place", "feature", "sigma", "id", *wanted, *_TOUCH_APPROACHES[0], *_TOUCH_APPROACHES[1]}
    separator, names = split_header(line, known.__contains__)
    joint_columns = [name for name in names if re.fullmatch(r"q[0-9]+", name)]
    found: list[tuple[str, str]] = []
    if sorted(joint_columns) != sorted(wanted):
        message = (
            f"the robot has {count} joints, the file has {listed(joint_columns) if joint_columns else 'no column q1'}"
        )
        found.append((message, f"write one column for each joint from base to tip: {', '.join(wanted)}"))
    found += [
        (f"unknown column {name!r}", did_you_mean(name, sorted(known)))
        for name in names
        if name not in known and name not in joint_columns
    ]
    found += [(f"there is no column {name!r}", "add it") for name in ("place", "feature") if name not in names]
    found += [(f"column {n!r} is given twice", "remove one") for n in dict.fromkeys(names) if names.count(n) > 1]
    given = [[name for name in vector if name in names] for vector in _TOUCH_APPROACHES]
    if any(len(part) not in (0, 3) for part in given) or all(given):
        found.append(("the approach is not one whole vector", "give ax, ay, az in base or fx, fy, fz in the flange"))
    problems.extend(Problem(message, remedy, line=index + 1) for message, remedy in found)
    return None if found else Header(ContactOptions(), tuple(names), separator, index + 1, frozenset())


def _check_names(table: Table, cell: Cell, problems: list[Problem]) -> None:
    for index, (place, feature) in enumerate(zip(table.columns["place"], table.columns["feature"], strict=True)):
        if place not in cell.places:
            problems.append(table.problem(index, f"there is no place {place!r}", did_you_mean(place, cell.places)))
        elif feature not in cell.places[place].fixture.features:
            fixture = cell.places[place].fixture
            message = f"{fixture.name} at {place!r} has no feature {feature!r}"
            problems.append(table.problem(index, message, did_you_mean(feature, fixture.features)))


def _joints(raw: Floats, cell: Cell, settings: _Settings) -> Floats:
    angle = np.pi / 180 if settings.joints == "deg" else 1.0
    length = factor(settings.units, cell.units) if settings.units else 1.0
    return np.asarray(raw * [length if joint.is_prismatic else angle for joint in cell.chain.joints])


def _check_limits(table: Table, joints: Floats, limits: Sequence[Joint], unit: str, problems: list[Problem]) -> None:
    """A problem for each coordinate beyond its joint's limits, and one if the angles seem to be in the other unit."""
    other = "rad" if unit == "deg" else "deg"
    turning = [k for k, joint in enumerate(limits) if not joint.is_prismatic]
    raw = np.rad2deg(joints[:, turning]) if unit == "deg" else joints[:, turning]
    if unit == "deg" and len(joints) > 5 and np.abs(raw).max(initial=0.0) <= _TIMES:
        message = "no joint is ever 6.3 degrees from zero: these are rad"
        problems.append(table.problem(0, message, "write '# joints: rad' above the header"))
        return
    for k, joint in enumerate(limits):
        low, high = joint.low - _LIMIT_SLACK, joint.high + _LIMIT_SLACK
        if not joint.is_prismatic:
            low, high = max(low, -_LARGEST_JOINT_ANGLE), min(high, _LARGEST_JOINT_ANGLE)
        for index in np.flatnonzero((joints[:, k] < low) | (joints[:, k] > high)):
            shown = table.columns[f"q{k + 1}"][int(index)]
            unit_ = "" if joint.is_prismatic else f" {unit}"
            limits_ = _shown(max(low, joint.low), min(high, joint.high), unit, joint)
            message = f"q{k + 1} is {shown}{unit_}, outside {limits_} of {joint.name}"
            remedy = "check the row" if joint.is_prismatic else f"check the row, or write '# joints: {other}'"
            problems.append(table.problem(int(index), message, remedy))


def _shown(low: float, high: float, unit: str, joint: Joint) -> str:
    scale = 1.0 if joint.is_prismatic or unit == "rad" else 180 / np.pi
    return f"{low * scale:.4g} to {high * scale:.4g}"


def _sigmas(table: Table, cell: Cell, settings: _Settings, sigma: float | None, problems: list[Problem]) -> Floats:
    """The sigma (n,) of each touch in the cell's units: the row's, else the header's, else the probe's."""
    scale = factor(settings.units, cell.units) if settings.units else 1.0
    if settings.sigma is not None:
        value = number_of(settings.sigma)
        if value is None or value <= 0:
            problems.append(Problem(f"sigma is {settings.sigma!r}", "write a number above 0"))
            return np.ones(len(table))
        sigma = value * scale
    own = own_sigmas(table, problems) * scale
    if sigma is None and np.isnan(own).any():
        problems.append(Problem("the sigma of a touch is not given", "write probe: {sigma: ...} in the cell file"))
    return np.asarray(np.where(np.isnan(own), sigma or 1.0, own))
