"""The rows below the header of a contact file as columns of numbers; a bad cell is looked for only if there is one."""

import math
import re
from collections.abc import Sequence
from typing import Final

import numpy as np

from tactfix.decimal_text import DECIMAL_COMMA, MOST_CHARACTERS, NUMBER
from tactfix.errors import Problem
from tactfix.geometry.arrays import Floats
from tactfix.values import frozen_value

# What plain decimal numbers are made of: excludes nan, inf, 0x10, 1_000 and digits of other scripts, all of which
# float() would take.
_PLAIN_NUMBERS: Final = re.compile(r"[0-9eE+\-. \n]*")
_THOUSANDS: Final = r"[+-]?[0-9]{1,3}([ ',.\u00a0\u202f][0-9]{3})+([.,][0-9]*)?"


@frozen_value(eq=True)
class Table:
    """Cells, stripped, by column name; row and line of each in the file; the separator, and the mark of decimals."""

    columns: dict[str, Sequence[str]]
    rows: Sequence[int]
    lines: Sequence[int]
    separator: str
    decimal: str = "."

    def __len__(self) -> int:
        return len(self.lines)

    def problem(self, index: int, what: str, remedy: str) -> Problem:
        """A problem of the row with this index (from 0)."""
        return Problem(what, remedy, line=self.lines[index], row=self.rows[index])


def decimal_mark(table: Table, names: Sequence[str], problems: list[Problem]) -> str:
    """What divides whole from fraction in the columns names: a comma only where it does not divide cells too."""
    if table.separator == ",":
        return "."
    commas = _first_with(table, names, ",")
    points = _first_with(table, names, ".")
    if commas is None or points is None:
        return "." if commas is None else ","
    if commas != points:  # a cell with both is refused by itself
        first = f"decimal commas (first in row {table.rows[commas]})"
        what = f"{first} and decimal points (first in row {table.rows[points]}) are mixed"
        problems.append(table.problem(max(commas, points), what, "write all numbers with the same decimal mark"))
        return ","  # so that each of them is understood, and not told a second time
    return "."


def _first_with(table: Table, names: Sequence[str], mark: str) -> int | None:
    rows = [
        next(index for index, cell in enumerate(table.columns[name]) if mark in cell)
        for name in names
        if mark in "".join(table.columns[name])
    ]
    return min(rows, default=None)


def numbers(table: Table, names: Sequence[str], problems: list[Problem], *, may_be_empty: bool = False) -> Floats:
    """The columns names as (n, len(names)); an empty cell, and one that is no finite number, becomes nan.

    Each that is no number is a problem, an empty one unless it may be empty.
    """
    columns = [_fast_column(table, name) for name in names]
    if any(column is None for column in columns):
        columns = [_slow_column(table, name, problems, may_be_empty) for name in names]
    return np.stack([column for column in columns if column is not None], axis=1)


def _fast_column(table: Table, name: str) -> Floats | None:
    """All cells of a column at once, None if one of them is not a finite number."""
    cells = table.columns[name]
    joined = "\n".join(cells)
    if table.decimal == ",":
        if "." in joined:
            return None
        cells = joined.replace(",", ".").split("\n")
    if not _PLAIN_NUMBERS.fullmatch(joined.replace(",", ".") if table.decimal == "," else joined):
        return None
    if max(map(len, cells), default=0) > MOST_CHARACTERS:
        return None
    try:
        values = np.fromiter(map(float, cells), dtype=np.float64, count=len(table))
    except ValueError:
        return None
    return values if np.isfinite(values).all() else None


def _slow_column(table: Table, name: str, problems: list[Problem], may_be_empty: bool) -> Floats:
    values = np.full(len(table), np.nan)
    for index, cell in enumerate(table.columns[name]):
        text = cell.replace(",", ".") if table.decimal == "," and "." not in cell else cell
        if len(text) <= MOST_CHARACTERS and NUMBER.fullmatch(text) and math.isfinite(float(text)):
            values[index] = float(text)
        elif cell or not may_be_empty:
            problems.append(table.problem(index, *_cell_problem(name, cell, table.separator)))
    return values


def _cell_problem(name: str, cell: str, separator: str) -> tuple[str, str]:
    """What is wrong with a cell that is no number, and what to write instead."""
    if not cell:
        return f"{name} is empty", "write a number"
    shown = repr(cell if len(cell) <= 40 else cell[:40] + "...")
    if re.fullmatch(_THOUSANDS, cell) and not re.fullmatch(r"[+-]?[0-9]+,[0-9]+", cell):
        return f"{name} is {shown}", "write it without thousands separators"
    if separator == "," and DECIMAL_COMMA.fullmatch(cell):
        return f"{name} is {shown}", "write a decimal point, or divide cells by semicolons or tabs"
    if re.fullmatch(r"[+-]?(nan|inf|infinity)|#.*|n/?a|null|none", cell, re.IGNORECASE):
        return f"{name} is {shown}", "write a finite number, or remove the row if the touch failed"
    return f"{name} is {shown}, not a number", "write digits with a decimal point, without a unit"
