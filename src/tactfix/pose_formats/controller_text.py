"""Reads poses from controller files: the one pose literal among declarations, comments and program text.

Units and frames given in the file are used: inch words, an object frame within a user frame, a work object on the
robot. Work offsets of machine tools in G-code, LinuxCNC's G10 L2 and the tilted plane of G68.2, are read by block.
G20 and G21 apply from where they are written, anywhere in a block; comments are skipped. In G91 some controls add the
words to the previous offset and others do not: such an offset is rejected.
"""

import re
from typing import Final

import numpy as np

from tactfix.gcode import GCODE_COMMENT, Block, missing, read_block
from tactfix.geometry.arrays import Floats
from tactfix.lexer import Lexer, TextError, text_lines
from tactfix.pose_formats.literals import (
    ABB_EXAMPLE,
    KUKA_LABELS,
    abb_pose,
    fanuc_pose,
    group,
    kuka_position,
    single,
    the_one,
    ur_pose,
    without_comments,
)
from tactfix.pose_formats.orientation import Quaternion
from tactfix.pose_formats.pose import PoseSyntaxError, syntax_error

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
_SIEMENS: Final = re.compile(r"(?<![\w:])(?<!: )CTRANS\s*\(", re.IGNORECASE)
_SIEMENS_PART: Final = re.compile(r"(?<!\w)C(?:TRANS|FINE|ROTS?|RPL|SCALE|MIRROR)\s*\(", re.IGNORECASE)
_SIEMENS_HIDDEN: Final = re.compile(r";\s*:?\s*C(?:FINE|ROT)\s*\(", re.IGNORECASE)
_SIEMENS_EXAMPLE: Final = "$P_UIFR[1]=CTRANS(X,0.0,Y,0.0,Z,0.0):CROT(X,0.0,Y,0.0,Z,0.0)"
_SIEMENS_REMEDY: Final = f"write {_SIEMENS_EXAMPLE}"
_HEIDENHAIN_UNITS: Final = re.compile(r"BEGIN\s+PGM\s+\S+\s+(MM|INCH)\b", re.IGNORECASE)
_QUATERNION: Final = Quaternion(scalar_first=True)


def read_kuka(text: str) -> tuple[Floats, None]:
    """X, Y, Z, A, B, C (6,)."""
    numbers = the_one(
        without_comments(text, _KUKA_COMMENT), _KUKA, kuka_position, "{X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}"
    )
    return np.array([numbers[label] for label in KUKA_LABELS]), None


def read_abb(text: str) -> tuple[Floats, None]:
    """x, y, z, q1, q2, q3, q4 (7,) of a pose or robtarget."""
    content = without_comments(text, _ABB_COMMENT)
    return np.array(the_one(content, _ABB, abb_pose, "[[0.0,0.0,0.0],[1.0,0.0,0.0,0.0]]")[0]), None


def read_wobjdata(text: str) -> tuple[Floats, None]:
    """x, y, z, q1, q2, q3, q4 (7,) of the object frame: user frame times object frame within it."""
    example = '[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]]'
    return the_one(without_comments(text, _ABB_COMMENT), _WOBJDATA, _wobjdata, example), None


def _wobjdata(lexer: Lexer) -> Floats:
    """[robhold, ufprog, "ufmec", uframe, oframe]: rejected if a robot holds it or a unit moves it."""
    lexer.mark("[", ABB_EXAMPLE)
    if lexer.take("TRUE"):
        lexer.refuse("the robot holds this work object (robhold is TRUE)", "give one that is fixed in the cell")
    lexer.mark("FALSE", ABB_EXAMPLE)
    lexer.mark(",", ABB_EXAMPLE)
    if not lexer.take("TRUE"):
        lexer.refuse("a mechanical unit moves this user frame (ufprog is not TRUE)", "give one that does not move")
    lexer.mark(",", ABB_EXAMPLE)
    if lexer.quoted('"', ABB_EXAMPLE).strip():
        lexer.refuse("a mechanical unit moves this user frame", "give one that does not move")
    lexer.mark(",", ABB_EXAMPLE)
    frames = []
    for separator in (",", "]"):
        lexer.mark("[", ABB_EXAMPLE)
        point = group(lexer, 3)
        lexer.mark(",", ABB_EXAMPLE)
        frames.append((np.array(point), _QUATERNION.rotation(np.array(group(lexer, 4)))))
        lexer.mark("]", ABB_EXAMPLE)
        lexer.mark(separator, ABB_EXAMPLE)
    (user, user_turn), (inner, inner_turn) = frames
    return np.array([*(user + user_turn @ inner), *_QUATERNION.numbers(user_turn @ inner_turn)])


def read_fanuc(text: str) -> tuple[Floats, None]:
    """X, Y, Z, W, P, R (6,) of a position, register or frame, or six numbers on a line."""
    return np.array(the_one(text, _FANUC, fanuc_pose, "X = 0.0 mm, Y = 0.0 mm, Z = 0.0 mm, W = 0.0 deg, ...")), None


def read_ur(text: str) -> tuple[Floats, None]:
    """x, y, z, rx, ry, rz (6,)."""
    return np.array(the_one(without_comments(text, _UR_COMMENT), _UR, ur_pose, "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]")), None


def read_siemens(text: str) -> tuple[Floats, str | None]:
    """X, Y, Z, RX, RY, RZ (6,) of the one CTRANS(...):CFINE(...):CROT(...), and the unit; omitted axes are zero."""
    if any(_SIEMENS_HIDDEN.match(comment) for comment in _SIEMENS_COMMENT.findall(text)):
        raise syntax_error("contains a part of the frame in a comment", f"write one, like {_SIEMENS_EXAMPLE}")
    content = without_comments(text, _SIEMENS_COMMENT)
    numbers, parts = the_one(content, _SIEMENS, _siemens_frame, _SIEMENS_EXAMPLE)
    if len(_SIEMENS_PART.findall(content)) != parts:
        raise syntax_error("contains more than one frame", f"write one, like {_SIEMENS_EXAMPLE}")
    return numbers, siemens_units(_SIEMENS.split(content, maxsplit=1)[0])


def _siemens_frame(lexer: Lexer) -> tuple[Floats, int]:
    """The numbers (6,) of a frame, and the number of its chained parts."""
    axes_of_part: dict[str, Floats] = {}
    end = lexer.position
    while not axes_of_part or lexer.take(":"):
        part = lexer.name(_SIEMENS_REMEDY).upper()
        if part not in ("CTRANS", "CFINE", "CROT") or part in axes_of_part or "CROT" in axes_of_part:
            lexer.refuse(f"{part} does not follow here", "write CTRANS(...):CFINE(...):CROT(...), each once")
        axes_of_part[part] = _siemens_axes(lexer)
        end = lexer.position
    lexer.position = end
    rest = re.split(r"[\r\n]", lexer.rest, maxsplit=1)[0].strip()
    if rest:
        lexer.refuse(f"{rest[:20]!r} is left over", _SIEMENS_REMEDY)
    zeros = np.zeros(3)
    shift = axes_of_part["CTRANS"] + axes_of_part.get("CFINE", zeros)
    return np.concatenate([shift, axes_of_part.get("CROT", zeros)]), len(axes_of_part)


def _siemens_axes(lexer: Lexer) -> Floats:
    """(X,1.0,Z,3.0): numbers (3,) by axis."""
    values: dict[str, float] = {}
    lexer.mark("(", _SIEMENS_REMEDY)
    while True:
        axis = lexer.name(_SIEMENS_REMEDY).upper()
        if axis not in ("X", "Y", "Z") or axis in values:
            lexer.refuse(f"{axis} is not an axis, or is given twice", _SIEMENS_REMEDY)
        lexer.mark(",", _SIEMENS_REMEDY)
        values[axis] = lexer.number(_SIEMENS_REMEDY)
        if not lexer.take(","):
            break
    lexer.mark(")", _SIEMENS_REMEDY)
    return np.array([values.get(axis, 0.0) for axis in "XYZ"])


def siemens_units(text: str) -> str | None:
    """The unit of a text without comments: in after G70 or G700, mm after G71 or G710, None without either."""
    codes = _SIEMENS_UNITS.findall(text)
    return None if not codes else "in" if codes[-1] == "70" else "mm"


def heidenhain_units(text: str) -> str | None:
    """The unit in BEGIN PGM NAME MM or INCH, None without it."""
    match = _HEIDENHAIN_UNITS.search(text)
    return None if match is None else "in" if match.group(1).upper() == "INCH" else "mm"


_READ_BLOCK: Final = re.compile(r"G\s*0*(?:10|68\.2|20|21|70|71)(?![0-9])", re.IGNORECASE)
"""Blocks of a program that set offsets or units; all others are skipped, whatever their syntax."""

_DISTANCE_MODE: Final = re.compile(r"G\s*0*9([01])(?![0-9.])", re.IGNORECASE)
"""G90 (absolute) or G91 (incremental)."""


def read_g10(text: str) -> tuple[Floats, str]:
    """X, Y, Z, R (4,) of the one G10 L2 block, and the unit of its lengths."""
    words, units = _the_one(text, "G10", "G10 L2 P1 X0.0 Y0.0 Z0.0 R0.0", "GLPXYZR", "LXYZR")
    if words["L"] != 2:
        raise syntax_error(f"is G10 L{words['L']:g}, which sets something else", "give the offset as G10 L2")
    return np.array([words[letter] for letter in "XYZR"]), units


def read_tilted_plane(text: str) -> tuple[Floats, str]:
    """X, Y, Z, I, J, K (6,) of the one G68.2 block, and the unit of its lengths."""
    words, units = _the_one(text, "G68.2", "G68.2 X0.0 Y0.0 Z0.0 I0.0 J0.0 K0.0", "GPXYZIJK", "XYZIJK")
    if words.get("P", 0.0) != 0:
        raise syntax_error(f"is G68.2 P{words['P']:g}, which is not three Euler angles", "give it as G68.2 P0")
    return np.array([words[letter] for letter in "XYZIJK"]), units


def _the_one(text: str, name: str, example: str, known: str, needed: str) -> tuple[dict[str, float], str]:
    """The words of the one block with the code name, and the unit active there."""
    code, units, is_incremental, found = float(name[1:]), "mm", False, []
    for number, line in enumerate(text_lines(text), 1):
        content = GCODE_COMMENT.sub(" ", line)
        is_incremental = [is_incremental, *(digit == "1" for digit in _DISTANCE_MODE.findall(content))][-1]
        if not _READ_BLOCK.search(content):
            continue
        lexer = Lexer(line, number)
        try:
            block = read_block(lexer)
            units = _units(block, units)
            if code in block.codes("G") and is_incremental:
                lexer.refuse(f"{name} is in G91, where some controls add it to the old offset", "write it in G90")
            if code in block.codes("G"):
                found.append((_words(block, code, known, needed, lexer, f"write one, like {example}"), units))
        except TextError as error:
            raise PoseSyntaxError([error.problem]) from error
    return single(found, example)


_MODAL: Final = frozenset(("G", code) for code in (17.0, 20.0, 21.0, 90.0))
"""Codes also allowed after the offset code: plane, unit, absolute mode."""


def _units(block: Block, units: str) -> str:
    """The active unit after a block."""
    for code in block.codes("G"):
        units = {20.0: "in", 21.0: "mm", 70.0: "in", 71.0: "mm"}.get(code, units)
    return units


def _words(block: Block, code: float, known: str, needed: str, lexer: Lexer, remedy: str) -> dict[str, float]:
    """The words of the block from its code on; before it only N and G words are allowed."""
    codes = [i for i, word in enumerate(block.words) if word == ("G", code)]
    before = [letter for letter, _ in block.words[: codes[0]]]
    after = [(letter, number) for letter, number in block.words[codes[0] :] if (letter, number) not in _MODAL]
    if set(before) - {"N", "G"}:
        lexer.refuse(f"{''.join(before)} come before G{code:g}", remedy)
    words = Block(tuple(after)).only(known, lexer, remedy)
    absent = missing(words, needed)
    if absent:
        lexer.refuse(f"{', '.join(absent)} is missing", remedy)
    return words
