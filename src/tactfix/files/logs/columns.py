"""Lines of bare numbers: one separator for the whole file, and a decimal comma only if it is unambiguous.

The separator of a line is the first of semicolon, tab, comma and blank that it contains. A comma is a decimal mark if
the separator is a semicolon or tab and no number of the file has a point.

Robot poses may have a header row. Without one a line holds the numbers of the controller's own pose in
their order, or x, y and z alone. With one the columns may be in any order; those of external axes must not
change; those of a recorder (RTDE) that do not belong to the pose are skipped.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from tactfix.files.logs.log import ConstantStates, LogContact, vector
from tactfix.lexer import Lexer
from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.dialect import Numbers
from tactfix.pose_formats.pose import PoseSyntaxError
from tactfix.values import frozen_value

_COLUMNS_REMEDY: Final = "write numbers with a decimal point and one separator throughout"
_SEPARATOR_NAMES: Final = {";": "semicolons", "\t": "tabs", ",": "commas", " ": "blanks"}


@frozen_value(eq=True)
class Cell:
    """The text between two separators, stripped, and the column (from 1) of its first character."""

    text: str
    column: int


NAMING: Final = frozenset({"NAME", "ID", "POINT", "POINT ID", "POINT NAME", "LABEL", "PT"})
COUNTING: Final = frozenset(
    {"NO", "NO.", "NR", "NR.", "N", "#", "INDEX", "COUNT", "TIME", "TIMESTAMP", "DATE", "GROUP"}
)
"""Columns other than coordinates: names of contacts; counters and times, which are ignored."""


def is_header(text: str) -> bool:
    """Whether a line is a header row: its cells include X, Y and Z and no number."""
    separator = separator_of(text)
    parts = [part.strip().strip('"') for part in (text.split(separator) if separator != " " else text.split())]
    names = {part.split("[")[0].split("(")[0].strip().upper() for part in parts}
    return {"X", "Y", "Z"} <= names and not any(part[:1] in set("+-.0123456789") for part in parts if part)


def separator_of(line: str) -> str:
    """The separator of this line."""
    return next((mark for mark in ";\t," if mark in line.strip()), " ")


def cells_of(lexer: Lexer, constant: ConstantStates) -> tuple[Cell, ...]:
    """The cells of a line; an error if its separator differs from that of the lines before."""
    separator = separator_of(lexer.rest)
    if len(lexer.rest.split()) > 1 or separator != " ":
        constant.keep("the separator of the numbers", _SEPARATOR_NAMES[separator], lexer, _COLUMNS_REMEDY)
    cells, column = [], lexer.column
    for part in lexer.rest.split(separator):
        inside = part.lstrip()
        cells.append(Cell(inside.rstrip(), column + len(part) - len(inside)))
        column += len(part) + 1
    return tuple(cell for cell in cells if cell.text or separator != " ")


def is_number(cell: Cell) -> bool:
    """Whether a cell begins like a number."""
    return cell.text[:1] in set("+-.0123456789") and bool(cell.text)


def numbers_of(lexer: Lexer, cells: Sequence[Cell], constant: ConstantStates) -> tuple[float, ...]:
    """Each cell as a number."""
    commas = separator_of(lexer.rest) in ";\t"
    found = []
    for cell in cells:
        text = cell.text
        if commas and "," in text and "." not in text:
            constant.keep("the decimal mark", "comma", lexer, _COLUMNS_REMEDY)
            text = text.replace(",", ".", 1)
        elif "." in text:
            constant.keep("the decimal mark", "point", lexer, _COLUMNS_REMEDY)
        inside = Lexer(text, lexer.line, cell.column)
        found.append(inside.number(_COLUMNS_REMEDY))
        inside.end(_COLUMNS_REMEDY)
    return tuple(found)


_RECORDED: Final = re.compile(
    r"timestamp|(actual|target|input|output|joint|tool|robot|safety|runtime|speed|standard|payload|euromap67|ft_raw|"
    r"elbow|tcp|script|wrench|io|analog|time|collision)_\w+|tcp_offset_\d",
    re.IGNORECASE,
)
_RECORDED_POSES: Final = ("ACTUAL_TCP_POSE", "TARGET_TCP_POSE")
_PASSED: Final = frozenset({"S", "T"})
_EXTERNAL: Final = re.compile(r"E[1-6]|EAX_[A-F]")
_OF_TOOL: Final = re.compile(r"(?:TCP|POSE)[_.](?=\w)")
_SCALAR_FIRST: Final = (("Q0", "Q1", "Q2", "Q3"), ("QW", "QX", "QY", "QZ"), ("U0", "U1", "U2", "U3"))
"""Other column names of the quaternion q1 to q4, scalar first."""


@dataclass(slots=True)
class PoseColumns:
    """Reads lines of numbers as poses whose numbers are those of a pose format."""

    numbers: Numbers
    constant: ConstantStates = field(default_factory=ConstantStates)
    columns: tuple[str, ...] = ()
    passed: list[str] = field(default_factory=list)
    open_end: bool = False

    @classmethod
    def of(cls, dialect: str) -> "PoseColumns":
        """Columns with the numbers of a pose format."""
        numbers = DIALECTS[dialect].numbers
        assert numbers is not None
        return cls(numbers)

    @property
    def _remedy(self) -> str:
        return f"write {', '.join(self.numbers.labels)} with one separator throughout"

    def line(self, lexer: Lexer) -> LogContact | None:
        """The contact of a line; None for the header row."""
        cells = cells_of(lexer, self.constant)
        if not self.columns and not any(map(is_number, cells)):
            self._names(lexer, cells)
            return None
        if not self.columns:
            labels = self.numbers.labels
            if len(cells) not in (3, len(labels)):
                lexer.refuse(f"{len(cells)} numbers are not a pose", self._remedy)
            self.columns = tuple(labels[: len(cells)])
        if self.open_end and not cells[-1].text:
            cells = cells[:-1]
        if len(cells) != len(self.columns):
            lexer.refuse(f"{len(cells)} numbers where there are {len(self.columns)} columns", self._remedy)
        by_name = dict(zip(self.columns, cells, strict=True))
        numbered = {name: cell for name, cell in by_name.items() if name not in NAMING | COUNTING}
        found = dict(zip(numbered, numbers_of(lexer, tuple(numbered.values()), self.constant), strict=True))
        name = next((cell.text.strip('"') for name, cell in by_name.items() if name in NAMING), None)
        return self._contact(lexer, found, name or None)

    def _names(self, lexer: Lexer, cells: tuple[Cell, ...]) -> None:
        """The header row: every name must be known, and none of the position missing."""
        by_capitals = {label.upper(): label for label in self.numbers.labels}
        self.open_end = not cells[-1].text
        cells = cells[:-1] if self.open_end else cells
        names = [cell.text.strip('"').upper() for cell in cells]
        bare = [_OF_TOOL.sub("", name, count=1) for name in names]
        names = [short if short in by_capitals else name for short, name in zip(bare, names, strict=True)]
        for others in _SCALAR_FIRST:
            if len(by_capitals) == 7 and set(others) <= set(names):
                names = [f"Q{others.index(name) + 1}" if name in others else name for name in names]
        recorded = next((name for name in _RECORDED_POSES if f"{name}_0" in names), None)
        if recorded is not None:
            by_capitals = {f"{recorded}_{i}": label for i, label in enumerate(self.numbers.labels)}
        columns = tuple(by_capitals.get(name, name) for name in names)
        for cell, name, column in zip(cells, names, columns, strict=True):
            lexer.position = cell.column - 1
            known = column in self.numbers.labels or name in _PASSED | NAMING | COUNTING or _EXTERNAL.fullmatch(name)
            if not known and not _RECORDED.fullmatch(name):
                lexer.refuse(f"the column {cell.text[:40]!r} is not known", self._remedy)
            if names.count(name) > 1:
                lexer.refuse(f"the column {cell.text[:40]!r} is given twice", self._remedy)
        absent = [label for label in self.numbers.labels if label not in columns]
        if absent and absent != list(self.numbers.labels[3:]):
            lexer.refuse(f"there is no column {', '.join(absent)}", self._remedy)
        self.columns = columns
        self.passed = [name.lower() for name, column in zip(names, columns, strict=True) if _says_nothing(column)]

    def _contact(self, lexer: Lexer, found: dict[str, float], called: str | None) -> LogContact:
        for name, value in found.items():
            if _EXTERNAL.fullmatch(name):
                self.constant.keep(f"the external axis {name}", value, lexer)
            elif name.upper().startswith("TCP_OFFSET"):
                self.constant.keep(f"the tool's offset, {name.lower()},", value, lexer)
        labels = self.numbers.labels
        if not all(label in found for label in labels):
            return LogContact(lexer.line, vector([found[label] for label in labels[:3]]), id=called)
        return pose_contact(lexer, self.numbers, [found[label] for label in labels], called)


def _says_nothing(column: str) -> bool:
    return column in COUNTING or _RECORDED.fullmatch(column) is not None


def pose_contact(lexer: Lexer, numbers: Numbers, values: Sequence[float], name: str | None = None) -> LogContact:
    """The contact whose pose has these numbers."""
    line = lexer.line
    try:
        pose = numbers.pose(np.array(values))
    except PoseSyntaxError as error:
        lexer.refuse(error.problems[0].what, error.problems[0].remedy)
    return LogContact(line, vector(pose[:3, 3].tolist()), rotation=pose[:3, :3], id=name)
