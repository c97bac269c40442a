"""One pose in the literal of a robot's controller, read whole: KUKA, ABB, FANUC, Universal Robots.

Each reader passes one literal of a Lexer and gives its numbers; readers of pose files and of logs share them.
"""

import re
from typing import Final

from tactfix.lexer import Lexer

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
    """X 1,Y 2,Z 3,A 0,B 90,C 0 by name. loose: with = or : after the names too, and blanks alone between."""
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
