"""Universal Robots: p[x, y, z, rx, ry, rz] a line, columns, or the recorder of RTDE; metres, rotation vector.

A list without p, as Python prints it, is a pose too, unless it is assigned to a name: in URScript such a list may hold
joint angles.
"""

import re
from dataclasses import dataclass, field
from typing import Final

from tactfix.errors import Problem
from tactfix.files.logs.columns import PoseColumns, pose_contact
from tactfix.files.logs.console import read_opening
from tactfix.files.logs.log import Log, LogContact, read_lines, skipped
from tactfix.lexer import Lexer
from tactfix.pose_formats.literals import UR_EXAMPLE, ur_pose

_POSE: Final = re.compile(r"(?<![A-Za-z0-9_])p\s*\[")
# An optional time stamp, a name or words that may end in a number, and = or :.
_BRACKETED: Final = re.compile(r"([\[(])([^\[\]()]*)[\])]\s*")
_VARIABLE: Final = re.compile(r"\s*(?:(?:global|local)\s+)?[A-Za-z_]\w*\s*=", re.ASCII)
_ENTRY_NAME: Final = re.compile(
    r"\s*(?:[0-9]{1,4}[-:/.][0-9:./T Z-]*[,;:]?\s+)?((?:[A-Za-z_]\w*(?:\s+\w+)*)?)\s*(?::=|=|:|,)?\s*", re.ASCII
)


@dataclass(slots=True)
class _Reader:
    columns: PoseColumns
    contacts: list[LogContact] = field(default_factory=list)
    comments: list[int] = field(default_factory=list)
    variables: list[int] = field(default_factory=list)

    def line(self, lexer: Lexer) -> None:
        if lexer.text.lstrip().startswith("#"):
            self.comments.append(lexer.line)
            return
        literal = _POSE.search(lexer.text)
        if literal is None and _VARIABLE.match(lexer.text):
            self.variables.append(lexer.line)
            return
        contact = self._list(lexer) if literal is None else self._pose(lexer, literal)
        if contact is not None:
            self.contacts.append(contact)

    def _list(self, lexer: Lexer) -> LogContact | None:
        """[x, y, z, rx, ry, rz], as Python prints it, with an optional time stamp; else columns."""
        begin = lexer.position
        read_opening(lexer)
        if lexer.rest[:1] not in ("[", "(") or _BRACKETED.fullmatch(lexer.rest) is None:
            lexer.position = begin
            return self.columns.line(lexer)
        closing = {"[": "]", "(": ")"}[lexer.rest[0]]
        lexer.take(lexer.rest[0])
        values = lexer.numbers(6, UR_EXAMPLE)
        lexer.mark(closing, UR_EXAMPLE)
        lexer.end(UR_EXAMPLE)
        return pose_contact(lexer, self.columns.numbers, values)

    def _pose(self, lexer: Lexer, literal: re.Match[str]) -> LogContact:
        before = _ENTRY_NAME.fullmatch(lexer.text, 0, literal.start())
        if before is None:
            lexer.refuse("what precedes p[ is not a name", UR_EXAMPLE)
        lexer.position = literal.start()
        values = ur_pose(lexer)
        lexer.take(";")
        lexer.end(UR_EXAMPLE)
        return pose_contact(lexer, self.columns.numbers, values, before.group(1) or None)


def read_ur(text: str, problems: list[Problem]) -> Log:
    """Poses of the tool in the robot's base, in metres."""
    reader = _Reader(PoseColumns.of("ur"))
    read_lines(text, problems, reader.line)
    passed = reader.columns.passed
    notes = (f"the columns {', '.join(passed[:5])} are not part of the pose; skipped",) if passed else ()
    other = (*skipped(reader.comments, "comments"), *skipped(reader.variables, "variables that are no poses"))
    return Log(tuple(reader.contacts), "m", (*notes, *other))
