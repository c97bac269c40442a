"""Finds the one pose literal in a text by its beginning, and reads it.

Each reader of the literals of KUKA, ABB, FANUC and Universal Robots consumes one literal and returns its numbers; pose
files and logs share them.
"""

import re
from collections.abc import Callable, Sequence
from typing import Final, TypeVar

from tactfix.lexer import Lexer, TextError
from tactfix.pose_formats.pose import PoseSyntaxError, syntax_error

Found = TypeVar("Found")

_BLANKED: Final = re.compile(r"[^\r\n]")


def without_comments(text: str, comment: re.Pattern[str]) -> str:
    """The text with comments replaced by blanks, so that lines and columns are kept."""
    return comment.sub(lambda found: _BLANKED.sub(" ", found.group()), text)


def the_one(text: str, begins: re.Pattern[str], read: Callable[[Lexer], Found], example: str) -> Found:
    """The result of read at the only match of begins; PoseSyntaxError for no match, several, or malformed text."""
    lexer = Lexer(text)
    found: list[Found] = []
    while (beginning := begins.search(text, lexer.position)) is not None:
        lexer.position = beginning.start()
        try:
            found.append(read(lexer))
        except TextError as error:
            raise PoseSyntaxError([error.problem]) from error
    return single(found, example)


def single(found: Sequence[Found], example: str) -> Found:
    """The only element of found; PoseSyntaxError for none or several."""
    if len(found) != 1:
        message = f"contains {len(found)} poses of this form" if found else "contains no pose of this form"
        raise syntax_error(message, f"write one, like {example}")
    return found[0]


KUKA_LABELS: Final = ("X", "Y", "Z", "A", "B", "C")
KUKA_AXES: Final = ("E1", "E2", "E3", "E4", "E5", "E6")
FANUC_LABELS: Final = ("X", "Y", "Z", "W", "P", "R")
KUKA_EXAMPLE: Final = "write {X 1.0,Y 2.0,Z 3.0,A 0.0,B 90.0,C 0.0}"
ABB_EXAMPLE: Final = "write [[x,y,z],[q1,q2,q3,q4]], for a robtarget with configuration and external axes"
FANUC_EXAMPLE: Final = "write X = 1.0 mm, Y = 2.0 mm, Z = 3.0 mm, W = 0.0 deg, P = 0.0 deg, R = 0.0 deg"
UR_EXAMPLE: Final = "write p[x, y, z, rx, ry, rz]"

_KUKA_TYPE: Final = re.compile(r"\s*(?:E6POS|POS|FRAME)\s*:", re.IGNORECASE)
_KUKA_BITS: Final = re.compile(r"\s*'(?:B[01]{1,32}|H[0-9A-F]{1,8})'", re.IGNORECASE)
_ABB_ABSENT: Final = 9e9
"""ABB writes 9E9 for an absent axis."""


def kuka_position(lexer: Lexer) -> dict[str, float]:
    """{X 1,Y 2,Z 3,A 0,B 90,C 0}, with optional S, T and E1 to E6, by name; S and T do not affect the pose."""
    lexer.mark("{", KUKA_EXAMPLE)
    lexer.match(_KUKA_TYPE)
    numbers = kuka_items(lexer)
    lexer.mark("}", KUKA_EXAMPLE)
    return numbers


def kuka_items(lexer: Lexer, *, loose: bool = False) -> dict[str, float]:
    """X 1,Y 2,Z 3,A 0,B 90,C 0 by name. loose: names may be followed by = or :, and blanks alone may separate."""
    numbers: dict[str, float] = {}
    while True:
        name = lexer.name(KUKA_EXAMPLE).upper()
        if name not in (*KUKA_LABELS, *KUKA_AXES, "S", "T"):
            lexer.refuse(f"{name} is not known in a position", KUKA_EXAMPLE)
        if name in numbers:
            lexer.refuse(f"{name} is given twice", KUKA_EXAMPLE)
        if loose and not lexer.take("="):
            lexer.take(":")
        bits = name in ("S", "T") and lexer.match(_KUKA_BITS)
        numbers[name] = (
            0.0 if bits else lexer.integer(KUKA_EXAMPLE) if name in ("S", "T") else lexer.number(KUKA_EXAMPLE)
        )
        if not lexer.take(",") and not (loose and lexer.blanks().rest[:1].isalpha()):
            break
    absent = [label for label in KUKA_LABELS if label not in numbers]
    if absent:
        lexer.refuse(f"the position lacks {', '.join(absent)}", KUKA_EXAMPLE)
    return numbers


def abb_pose(lexer: Lexer) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """[[x,y,z],[q1,q2,q3,q4]] or a robtarget: its numbers (7,), and its external axes, 0 for an absent one."""
    lexer.mark("[", ABB_EXAMPLE)
    values = group(lexer, 3)
    lexer.mark(",", ABB_EXAMPLE)
    values += group(lexer, 4)
    axes: tuple[float, ...] = ()
    if lexer.take(","):
        if any(number != int(number) for number in group(lexer, 4)):
            lexer.refuse("the configuration is not four whole numbers", ABB_EXAMPLE)
        lexer.mark(",", ABB_EXAMPLE)
        axes = tuple(0.0 if abs(axis) >= _ABB_ABSENT else axis for axis in group(lexer, 6))
    lexer.mark("]", ABB_EXAMPLE)
    return values, axes


def group(lexer: Lexer, count: int) -> tuple[float, ...]:
    """[1,2,...] with count numbers."""
    lexer.mark("[", ABB_EXAMPLE)
    numbers = lexer.numbers(count, ABB_EXAMPLE)
    lexer.mark("]", ABB_EXAMPLE)
    return numbers


def fanuc_pose(lexer: Lexer) -> tuple[float, ...]:
    """X, Y, Z, W, P, R in this order, each after = or :, with optional unit mm or deg, and optional commas."""
    numbers = []
    for label in FANUC_LABELS:
        lexer.mark(label, FANUC_EXAMPLE)
        numbers.append(fanuc_item(lexer, "mm" if label in "XYZ" else "deg"))
        lexer.take(",")
    return tuple(numbers)


def fanuc_item(lexer: Lexer, *units: str) -> float:
    """= 1.0 mm."""
    if not lexer.take(":"):
        lexer.mark("=", FANUC_EXAMPLE)
    number = lexer.number(FANUC_EXAMPLE)
    any(lexer.take(unit) for unit in units)
    return number


def ur_pose(lexer: Lexer) -> tuple[float, ...]:
    """p[x, y, z, rx, ry, rz]."""
    lexer.mark("p", UR_EXAMPLE)
    lexer.mark("[", UR_EXAMPLE)
    numbers = lexer.numbers(6, UR_EXAMPLE)
    lexer.mark("]", UR_EXAMPLE)
    return numbers
