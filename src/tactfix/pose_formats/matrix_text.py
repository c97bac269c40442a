"""Reads a 4 x 4 or 3 x 4 matrix in common notations: rows, one line, brackets of numpy, Python and MATLAB."""

import re
from typing import Final

from tactfix.lexer import Lexer, TextError
from tactfix.pose_formats.pose import PoseSyntaxError, syntax_error
from tactfix.settings import Setting

_MATRIX_REMEDY: Final = "write the 4 x 4 matrix, or name the format with " + Setting.DIALECT.word
_ARRAY_OPENS: Final = re.compile(r"\s*(?:[A-Za-z_]\w*\s*=\s*)?(?:(?:np\.|numpy\.)?(?:array|matrix)\s*\()?", re.ASCII)
_AFTER: Final = re.compile(r"\s*(?:,\s*dtype\s*=\s*[\w.]+\s*)?\)?\s*;?", re.ASCII)
_SPACES: Final = re.compile(r"[ \t]+")
_NEW_LINE: Final = re.compile(r"[\r\n]+")
_NUMBER_BEGINS: Final = re.compile(r"[-+.0-9]")
_LAST: Final = [0.0, 0.0, 0.0, 1.0]


def read_matrix(text: str, first_line: int = 1) -> list[list[float]]:
    """The rows (4 x 4) of a text; the last one is added if it has only three."""
    lexer = Lexer(text, first_line)
    lexer.match(_ARRAY_OPENS)
    try:
        rows = _rows(lexer)
        lexer.match(_AFTER)
        lexer.end(_MATRIX_REMEDY)
    except TextError as error:
        raise PoseSyntaxError([error.problem]) from error
    if len(rows) == 1 and len(rows[0]) in (12, 16):
        rows = [rows[0][i : i + 4] for i in range(0, len(rows[0]), 4)]
    if [len(row) for row in rows] == [4, 4, 4]:
        rows = [*rows, _LAST]
    if [len(row) for row in rows] != [4, 4, 4, 4]:
        raise syntax_error("is not four rows of four numbers", _MATRIX_REMEDY)
    return rows


def _rows(lexer: Lexer) -> list[list[float]]:
    """Numbers separated by blanks or commas; a row ends at ;, a bracket, or a line end outside a bracketed row."""
    rows: list[list[float]] = [[]]
    depth, apart = 0, True
    while True:
        if lexer.match(_SPACES):
            apart = True
        elif lexer.match(_NEW_LINE):
            apart, ends = True, depth < 2
            rows += [[]] if ends else []
        elif lexer.rest[:1] == "," and not (apart and not rows[-1] and depth == 0):
            lexer.position += 1
            apart = True
        elif lexer.rest[:1] in ("[", "]", ";") and (depth or lexer.rest[0] != "]"):
            depth += {"[": 1, "]": -1, ";": 0}[lexer.rest[0]]
            lexer.position += 1
            apart = True
            rows.append([])
        elif apart and _NUMBER_BEGINS.match(lexer.rest):
            rows[-1].append(lexer.number(_MATRIX_REMEDY))
            apart = False
        else:
            break
    if depth:
        lexer.refuse("a bracket is left open", _MATRIX_REMEDY)
    return [row for row in rows if row]
