"""Lines of bare numbers: one separator for the whole file, and a decimal comma only where it is certain.

Semicolons divide before tabs, tabs before commas, commas before blanks. A comma is a decimal mark where semicolons or
tabs divide and no number of the file has a point.
"""

from collections.abc import Sequence
from typing import Final

from tactfix.files.logs.log import Standing
from tactfix.lexer import Lexer
from tactfix.values import frozen_value

_COLUMNS_REMEDY: Final = "write numbers with a decimal point and one separator throughout"
_SEPARATOR_NAMES: Final = {";": "semicolons", "\t": "tabs", ",": "commas", " ": "blanks"}


@frozen_value(eq=True)
class Cell:
    """What stands between two separators, without blanks around, and the column of its first character."""

    text: str
    column: int


NAMING: Final = frozenset({"NAME", "ID", "POINT", "POINT ID", "POINT NAME", "LABEL", "PT"})
COUNTING: Final = frozenset(
    {"NO", "NO.", "NR", "NR.", "N", "#", "INDEX", "COUNT", "TIME", "TIMESTAMP", "DATE", "GROUP"}
)
"""Columns beside the coordinates: what a contact is called, and what says nothing of where it is."""


def is_header(text: str) -> bool:
    """Whether a line names columns: X, Y and Z are among its cells, and no number is."""
    separator = separator_of(text)
    parts = [part.strip().strip('"') for part in (text.split(separator) if separator != " " else text.split())]
    names = {part.split("[")[0].split("(")[0].strip().upper() for part in parts}
    return {"X", "Y", "Z"} <= names and not any(part[:1] in set("+-.0123456789") for part in parts if part)


def separator_of(line: str) -> str:
    """What divides this line."""
    return next((mark for mark in ";\t," if mark in line.strip()), " ")


def cells_of(lexer: Lexer, standing: Standing) -> tuple[Cell, ...]:
    """The cells of a line; refused where it is divided otherwise than the lines before."""
    separator = separator_of(lexer.rest)
    if len(lexer.rest.split()) > 1 or separator != " ":
        standing.keep("what divides the numbers", _SEPARATOR_NAMES[separator], lexer, _COLUMNS_REMEDY)
    cells, column = [], lexer.column
    for part in lexer.rest.split(separator) if separator != " " else _by_blanks(lexer.rest):
        inside = part.lstrip()
        cells.append(Cell(inside.rstrip(), column + len(part) - len(inside)))
        column += len(part) + 1
    return tuple(cell for cell in cells if cell.text or separator != " ")


def _by_blanks(text: str) -> Sequence[str]:
    return text.split(" ")


def is_number(cell: Cell) -> bool:
    """Whether a cell begins like a number."""
    return cell.text[:1] in set("+-.0123456789") and bool(cell.text)


def numbers_of(lexer: Lexer, cells: Sequence[Cell], standing: Standing) -> tuple[float, ...]:
    """Each cell as a number."""
    commas = separator_of(lexer.rest) in ";\t"
    found = []
    for cell in cells:
        text = cell.text
        if commas and "," in text and "." not in text:
            standing.keep("the decimal mark", "comma", lexer, _COLUMNS_REMEDY)
            text = text.replace(",", ".", 1)
        elif "." in text:
            standing.keep("the decimal mark", "point", lexer, _COLUMNS_REMEDY)
        inside = Lexer(text, lexer.line, cell.column)
        found.append(inside.number(_COLUMNS_REMEDY))
        inside.end(_COLUMNS_REMEDY)
    return tuple(found)
