"""What a dialect is: a name, and the two ways between a pose and its text."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from tactfix.formats import PoseFormat
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import homogeneous
from tactfix.pose_formats.number_syntax import NumberSyntax
from tactfix.pose_formats.orientation import LOCK_SLACK, EulerAngles, Orientation
from tactfix.pose_formats.pose import Pose, syntax_error
from tactfix.settings import Setting
from tactfix.values import frozen_value


@frozen_value(eq=True)
class Numbers:
    """The numbers of a dialect: x, y, z in units, then those of the orientation; labels are the vendor's names."""

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
    """One way to write a pose.

    write: pose in units (in its own where units is None) and remarks -> text; read: text -> pose.
    numbers: the dialect's own numbers, whose sigmas the remarks tell; None where the text is the matrix itself.
    most_rounding: by how much (length in units, rad) a text may differ from its pose; (0, 0) where all digits stand.
    comments: whether remarks find a place in the text. has_units: whether the text says, or the dialect fixes, units.
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
"""Text -> the numbers (n,) of its one pose, and the unit of their lengths where the text says another than usual."""


def numeric(
    name: PoseFormat, title: str, numbers: Numbers, syntax: NumberSyntax, reader: NumberReader | None = None
) -> Dialect:
    """The dialect that writes numbers in syntax, and reads them with reader, without one by the same syntax."""

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
    """Text as it came, or from UTF-8 with or without byte order mark."""
    if isinstance(text, str):
        return text
    try:
        return text.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise syntax_error("is not a text (UTF-8)", "name its format with " + Setting.DIALECT.word) from error
