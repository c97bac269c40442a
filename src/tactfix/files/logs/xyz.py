"""XYZ files of measuring software: points, or points with the outward normal, a line each.

What the numbers of a line mean is PC-DMIS's: 3 or 5 a point (the last two say nothing), 6 or 8 a point with its
normal, 7 a circle with its normal and diameter, 4 a circle without normal, which is refused. A name may stand before.
"""

import re
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from tactfix.errors import Problem
from tactfix.files.logs.columns import Cell, cells_of, is_number, numbers_of
from tactfix.files.logs.log import Log, LogContact, Standing, against, passed_over, read_lines, vector
from tactfix.lexer import Lexer

_REMEDY: Final = "write x,y,z or x,y,z,i,j,k"
_HEADER: Final = "write XYZIJK METRIC, or XYZIJK for inch, above"
_COMMA: Final = "write a decimal point in each of x, y and z: a comma divides numbers here"
_WITH_NORMAL: Final = (6, 7, 8)
_NAME: Final = re.compile(r'"?[A-Za-z_][A-Za-z0-9_ #-]*"?')
_NAMES: Final = frozenset({"X", "Y", "Z", "I", "J", "K", "NX", "NY", "NZ", "NAME", "ID"})
# A normal that was printed with few digits; numbers of another kind are off by far more.
_MOST_OFF_UNIT: Final = 0.01


@dataclass(slots=True)
class _Reader:
    needs_header: bool
    begun: bool = False
    units: str | None = None
    contacts: list[LogContact] = field(default_factory=list)
    circles: list[int] = field(default_factory=list)
    comments: list[int] = field(default_factory=list)
    standing: Standing = field(default_factory=Standing)

    def line(self, lexer: Lexer) -> None:
        words = lexer.text.split()
        if not self.begun and words[0] == "XYZIJK":
            self._header(lexer, words)
        elif lexer.text.lstrip().startswith(("#", "//")):
            self.comments.append(lexer.line)
        elif self.needs_header and not self.begun:
            self.needs_header = False
            lexer.refuse("this does not start with XYZIJK", _HEADER)
        else:
            self._point(lexer)

    def _header(self, lexer: Lexer, words: list[str]) -> None:
        if words[1:] not in ([], ["METRIC"]):
            lexer.refuse(f"{' '.join(words[1:])!r} stands after XYZIJK", _HEADER)
        self.units = "mm" if words[1:] else "in"
        self.begun = True

    def _point(self, lexer: Lexer) -> None:
        cells = cells_of(lexer, self.standing)
        name = cells[0].text if not is_number(cells[0]) else None
        if not self.begun and {cell.text.strip('"').upper() for cell in cells} <= _NAMES:
            self.begun = True
            return
        self.begun = True
        if name is not None and not _NAME.fullmatch(name):
            lexer.refuse(f"{name[:40]!r} is neither a number nor a name", _REMEDY)
        cells = cells if name is None else cells[1:]
        numbers = numbers_of(lexer, cells, self.standing)
        if not 3 <= len(numbers) <= 8 or len(numbers) == 4:
            what = "a circle with its diameter" if len(numbers) == 4 else f"{len(numbers)} numbers"
            lexer.refuse(f"{what} where a touch has 3 or 6", _REMEDY)
        if name is not None and len(numbers) not in (3, 6):
            lexer.refuse(f"a name and {len(numbers)} numbers", _REMEDY)
        self.standing.keep("how many numbers stand in a line", len(numbers), lexer, _REMEDY)
        if len(numbers) not in (3, 6):
            self._check(lexer, cells, numbers)
        normal = numbers[3:6] if len(numbers) in _WITH_NORMAL else (0.0, 0.0, 0.0)
        self.contacts.append(LogContact(lexer.line, vector(numbers[:3]), against(normal), id=name))

    def _check(self, lexer: Lexer, cells: tuple[Cell, ...], numbers: tuple[float, ...]) -> None:
        """Lines of 5, 7 and 8 numbers could be shorter ones with a decimal comma in them."""
        if len({"." in cell.text for cell in cells[:3]}) > 1:
            lexer.refuse(f"{len(numbers)} numbers, some with a decimal point and some without", _COMMA)
        if len(numbers) in _WITH_NORMAL and abs(float(np.linalg.norm(numbers[3:6])) - 1) > _MOST_OFF_UNIT:
            lexer.refuse("i, j, k have not the length 1", _REMEDY)
        if len(numbers) == 7 and numbers[-1] != 0:
            self.circles.append(lexer.line)

    def log(self) -> Log:
        notes = [
            f"line {line}: a circle with its diameter; its centre is taken for the contact" for line in self.circles
        ]
        return Log(tuple(self.contacts), self.units, (*notes, *passed_over(self.comments, "comments")))


def read_xyzijk(text: str, problems: list[Problem]) -> Log:
    """An XYZ file of PC-DMIS: XYZIJK above, inch unless METRIC."""
    reader = _Reader(needs_header=True)
    read_lines(text, problems, reader.line)
    return reader.log()


def read_xyz(text: str, problems: list[Problem]) -> Log:
    """Any XYZ file; the unit is only known where XYZIJK stands above."""
    reader = _Reader(needs_header=False)
    read_lines(text, problems, reader.line)
    return reader.log()
