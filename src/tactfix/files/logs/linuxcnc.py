"""LinuxCNC's (PROBEOPEN name): X Y Z A B C U V W of the tip's centre a line, in the active work coordinates."""

from dataclasses import dataclass, field
from typing import Final

from tactfix.errors import Problem
from tactfix.files.logs.log import ConstantStates, Log, LogContact, read_lines, skipped, vector
from tactfix.lexer import Lexer

_LINUXCNC_REMEDY: Final = "write nine numbers, X Y Z A B C U V W, with blanks between"
_MISS_LIKE_HIT: Final = (
    "LinuxCNC logs a G38.3 or G38.5 that met nothing like a hit: its line is the end of the move, and only the "
    "residuals show it"
)


@dataclass(slots=True)
class _Reader:
    contacts: list[LogContact] = field(default_factory=list)
    constant: ConstantStates = field(default_factory=ConstantStates)
    comments: list[int] = field(default_factory=list)

    def line(self, lexer: Lexer) -> None:
        if lexer.text.lstrip().startswith(("#", ";")):
            self.comments.append(lexer.line)
            return
        axes = [lexer.number(_LINUXCNC_REMEDY) for _ in range(9)]
        lexer.end(_LINUXCNC_REMEDY)
        self.constant.keep("A B C U V W", tuple(axes[3:]), lexer)
        self.contacts.append(LogContact(lexer.line, vector(axes[:3])))


def read_linuxcnc(text: str, problems: list[Problem]) -> Log:
    """A log of straight probes (G38.2 to G38.5). Rotary and parallel axes must not move."""
    reader = _Reader()
    read_lines(text, problems, reader.line)
    notes = (_MISS_LIKE_HIT, *reader.constant.notes("A B C U V W"), *skipped(reader.comments, "comments"))
    return Log(tuple(reader.contacts), notes=notes)
