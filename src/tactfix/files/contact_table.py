"""The rows of a contact file below its header, split into columns, and columns as numbers."""

import math
import re
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from tactfix.decimal_text import DECIMAL_COMMA, MOST_CHARACTERS, NUMBER
from tactfix.errors import Problem
from tactfix.files.contact_header import Header
from tactfix.files.contact_settings import key_of
from tactfix.geometry.arrays import Floats
from tactfix.values import frozen_value
from tactfix.wording import UNPRINTABLE

# Characters of plain decimal numbers: excludes nan, inf, 0x10, 1_000 and digits of other scripts, all of which
# float() would take.
_PLAIN_NUMBERS: Final = re.compile(r"[0-9eE+\-. \n]*")
_THOUSANDS: Final = r"[+-]?[0-9]{1,3}([ ',.\u00a0\u202f][0-9]{3})+([.,][0-9]*)?"


@frozen_value(eq=True)
class Table:
    """Cells, stripped, by column name; number and line of each row; the separator, and the decimal mark."""

    columns: dict[str, Sequence[str]]
    rows: Sequence[int]
    lines: Sequence[int]
    separator: str
    decimal: str = "."

    def __len__(self) -> int:
        return len(self.lines)

    def problem(self, index: int, message: str, remedy: str) -> Problem:
        """A problem of the row with this index (from 0)."""
        return Problem(message, remedy, line=self.lines[index], row=self.rows[index])


def read_table(lines: Sequence[str], header: Header, problems: list[Problem]) -> Table | None:
    """The cells below the header; None, with a problem, if there are none.

    A row that cannot be split into the columns of the header is a problem and left out; the others keep their numbers
    and are checked too.
    """
    body, places = _content(lines, header, problems)
    if not body:
        problems.append(Problem("there are no contacts", "write one row for each touch below the header row"))
        return None
    text = "\n".join(body)
    problems.extend(_unprintable(text, body, places))
    width = len(header.columns)
    rows: Sequence[int] = range(1, len(body) + 1)
    if '"' in text:
        cut = _quoted_rows(body, places, header, problems)
        sound = [index for index, cells in enumerate(cut) if cells is not None and len(cells) == width]
        widths = [width if cells is None else len(cells) for cells in cut]
        cells = [cell for index in sound for cell in cut[index] or ()]
    else:
        widths = [line.count(header.separator) + 1 for line in body]
        sound = [index for index, found in enumerate(widths) if found == width]
        # Cells of all rows in one list: one list per row takes more time than parsing all numbers.
        whole = text if len(sound) == len(body) else "\n".join(body[index] for index in sound)
        cells = whole.replace("\n", header.separator).split(header.separator) if sound else []
    problems.extend(_ragged(body, widths, places, header))
    if len(sound) < len(body):
        rows, places = [rows[index] for index in sound], [places[index] for index in sound]
    if " " in text or "\t" in text:
        cells = [cell.strip() for cell in cells]
    columns: dict[str, Sequence[str]] = {name: cells[k::width] for k, name in enumerate(header.columns)}
    for name in ("feature", "id"):
        if name in columns and "'" in text:
            columns[name] = [_without_apostrophe(cell) for cell in columns[name]]
    return Table(columns, rows, places, header.separator)


def _without_apostrophe(cell: str) -> str:
    """A text without the apostrophe that keeps a spreadsheet from taking it for a formula."""
    return cell[1:] if cell.startswith(("'=", "'+", "'-", "'@")) else cell


def _unprintable(text: str, body: Sequence[str], places: Sequence[int]) -> Iterator[Problem]:
    """A problem for each row with an unprintable character."""
    if not UNPRINTABLE.search(text):
        return
    for index, line in enumerate(body):
        found = UNPRINTABLE.search(line)
        if found:
            message, remedy = f"there is a control character, {found[0]!r}", "remove it; it may not show in your editor"
            yield Problem(message, remedy, line=places[index], column=found.start() + 1, row=index + 1)


def _content(lines: Sequence[str], header: Header, problems: list[Problem]) -> tuple[list[str], Sequence[int]]:
    """The non-empty rows, and the line of each; comments are skipped, a setting below the header is a problem."""
    rest = lines[header.first_line :]
    first = header.first_line + 1
    empty = header.separator + " \t"
    header_row = lines[header.first_line - 1]
    keep = [bool(line.strip(empty)) and not line.lstrip().startswith("#") and line != header_row for line in rest]
    for number, line in enumerate(rest, first):
        if line == header_row:
            remedy = "remove it, or give each of the files joined here by itself"
            problems.append(Problem("the header row is given twice", remedy, line=number))
        if "#" in line and line.lstrip().startswith("#"):
            key = key_of(line.strip())
            if key:
                problems.append(Problem(f"{key} is below the header row", "move it above", line=number))
    if all(keep):
        return list(rest), range(first, first + len(rest))
    body = [line for line, kept in zip(rest, keep, strict=True) if kept]
    return body, [number for number, kept in enumerate(keep, first) if kept]


def _quoted_rows(
    body: list[str], places: Sequence[int], header: Header, problems: list[Problem]
) -> list[list[str] | None]:
    """The cells of each row of a file with quotation marks; None, with a problem, if one is not closed."""
    import csv

    rows: list[list[str] | None] = []
    for index, line in enumerate(body):
        try:
            rows.append(next(csv.reader([line], delimiter=header.separator, strict=True)))
        except csv.Error:
            message, remedy = "a quotation mark is left open or inside a cell", "close it in its line, or remove it"
            problems.append(Problem(message, remedy, line=places[index], row=index + 1))
            rows.append(None)
    return rows


def _ragged(body: Sequence[str], widths: Sequence[int], places: Sequence[int], header: Header) -> list[Problem]:
    """A problem for each row with more or fewer cells than the header."""
    width, mark = len(header.columns), header.separator
    fewer = f"write {mark.join(header.columns)}; leave a cell empty, but keep its separator"
    more = f"{fewer}; decimal commas need semicolons or tabs between cells" if mark == "," else fewer
    closed = "remove the separator at the end of the row"

    def remedy(index: int) -> str:
        if widths[index] < width:
            return fewer
        return closed if body[index].rstrip(" ").endswith(mark) else more

    return [
        Problem(f"{found} cells where the header has {width}", remedy(index), line=places[index], row=index + 1)
        for index, found in enumerate(widths)
        if found != width
    ]


def decimal_mark(table: Table, names: Sequence[str], problems: list[Problem]) -> str:
    """The decimal mark of the columns names: a comma only if it is not the separator."""
    if table.separator == ",":
        return "."
    commas = _first_with(table, names, ",")
    points = _first_with(table, names, ".")
    if commas is None or points is None:
        return "." if commas is None else ","
    if commas != points:  # a cell with both is an error of its own
        first = f"decimal commas (first in row {table.rows[commas]})"
        message = f"{first} and decimal points (first in row {table.rows[points]}) are mixed"
        problems.append(table.problem(max(commas, points), message, "write all numbers with the same decimal mark"))
        return ","  # so that each is accepted, and no second problem is reported
    return "."


def _first_with(table: Table, names: Sequence[str], mark: str) -> int | None:
    rows = [
        next(index for index, cell in enumerate(table.columns[name]) if mark in cell)
        for name in names
        if mark in "".join(table.columns[name])
    ]
    return min(rows, default=None)


def numbers(table: Table, names: Sequence[str], problems: list[Problem], *, may_be_empty: bool = False) -> Floats:
    """The columns names as (n, len(names)); empty cells and those that are no finite number become nan.

    Each cell that is no number is a problem, an empty one only if not may_be_empty.
    """
    columns = [_fast_column(table, name) for name in names]
    if any(column is None for column in columns):
        columns = [_slow_column(table, name, problems, may_be_empty) for name in names]
    return np.stack([column for column in columns if column is not None], axis=1)


def directions(
    table: Table, choices: Sequence[tuple[str, ...]], problems: list[Problem]
) -> tuple[tuple[str, ...], Floats]:
    """The first of choices (names of three columns) in the table, and its unit vectors (n, 3), nan for empty cells.

    A vector that is incomplete or zero is a problem.
    """
    names = next((names for names in choices if names[0] in table.columns), ())
    if not names:
        return (), np.full((len(table), 3), np.nan)
    before = len(problems)
    vectors = numbers(table, names, problems, may_be_empty=True)
    given = np.array([[bool(cell) for cell in table.columns[name]] for name in names]).T
    for index in np.flatnonzero(given.any(axis=1) & ~given.all(axis=1)):
        missing = ", ".join(name for name, is_given in zip(names, given[index], strict=True) if not is_given)
        problems.append(table.problem(int(index), f"{missing} is empty", "give all three of the approach or none"))
    largest = np.abs(vectors).max(axis=1, initial=0.0)
    for index in np.flatnonzero(largest == 0):
        message = f"the direction {', '.join(names)} is zero"
        remedy = "write one of any other length, or leave the three cells empty"
        problems.append(table.problem(int(index), message, remedy))
    if len(problems) > before:
        return names, vectors
    # Divide by the largest component first, so that no square under- or overflows.
    vectors = vectors / largest[:, None]
    return names, np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None])


def own_sigmas(table: Table, problems: list[Problem]) -> Floats:
    """The sigma of each contact (n,), in the file's units, nan if its row gives none."""
    if "sigma" not in table.columns:
        return np.full(len(table), np.nan)
    sigmas = numbers(table, ("sigma",), problems, may_be_empty=True)[:, 0]
    for index in np.flatnonzero(sigmas <= 0):
        problems.append(
            table.problem(int(index), f"sigma is {sigmas[index]:g}", "write a number above 0; no touch is exact")
        )
    return sigmas


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
    """The problem of a cell that is no number, and what to write instead."""
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
