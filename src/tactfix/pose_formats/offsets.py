"""Work offsets of machine tools in G-code: LinuxCNC's G10 L2 and the tilted plane of G68.2, read as blocks.

G20 and G21 hold from where they stand, wherever in a block that is; comments say nothing. In G91 some controls add the
words to the offset that was, others do not: such an offset is refused.
"""

import re
from typing import Final

import numpy as np

from tactfix.gcode import GCODE_COMMENT, Block, missing, read_block
from tactfix.geometry.arrays import Floats
from tactfix.lexer import Lexer, TextError, text_lines
from tactfix.pose_formats.pose import PoseSyntaxError, syntax_error

_SPEAKS: Final = re.compile(r"G\s*0*(?:10|68\.2|20|21|70|71)(?![0-9])", re.IGNORECASE)
"""Blocks of a program that are read: the others say nothing of offsets and units, and may hold any syntax."""

_DISTANCES: Final = re.compile(r"G\s*0*9([01])(?![0-9.])", re.IGNORECASE)
"""G90, words are places, or G91, words are steps."""


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
    """The words of the one block with the code name, and the unit that holds there."""
    code, units, steps, found = float(name[1:]), "mm", False, []
    for number, line in enumerate(text_lines(text), 1):
        spoken = GCODE_COMMENT.sub(" ", line)
        steps = [steps, *(said == "1" for said in _DISTANCES.findall(spoken))][-1]
        if not _SPEAKS.search(spoken):
            continue
        lexer = Lexer(line, number)
        try:
            block = read_block(lexer)
            units = _units(block, units)
            if code in block.codes("G") and steps:
                lexer.refuse(f"{name} stands in G91, where some controls add it to the old offset", "write it in G90")
            if code in block.codes("G"):
                found.append((_words(block, code, known, needed, lexer, f"write one, like {example}"), units))
        except TextError as error:
            raise PoseSyntaxError([error.problem]) from error
    if len(found) != 1:
        what = f"holds {len(found)} poses of this form" if found else "holds no pose of this form"
        raise syntax_error(what, f"write one, like {example}")
    return found[0]


_MODAL: Final = frozenset(("G", code) for code in (17.0, 20.0, 21.0, 90.0))
"""What may stand after the code too: the plane, the unit, absolute words."""


def _units(block: Block, units: str) -> str:
    """The unit after a block."""
    for code in block.codes("G"):
        units = {20.0: "in", 21.0: "mm", 70.0: "in", 71.0: "mm"}.get(code, units)
    return units


def _words(block: Block, code: float, known: str, needed: str, lexer: Lexer, remedy: str) -> dict[str, float]:
    """The words of the block from its code on; before it the line number and other G words may be any."""
    codes = [i for i, word in enumerate(block.words) if word == ("G", code)]
    before = [letter for letter, _ in block.words[: codes[0]]]
    after = [(letter, number) for letter, number in block.words[codes[0] :] if (letter, number) not in _MODAL]
    if set(before) - {"N", "G"}:
        lexer.refuse(f"{''.join(before)} stand before G{code:g}", remedy)
    said = Block(tuple(after)).only(known, lexer, remedy)
    lacking = missing(said, needed)
    if lacking:
        lexer.refuse(f"{', '.join(lacking)} is missing", remedy)
    return said
