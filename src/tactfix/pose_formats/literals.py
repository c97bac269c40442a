"""One pose in a text, wherever it stands: found by how it begins, then read whole.

The literals of KUKA, ABB, FANUC and Universal Robots: each reader passes one of them and gives its numbers; readers of
pose files and of logs share them.
"""

import re
from collections.abc import Callable, Sequence
from typing import Final, TypeVar

from tactfix.lexer import Lexer, TextError
from tactfix.pose_formats.pose import PoseSyntaxError, syntax_error

Found = TypeVar("Found")

_BLANKED: Final = re.compile(r"[^\r\n]")


def without_comments(text: str, comment: re.Pattern[str]) -> str:
    """The text with blanks for its comments: each character that is left keeps its line and column."""
    return comment.sub(lambda found: _BLANKED.sub(" ", found.group()), text)


def the_one(text: str, begins: re.Pattern[str], read: Callable[[Lexer], Found], example: str) -> Found:
    """What read gives at the one place that begins finds; PoseSyntaxError for none, two, or a damaged one."""
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
    """What was found where it is one; PoseSyntaxError for none or several."""
    if len(found) != 1:
        what = f"holds {len(found)} poses of this form" if found else "holds no pose of this form"
        raise syntax_error(what, f"write one, like {example}")
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
"""ABB writes 9E9 for an axis that is not there."""


def kuka_position(lexer: Lexer) -> dict[str, float]:
    """{X 1,Y 2,Z 3,A 0,B 90,C 0}, with S, T and E1 to E6 or without, by name; S and T are read and say nothing."""
    lexer.mark("{", KUKA_EXAMPLE)
    lexer.match(_KUKA_TYPE)
    said = kuka_items(lexer)
    lexer.mark("}", KUKA_EXAMPLE)
    return said


def kuka_items(lexer: Lexer, *, loose: bool = False) -> dict[str, float]:
    """X 1,Y 2,Z 3,A 0,B 90,C 0 by name. loose: names may be followed by = or :, and blanks alone may separate."""
    said: dict[str, float] = {}
    while True:
        name = lexer.name(KUKA_EXAMPLE).upper()
        if name not in (*KUKA_LABELS, *KUKA_AXES, "S", "T"):
            lexer.refuse(f"{name} is not known in a position", KUKA_EXAMPLE)
        if name in said:
            lexer.refuse(f"{name} stands twice", KUKA_EXAMPLE)
        if loose and not lexer.take("="):
            lexer.take(":")
        bits = name in ("S", "T") and lexer.match(_KUKA_BITS)
        said[name] = 0.0 if bits else lexer.integer(KUKA_EXAMPLE) if name in ("S", "T") else lexer.number(KUKA_EXAMPLE)
        if not lexer.take(",") and not (loose and lexer.blanks().rest[:1].isalpha()):
            break
    lacking = [label for label in KUKA_LABELS if label not in said]
    if lacking:
        lexer.refuse(f"the position lacks {', '.join(lacking)}", KUKA_EXAMPLE)
    return said


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
    """[1,2,...] of so many numbers."""
    lexer.mark("[", ABB_EXAMPLE)
    numbers = lexer.numbers(count, ABB_EXAMPLE)
    lexer.mark("]", ABB_EXAMPLE)
    return numbers


def fanuc_pose(lexer: Lexer) -> tuple[float, ...]:
    """X, Y, Z, W, P, R in this order, each with = or : and mm or deg or no unit; commas between or none."""
    said = []
    for label in FANUC_LABELS:
        lexer.mark(label, FANUC_EXAMPLE)
        said.append(fanuc_item(lexer, "mm" if label in "XYZ" else "deg"))
        lexer.take(",")
    return tuple(said)


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
