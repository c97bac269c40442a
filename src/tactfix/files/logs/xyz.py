"""XYZ files of measuring software: points, or points with the outward normal, one per line.

The number of numbers in a line has the meaning of PC-DMIS: 3 or 5 a point (the last two are not used), 6 or 8 a point
with its normal, 7 a circle with its normal and diameter, 4 a circle without normal, which is an error. A name may come
first. A header row gives the columns, and optionally the unit: X [mm]. Each number may have a letter, X1.0 Y2.0 Z3.0,
as controllers write point clouds; other axes must not change.
"""

import re
from dataclasses import dataclass, field
from typing import Final

from tactfix.errors import Problem
from tactfix.files.logs.columns import COUNTING, NAMING, Cell, cells_of, is_header, is_number, numbers_of
from tactfix.files.logs.log import (
    ConstantStates,
    Log,
    LogContact,
    against,
    check_normal,
    read_lines,
    skipped,
    vector,
)
from tactfix.lexer import Lexer
from tactfix.units import UNITS, which_unit

_XYZ_REMEDY: Final = "write x,y,z or x,y,z,i,j,k"
_HEADER: Final = "write XYZIJK METRIC, or XYZIJK for inch, above"
_COMMA: Final = "write a decimal point in each of x, y and z: a comma divides numbers here"
_WITH_NORMAL: Final = (6, 7, 8)
"""Counts of numbers of a line that has a normal after the coordinates."""
_COLUMN_NAME: Final = re.compile(r'"?[A-Za-z_][A-Za-z0-9_ #-]*"?')
_NORMALS: Final = (("I", "J", "K"), ("NX", "NY", "NZ"))
_COORDINATES: Final = frozenset({"X", "Y", "Z", "I", "J", "K", "NX", "NY", "NZ"})
_COLUMN: Final = re.compile(r'"?([^"\[(]*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])]\s*)?"?')
_LETTERED: Final = re.compile(r'\s*(?:("?[A-Za-z_][\w #-]*"?)\s*[,;:]\s*)?(?=X\s*[=:]?\s*[-+.0-9])', re.IGNORECASE)
_LETTERS: Final = "write X1.0 Y2.0 Z3.0, or x,y,z"
_ROTARY_AXES: Final = "ABCUVW"


@dataclass(slots=True)
class _Reader:
    needs_header: bool
    begun: bool = False
    columns: tuple[str, ...] = ()
    units: str | None = None
    contacts: list[LogContact] = field(default_factory=list)
    circles: list[int] = field(default_factory=list)
    comments: list[int] = field(default_factory=list)
    constant: ConstantStates = field(default_factory=ConstantStates)
    notes: list[str] = field(default_factory=list)

    def line(self, lexer: Lexer) -> None:
        words = lexer.text.split()
        if not self.begun and words[0].upper() == "XYZIJK":
            self._header(lexer, words)
        elif lexer.text.lstrip().startswith(("#", "//")):
            self.comments.append(lexer.line)
        elif self.needs_header and not self.begun:
            self.needs_header = False
            lexer.refuse("this does not start with XYZIJK", _HEADER)
        else:
            self._point(lexer)

    def _header(self, lexer: Lexer, words: list[str]) -> None:
        system = " ".join(words[1:]).upper()
        if system not in ("", "METRIC", "INCH"):
            lexer.refuse(f"{' '.join(words[1:])!r} follows XYZIJK", _HEADER)
        self.units = "mm" if system == "METRIC" else "in"
        self.begun = True

    def _names(self, lexer: Lexer) -> None:
        """The header row: every name must be known, and none of the point missing."""
        columns: list[str] = []
        for cell in cells_of(lexer, self.constant):
            lexer.position = cell.column - 1
            match = _COLUMN.fullmatch(cell.text)
            name = match.group(1).strip().upper() if match else ""
            if name not in _COORDINATES | NAMING | COUNTING or name in columns:
                lexer.refuse(f"the column {cell.text[:40]!r} is not known, or is given twice", _XYZ_REMEDY)
            columns.append(name)
            unit = match.group(2) if match else None
            if unit is not None and (unit not in UNITS or self.units not in (None, unit)):
                lexer.refuse(f"the unit {unit[:40]!r} is not known, or another one than before", which_unit(unit))
            self.units = unit or self.units
        normals = [[axis for axis in normal if axis in columns] for normal in _NORMALS]
        if not {"X", "Y", "Z"} <= set(columns) or sorted(map(len, normals)) not in ([0, 0], [0, 3]):
            lexer.refuse("the names are not those of a point, with its normal or without", _XYZ_REMEDY)
        self.columns = tuple(columns)

    def _named(self, lexer: Lexer) -> None:
        """A line below a header row."""
        cells = cells_of(lexer, self.constant)
        if len(cells) != len(self.columns):
            lexer.refuse(f"{len(cells)} cells where there are {len(self.columns)} columns", _XYZ_REMEDY)
        by_name = dict(zip(self.columns, cells, strict=True))
        numbered = {name: cell for name, cell in by_name.items() if name in _COORDINATES}
        values = dict(zip(numbered, numbers_of(lexer, tuple(numbered.values()), self.constant), strict=True))
        name = next((cell.text.strip('"') for name, cell in by_name.items() if name in NAMING), None)
        self._add(lexer, values, name or None)

    def _lettered(self, lexer: Lexer, name: str | None) -> None:
        """X1.0 Y2.0 Z3.0, with optional =, optional I J K, and rotary axes, which must not change."""
        values: dict[str, float] = {}
        while lexer.blanks().rest:
            letter = lexer.rest[0].upper()
            if letter not in "XYZIJK" + _ROTARY_AXES or letter in values:
                lexer.refuse(f"{lexer.rest[0]!r} is not a letter of a point, or is given twice", _LETTERS)
            lexer.position += 1
            if not lexer.take("="):
                lexer.take(":")
            values[letter] = lexer.number(_LETTERS, glued=True)
            if not lexer.take(","):
                lexer.take(";")
        if not {"X", "Y", "Z"} <= values.keys() or len(values.keys() & set("IJK")) not in (0, 3):
            lexer.refuse("a point has X, Y and Z, and I, J and K or none of them", _LETTERS)
        for axis in _ROTARY_AXES:
            if axis in values:
                self.constant.keep(f"the axis {axis}", values[axis], lexer)
        self._add(lexer, values, name)

    def _add(self, lexer: Lexer, values: dict[str, float], name: str | None) -> None:
        normal = next(([values[axis] for axis in axes] for axes in _NORMALS if axes[0] in values), [0.0, 0.0, 0.0])
        check_normal(lexer, normal, _XYZ_REMEDY)
        self.contacts.append(LogContact(lexer.line, vector([values[axis] for axis in "XYZ"]), against(normal), id=name))

    def _point(self, lexer: Lexer) -> None:
        begun, self.begun = self.begun, True
        lettered = _LETTERED.match(lexer.text)
        if not begun and is_header(lexer.text):
            self._names(lexer)
        elif self.columns:
            self._named(lexer)
        elif lettered:
            lexer.position = lettered.end()
            self._lettered(lexer, lettered.group(1))
        else:
            self._numbers(lexer)

    def _numbers(self, lexer: Lexer) -> None:
        """A line of numbers, optionally after a name."""
        cells = cells_of(lexer, self.constant)
        name = cells[0].text if not is_number(cells[0]) else None
        if name is not None and not _COLUMN_NAME.fullmatch(name):
            lexer.refuse(f"{name[:40]!r} is neither a number nor a name", _XYZ_REMEDY)
        cells = cells if name is None else cells[1:]
        numbers = numbers_of(lexer, cells, self.constant)
        if not 3 <= len(numbers) <= 8 or len(numbers) == 4:
            given = "a circle with its diameter" if len(numbers) == 4 else f"{len(numbers)} numbers"
            lexer.refuse(f"{given} where a touch has 3 or 6", _XYZ_REMEDY)
        if name is not None and len(numbers) not in (3, 6):
            lexer.refuse(f"a name and {len(numbers)} numbers", _XYZ_REMEDY)
        self.constant.keep("the number of numbers in a line", len(numbers), lexer, _XYZ_REMEDY)
        if len(numbers) not in (3, 6):
            self._check(lexer, cells, numbers)
        normal = numbers[3:6] if len(numbers) in _WITH_NORMAL else (0.0, 0.0, 0.0)
        check_normal(lexer, normal, _XYZ_REMEDY)
        self.contacts.append(LogContact(lexer.line, vector(numbers[:3]), against(normal), id=name))

    def _check(self, lexer: Lexer, cells: tuple[Cell, ...], numbers: tuple[float, ...]) -> None:
        """Lines of 5, 7 and 8 numbers could be shorter ones with decimal commas."""
        if len({"." in cell.text for cell in cells[:3]}) > 1:
            lexer.refuse(f"{len(numbers)} numbers, some with a decimal point and some without", _COMMA)
        if len(numbers) == 7 and numbers[-1] != 0:
            self.circles.append(lexer.line)

    def log(self) -> Log:
        for axis in _ROTARY_AXES:
            self.notes.extend(self.constant.notes(f"the axis {axis}"))
        notes = [
            f"line {line}: a circle with its diameter; its centre is taken for the contact" for line in self.circles
        ]
        return Log(tuple(self.contacts), self.units, (*notes, *self.notes, *skipped(self.comments, "comments")))


def read_xyzijk(text: str, problems: list[Problem]) -> Log:
    """An XYZ file of PC-DMIS: XYZIJK in the first line, inch unless METRIC."""
    reader = _Reader(needs_header=True)
    read_lines(text, problems, reader.line)
    return reader.log()


def read_xyz(text: str, problems: list[Problem]) -> Log:
    """Any XYZ file; the unit is known only from XYZIJK in the first line or from a header row."""
    reader = _Reader(needs_header=False)
    read_lines(text, problems, reader.line)
    return reader.log()
