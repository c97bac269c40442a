"""KUKA: positions as KRL writes them, one a line, of .dat and .src files and of what a program wrote; mm and degrees.

    {X 1,Y 2,Z 3,A 0,B 90,C 0,S 2,T 35,E1 0.0, ...}      also {POS: ...}, {E6POS: ...}, {FRAME: ...}
    DECL E6POS XP1={...}    GLOBAL FRAME P1={...}    $POS_ACT={...}    LIN {...} C_DIS    P1: X 1 Y 2 Z 3 A 0 B 90 C 0

or six columns. External axes must not move; DECL FDAT, $TOOL, $BASE, BAS and FDAT_ACT give tool and base, which must
be the same throughout. TOOL_DATA, BASE_DATA, $WORLD and $ROBROOT are frames, not touches.
"""

import re
from dataclasses import dataclass, field
from functools import partial
from typing import Final

from tactfix.errors import Problem
from tactfix.files.logs.columns import PoseColumns, is_header, pose_contact, separator_of
from tactfix.files.logs.console import read_opening
from tactfix.files.logs.log import Log, LogContact, read_lines, skipped, try_reading
from tactfix.lexer import Lexer
from tactfix.pose_formats.literals import KUKA_AXES, KUKA_EXAMPLE, KUKA_LABELS, kuka_items, kuka_position

_DAT_COMMENT: Final = re.compile(r";.*")
_POSITION: Final = re.compile(r"(?<![A-Za-z0-9_])[XYZ]\s*[=:]?\s*\"?[-+.0-9]", re.IGNORECASE)
_LABELLED: Final = re.compile(r"X\s*[=:]?\s*[-+.0-9]", re.IGNORECASE)
_RELATIVE: Final = re.compile(r"\s*S?(?:PTP|LIN|CIRC)_REL\b", re.IGNORECASE)
_ACTIVE: Final = re.compile(
    r"\s*(?:(\$(?:ACT_)?(?:TOOL|BASE)|FDAT_ACT)\s*=\s*([^;]*)|BAS\s*\(\s*#(TOOL|BASE)\s*,\s*([^)]*)\))",
    re.IGNORECASE,
)
_DECLARATION: Final = re.compile(
    r"\s*(?:(?:GLOBAL|DECL|CONST)\s+)*(?:(E6POS|POS|FRAME|FDAT)\s+)?([A-Za-z_$][\w$.]*(?:\[\s*\d*\s*\])?)\s*[=:]\s*",
    re.IGNORECASE | re.ASCII,
)
_PTP_OR_LIN: Final = re.compile(r"\s*S?(?:PTP|LIN)\s*(?=\{)", re.IGNORECASE)
_APPROXIMATE: Final = re.compile(r"\s*C_(?:DIS|PTP|ORI|VEL|SPL)\b", re.IGNORECASE)
_INSIDE: Final = re.compile(r"\{\s*([A-Za-z_]\w*)", re.ASCII)
_TAUGHT: Final = re.compile(r"\bF(\w+)\s*=", re.ASCII)
_HELD_PART: Final = re.compile(r"IPO_FRAME\s*#TCP\b", re.IGNORECASE)
_FRAMES: Final = re.compile(
    r"\s*(?:(?:GLOBAL|DECL|CONST|FRAME)\s+)*(?:(?:TOOL|BASE)_DATA\s*\[|\$(?:WORLD|ROBROOT|NULLFRAME)\b)", re.IGNORECASE
)
_TAUGHT_NUMBER: Final = re.compile(r"(TOOL_NO|BASE_NO)\s+(-?[0-9]{1,3})\b", re.IGNORECASE)


@dataclass(slots=True)
class _Reader:
    columns: PoseColumns
    contacts: list[LogContact] = field(default_factory=list)
    talk: list[int] = field(default_factory=list)
    axes: list[int] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)
    taught: dict[str, tuple[int, list[tuple[str, str]]]] = field(default_factory=dict)
    active: dict[str, str] = field(default_factory=dict)

    def line(self, lexer: Lexer) -> None:
        comment = lexer.text.lstrip().startswith((";", "#"))
        inside = None if comment else _INSIDE.search(lexer.text)
        word = inside.group(1).upper() if inside else ""
        if comment or self._selects(lexer):
            self.talk.append(lexer.line)
        elif _FRAMES.match(lexer.text):
            self.frames.append(lexer.line)
        elif _RELATIVE.match(lexer.text):
            lexer.refuse("a relative motion gives no position", KUKA_EXAMPLE)
        elif word in ("X", "E6POS", "POS", "FRAME"):
            self._position(lexer)
        elif word in ("A1", "E6AXIS", "AXIS"):
            self.axes.append(lexer.line)
        elif word in ("TOOL_NO", "BASE_NO"):
            self._tool(lexer)
        elif not _POSITION.search(lexer.text) and not _is_row(lexer.text) and self.columns.columns == ():
            self._talk_or_names(lexer)
        elif "{" in lexer.text or "}" in lexer.text:
            lexer.refuse("this is not a whole position", KUKA_EXAMPLE)
        elif _POSITION.search(lexer.text):
            self._labelled(lexer)
        else:
            self._row(lexer)

    def _selects(self, lexer: Lexer) -> bool:
        """$TOOL=..., BAS(#BASE,2) and FDAT_ACT=... apply to the positions below."""
        active = _ACTIVE.match(lexer.text)
        if active is not None:
            name, value = active.group(1) or f"${active.group(3)}", active.group(2) or active.group(4) or ""
            self.active[name.upper()] = value.strip()
        return active is not None

    def _talk_or_names(self, lexer: Lexer) -> None:
        if is_header(lexer.text):
            self._row(lexer)
        else:
            self.talk.append(lexer.line)

    def _row(self, lexer: Lexer) -> None:
        contact = self.columns.line(lexer)
        if contact is not None:
            self.contacts.append(contact)

    def _position(self, lexer: Lexer) -> None:
        """One position, with the declaration or motion around it."""
        if lexer.match(_PTP_OR_LIN):
            name = None
        else:
            before = lexer.match(_DECLARATION)
            name = before.group(2) if before else None
            if before is None:
                read_opening(lexer)
        numbers = kuka_position(lexer)
        lexer.match(_APPROXIMATE)
        lexer.blanks().match(_DAT_COMMENT)
        lexer.end(KUKA_EXAMPLE)
        self._contact(lexer, numbers, name)

    def _labelled(self, lexer: Lexer) -> None:
        """P1: X 1 Y 2 Z 3 A 0 B 90 C 0, without braces."""
        if not _LABELLED.match(lexer.text.lstrip()):
            before = lexer.match(_DECLARATION)
            if before is None:
                read_opening(lexer)
                before = None if _LABELLED.match(lexer.rest) else lexer.match(_DECLARATION)
            name = before.group(2) if before else None
        else:
            name = None
        if not _LABELLED.match(lexer.blanks().rest):
            lexer.refuse("this is not a whole position", KUKA_EXAMPLE)
        numbers = kuka_items(lexer, loose=True)
        lexer.end(KUKA_EXAMPLE)
        self._contact(lexer, numbers, name)

    def _contact(self, lexer: Lexer, numbers: dict[str, float], name: str | None) -> None:
        for state in ("$TOOL", "$BASE", "$ACT_TOOL", "$ACT_BASE", "FDAT_ACT"):
            self.columns.constant.keep(state, self.active.get(state, "that before the program"), lexer)
        self.columns.constant.keep("external axes", tuple(numbers.get(axis, 0.0) for axis in KUKA_AXES), lexer)
        self.contacts.append(pose_contact(lexer, self.columns.numbers, [numbers[label] for label in KUKA_LABELS], name))

    def _tool(self, lexer: Lexer) -> None:
        """DECL FDAT FP1={TOOL_NO 1,BASE_NO 2,...}: the tool and base that the point XP1 was taught with."""
        name = _TAUGHT.search(lexer.text)
        if _HELD_PART.search(lexer.text):
            lexer.refuse("IPO_FRAME #TCP: this position is of a part in the gripper, not of a tool", KUKA_EXAMPLE)
        if name is not None:
            self.taught[name.group(1).upper()] = lexer.line, _TAUGHT_NUMBER.findall(lexer.text)
        self.talk.append(lexer.line)

    def check_taught(self, problems: list[Problem]) -> None:
        """Reject contacts whose FDAT name different tools or bases."""
        for contact in self.contacts:
            line, numbers = self.taught.get((contact.id or "").upper().removeprefix("X"), (0, []))
            for state, number in numbers:
                try_reading(Lexer("", line), problems, partial(self.columns.constant.keep, state.upper(), int(number)))

    def log(self) -> Log:
        notes = (
            *skipped(self.axes, "positions of axes, which give no point,"),
            *skipped(self.frames, "frames of tools, bases and the robot itself"),
            *skipped(self.talk, "other lines"),
        )
        return Log(
            tuple(self.contacts), "mm", (*self.columns.constant.notes("external axes", "TOOL_NO", "BASE_NO"), *notes)
        )


def _is_row(text: str) -> bool:
    """Whether a line begins with a number."""
    cells = text.strip().split(separator_of(text))
    return cells[0].strip()[:1] in set("+-.0123456789")


def read_kuka(text: str, problems: list[Problem]) -> Log:
    """Positions of the tool in the active base."""
    reader = _Reader(PoseColumns.of("kuka"))
    read_lines(text, problems, reader.line)
    reader.check_taught(problems)
    return reader.log()
