"""ABB: robtargets and poses as RAPID writes them, of modules and of what a program wrote; mm, quaternion scalar first.

    [LOCAL|TASK] CONST|VAR|PERS robtarget p10:=[[x,y,z],[q1,q2,q3,q4],[cf1,cf4,cf6,cfx],[eax_a, ... eax_f]];
    MoveL [[...],[...],[...],[...]],v100,fine,tool0\\WObj:=wobj1;

or the value alone, or three or seven columns. External axes must not move; 9E+09 means an absent axis. Tool and
work object are taken from the motions to each target, and must be the same for all.
"""

import re
from dataclasses import dataclass, field
from functools import partial
from typing import Final

from tactfix.errors import Problem
from tactfix.files.logs.columns import PoseColumns, is_header, pose_contact
from tactfix.files.logs.console import read_opening
from tactfix.files.logs.log import Log, LogContact, skipped, try_reading, vector
from tactfix.lexer import Lexer, text_lines
from tactfix.pose_formats.literals import ABB_EXAMPLE, abb_pose

_MOD_COMMENT: Final = re.compile(r"!.*")
_DECLARED: Final = re.compile(
    r"\s*(?:(?:LOCAL|TASK)\s+)?(?:CONST|VAR|PERS)\s+(\w+)\s+(\w+)\s*(\{[0-9\s,]*\})?\s*(?=:=|;|$)",
    re.IGNORECASE | re.ASCII,
)
_ASSIGNED: Final = re.compile(r"\s*([A-Za-z_]\w*)\s*(?::=|=|:)", re.ASCII)
_MOVE_TO_PLACE: Final = re.compile(r"\s*Move(?:L|J)\w*\s*(?:\\\s*Conc\s*,)?\s*(?=\[)", re.IGNORECASE)
_DISPLACED: Final = re.compile(r"\s*(?:PDisp|EOffs)(?:On|Set)\b", re.IGNORECASE)
_JOINTS: Final = re.compile(r"\s*MoveAbsJ\b", re.IGNORECASE)
_NAMED_MOTION: Final = re.compile(
    r"\s*(?:Move|Search)[A-Za-z]+((?:\s*\\\s*\w+)*\s*,?[^\[\]]*?),\s*(\w+)\s*(?:\\\s*WObj\s*:=\s*(\w+)\s*)?;?\s*",
    re.IGNORECASE | re.ASCII,
)
_AFTER_MOTION: Final = re.compile(
    r"\s*,[A-Za-z0-9_,\s\\:=.]*?,\s*(\w+)\s*(?:\\\s*WObj\s*:=\s*(\w+)\s*)?(?=;|$)", re.IGNORECASE | re.ASCII
)
_POSITION_TYPES: Final = ("ROBTARGET", "POSE", "POS")
_NUMBER_LINE: Final = re.compile(r"\s*[-+.0-9]")
_POSITION_LINES: Final = 200
"""Greatest number of lines of one position."""


@dataclass(slots=True)
class _Reader:
    columns: PoseColumns
    contacts: list[LogContact] = field(default_factory=list)
    other: list[int] = field(default_factory=list)
    motions: dict[str, list[tuple[int, str, str]]] = field(default_factory=dict)

    def statement(self, lexer: Lexer) -> None:
        if _DISPLACED.match(lexer.text):
            lexer.refuse("a program displacement shifts the targets", "write them without one: PDispOff, EOffsOff")
        declared = _DECLARED.match(lexer.text)
        if _JOINTS.match(lexer.text) or (declared is not None and declared.group(1).upper() not in _POSITION_TYPES):
            self.other.append(lexer.line)
        elif declared is not None:
            lexer.position = declared.end()
            if lexer.take(":="):
                self._values(lexer, declared.group(2), array=declared.group(3) is not None)
        elif "[[" in re.sub(r"\s", "", lexer.text):
            self._bare(lexer)
        elif "[" in lexer.text or "]" in lexer.text:
            lexer.refuse("this is not a whole robtarget", ABB_EXAMPLE)
        elif motion := _NAMED_MOTION.fullmatch(lexer.text):
            self._motion(lexer, motion)
        elif _NUMBER_LINE.match(lexer.text) or self.columns.columns or is_header(lexer.text):
            contact = self.columns.line(lexer)
            self.contacts.extend([contact] if contact else [])
        else:
            self.other.append(lexer.line)

    def _motion(self, lexer: Lexer, motion: re.Match[str]) -> None:
        """MoveL p10,v100,fine,tool0\\WObj:=wobj1; records tool and work object of the targets it names."""
        for name in re.findall(r"[A-Za-z_]\w*", motion.group(1)):
            self.motions.setdefault(name.upper(), []).append((lexer.line, motion.group(2), motion.group(3) or "wobj0"))
        self.other.append(lexer.line)

    def check_motions(self, problems: list[Problem]) -> None:
        """Reject targets whose motions name different tools or work objects."""
        for name in dict.fromkeys(contact.id for contact in self.contacts if contact.id):
            for line, tool, work_object in self.motions.get(name.upper(), []):
                for state, value in (("the tool", tool), ("the work object", work_object)):
                    try_reading(Lexer("", line), problems, partial(self.columns.constant.keep, state, value))

    def _bare(self, lexer: Lexer) -> None:
        """A position: declared with a name, inside a motion, or alone."""
        if lexer.match(_MOVE_TO_PLACE):
            self.contacts.append(self._target(lexer, None))
            after = lexer.match(_AFTER_MOTION)
            if after is None:
                lexer.refuse("what follows the target is no motion", ABB_EXAMPLE)
            self.columns.constant.keep("the tool", after.group(1), lexer)
            self.columns.constant.keep("the work object", after.group(2) or "wobj0", lexer)
            lexer.take(";")
            lexer.end(ABB_EXAMPLE)
            return
        named = lexer.match(_ASSIGNED)
        if named is None:
            read_opening(lexer)
            named = lexer.match(_ASSIGNED)
        self._values(lexer, named.group(1) if named else None, array=False)

    def _values(self, lexer: Lexer, name: str | None, *, array: bool) -> None:
        """One target, or as many as the array holds, up to the end of the statement."""
        if array:
            lexer.mark("[", ABB_EXAMPLE)
        found = [self._target(lexer, name)]
        while array and lexer.take(","):
            found.append(self._target(lexer, name))
        if array:
            lexer.mark("]", ABB_EXAMPLE)
        lexer.take(";")
        lexer.end(ABB_EXAMPLE)
        self.contacts.extend(found)

    def _target(self, lexer: Lexer, name: str | None) -> LogContact:
        """[[x,y,z],[quaternion]], with configuration and external axes for a robtarget; [x,y,z] for a pos."""
        start = lexer.position
        lexer.mark("[", ABB_EXAMPLE)
        if not lexer.follows("["):
            point = vector(lexer.numbers(3, ABB_EXAMPLE))
            lexer.mark("]", ABB_EXAMPLE)
            return LogContact(lexer.line, point, id=name)
        lexer.position = start
        values, axes = abb_pose(lexer)
        if axes:
            self.columns.constant.keep("external axes", axes, lexer)
        return pose_contact(lexer, self.columns.numbers, values, name)

    def log(self) -> Log:
        notes = (*self.columns.constant.notes("external axes"), *skipped(self.other, "other statements"))
        return Log(tuple(self.contacts), "mm", notes)


def _statements(text: str) -> list[Lexer]:
    """Lines without comments, joined as long as brackets are open, and split at the end of each statement."""
    found: list[Lexer] = []
    pending: list[str] = []
    for number, line in enumerate(text_lines(text), 1):
        pending.append(_MOD_COMMENT.sub("", line))
        joined = "\n".join(pending)
        if joined.count("[") > joined.count("]") and len(pending) < _POSITION_LINES:
            continue
        first = number - len(pending) + 1
        found.extend(
            _divided(Lexer(joined, first)) if "[" in joined else [Lexer(joined, first)] if joined.strip() else []
        )
        pending = []
    rest = "\n".join(pending)
    return [*found, Lexer(rest, text.count("\n") + 2 - len(pending))] if rest.strip() else found


def _divided(lexer: Lexer) -> list[Lexer]:
    """The statements of a text, each to its ; outside of a string."""
    found = []
    for part in re.finditer(r'(?:"[^"]*"|[^;"])+;?', lexer.text):
        lexer.position = part.start()
        if part.group().strip():
            found.append(Lexer(part.group(), lexer.line, lexer.column))
    return found


def read_abb(text: str, problems: list[Problem]) -> Log:
    """Targets of the tool in the active work object."""
    reader = _Reader(PoseColumns.of("abb"))
    for statement in _statements(text):
        try_reading(statement, problems, reader.statement)
    reader.check_motions(problems)
    return reader.log()
