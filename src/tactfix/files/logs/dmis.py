"""DMIS: PTMEAS/CART,x,y,z,i,j,k in the unit of UNITS/; i, j, k is the normal out of the material.

A $ at the end of a line continues the statement on the next; $$ begins a comment. Other statements hold no
contacts, but unit, part coordinate system, sensor, tip compensation and rotary table must not change between contacts.
"""

import re
from dataclasses import dataclass, field
from typing import Final

from tactfix.errors import Problem
from tactfix.files.logs.log import (
    ONE_STATE_REMEDY,
    ConstantStates,
    Log,
    LogContact,
    against,
    check_normal,
    skipped,
    try_reading,
    vector,
)
from tactfix.lexer import Lexer, text_lines

_POINT_LINE: Final = re.compile(r"\s*(?:PTMEAS|PTDATA)\s*/", re.IGNORECASE)
_UNITS_LINE: Final = re.compile(r"\s*UNITS\s*/\s*([A-Z]+)", re.IGNORECASE)
_FRAME_LINE: Final = re.compile(r"\s*(?:RECALL\s*/|D\s*\(|DA\s*\()", re.IGNORECASE)
_STATES: Final = (
    ("the sensor", re.compile(r"\s*SNSLCT\s*/", re.IGNORECASE)),
    ("the compensation of the tip", re.compile(r"\s*PRCOMP\s*/", re.IGNORECASE)),
    ("the rotary table", re.compile(r"\s*ROT(?:AB|SET)\s*/", re.IGNORECASE)),
)
_RAW: Final = re.compile(r"\s*RAWDAT\s*/", re.IGNORECASE)
_QUOTED_TEXT: Final = re.compile(r"'[^']*'")
_DMIS_REMEDY: Final = "write PTMEAS/CART,x,y,z or PTMEAS/CART,x,y,z,i,j,k"
_KNOWN_UNITS: Final = {"MM": "mm", "M": "m", "INCH": "in"}


@dataclass(slots=True)
class _Reader:
    contacts: list[LogContact] = field(default_factory=list)
    units: str | None = None
    frame: str = ""
    states: dict[str, str] = field(default_factory=dict)
    constant: ConstantStates = field(default_factory=ConstantStates)
    other: list[int] = field(default_factory=list)

    def statement(self, lexer: Lexer) -> None:
        units = _UNITS_LINE.match(lexer.text)
        if lexer.match(_POINT_LINE):
            self._point(lexer)
        elif _RAW.match(lexer.text):
            lexer.refuse("RAWDAT is data as the machine has it, not a touch", _DMIS_REMEDY)
        elif (
            re.match(r"\s*PT(MEAS|DATA)", lexer.text, re.IGNORECASE)
            or "PTMEAS" in _QUOTED_TEXT.sub("", lexer.text).upper()
        ):
            lexer.refuse("this is not a whole PTMEAS", _DMIS_REMEDY)
        elif units:
            self._unit(lexer, units.group(1).upper())
        else:
            self.frame = lexer.text.strip() if _FRAME_LINE.match(lexer.text) else self.frame
            for state, statement in _STATES:
                if statement.match(lexer.text):
                    content = re.sub(r"\s+", "", lexer.text)
                    # Every ROTAB statement moves the table, even if its text is the same.
                    self.states[state] = (
                        f"{content} in line {lexer.line}" if content.upper().startswith("ROT") else content
                    )
            self.other.append(lexer.line)

    def _unit(self, lexer: Lexer, name: str) -> None:
        """UNITS/ applies to what follows; all touches must be in one unit."""
        if name not in _KNOWN_UNITS:
            lexer.refuse(f"UNITS/{name} is not known here", "write it in MM, M or INCH")
        unit = _KNOWN_UNITS[name]
        if self.contacts and unit != self.units:
            lexer.refuse(
                f"the unit changes to {unit} below touches in {self.units or 'a unit that is not given'}",
                ONE_STATE_REMEDY,
            )
        self.units = unit

    def _point(self, lexer: Lexer) -> None:
        lexer.mark("CART", _DMIS_REMEDY)
        lexer.mark(",", _DMIS_REMEDY)
        numbers = lexer.numbers(3, _DMIS_REMEDY)
        normal = (0.0, 0.0, 0.0)
        if lexer.take(","):
            i, j, k = lexer.numbers(3, _DMIS_REMEDY)
            normal = (i, j, k)
        lexer.end(_DMIS_REMEDY)
        check_normal(lexer, normal, _DMIS_REMEDY)
        self.constant.keep("the part coordinate system", self.frame, lexer)
        for state, _ in _STATES:
            self.constant.keep(state, self.states.get(state, "as at the beginning"), lexer)
        self.contacts.append(LogContact(lexer.line, vector(numbers), against(normal)))

    def log(self) -> Log:
        return Log(tuple(self.contacts), self.units, skipped(self.other, "other statements"))


def _statements(text: str) -> list[Lexer]:
    """Each statement, its lines joined, without comments."""
    found: list[Lexer] = []
    pending: list[str] = []
    for number, line in enumerate(text_lines(text), 1):
        inside = line.split("$$", 1)[0]
        goes_on = inside.rstrip().endswith("$")
        pending.append(inside.rstrip()[:-1] if goes_on else inside)
        if not goes_on:
            if "".join(pending).strip():
                found.append(Lexer("\n".join(pending), number - len(pending) + 1))
            pending = []
    return [*found, Lexer("\n".join(pending), 1)] if "".join(pending).strip() else found


def read_dmis(text: str, problems: list[Problem]) -> Log:
    """The measured points of a DMIS file, in the active part coordinate system."""
    reader = _Reader()
    for statement in _statements(text):
        try_reading(statement, problems, reader.statement)
    return reader.log()
