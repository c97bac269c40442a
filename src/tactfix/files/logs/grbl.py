"""Consoles of grbl and its relatives: [PRB:x,y,z:1] for a hit, in machine coordinates; [PRB:...:0] for a miss.

TinyG and g2core report in JSON: {"prb":{"e":1,"x":..,"y":..,"z":..}}. Marlin answers G30, which probes straight down,
with Bed X: .. Y: .. Z: .., in mm and in the active coordinates. Of the other lines, probe
commands give the approach, G90 and G91 their distance mode, and $13 or G20 the unit.
"""

import json
import re
from dataclasses import dataclass, field
from typing import Any, Final

from tactfix.errors import Problem
from tactfix.files.contact_options import Vector
from tactfix.files.logs.console import block_of, read_closing, read_opening, unwrapped
from tactfix.files.logs.log import ONE_STATE_REMEDY, ConstantStates, Log, LogContact, read_lines, skipped, vector
from tactfix.gcode import Block
from tactfix.lexer import LARGEST_NUMBER, Lexer

_GRBL_REMEDY: Final = "write [PRB:1.000,2.000,3.000:1]"
_DECIMAL_POINT: Final = "write each number with a decimal point: a comma divides numbers here"
_JSON: Final = 'write {"prb":{"e":1,"x":1.0,"y":2.0,"z":3.0}}'
_PARAMETER: Final = re.compile(r"\[(?:G5[4-9]|G28|G30|G92|TLO)[.:]", re.IGNORECASE)
_UNIT_SETTING: Final = re.compile(r"\$13\s*=\s*([01])\b")
_MODES: Final = re.compile(r"\[GC:([^\]]*)\]", re.IGNORECASE)
_FAILED: Final = re.compile(r"\b(?:ALARM|error):", re.IGNORECASE)
_ROTARY: Final = "the axes beyond X Y Z"
_BED: Final = "write Bed X: 1.00 Y: 2.00 Z: 3.00"
_DOWN: Final = (0.0, 0.0, -1.0)
"""Approach of Marlin's G30: straight down."""


_TOWARDS_WORK: Final = (38.2, 38.3)
"""G38.2 and G38.3 probe towards the work."""
_OUT_OF: Final = (38.4, 38.5)
"""G38.4 and G38.5 probe away from it."""


@dataclass(slots=True)
class _ProbeCommands:
    """Probe commands without a report yet, and their distance mode.

    G38.2 Z-20 in G91 moves towards -z. In G90 the words are the end point, which gives no direction without the
    start. Without G90 or G91 a command of one axis is taken as incremental, with a note.
    """

    incremental: bool | None = None
    waiting: list[Vector | None] = field(default_factory=list)
    assumed: bool = False
    absolute: bool = False

    def add(self, block: Block) -> None:
        """A command on a line of its own."""
        if self._probes(block):
            self.waiting.append(self._direction(block))
        else:
            self.mode(block)

    def forget(self) -> None:
        """An alarm: no report will follow."""
        self.waiting.clear()

    def approach(self, command: Block | None) -> Vector | None:
        """The approach of a report: of the command in its own line, else of the waiting ones if they agree."""
        if command is not None and self._probes(command):
            return self._direction(command)
        if not self.waiting:
            return None
        first, is_unanimous = self.waiting[0], len(set(self.waiting)) == 1
        del self.waiting[0]
        return first if is_unanimous else None

    def notes(self) -> tuple[str, ...]:
        """Notes on assumed and undetermined approaches."""
        notes = []
        if self.assumed:
            notes.append("approaches are read from probe commands, taken as incremental (G91): the log does not say")
        if self.absolute:
            notes.append("probe commands in G90 do not give the approach; give it with the contacts")
        return tuple(notes)

    def mode(self, block: Block) -> None:
        """Set the distance mode (G90, G91), which is modal."""
        for code in block.codes("G"):
            self.incremental = {90.0: False, 91.0: True}.get(code, self.incremental)

    def _probes(self, block: Block) -> bool:
        return any(code in _TOWARDS_WORK or code in _OUT_OF for code in block.codes("G"))

    def _direction(self, block: Block) -> Vector | None:
        """Unit direction of the probe into the material, None if the command does not determine it."""
        self.mode(block)
        move = [sum(block.codes(axis)) for axis in "XYZ"]
        axes = sum(value != 0 for value in move)
        turns = any(any(block.codes(axis)) for axis in "ABC")
        if axes == 0 or turns or self.incremental is False or (self.incremental is None and axes > 1):
            self.absolute = self.absolute or self.incremental is False
            return None
        self.assumed = self.assumed or self.incremental is None
        sign = -1.0 if any(code in _OUT_OF for code in block.codes("G")) else 1.0
        length = max(abs(value) for value in move)
        x, y, z = (sign * value / length + 0.0 for value in move)
        return x, y, z


@dataclass(slots=True)
class _Reader:
    contacts: list[LogContact] = field(default_factory=list)
    misses: list[int] = field(default_factory=list)
    repeated: list[int] = field(default_factory=list)
    noisy: list[int] = field(default_factory=list)
    talk: list[int] = field(default_factory=list)
    constant: ConstantStates = field(default_factory=ConstantStates)
    commands: _ProbeCommands = field(default_factory=_ProbeCommands)
    units: str | None = None
    json_units: str | None = None
    last: tuple[Vector, bool] | None = None
    listing: bool = False
    on_bed: bool = False

    def line(self, lexer: Lexer) -> None:
        lexer = unwrapped(lexer)
        opening = read_opening(lexer)
        if lexer.follows("[PRB:"):
            self._noted(lexer, opening.noise)
            self._report(lexer, opening.command)
        elif '"prb"' in lexer.rest.lower() and lexer.follows("{"):
            self._noted(lexer, opening.noise)
            self._json(lexer)
        elif lexer.follows("Bed X"):
            self._noted(lexer, opening.noise)
            self._bed(lexer)
        elif "PRB" in lexer.text.upper() or "BED X" in lexer.text.upper():
            lexer.refuse("this is not a whole probe report", _GRBL_REMEDY)
        else:
            self._talk(lexer, opening.command)

    def _noted(self, lexer: Lexer, noise: bool) -> None:
        if noise:
            self.noisy.append(lexer.line)

    def _report(self, lexer: Lexer, command: Block | None) -> None:
        """[PRB:x,y,z:1], with more axes after z if the controller has them."""
        lexer.take("[PRB:")
        literals = [lexer.literal(_GRBL_REMEDY)]
        while lexer.take(","):
            literals.append(lexer.literal(_GRBL_REMEDY))
        if len(literals) < 3:
            lexer.refuse(f"{len(literals)} numbers are not x,y,z", _GRBL_REMEDY)
        if len(literals) > 3 and not all("." in literal for literal in literals):
            lexer.refuse(f"{len(literals)} numbers, some without a decimal point", _DECIMAL_POINT)
        lexer.mark(":", _GRBL_REMEDY)
        hit = lexer.integer(_GRBL_REMEDY)
        if hit not in (0, 1):
            lexer.refuse(f"{hit} is neither 1 for a hit nor 0 for a miss", _GRBL_REMEDY)
        lexer.mark("]", _GRBL_REMEDY)
        read_closing(lexer, _GRBL_REMEDY)
        self._touched(lexer, [float(literal) for literal in literals], bool(hit), command)

    def _json(self, lexer: Lexer) -> None:
        """{"prb":{...}} or {"r":{"prb":{...}},...}, as JSON reads it."""
        try:
            tree = json.loads(lexer.rest, object_pairs_hook=_once)
        except (ValueError, RecursionError):
            lexer.refuse("this is not JSON", _JSON)
        report = tree.get("prb") or tree.get("r", {}).get("prb") if isinstance(tree, dict) else None
        if not isinstance(report, dict) or not {"e", "x", "y", "z"} <= report.keys() <= set("exyzabcuvw"):
            lexer.refuse("prb does not contain exactly e, x, y and z", _JSON)
        if report["e"] not in (0, 1) or not all(_plain(value) for value in report.values()):
            lexer.refuse("prb contains something that is not a number", _JSON)
        if report["e"]:
            for axis in "abcuvw":
                if axis in report:
                    self.constant.keep(f"the axis {axis.upper()}", float(report[axis]), lexer)
        if self.json_units is not None:
            self.constant.keep("the unit, G20 or G21,", self.json_units, lexer)
        self.units = self.units or self.json_units
        self._touched(lexer, [float(report[axis]) for axis in "xyz"], bool(report["e"]), None)

    def _bed(self, lexer: Lexer) -> None:
        """Bed X: 1.00 Y: 2.00 Z: 3.00"""
        lexer.take("Bed")
        point = []
        for axis in "XYZ":
            lexer.mark(axis, _BED)
            lexer.mark(":", _BED)
            point.append(lexer.number(_BED))
        read_closing(lexer, _BED)
        self.constant.keep("the controller", "Marlin", lexer)
        self.units = self.units or "mm"
        self.on_bed = True
        self.contacts.append(LogContact(lexer.line, vector(point), _DOWN))

    def _touched(self, lexer: Lexer, axes: list[float], hit: bool, command: Block | None) -> None:
        """One report: a miss, a repetition of the last report ($#), or a contact."""
        now = (vector([axis + 0.0 for axis in axes[:3]]), hit)
        if self.listing and now == self.last:
            self.repeated.append(lexer.line)
            return
        self.last = now
        approach = self.commands.approach(command)
        if not hit:
            self.misses.append(lexer.line)
            return
        self.constant.keep("the controller", "grbl", lexer)
        self.constant.keep(_ROTARY, tuple(axes[3:]), lexer)
        self.contacts.append(LogContact(lexer.line, now[0], approach))

    def _talk(self, lexer: Lexer, command: Block | None) -> None:
        """A line that is no report: record commands, settings, and the start of a parameter listing ($#)."""
        content = lexer.rest.strip()
        self.talk.append(lexer.line)
        setting, modes = _UNIT_SETTING.match(content), _MODES.fullmatch(content)
        if content == "$#" or _PARAMETER.match(content):
            self.listing = True
        elif content.lower() == "ok":
            self.listing = False
            self._modes(command)
        elif _FAILED.search(lexer.text):
            self.commands.forget()
        elif setting:
            self._unit(lexer, "in" if setting.group(1) == "1" else "mm")
        else:
            self._command(block_of(modes.group(1)) if modes else block_of(content) or command)

    def _unit(self, lexer: Lexer, unit: str) -> None:
        """$13 applies to earlier reports too, unless one had another unit: consoles list it at any time."""
        if self.contacts and self.units not in (None, unit):
            lexer.refuse(f"the unit changes to {unit} below reports in {self.units}", ONE_STATE_REMEDY)
        self.units = unit

    def _command(self, block: Block | None) -> None:
        if block is None:
            return
        self.listing = False
        self.commands.add(block)
        self._modes(block)

    def _modes(self, block: Block | None) -> None:
        """Apply the modal codes of a command; its probing, if any, has been reported already."""
        if block is None:
            return
        self.commands.mode(block)
        for code in block.codes("G"):
            self.json_units = {20.0: "in", 21.0: "mm"}.get(code, self.json_units)

    def log(self) -> Log:
        notes = [f"line {line}: the probe met nothing; dropped" for line in self.misses]
        notes += [f"line {line}: $# repeats the last hit; dropped" for line in self.repeated]
        notes += [f"line {line}: stray bytes before the report" for line in self.noisy]
        if self.on_bed:
            notes.append("Marlin's G30 reports in the active coordinates; a work offset takes the results out of them")
        rotary = (_ROTARY, *(f"the axis {axis}" for axis in "ABCUVW"))
        notes += [*self.commands.notes(), *self.constant.notes(*rotary)]
        return Log(tuple(self.contacts), self.units, (*notes, *skipped(self.talk, "lines that are no reports")))


def _plain(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST_NUMBER


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a key is given twice")
    return found


def read_grbl(text: str, problems: list[Problem]) -> Log:
    """The hits of a console, with the approach if the console echoes the probe command before them."""
    reader = _Reader()
    read_lines(text, problems, reader.line)
    return reader.log()
