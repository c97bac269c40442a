"""I++ DME answers (version 1.4.3): tag, #, and the properties that OnPtMeasReport selects, in millimetres.

X() Y() Z() are the tip's centre, IJK() the outward normal, ER() the effective radius of the tip, Q() the quality (0
is good), R() the rotary table and Tool.A() Tool.B() Tool.C() the head, in degrees. Some servers write PtMeas(...)
around an answer. & and % acknowledge a command, ! is an error, and a tag that begins with E belongs to an event.
"""

import re
from dataclasses import dataclass, field
from typing import Final

from tactfix.errors import Problem
from tactfix.files.logs.console import read_opening
from tactfix.files.logs.log import ConstantStates, Log, LogContact, against, read_lines, skipped, vector
from tactfix.lexer import Lexer

_TAG: Final = re.compile(r"(?:[0-9]{5}|E[0-9]{4})(?![0-9A-Za-z])")
_COORDINATE_OPENS: Final = re.compile(r"(?<![A-Za-z0-9_.])[XYZ]\s*\(", re.IGNORECASE)
_COMMAND: Final = re.compile(r"\s*([A-Za-z]\w*)\s*\(")
_IPPDME_REMEDY: Final = "write 00001 # X(1.0), Y(2.0), Z(3.0), IJK(0, 0, 1), ER(1.0)"
_WIDTHS: Final = {"X": 1, "Y": 1, "Z": 1, "IJK": 3, "IJKACT": 3, "R": 1, "Q": 1, "ER": 1}
_HEAD_ANGLES: Final = ("TOOL.A", "TOOL.B", "TOOL.C")
_COORDINATE_SYSTEM: Final = "the coordinate system"
_TOOL: Final = "the tool"
_CONSTANT: Final = {"R": "the rotary table, R()", **{name: f"the head, Tool.{name[-1]}()," for name in _HEAD_ANGLES}}


@dataclass(slots=True)
class _Reader:
    contacts: list[LogContact] = field(default_factory=list)
    constant: ConstantStates = field(default_factory=ConstantStates)
    commands: dict[str, str] = field(default_factory=dict)
    now: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    talk: list[int] = field(default_factory=list)

    def line(self, lexer: Lexer) -> None:
        begin = lexer.position
        tag = lexer.blanks().match(_TAG)
        if tag is None:
            lexer.position = begin
            read_opening(lexer)
            tag = lexer.blanks().match(_TAG)
        if tag is None:
            if _COORDINATE_OPENS.search(lexer.text) and "#" in lexer.text:
                lexer.refuse("this answer has no tag of five digits", _IPPDME_REMEDY)
            self.talk.append(lexer.line)
        elif lexer.take("!"):
            self.notes.append(f"line {lexer.line}: the machine reports an error instead of a contact; dropped")
        elif lexer.take("#"):
            self._answer(lexer, tag.group())
        elif lexer.take("&") or lexer.take("%"):
            lexer.end("write nothing after & and %")
            self.talk.append(lexer.line)
        else:
            self._command(lexer, tag.group())

    def _command(self, lexer: Lexer, tag: str) -> None:
        """A command of the client; frame and tool are recorded for the contacts that follow."""
        command = _COMMAND.match(lexer.rest)
        if command is None:
            lexer.refuse("this is neither a command nor an answer", _IPPDME_REMEDY)
        name = command.group(1).upper()
        self.commands[tag] = name
        self.talk.append(lexer.line)
        if name in ("SETCOORDSYSTEM", "SETCSYTRANSFORMATION"):
            self.now[_COORDINATE_SYSTEM] = lexer.rest.strip()
        elif name in ("CHANGETOOL", "SETTOOL", "ALIGNTOOL"):
            self.now[_TOOL] = lexer.rest.strip()

    def _answer(self, lexer: Lexer, tag: str) -> None:
        """A contact, if the answer holds a coordinate and its command was a measurement."""
        command = self.commands.get(tag, "PTMEAS")
        if not _COORDINATE_OPENS.search(lexer.rest) or tag.startswith("E") or command.startswith("GET"):
            self.talk.append(lexer.line)
            return
        wrapped = lexer.take("PtMeas")
        if wrapped:
            lexer.mark("(", _IPPDME_REMEDY)
        properties = _properties(lexer)
        if wrapped:
            lexer.mark(")", _IPPDME_REMEDY)
        lexer.end(_IPPDME_REMEDY)
        self._contact(lexer, tag, properties, wrapped)

    def _contact(self, lexer: Lexer, tag: str, properties: dict[str, tuple[float, ...]], wrapped: bool) -> None:
        absent = [f"{axis}()" for axis in "XYZ" if axis not in properties]
        if absent:
            lexer.refuse(f"the answer lacks {', '.join(absent)}", "ask for X(), Y(), Z() with OnPtMeasReport")
        if properties.get("Q", (0.0,))[0] != 0:
            self.notes.append(f"line {lexer.line}: the machine reports bad quality, Q({properties['Q'][0]:g}); dropped")
            return
        radius = properties.get("ER")
        if wrapped and radius is None and not any(name in properties for name in _HEAD_ANGLES) and "R" in properties:
            radius = properties.pop("R")
            self.notes.append(f"line {lexer.line}: {_RADIUS}") if not self.contacts else None
        for name, state in _CONSTANT.items():
            if name in properties:
                self.constant.keep(state, properties[name], lexer)
        for state, value in self.now.items():
            self.constant.keep(state, value, lexer)
        point = vector([properties[axis][0] for axis in "XYZ"])
        tip_radius = None if radius is None else radius[0]
        normal = properties.get("IJKACT", properties.get("IJK", (0.0, 0.0, 0.0)))
        self.contacts.append(LogContact(lexer.line, point, against(normal), tip_radius=tip_radius, id=tag))

    def log(self) -> Log:
        notes = (*self.notes, *self.constant.notes(*_CONSTANT.values()))
        return Log(tuple(self.contacts), "mm", (*notes, *skipped(self.talk, "lines that are no measurements")))


_RADIUS: Final = (
    "R() without ER(), inside PtMeas(...), is taken as the radius of the tip, as in files that were not written by "
    "the standard, where R() is the rotary table; a tip radius that is given takes precedence"
)


def _properties(lexer: Lexer) -> dict[str, tuple[float, ...]]:
    """NAME(number, ...) by name in upper case, separated by commas."""
    properties: dict[str, tuple[float, ...]] = {}
    while True:
        name = lexer.name(_IPPDME_REMEDY).upper()
        if lexer.text.startswith(".", lexer.position):
            lexer.take(".")
            name += "." + lexer.name(_IPPDME_REMEDY).upper()
        if name not in _WIDTHS and name not in _HEAD_ANGLES:
            lexer.refuse(f"{name}() is not known in a measurement", _IPPDME_REMEDY)
        if name in properties:
            lexer.refuse(f"{name}() is given twice", _IPPDME_REMEDY)
        lexer.mark("(", _IPPDME_REMEDY)
        properties[name] = lexer.numbers(_WIDTHS.get(name, 1), _IPPDME_REMEDY)
        lexer.mark(")", _IPPDME_REMEDY)
        if not lexer.take(","):
            return properties


def read_ippdme(text: str, problems: list[Problem]) -> Log:
    """The measurements in a dialogue, or in its answers alone."""
    reader = _Reader()
    read_lines(text, problems, reader.line)
    return reader.log()
