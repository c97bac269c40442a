"""One pose in the literal of a robot's controller, read whole: KUKA, ABB, FANUC, Universal Robots.

Each reader passes one literal of a Lexer and gives its numbers; readers of pose files and of logs share them.
"""

import re
from typing import Final

from tactfix.lexer import Lexer

KUKA_LABELS: Final = ("X", "Y", "Z", "A", "B", "C")
KUKA_AXES: Final = ("E1", "E2", "E3", "E4", "E5", "E6")
FANUC_LABELS: Final = ("X", "Y", "Z", "W", "P", "R")
KUKA: Final = "write {X 1.0,Y 2.0,Z 3.0,A 0.0,B 90.0,C 0.0}"
ABB: Final = "write [[x,y,z],[q1,q2,q3,q4]], for a robtarget with configuration and external axes"
FANUC: Final = "write X = 1.0 mm, Y = 2.0 mm, Z = 3.0 mm, W = 0.0 deg, P = 0.0 deg, R = 0.0 deg"
UR: Final = "write p[x, y, z, rx, ry, rz]"

_KUKA_TYPE: Final = re.compile(r"\s*(?:E6POS|POS|FRAME)\s*:", re.IGNORECASE)
_KUKA_BITS: Final = re.compile(r"\s*'(?:B[01]{1,32}|H[0-9A-F]{1,8})'", re.IGNORECASE)
_ABB_ABSENT: Final = 9e9
"""ABB writes 9E9 for an axis that is not there."""


def kuka_position(lexer: Lexer) -> dict[str, float]:
    """{X 1,Y 2,Z 3,A 0,B 90,C 0}, with S, T and E1 to E6 or without, by name; S and T are read and say nothing."""
    lexer.mark("{", KUKA)
    lexer.match(_KUKA_TYPE)
    said = kuka_items(lexer)
    lexer.mark("}", KUKA)
    return said


def kuka_items(lexer: Lexer, *, loose: bool = False) -> dict[str, float]:
    """X 1,Y 2,Z 3,A 0,B 90,C 0 by name. loose: with = or : after the names too, and blanks alone between."""
    said: dict[str, float] = {}
    while True:
        name = lexer.name(KUKA).upper()
        if name not in (*KUKA_LABELS, *KUKA_AXES, "S", "T"):
            lexer.refuse(f"{name} is not known in a position", KUKA)
        if name in said:
            lexer.refuse(f"{name} stands twice", KUKA)
        if loose and not lexer.take("="):
            lexer.take(":")
        bits = name in ("S", "T") and lexer.match(_KUKA_BITS)
        said[name] = 0.0 if bits else lexer.integer(KUKA) if name in ("S", "T") else lexer.number(KUKA)
        if not lexer.take(",") and not (loose and lexer.blanks().rest[:1].isalpha()):
            break
    lacking = [label for label in KUKA_LABELS if label not in said]
    if lacking:
        lexer.refuse(f"the position lacks {', '.join(lacking)}", KUKA)
    return said


def abb_pose(lexer: Lexer) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """[[x,y,z],[q1,q2,q3,q4]] or a robtarget: its numbers (7,), and its external axes, 0 for an absent one."""
    lexer.mark("[", ABB)
    values = group(lexer, 3)
    lexer.mark(",", ABB)
    values += group(lexer, 4)
    axes: tuple[float, ...] = ()
    if lexer.take(","):
        if any(number != int(number) for number in group(lexer, 4)):
            lexer.refuse("the configuration is not four whole numbers", ABB)
        lexer.mark(",", ABB)
        axes = tuple(0.0 if abs(axis) >= _ABB_ABSENT else axis for axis in group(lexer, 6))
    lexer.mark("]", ABB)
    return values, axes


def group(lexer: Lexer, count: int) -> tuple[float, ...]:
    """[1,2,...] of so many numbers."""
    lexer.mark("[", ABB)
    numbers = lexer.numbers(count, ABB)
    lexer.mark("]", ABB)
    return numbers


def fanuc_pose(lexer: Lexer) -> tuple[float, ...]:
    """X, Y, Z, W, P, R in this order, each with = or : and mm or deg or no unit; commas between or none."""
    said = []
    for label in FANUC_LABELS:
        lexer.mark(label, FANUC)
        said.append(fanuc_item(lexer, "mm" if label in "XYZ" else "deg"))
        lexer.take(",")
    return tuple(said)


def fanuc_item(lexer: Lexer, *units: str) -> float:
    """= 1.0 mm."""
    if not lexer.take(":"):
        lexer.mark("=", FANUC)
    number = lexer.number(FANUC)
    any(lexer.take(unit) for unit in units)
    return number


def ur_pose(lexer: Lexer) -> tuple[float, ...]:
    """p[x, y, z, rx, ry, rz]."""
    lexer.mark("p", UR)
    lexer.mark("[", UR)
    numbers = lexer.numbers(6, UR)
    lexer.mark("]", UR)
    return numbers
