"""A lexer for text written by machines: each part is read whole, or a TextError is raised.

A grammar requests words, numbers and marks from a Lexer in turn and finally the end, so that no character is
skipped. A letter, a digit or a second decimal point directly after a number makes the whole invalid. Only ASCII digits
are digits.
"""

import re
from dataclasses import dataclass
from typing import Final, NoReturn

from tactfix.decimal_text import FIXED_POINT, NUMBER
from tactfix.errors import Problem, TactfixError

LARGEST_NUMBER: Final = 1e30
"""Largest length, angle or count accepted; a larger one comes from a damaged file."""
_LINE_END: Final = re.compile(r"\r*\n|\r")
_LONGEST_NUMBER: Final = 40
"""Largest number of characters of a number; a double has 17 digits."""
_LIKE_A_NUMBER: Final = re.compile(r"[+-]?[0-9A-Za-z_.]*")
_IDENTIFIER: Final = re.compile(r"[A-Za-z_$][A-Za-z0-9_$]*")
_BLANKS: Final = re.compile(r"[ \t\r\n]*")


class TextError(TactfixError):
    """A syntax error at one place of a text; a caller that knows the file's name turns it into a FileError."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        super().__init__(problem.text)


def text_lines(text: str) -> list[str]:
    """The lines of a text; consoles write any number of carriage returns before a line end."""
    return _LINE_END.split(text)


@dataclass(slots=True)
class Lexer:
    """A position in text, which starts in line first_line at column first_column of its file."""

    text: str
    first_line: int = 1
    first_column: int = 1
    position: int = 0

    @property
    def line(self) -> int:
        """The line of the next character."""
        return self.first_line + self.text.count("\n", 0, self.position)

    @property
    def column(self) -> int:
        """The column of the next character."""
        before = self.text.rfind("\n", 0, self.position)
        return self.position - before if before >= 0 else self.first_column + self.position

    @property
    def rest(self) -> str:
        """The text not read yet."""
        return self.text[self.position :]

    def refuse(self, message: str, remedy: str) -> NoReturn:
        """Raise TextError at the next character."""
        raise TextError(Problem(message, remedy, line=self.line, column=self.column))

    def blanks(self) -> "Lexer":
        """Skip blanks."""
        found = _BLANKS.match(self.text, self.position)
        self.position = found.end() if found else self.position
        return self

    def follows(self, mark: str) -> bool:
        """Whether mark (any case) comes next, after blanks."""
        self.blanks()
        return self.text[self.position : self.position + len(mark)].upper() == mark.upper()

    def take(self, mark: str) -> bool:
        """Skip mark (any case) and the blanks before it, if it comes next."""
        if not self.follows(mark):
            return False
        self.position += len(mark)
        return True

    def mark(self, mark: str, remedy: str) -> None:
        """Skip mark, which must come next."""
        if not self.take(mark):
            self.refuse(f"{mark!r} is missing before {self._shown()}", remedy)

    def match(self, pattern: re.Pattern[str]) -> re.Match[str] | None:
        """Skip and return the match of pattern at the current position, if any."""
        found = pattern.match(self.text, self.position)
        if found is not None:
            self.position = found.end()
        return found

    def name(self, remedy: str) -> str:
        """The name that comes next: letters, digits, _ and $, no digit first."""
        self.blanks()
        found = self.match(_IDENTIFIER)
        return found.group() if found else self.refuse(f"there is no name before {self._shown()}", remedy)

    def literal(self, remedy: str, *, glued: bool = False) -> str:
        """The characters of the number that comes next.

        glued: a letter may follow without a blank, as in G-code, where there is no exponent either.
        """
        self.blanks()
        found = (FIXED_POINT if glued else NUMBER).match(self.text, self.position)
        end = found.end() if found else self.position
        after = self.text[end : end + 1]
        continued = after.isalnum() or after in ("_", ".") if after else False
        if found is None or (continued and not (glued and after.isalpha())):
            looks = _LIKE_A_NUMBER.match(self.text, self.position)
            shown = looks.group() if looks else ""
            self.refuse(f"{shown[:_LONGEST_NUMBER]!r} is no number" if shown else self._no_number(), remedy)
        literal = found.group()
        if len(literal) > _LONGEST_NUMBER or not abs(float(literal)) <= LARGEST_NUMBER:
            self.refuse(f"{literal[:_LONGEST_NUMBER]} is too long, or larger than 1e30", remedy)
        self.position = end
        return literal

    def number(self, remedy: str, *, glued: bool = False) -> float:
        """The number that comes next."""
        return float(self.literal(remedy, glued=glued)) + 0.0

    def numbers(self, count: int, remedy: str, separator: str = ",") -> tuple[float, ...]:
        """The next count numbers, with separator between them."""
        found = [self.number(remedy)]
        for _ in range(count - 1):
            self.mark(separator, remedy)
            found.append(self.number(remedy))
        return tuple(found)

    def integer(self, remedy: str) -> int:
        """The whole number that comes next."""
        here = self.blanks().position
        literal = self.literal(remedy)
        if not literal.lstrip("+-").isdigit():
            self.position = here
            self.refuse(f"{literal} is no whole number", remedy)
        return int(literal)

    def quoted(self, mark: str, remedy: str) -> str:
        """The text between two marks."""
        self.mark(mark, remedy)
        end = self.text.find(mark, self.position)
        if end < 0:
            self.refuse(f"{mark} is left open", remedy)
        inside = self.text[self.position : end]
        self.position = end + len(mark)
        return inside

    def end(self, remedy: str) -> None:
        """Raise TextError if anything but blanks remains."""
        self.blanks()
        if self.position < len(self.text):
            self.refuse(f"{self._shown()} is left over", remedy)

    def _no_number(self) -> str:
        return f"there is no number before {self._shown()}"

    def _shown(self) -> str:
        rest = self.rest.strip()
        return repr(rest if len(rest) <= 20 else rest[:20] + "...") if rest else "the end of the line"
