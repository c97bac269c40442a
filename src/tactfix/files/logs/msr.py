"""MSR results files of machine tools: G800 nominal point with outward normal, G801 measured centre of the tip.

START and END, names, time stamps and other text may surround the blocks; a block begins with G, or with N and G.
G330 is the work plane of the points, G331 the position of the model, G802 a deviation computed by the machine.
"""

import re
from dataclasses import dataclass, field
from typing import Final

from tactfix.errors import Problem
from tactfix.files.contact_options import Vector
from tactfix.files.logs.log import ConstantStates, Log, LogContact, against, read_lines, skipped, vector
from tactfix.gcode import missing, read_block
from tactfix.lexer import Lexer

_BLOCK: Final = re.compile(r"\s*(?:N\s*[0-9]+\s*)?G\s*([0-9][0-9.]*)", re.IGNORECASE)
_NUMBER_BEFORE: Final = re.compile(r"\s*N\s*[0-9]+(?=\s*G)", re.IGNORECASE)
_ROW_NUMBER: Final = re.compile(r"N\s*[0-9]", re.IGNORECASE)
_MEASURED_REMEDY: Final = "write G801 N1 X1.0 Y2.0 Z3.0 R3.0"
_NOMINAL_REMEDY: Final = "write G800 N1 X1.0 Y2.0 Z3.0 I0 J0 K1"
_PLANE: Final = "write G330 N1 A0 B0 C0 X0 Y0 Z0 I0 R0"
_MODEL: Final = "the model, X Y Z A B C of G331,"
_SHIFTED: Final = "give the points in coordinates that are not shifted: X, Y, Z, I and R of G330 are zero"


@dataclass(slots=True)
class _Reader:
    """State while reading: contacts, nominal normals by point name, lines of points not yet measured."""

    contacts: list[LogContact] = field(default_factory=list)
    normals: dict[str, Vector | None] = field(default_factory=dict)
    waiting: dict[str, int] = field(default_factory=dict)
    constant: ConstantStates = field(default_factory=ConstantStates)
    notes: list[str] = field(default_factory=list)
    other: list[int] = field(default_factory=list)

    def line(self, lexer: Lexer) -> None:
        block = _BLOCK.match(lexer.text)
        if block is None:
            if lexer.text.strip().upper() not in ("START", "END"):
                self.other.append(lexer.line)
            return
        match block.group(1).lstrip("0"):
            case "330":
                self._plane(lexer)
            case "331":
                words = _words(lexer, "GNABCXYZ", "", _PLANE)
                self.constant.keep(_MODEL, tuple(words.get(axis, 0.0) for axis in "XYZABC"), lexer)
            case "800":
                self._nominal(lexer)
            case "801":
                self._measured(lexer)
            case "802":
                self.other.append(lexer.line)
            case code:
                lexer.refuse(f"G{code} is no block of a results file", "write G330, G331, G800, G801 or G802")

    def _plane(self, lexer: Lexer) -> None:
        """G330: reject a change of work plane between points, which would not be in one frame."""
        words = _words(lexer, "GNABCXYZIR", "", _PLANE)
        if any(words.get(letter, 0.0) for letter in "XYZIR"):
            lexer.refuse("G330 shifts the points", _SHIFTED)
        self.constant.keep("A B C of G330", tuple(words.get(axis, 0.0) for axis in "ABC"), lexer)

    def _nominal(self, lexer: Lexer) -> None:
        """G800: record the normal of a point; its G801 follows."""
        words = _words(lexer, "GNXYZIJKOUL", "NIJK", _NOMINAL_REMEDY)
        name = f"N{words['N']:g}"
        self._unmeasured(name)
        self.normals[name] = against([words[axis] for axis in "IJK"])
        self.waiting[name] = lexer.line

    def _measured(self, lexer: Lexer) -> None:
        """G801: one contact, with the approach of its G800."""
        words = _words(lexer, "GNXYZR", "NXYZ", _MEASURED_REMEDY)
        name = f"N{words['N']:g}"
        approach = self.normals.pop(name, None)
        if self.waiting.pop(name, None) is None:
            self.notes.append(f"line {lexer.line}: point {name} has no G800 before it, and so no approach")
        point = vector([words[axis] for axis in "XYZ"])
        self.contacts.append(LogContact(lexer.line, point, approach, tip_radius=words.get("R"), id=name))

    def _unmeasured(self, name: str) -> None:
        line = self.waiting.pop(name, None)
        if line is not None:
            self.notes.append(f"line {line}: point {name} has no measurement; dropped")

    def log(self) -> Log:
        for name in list(self.waiting):
            self._unmeasured(name)
        notes = (*self.notes, *self.constant.notes("A B C of G330", _MODEL))
        return Log(tuple(self.contacts), notes=(*notes, *skipped(self.other, "lines of text")))


def _words(lexer: Lexer, known: str, needed: str, remedy: str) -> dict[str, float]:
    """The words of the block; a line number before it (N5 G801 N1 ...) is skipped."""
    number = _NUMBER_BEFORE.match(lexer.text)
    if number and _ROW_NUMBER.search(lexer.text, number.end()):
        lexer.position = number.end()
    words = read_block(lexer, comments=False).only(known, lexer, remedy)
    absent = missing(words, needed)
    if absent:
        lexer.refuse(f"G{words['G']:g} without {', '.join(absent)}", remedy)
    return words


def read_msr(text: str, problems: list[Problem]) -> Log:
    """The measured points of a results file, in the active work coordinates."""
    reader = _Reader()
    read_lines(text, problems, reader.line)
    return reader.log()
