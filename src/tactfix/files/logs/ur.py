"""Universal Robots: p[x, y, z, rx, ry, rz] a line, columns, or the recorder of RTDE; metres, rotation vector."""

import re
from dataclasses import dataclass, field
from typing import Final

from tactfix.errors import Problem
from tactfix.files.logs.log import Log, LogContact, Standing, passed_over, read_lines
from tactfix.files.logs.robot_columns import PoseColumns, pose_contact
from tactfix.lexer import Lexer
from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.literals import UR, ur_pose

_POSE: Final = re.compile(r"(?<![A-Za-z0-9_])p\s*\[")
# A time stamp, then a name or a remark of words, which may end in a count, then = or :.
_BEFORE: Final = re.compile(
    r"\s*(?:[0-9]{1,4}[-:/.][0-9:./T Z-]*[,;:]?\s+)?((?:[A-Za-z_]\w*(?:\s+\w+)*)?)\s*(?::=|=|:|,)?\s*", re.ASCII
)


@dataclass(slots=True)
class _Reader:
    columns: PoseColumns
    contacts: list[LogContact] = field(default_factory=list)
    comments: list[int] = field(default_factory=list)

    def line(self, lexer: Lexer) -> None:
        if lexer.text.lstrip().startswith("#"):
            self.comments.append(lexer.line)
            return
        literal = _POSE.search(lexer.text)
        contact = self.columns.line(lexer) if literal is None else self._pose(lexer, literal)
        if contact is not None:
            self.contacts.append(contact)

    def _pose(self, lexer: Lexer, literal: re.Match[str]) -> LogContact:
        before = _BEFORE.fullmatch(lexer.text, 0, literal.start())
        if before is None:
            lexer.refuse("what stands before p[ is no name", UR)
        lexer.position = literal.start()
        values = ur_pose(lexer)
        lexer.take(";")
        lexer.end(UR)
        return pose_contact(lexer, self.columns.numbers, values, before.group(1) or None)


def read_ur(text: str, problems: list[Problem]) -> Log:
    """Poses of the tool in the robot's base, in metres."""
    standing = Standing()
    numbers = DIALECTS["ur"].numbers
    assert numbers is not None
    reader = _Reader(PoseColumns(numbers, standing))
    read_lines(text, problems, reader.line)
    passed = reader.columns.passed
    notes = (f"the columns {', '.join(passed[:5])} say nothing of the pose; passed over",) if passed else ()
    return Log(tuple(reader.contacts), "m", (*notes, *passed_over(reader.comments, "comments")))
