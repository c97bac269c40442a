"""FANUC: positions of .ls programs, and position registers and frames as the controller lists them; mm and degrees.

    P[1:"name"]{ GP1: UF : 0, UT : 1, CONFIG : 'N U T, 0, 0, 0', X = 1.0 mm, ... R = 0.0 deg };
    [1,2] = 'name' Group: 1 Config: N U T, 0, 0, 0   X: 1.0 Y: 2.0 Z: 3.0   W: 0.0 P: 0.0 R: 0.0

or six columns. List, user frame, tool and the axes of other groups must be the same throughout.
"""

import re
from dataclasses import dataclass, field
from functools import partial
from typing import Final

from tactfix.errors import Problem
from tactfix.files.logs.columns import PoseColumns, is_header, pose_contact
from tactfix.files.logs.log import Log, LogContact, skipped, try_reading
from tactfix.lexer import Lexer
from tactfix.pose_formats.literals import FANUC_EXAMPLE, fanuc_item, fanuc_pose

_POSITION_OPENS: Final = re.compile(
    r"[ \t]*P[ \t]*\[[ \t]*([0-9]{1,5})[ \t]*(?::[ \t]*\"([^\"\n]*)\"[ \t]*)?\][ \t]*\{", re.IGNORECASE
)
_LISTED: Final = re.compile(r"[ \t]*\[[ \t]*([0-9]{1,3}[ \t]*(?:,[ \t]*[0-9]{1,3})?)[ \t]*\][ \t]*=")
_ITEM: Final = re.compile(
    r"[ \t]*(?:(P|PR)[ \t]*\[[ \t]*([0-9]{1,5})[ \t]*(?::[^\]\n]*)?\][ \t]*[=:]?)?[ \t]*(?=X[ \t]*[=:])", re.IGNORECASE
)
_PROGRAM_LIST: Final = re.compile(r"[ \t]*\[\*\w+\*\][ \t]*(\$\w+)")
_POSITION_HEADING: Final = re.compile(r"[ \t]*CURRENT[ \t]+(\w[\w \t]*?)[ \t]*POSITION", re.IGNORECASE)
_SELECTIONS: Final = {
    "UF": ("the user frame, UF,", re.compile(r"[^!\n]*\bUFRAME_NUM[ \t]*=[ \t]*([^;\n]*)", re.IGNORECASE)),
    "UT": ("the tool, UT,", re.compile(r"[^!\n]*\bUTOOL_NUM[ \t]*=[ \t]*([^;\n]*)", re.IGNORECASE)),
}
"""Frame and tool of a position: name of each state, and the statement that selects it in a program."""
_SELECTED_FRAME: Final = "F"
"""Value for a position without its own number: it uses the frame or tool that the program has selected."""
_SHOWN: Final = re.compile(r"[ \t]*Frame[ \t]*#[ \t]*:[ \t]*(\w+)[ \t]+Tool[ \t]*#[ \t]*:[ \t]*(\w+)", re.IGNORECASE)
_COORDINATE: Final = re.compile(r"(?<![A-Za-z])X[ \t]*[=:][ \t]*[-+.0-9][^\n]*(?<![A-Za-z])Y[ \t]*[=:][ \t]*[-+.0-9]")
_CONFIGURATION: Final = re.compile(
    r"\s*(?:[A-Z][ \t,]*){1,4}(?:[ \t]*,?[ \t]*-?[0-9]{1,2}){0,4}[ \t]*,?", re.IGNORECASE
)
_UNTAUGHT: Final = re.compile(r"\*{3,}")
_LISTED_NUMBER: Final = re.compile(r"[ \t]*[-+.0-9]")


@dataclass(slots=True)
class _Reader:
    columns: PoseColumns
    contacts: list[LogContact] = field(default_factory=list)
    other: list[int] = field(default_factory=list)
    empty: list[int] = field(default_factory=list)
    joints: list[int] = field(default_factory=list)
    now: dict[str, str] = field(default_factory=dict)
    selected: dict[str, list[tuple[int, str]]] = field(default_factory=dict)

    def part(self, lexer: Lexer) -> None:
        """One position with all its lines, or one line."""
        if point := lexer.match(_POSITION_OPENS):
            self._taught(lexer, point.group(2) or f"P[{point.group(1)}]")
        elif listed := lexer.match(_LISTED):
            self._listed(lexer, f"[{listed.group(1)}]")
        elif item := _ITEM.match(lexer.text):
            lexer.position = item.end()
            pose = fanuc_pose(lexer)
            lexer.end(FANUC_EXAMPLE)
            self._contact(lexer, pose, f"{item.group(1)}[{item.group(2)}]" if item.group(1) else None)
        elif match := _PROGRAM_LIST.match(lexer.text):
            self.now["the list"] = match.group(1).upper()
            self.other.append(lexer.line)
        elif heading := _POSITION_HEADING.match(lexer.text):
            self.now["the frame of the positions"] = heading.group(1).upper()
            self.other.append(lexer.line)
        elif shown := _SHOWN.match(lexer.text):
            self.now |= {"the user frame, UF,": shown.group(1), "the tool, UT,": shown.group(2)}
            self.other.append(lexer.line)
        elif self._select(lexer):
            self.other.append(lexer.line)
        elif self._is_row(lexer.text):
            contact = self.columns.line(lexer)
            self.contacts.extend([contact] if contact else [])
        elif _COORDINATE.search(lexer.text):
            lexer.refuse("this is not a whole position", FANUC_EXAMPLE)
        else:
            self.other.append(lexer.line)

    def _select(self, lexer: Lexer) -> bool:
        """1: UTOOL_NUM=2 ; recorded for positions that use the selected tool or frame."""
        found = [
            (label, match.group(1).strip()) for label, one in _SELECTIONS.values() if (match := one.match(lexer.text))
        ]
        for label, number in found:
            self.selected.setdefault(label, []).append((lexer.line, number))
        return bool(found)

    def check_selected(self, problems: list[Problem]) -> None:
        """Positions without their own frame or tool: the program must select the same one throughout."""
        for label, selected in self.selected.items():
            if self.columns.constant.values.get(label, ("", 0))[0] == _SELECTED_FRAME:
                for line, number in selected:
                    try_reading(
                        Lexer("", line), problems, partial(self.columns.constant.keep, f"{label} selected", number)
                    )

    def _is_row(self, text: str) -> bool:
        """Whether a line is a row of columns (header, numbers, or cells below a header) and not a line of a program."""
        numbers = _LISTED_NUMBER.match(text) and not re.match(r"\s*[0-9]+\s*:", text)
        return bool(numbers) or is_header(text) or (self.columns.columns != () and any(mark in text for mark in ",;\t"))

    def _taught(self, lexer: Lexer, name: str) -> None:
        """P[n]{ groups };"""
        pose: tuple[float, ...] | None = None
        axes: list[float] = []
        while lexer.take("GP"):
            group = lexer.integer(FANUC_EXAMPLE)
            lexer.mark(":", FANUC_EXAMPLE)
            self._frame(lexer, group)
            if lexer.follows("X"):
                pose = pose or fanuc_pose(lexer)
            axes += _axes(lexer)
        lexer.mark("}", FANUC_EXAMPLE)
        lexer.take(";")
        lexer.end(FANUC_EXAMPLE)
        if pose is None:
            self.joints.append(lexer.line)
            return
        self.columns.constant.keep("axes of other groups", tuple(axes), lexer)
        self._contact(lexer, pose, name)

    def _frame(self, lexer: Lexer, group: int) -> None:
        """UF : 0, UT : 1, CONFIG : '...',"""
        for state, (label, _) in _SELECTIONS.items():
            number = _SELECTED_FRAME
            if lexer.take(state):
                lexer.mark(":", FANUC_EXAMPLE)
                number = _SELECTED_FRAME if lexer.take(_SELECTED_FRAME) else str(lexer.integer(FANUC_EXAMPLE))
                lexer.mark(",", FANUC_EXAMPLE)
            if group == 1:
                self.columns.constant.keep(label, number, lexer)
        if lexer.take("CONFIG"):
            lexer.mark(":", FANUC_EXAMPLE)
            lexer.quoted("'", FANUC_EXAMPLE)
            lexer.mark(",", FANUC_EXAMPLE)

    def _listed(self, lexer: Lexer, name: str) -> None:
        """The rest of an entry after [1,2] = in a list of position registers or frames."""
        if lexer.follows("'"):
            name = lexer.quoted("'", FANUC_EXAMPLE).strip() or name
        if lexer.take("Uninitialized") or _UNTAUGHT.search(lexer.text):
            self.empty.append(lexer.line)
            return
        if lexer.take("Group"):
            lexer.mark(":", FANUC_EXAMPLE)
            lexer.integer(FANUC_EXAMPLE)
        if lexer.take("Config"):
            lexer.mark(":", FANUC_EXAMPLE)
            lexer.match(_CONFIGURATION)
        if lexer.follows("J1"):
            self.joints.append(lexer.line)
            return
        if not lexer.follows("X"):
            self.other.append(lexer.line)
            return
        pose = fanuc_pose(lexer)
        self.columns.constant.keep("axes of other groups", tuple(_axes(lexer)), lexer)
        lexer.end(FANUC_EXAMPLE)
        self._contact(lexer, pose, name)

    def _contact(self, lexer: Lexer, pose: tuple[float, ...], name: str | None) -> None:
        begin = Lexer("", lexer.first_line)
        for state, value in self.now.items():
            self.columns.constant.keep(state, value, begin)
        self.contacts.append(pose_contact(begin, self.columns.numbers, pose, name))

    def log(self) -> Log:
        notes = (
            *self.columns.constant.notes("axes of other groups"),
            *skipped(self.joints, "positions of joints, which give no point,"),
            *skipped(self.empty, "positions that were never set"),
            *skipped(self.other, "other lines"),
        )
        return Log(tuple(self.contacts), "mm", notes)


def _axes(lexer: Lexer) -> list[float]:
    """J1= 100.0 mm, E1= 0.0 mm, ... of a group."""
    found = []
    while lexer.follows("J") or lexer.follows("E"):
        lexer.name(FANUC_EXAMPLE)
        found.append(fanuc_item(lexer, "mm", "deg"))
        lexer.take(",")
    return found


def _parts(text: str) -> list[Lexer]:
    """Positions with all their lines, and single lines between them."""
    found: list[Lexer] = []
    pending: list[str] = []
    for number, line in enumerate(text.split("\n"), 1):
        opened = bool(pending)
        taught = opened and _POSITION_OPENS.match(pending[0])
        again = opened and _ITEM.match(pending[0]) and _ITEM.match(line)
        goes_on = opened and (taught or (line.strip() and not again and not _begins(line)))
        if opened and not goes_on:
            found.append(Lexer("\n".join(pending), number - len(pending)))
            pending = []
        pending.append(line)
        if not _POSITION_OPENS.match(pending[0]) and not _LISTED.match(pending[0]) and not _ITEM.match(pending[0]):
            found.append(Lexer(line, number)) if line.strip() else None
            pending = []
        elif taught and "}" in line:
            found.append(Lexer("\n".join(pending), number - len(pending) + 1))
            pending = []
    rest = "\n".join(pending)
    return [*found, Lexer(rest, text.count("\n") + 2 - len(pending))] if rest.strip() else found


def _begins(line: str) -> bool:
    """Whether a line begins a new entry."""
    return bool(
        _POSITION_OPENS.match(line)
        or _LISTED.match(line)
        or re.match(r"[ \t]*(?:\[\*|/|X[ \t]*=|PR?[ \t]*\[|Frame[ \t]*#)", line, re.IGNORECASE)
    )


def read_fanuc(text: str, problems: list[Problem]) -> Log:
    """Positions of the tool in the active user frame."""
    reader = _Reader(PoseColumns.of("fanuc"))
    for part in _parts(text.replace("\r", "")):
        try_reading(part, problems, reader.part)
    reader.check_selected(problems)
    return reader.log()
