"""A line of numbers in a controller's literal syntax: written from a template, read back by the same template."""

import re

import numpy as np

from tactfix.decimal_text import NUMBER
from tactfix.geometry.arrays import Floats
from tactfix.lexer import Lexer
from tactfix.pose_formats.one_pose import the_one, without_comments
from tactfix.pose_formats.pose import syntax_error
from tactfix.values import frozen_value

_FIELD = re.compile(r"%\+?\d*\.(\d+)f")
_BEGINS = r"(?<![0-9.({\[+-])(?<![0-9.({\[+-] )"
_DIGIT = re.compile(r"[0-9]")
_ENDS = r"(?![A-Za-z0-9_.]|,[0-9])"


@frozen_value(eq=True)
class NumberSyntax:
    """Numbers set into literal text: template has one printf field (%.6f) for each.

    degrees: which numbers are angles in degrees, whose -180 is written as 180.
    comment: what opens and what closes a comment; ("", "") where the syntax has none.
    around: what stands around the line when written, "{}" being the line. A reader looks for the line alone.
    """

    template: str
    degrees: tuple[bool, ...]
    comment: tuple[str, str] = ("", "")
    around: str = "{}"

    @property
    def half_steps(self) -> Floats:
        """The most by which each number (n,) is rounded."""
        return np.array([0.5 * 10.0 ** -int(digits) for digits in _FIELD.findall(self.template)])

    def write(self, numbers: Floats, remarks: tuple[str, ...] = ()) -> str:
        """The text, with a comment line before it for each remark where the syntax has comments."""
        fields = iter(zip(numbers, self.degrees, strict=True))
        line = _FIELD.sub(lambda field: _printed(field.group(), *next(fields)), self.template)
        opening, closing = self.comment
        comments = [f"{opening}{remark}{closing}" for remark in remarks] if opening else []
        return "\n".join([*comments, self.around.replace("{}", line)]) + "\n"

    def read(self, text: str) -> Floats:
        """The numbers (n,) of the one line of this syntax in text, or PoseSyntaxError."""
        pattern = self._pattern()
        spoken = without_comments(text, self._comments())
        if self._whole_line and sum(bool(_DIGIT.search(line)) for line in spoken.splitlines()) > 1:
            raise syntax_error("holds more than one line with numbers", f"write one, like {self._example()}")
        return the_one(spoken, pattern, lambda lexer: self._numbers(lexer, pattern), self._example())

    def _numbers(self, lexer: Lexer, pattern: re.Pattern[str]) -> Floats:
        found = lexer.match(pattern)
        assert found is not None
        remedy = f"write one, like {self._example()}"
        return np.array([Lexer(number, lexer.line, lexer.column).number(remedy) for number in found.groups()])

    def _example(self) -> str:
        return _FIELD.sub("0.0", self.template).replace("\n", " / ")

    def _comments(self) -> re.Pattern[str]:
        opening, closing = (part.strip() for part in self.comment)
        if not opening:
            return re.compile(r"(?!)")
        return re.compile(re.escape(opening) + ("(?s:.*?)" + re.escape(closing) if closing else "[^\r\n]*"))

    def _pattern(self) -> re.Pattern[str]:
        """The template as a pattern: any case, any number in a field, blanks anywhere between its words."""
        literals = _FIELD.split(self.template)[::2]  # the odd ones are the digits of the fields
        parts = [r"\s*".join(map(re.escape, re.findall(r"\w+|[^\w\s]", literal))) for literal in literals]
        pattern = rf"\s*({NUMBER.pattern})\s*".join(parts).removesuffix(r"\s*") + _ENDS
        if self._whole_line:
            pattern = rf"^{pattern}$"
        elif not self.template[0].isalnum():
            pattern = _BEGINS + pattern
        return re.compile(pattern, re.IGNORECASE | re.MULTILINE)

    @property
    def _whole_line(self) -> bool:
        """A line that starts with a number has nothing that says where it starts: it must be alone."""
        return self.template.startswith("%")


def _printed(field: str, number: float, in_degrees: bool) -> str:
    """One number as printed: no negative zero, and 180 for -180 degrees."""
    text = field % number
    if float(text) == 0:
        return field % 0.0
    return field % 180.0 if in_degrees and float(text) == -180 else text
