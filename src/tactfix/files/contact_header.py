"""The header of a contact file: the settings above it, and the names of its columns."""

import re
from collections.abc import Callable, Sequence
from typing import Final

from tactfix.errors import Problem
from tactfix.files.contact_options import ContactOptions
from tactfix.files.contact_settings import SettingLines
from tactfix.settings import Setting
from tactfix.values import frozen_value

APPROACH_COLUMNS: Final = (("ax", "ay", "az"), ("nx", "ny", "nz"), ("fx", "fy", "fz"))
"""The approach in base, the outward normal in base, the approach in the flange frame."""
ORIENTATION_COLUMNS: Final = (("qw", "qx", "qy", "qz"), ("rx", "ry", "rz"), ("a", "b", "c"), ("w", "p", "r"))
"""Orientation of the flange; see `flange_columns`."""
_USUAL_COLUMNS: Final = ("feature", "x", "y", "z", "ax", "ay", "az", "nx", "ny", "nz", "id", "sigma")
COLUMNS: Final = ("feature", "x", "y", "z", *sum(APPROACH_COLUMNS + ORIENTATION_COLUMNS, ()), "id", "sigma", "target")
_WITH_UNIT: Final = re.compile(r"(x|y|z|sigma)\s*[(\[](?!\s*[-+.0-9])([^()\[\]]+)[)\]]")
"""A column name with a unit. A number in brackets is not a unit but a coordinate, X(12.5), of a measuring machine."""
_EXAMPLE: Final = "feature,x,y,z,ax,ay,az"
_OF_A_MACHINE: Final = (
    "; for the log of a machine give " + Setting.LOG_FORMAT.word + ", or have tactfix import make a contact file of it"
)
"""Advice if a file does not begin like a contact file."""


@frozen_value(eq=True)
class Header:
    """The settings of the file, the standard names of its columns, the separator, and the first row.

    first_line: index (from 0) of the first line below the header row. setting_keys: the keys that lines set,
    or fail to set, which has been reported.
    """

    settings: ContactOptions
    columns: tuple[str, ...]
    separator: str
    first_line: int
    setting_keys: frozenset[str]


def read_header(lines: Sequence[str], problems: list[Problem], *, feature_needed: bool) -> Header | None:
    """The header of a contact file; None, with a problem, if its columns cannot be determined."""
    settings = SettingLines(problems)
    for index, line in enumerate(lines):
        if line.lstrip().startswith("#"):
            settings.read(line.strip(), index + 1)
        elif line.strip():
            separator, cells = split_header(line, lambda cell: _column(cell)[0] in COLUMNS)
            names = [_column(cell)[0] for cell in cells]
            columns = _read_columns(names, separator, index + 1, problems, feature_needed)
            if not columns:
                return None
            units = [unit for _, unit in map(_column, cells) if unit is not None]
            if units:
                settings.read_units_of_columns(units, index + 1)
            return Header(settings.settings(separator), columns, separator, index + 1, settings.keys)
    message = "there is no header row" if any(line.strip() for line in lines) else "the file is empty"
    problems.append(Problem(message, f"begin with the names of the columns: {_EXAMPLE}"))
    return None


def _column(cell: str) -> tuple[str, str | None]:
    """The name of a column, and the unit in brackets after it: x (mm)."""
    match = _WITH_UNIT.fullmatch(cell)
    return (match[1], match[2].strip()) if match else (cell, None)


def split_header(line: str, is_known: Callable[[str], bool]) -> tuple[str, list[str]]:
    """The separator of a header row, and its cells in lower case, stripped of blanks and quotation marks.

    Tab, semicolon or comma: the one that gives the most known names; in a tie, the most cells.
    """
    rows = {mark: [cell.strip().strip('"').strip().lower() for cell in line.split(mark)] for mark in ("\t", ";", ",")}
    separator = max(rows, key=lambda mark: (sum(map(is_known, rows[mark])), len(rows[mark])))
    return separator, rows[separator]


def _read_columns(
    names: list[str], separator: str, number: int, problems: list[Problem], feature_needed: bool
) -> tuple[str, ...]:
    """The names of the columns if all of them are known, each once, and none is missing."""
    wrong = _header_problem(names)
    if wrong:
        problems.append(Problem(*wrong, line=number))
        return ()
    found = list(_column_problems(names, separator, feature_needed))
    problems.extend(Problem(message, remedy, line=number) for message, remedy in found)
    return () if found else tuple(names)


def _header_problem(names: list[str]) -> tuple[str, str] | None:
    """Why the row is no header, and what to do; None for a header."""
    if not any(name in COLUMNS for name in names):
        shown = ", ".join(names)[:60]
        if any(re.fullmatch(r"[-+]?[0-9.,]+(e[-+]?[0-9]+)?", name) for name in names):
            return (
                f"there is no header row, the first row is {shown!r}",
                f"begin with the names of the columns: {_EXAMPLE}" + _OF_A_MACHINE,
            )
        return (
            f"the header {shown!r} has no known column",
            f"divide by comma, semicolon or tab: {_EXAMPLE}" + _OF_A_MACHINE,
        )
    return None


def _column_problems(names: list[str], separator: str, feature_needed: bool) -> list[tuple[str, str]]:
    found: list[tuple[str, str]] = []
    directions = [name for name in ("i", "j", "k") if name in names]
    if directions:
        message = f"{', '.join(directions)}: is this the way the probe moved, or the outward normal of the surface?"
        found.append((message, "name the columns ax, ay, az for the former or nx, ny, nz for the latter"))
    for name in dict.fromkeys(names):
        if names.count(name) > 1:
            found.append((f"column {name!r} is given {names.count(name)} times", "remove or rename all but one"))
        if not name:
            position = names.index(name) + 1
            found.append(
                (f"column {position} has no name", "name it, or remove the separators without anything between")
            )
        elif name not in COLUMNS and name not in directions:
            remedy = f"remove it, or name it one of: {', '.join(_USUAL_COLUMNS)}"
            found.append((f"unknown column {name!r}", remedy))
    needed = (*(("feature",) if feature_needed else ()), "x", "y", "z")
    found += [(f"there is no column {name!r}", f"add it: {_EXAMPLE}") for name in needed if name not in names]
    return found + _vector_problems(names)


def _vector_problems(names: list[str]) -> list[tuple[str, str]]:
    found = [
        *_one_of(names, APPROACH_COLUMNS, "keep one of them: the approach, or the outward normal"),
        *_one_of(names, ORIENTATION_COLUMNS, "keep one of them: the orientation of the flange, in one convention"),
    ]
    if "fx" in names and not any(name in names for vector in ORIENTATION_COLUMNS for name in vector):
        remedy = "add the orientation of the flange, such as qw, qx, qy, qz, or give the approach in base: ax, ay, az"
        found.append(("fx, fy, fz are in the flange frame, and no column gives its orientation", remedy))
    return found


def _one_of(names: list[str], vectors: Sequence[tuple[str, ...]], remedy: str) -> list[tuple[str, str]]:
    """Problems if there are columns of several alternative vectors, or only some columns of one."""
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
