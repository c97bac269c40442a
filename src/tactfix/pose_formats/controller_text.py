"""Poses out of the files of controllers: the one literal among declarations, comments and program text.

What such a file says of units and frames is used: inch words, an object frame within a user frame, a work object on
the robot.
"""

import re
from typing import Final

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.lexer import Lexer
from tactfix.pose_formats.literals import ABB, KUKA_LABELS, abb_pose, fanuc_pose, group, kuka_position, ur_pose
from tactfix.pose_formats.one_pose import the_one, without_comments
from tactfix.pose_formats.orientation import Quaternion

_KUKA_COMMENT: Final = re.compile(r";[^\r\n]*")
_KUKA: Final = re.compile(r"\{\s*(?:(?:E6POS|POS|FRAME)\s*:\s*)?[XYZABC]\s+[-+.0-9]", re.IGNORECASE)
_ABB_COMMENT: Final = re.compile(r"![^\r\n]*")
_ABB: Final = re.compile(r"\[\s*\[")
_WOBJDATA: Final = re.compile(r"\[\s*(?:TRUE|FALSE)\s*,", re.IGNORECASE)
_FANUC: Final = re.compile(r"(?<![A-Za-z0-9_])X\s*[=:]", re.IGNORECASE)
_UR: Final = re.compile(r"(?<![A-Za-z0-9_])p\s*\[")
_UR_COMMENT: Final = re.compile(r"#[^\r\n]*")
_SIEMENS_UNITS: Final = re.compile(r"(?<![A-Za-z_$])G\s*(70|71)0?(?![0-9.])", re.IGNORECASE)
_SIEMENS_COMMENT: Final = re.compile(r";[^\r\n]*")
_HEIDENHAIN_UNITS: Final = re.compile(r"BEGIN\s+PGM\s+\S+\s+(MM|INCH)\b", re.IGNORECASE)
_QUATERNION: Final = Quaternion(scalar_first=True)


def read_kuka(text: str) -> tuple[Floats, None]:
    """X, Y, Z, A, B, C (6,)."""
    said = the_one(without_comments(text, _KUKA_COMMENT), _KUKA, kuka_position, "{X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}")
    return np.array([said[label] for label in KUKA_LABELS]), None


def read_abb(text: str) -> tuple[Floats, None]:
    """x, y, z, q1, q2, q3, q4 (7,) of a pose or a robtarget."""
    spoken = without_comments(text, _ABB_COMMENT)
    return np.array(the_one(spoken, _ABB, abb_pose, "[[0.0,0.0,0.0],[1.0,0.0,0.0,0.0]]")[0]), None


def read_wobjdata(text: str) -> tuple[Floats, None]:
    """x, y, z, q1, q2, q3, q4 (7,) of the object frame: user frame times object frame within it."""
    example = '[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]]'
    return the_one(without_comments(text, _ABB_COMMENT), _WOBJDATA, _wobjdata, example), None


def _wobjdata(lexer: Lexer) -> Floats:
    """[robhold, ufprog, "ufmec", uframe, oframe]: held by no robot and moved by no unit."""
    lexer.mark("[", ABB)
    if lexer.take("TRUE"):
        lexer.refuse("the robot holds this work object (robhold is TRUE)", "give one that stands in the cell")
    lexer.mark("FALSE", ABB)
    lexer.mark(",", ABB)
    if not lexer.take("TRUE"):
        lexer.refuse("a mechanical unit moves this user frame (ufprog is not TRUE)", "give one that stands still")
    lexer.mark(",", ABB)
    if lexer.quoted('"', ABB).strip():
        lexer.refuse("a mechanical unit moves this user frame", "give one that stands still")
    lexer.mark(",", ABB)
    frames = []
    for separator in (",", "]"):
        lexer.mark("[", ABB)
        point = group(lexer, 3)
        lexer.mark(",", ABB)
        frames.append((np.array(point), _QUATERNION.rotation(np.array(group(lexer, 4)))))
        lexer.mark("]", ABB)
        lexer.mark(separator, ABB)
    (user, user_turn), (inner, inner_turn) = frames
    return np.array([*(user + user_turn @ inner), *_QUATERNION.numbers(user_turn @ inner_turn)])


def read_fanuc(text: str) -> tuple[Floats, None]:
    """X, Y, Z, W, P, R (6,) of a position, register or frame, or six numbers on a line."""
    return np.array(the_one(text, _FANUC, fanuc_pose, "X = 0.0 mm, Y = 0.0 mm, Z = 0.0 mm, W = 0.0 deg, ...")), None


def read_ur(text: str) -> tuple[Floats, None]:
    """x, y, z, rx, ry, rz (6,)."""
    return np.array(the_one(without_comments(text, _UR_COMMENT), _UR, ur_pose, "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]")), None


def siemens_units(text: str) -> str | None:
    """in after G70 or G700, mm after G71 or G710; None where neither stands outside a comment."""
    said = _SIEMENS_UNITS.findall(without_comments(text, _SIEMENS_COMMENT))
    return None if not said else "in" if said[-1] == "70" else "mm"


def heidenhain_units(text: str) -> str | None:
    """What BEGIN PGM NAME MM or INCH says."""
    said = _HEIDENHAIN_UNITS.search(text)
    return None if said is None else "in" if said.group(1).upper() == "INCH" else "mm"
