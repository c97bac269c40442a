"""Definition of a dialect: a name, and the conversions between a pose and its text.

A line of numbers in a controller's literal syntax is written from a template and read back by the same template.
"""

import re
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from tactfix.decimal_text import NUMBER
from tactfix.formats import PoseFormat
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import homogeneous
from tactfix.lexer import Lexer
from tactfix.pose_formats.literals import the_one, without_comments
from tactfix.pose_formats.orientation import LOCK_SLACK, EulerAngles, Orientation
from tactfix.pose_formats.pose import Pose, syntax_error
from tactfix.settings import Setting
from tactfix.values import frozen_value

_FIELD = re.compile(r"%\+?\d*\.(\d+)f")
_BEGINS = r"(?<![0-9.({\[+-])(?<![0-9.({\[+-] )"
_DIGIT = re.compile(r"[0-9]")
_ENDS = r"(?![A-Za-z0-9_.]|,[0-9])"


@frozen_value(eq=True)
class NumberSyntax:
    """Numbers in literal text: template has one printf field (%.6f) for each number.

    degrees: which numbers are angles in degrees; -180 is written as 180.
    comment: opening and closing mark of a comment; ("", "") if the syntax has none.
    around: text around the line, which is "{}". It is written, but not needed to read the line.
    """

    template: str
    degrees: tuple[bool, ...]
    comment: tuple[str, str] = ("", "")
    around: str = "{}"

    @property
    def half_steps(self) -> Floats:
        """Largest rounding error of each number (n,)."""
        return np.array([0.5 * 10.0 ** -int(digits) for digits in _FIELD.findall(self.template)])

    def write(self, numbers: Floats, remarks: tuple[str, ...] = ()) -> str:
        """The text, after one comment line for each remark, if the syntax has comments."""
        fields = iter(zip(numbers, self.degrees, strict=True))
        line = _FIELD.sub(lambda field: _printed(field.group(), *next(fields)), self.template)
        opening, closing = self.comment
        comments = [f"{opening}{remark}{closing}" for remark in remarks] if opening else []
        return "\n".join([*comments, self.around.replace("{}", line)]) + "\n"

    def read(self, text: str) -> Floats:
        """The numbers (n,) of the one line of this syntax in text, or PoseSyntaxError."""
        pattern = self._pattern()
        content = without_comments(text, self._comments())
        if self._whole_line and sum(bool(_DIGIT.search(line)) for line in content.splitlines()) > 1:
            raise syntax_error("contains more than one line with numbers", f"write one, like {self._example()}")
        return the_one(content, pattern, lambda lexer: self._numbers(lexer, pattern), self._example())

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
        literals = _FIELD.split(self.template)[::2]  # the others are the digits of the fields
        parts = [r"\s*".join(map(re.escape, re.findall(r"\w+|[^\w\s]", literal))) for literal in literals]
        pattern = rf"\s*({NUMBER.pattern})\s*".join(parts).removesuffix(r"\s*") + _ENDS
        if self._whole_line:
            pattern = rf"^{pattern}$"
        elif not self.template[0].isalnum():
            pattern = _BEGINS + pattern
        return re.compile(pattern, re.IGNORECASE | re.MULTILINE)

    @property
    def _whole_line(self) -> bool:
        """Whether the syntax begins with a number, not a keyword or bracket; then it must be the whole line."""
        return self.template.startswith("%")


def _printed(field: str, number: float, in_degrees: bool) -> str:
    """One number as printed: no negative zero, and 180 for -180 degrees."""
    text = field % number
    if float(text) == 0:
        return field % 0.0
    return field % 180.0 if in_degrees and float(text) == -180 else text


@frozen_value(eq=True)
class Numbers:
    """The numbers of a dialect: x, y, z in units, then the orientation in angle_unit; labels are the vendor's names."""

    labels: tuple[str, ...]
    units: str
    orientation: Orientation
    angle_unit: str

    def of(self, base_from_fixture: Floats) -> Floats:
        """Numbers (n,) of a pose (4, 4) whose lengths are in units."""
        turned = self.orientation.numbers(base_from_fixture[:3, :3])
        return np.concatenate([base_from_fixture[:3, 3], turned]) + 0.0

    def pose(self, numbers: Floats) -> Floats:
        """The pose (4, 4), lengths in units, of numbers (n,)."""
        return homogeneous(self.orientation.rotation(numbers[3:]), numbers[:3])


@frozen_value(eq=True)
class Dialect:
    """A text format of a pose.

    write: pose in units (any unit if units is None) and remarks -> text; read: text -> pose.
    numbers: the numbers of the dialect, whose sigmas are in the remarks; None if the text is the matrix itself.
    most_rounding: largest rounding of the text (length in units, rad); (0, 0) if it has all digits.
    comments: whether the text can have comments. has_units: whether text or dialect determine the unit.
    """

    name: PoseFormat
    title: str
    write: Callable[[Pose, tuple[str, ...]], str | bytes]
    read: Callable[[str | bytes], Pose]
    units: str | None = None
    numbers: Numbers | None = None
    most_rounding: tuple[float, float] = (0.0, 0.0)
    comments: bool = False
    has_units: bool = True


NumberReader: TypeAlias = Callable[[str], tuple[Floats, str | None]]
"""Text -> the numbers (n,) of its one pose, and the unit of their lengths, None for that of the dialect."""


def numeric(
    name: PoseFormat, title: str, numbers: Numbers, syntax: NumberSyntax, reader: NumberReader | None = None
) -> Dialect:
    """The dialect that writes numbers in syntax, and reads them with reader or, by default, in the same syntax."""

    def write(pose: Pose, remarks: tuple[str, ...]) -> str:
        return syntax.write(numbers.of(pose.base_from_fixture), remarks)

    def read(text: str | bytes) -> Pose:
        found, units = reader(decoded(text)) if reader else (syntax.read(decoded(text)), None)
        pose = Pose(numbers.pose(found), units or numbers.units)
        return pose.in_units(numbers.units)

    orientation, half_steps = numbers.orientation, syntax.half_steps
    slack = LOCK_SLACK if isinstance(orientation, EulerAngles) else 0.0
    rounding = (float(half_steps[:3].max()), orientation.radians * float(half_steps[3:].sum()) + slack)
    return Dialect(name, title, write, read, numbers.units, numbers, rounding, bool(syntax.comment[0]))


def decoded(text: str | bytes) -> str:
    """Text unchanged; bytes decoded from UTF-8 with or without byte order mark."""
    if isinstance(text, str):
        return text
    try:
        return text.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise syntax_error("is not a text (UTF-8)", "name its format with " + Setting.DIALECT.word) from error
