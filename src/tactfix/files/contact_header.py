"""What stands above the rows of a contact file: "# key: value" lines, and the names of the columns."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from tactfix.errors import Problem
from tactfix.files.contact_options import ContactOptions
from tactfix.units import LEAST_LENGTH, MOST_LENGTH, UNITS, which_unit

KEYS: Final = ("units", "tip_radius", "sigma", "pose", "tip_offset")
APPROACHES: Final = (("ax", "ay", "az"), ("nx", "ny", "nz"), ("fx", "fy", "fz"))
"""The approach in base, the outward normal in base, the approach in the flange frame."""
ORIENTATIONS: Final = (("qw", "qx", "qy", "qz"), ("rx", "ry", "rz"), ("a", "b", "c"), ("w", "p", "r"))
"""How the flange stood; see `flange_columns`."""
_USUAL: Final = ("feature", "x", "y", "z", "ax", "ay", "az", "nx", "ny", "nz", "id", "sigma")
COLUMNS: Final = ("feature", "x", "y", "z", *sum(APPROACHES + ORIENTATIONS, ()), "id", "sigma")
_EXAMPLE: Final = "feature,x,y,z,ax,ay,az"
_NEAR: Final[dict[str, str]] = {
    **dict.fromkeys(("unit", "length_unit", "length_units", "einheit"), "units"),
    **dict.fromkeys(("tip", "tipradius", "radius", "probe_radius", "stylus_radius", "ball_radius"), "tip_radius"),
    **dict.fromkeys(("sigmas", "std", "stddev", "uncertainty"), "sigma"),
    **dict.fromkeys(("tcp", "tcp_offset", "tool_offset", "tipoffset", "probe_offset"), "tip_offset"),
}
# "# key: value" with a key of one word; a sentence with a colon in it is a plain comment. Spreadsheets
# pad the line with separators.
_KEY_LINE: Final = re.compile(r"#\s*([A-Za-z][\w-]*(?: [A-Za-z]+)?)\s*[:=]\s*(.*?)[\s,;]*")


@dataclass(frozen=True, slots=True)
class Header:
    """The settings of the file, the column names as tactfix calls them, the separator, and where the rows begin.

    first_line: index (from 0) of the first line below the header row. tried: the keys that some line means to set,
    though in vain where that is a problem already.
    """

    settings: ContactOptions
    columns: tuple[str, ...]
    separator: str
    first_line: int
    tried: frozenset[str]


def read_header(lines: Sequence[str], problems: list[Problem], *, feature_needed: bool) -> Header | None:
    """The header of a contact file; None, with a problem, where its columns cannot be told."""
    said: dict[str, tuple[str, int]] = {}
    meant: set[str] = set()
    for index, line in enumerate(lines):
        if line.lstrip().startswith("#"):
            _read_key_line(line.strip(), index + 1, said, meant, problems)
        elif line.strip():
            separator, names = _split(line)
            columns = _read_columns(names, separator, index + 1, problems, feature_needed)
            if not columns:
                return None
            settings = _settings(said, separator, problems)
            return Header(settings, columns, separator, index + 1, frozenset(said) | meant)
    what = "there is no header row" if any(line.strip() for line in lines) else "the file is empty"
    problems.append(Problem(what, f"begin with the names of the columns: {_EXAMPLE}"))
    return None


def key_of(line: str) -> str | None:
    """Which of the keys a comment line sets, None if it is plain text."""
    match = _KEY_LINE.fullmatch(line)
    return match[1].lower() if match and match[1].lower() in KEYS else None


def _read_key_line(
    line: str, number: int, said: dict[str, tuple[str, int]], meant: set[str], problems: list[Problem]
) -> None:
    match = _KEY_LINE.fullmatch(line)
    if not match:
        return
    key, value = match[1].lower(), match[2]
    if key in KEYS:
        if key in said:
            what = f"{key} stands here a second time, first in line {said[key][1]}"
            problems.append(Problem(what, "remove one of the two", line=number))
        said.setdefault(key, (value, number))
        return
    near = _meant_key(key)
    if near:
        meant.add(near)
        problems.append(Problem(f"unknown key {match[1]!r}", f"did you mean {near!r}?", line=number))


def _meant_key(key: str) -> str | None:
    """Which key was meant by something near it; None for the first word of a plain comment."""
    from difflib import get_close_matches

    plain = key.replace("-", "_").replace(" ", "_")
    # Not "pose": "probe" and "note" are near it, and begin plain comments.
    near = get_close_matches(plain, [key for key in KEYS if key != "pose"], n=1, cutoff=0.8)
    return _NEAR.get(plain) or (near[0] if near else None)


def _settings(said: dict[str, tuple[str, int]], separator: str, problems: list[Problem]) -> ContactOptions:
    units, line = said.get("units", (None, 0))
    if units is not None and units not in UNITS:
        problems.append(Problem(f"units is {units!r}", which_unit(units), line=line))
        units = None
    pose, line = said.get("pose", ("tip", 0))
    if pose not in ("tip", "flange"):
        remedy = "write 'flange' where x, y, z are the origin of the flange, 'tip' where they are the tip's centre"
        problems.append(Problem(f"pose is {pose!r}", remedy, line=line))
    return ContactOptions(
        units,
        _setting("tip_radius", said, separator, problems),
        _setting("sigma", said, separator, problems),
        _offset(said, separator, problems),
        of_flange=pose == "flange",
    )


def _offset(
    said: dict[str, tuple[str, int]], separator: str, problems: list[Problem]
) -> tuple[float, float, float] | None:
    """The three numbers of tip_offset; bad ones are a problem and count as not said."""
    if "tip_offset" not in said:
        return None
    text, line = said["tip_offset"]
    parts = text.strip("()[]").split(";" if ";" in text else ",")
    values = [_number(part.strip(), ";" if ";" in text else separator) for part in parts]
    if len(values) == 3 and all(abs(value) <= MOST_LENGTH for value in values):
        return values[0], values[1], values[2]
    remedy = "write the tip's centre in the flange frame as x, y, z in the units of this file"
    problems.append(Problem(f"tip_offset is {text[:40]!r}", remedy, line=line))
    return None


def _number(text: str, separator: str) -> float:
    """A decimal number, with a decimal comma too where that does not divide cells; nan for anything else."""
    text = text if separator == "," else text.replace(",", ".")
    plain = re.fullmatch(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?", text)
    return float(text) if plain else float("nan")


def _setting(key: str, said: dict[str, tuple[str, int]], separator: str, problems: list[Problem]) -> float | None:
    """A length of the header; a bad one is a problem and counts as not said."""
    if key not in said:
        return None
    text, line = said[key]
    value = _number(text, separator)
    least = "of at least 0" if key == "tip_radius" else "above 0"
    if LEAST_LENGTH <= value <= MOST_LENGTH or (value == 0 and key == "tip_radius"):
        return value
    remedy = f"write a number {least} in the units of this file, without its unit"
    shown = said[key][0] if len(said[key][0]) <= 40 else f"{said[key][0][:40]}..."
    problems.append(Problem(f"{key} is {shown!r}", remedy, line=line))
    return None


def _split(line: str) -> tuple[str, list[str]]:
    """The separator of a header row and its cells: that which makes the most known names."""

    def known(separator: str) -> int:
        return sum(name in COLUMNS for name in _cells(line, separator))

    separator = max(("\t", ";", ","), key=lambda mark: (known(mark), line.count(mark)))
    return separator, _cells(line, separator)


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip().strip('"').strip().lower() for cell in line.split(separator)]


def _read_columns(
    names: list[str], separator: str, number: int, problems: list[Problem], feature_needed: bool
) -> tuple[str, ...]:
    """The names of the columns if all of them are known, each once, and none is missing."""
    wrong = _header_problem(names)
    if wrong:
        problems.append(Problem(*wrong, line=number))
        return ()
    found = list(_column_problems(names, separator, feature_needed))
    problems.extend(Problem(what, remedy, line=number) for what, remedy in found)
    return () if found else tuple(names)


def _header_problem(names: list[str]) -> tuple[str, str] | None:
    """What makes the row no header at all."""
    if not any(name in COLUMNS for name in names):
        shown = ", ".join(names)[:60]
        if any(re.fullmatch(r"[-+]?[0-9.,]+(e[-+]?[0-9]+)?", name) for name in names):
            return (
                f"there is no header row, the first row is {shown!r}",
                f"begin with the names of the columns: {_EXAMPLE}",
            )
        return f"the header {shown!r} has no known column", f"divide by comma, semicolon or tab: {_EXAMPLE}"
    return None


def _column_problems(names: list[str], separator: str, feature_needed: bool) -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    directions = [name for name in ("i", "j", "k") if name in names]
    if directions:
        what = f"{', '.join(directions)}: is this the way the probe moved, or the outward normal of the surface?"
        found.append((what, "name the columns ax, ay, az for the former or nx, ny, nz for the latter"))
    for name in dict.fromkeys(names):
        if names.count(name) > 1:
            found.append((f"column {name!r} stands there {names.count(name)} times", "remove or rename all but one"))
        if not name:
            position = names.index(name) + 1
            found.append(
                (f"column {position} has no name", "name it, or remove the separators without anything between")
            )
        elif name not in COLUMNS and name not in directions:
            remedy = f"remove it, or name it one of: {', '.join(_USUAL)}"
            found.append((f"unknown column {name!r}", remedy))
    needed = (*(("feature",) if feature_needed else ()), "x", "y", "z")
    found += [(f"there is no column {name!r}", f"add it: {_EXAMPLE}") for name in needed if name not in names]
    return found + _vector_problems(names)


def _vector_problems(names: list[str]) -> list[tuple[str, str]]:
    found = [
        *_one_of(names, APPROACHES, "keep one of them: the approach, or the outward normal"),
        *_one_of(names, ORIENTATIONS, "keep one of them: the orientation of the flange, in one convention"),
    ]
    if "fx" in names and not any(name in names for vector in ORIENTATIONS for name in vector):
        remedy = "add how the flange stood, such as qw, qx, qy, qz, or give the approach in base: ax, ay, az"
        found.append(("fx, fy, fz are in the flange frame, and no column says how it stood", remedy))
    return found


def _one_of(names: list[str], vectors: Sequence[tuple[str, ...]], remedy: str) -> list[tuple[str, str]]:
    """What is wrong where columns of more than one of the vectors are there, or only some of one."""
    given = [[name for name in vector if name in names] for vector in vectors]
    whole = [", ".join(vector) for vector, part in zip(vectors, given, strict=True) if part]
    if len(whole) > 1:
        return [(f"both {' and '.join(whole)} are there", remedy)]
    return [
        (
            f"{', '.join(part)} without {', '.join(name for name in vector if name not in part)}",
            f"give all {'four' if len(vector) == 4 else 'three'} or none",
        )
        for part, vector in zip(given, vectors, strict=True)
        if part and len(part) < len(vector)
    ]
