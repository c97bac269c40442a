"""What a caller says about a machine log that the log itself cannot say."""

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from tactfix.errors import UsageError
from tactfix.files.contact_options import Vector
from tactfix.files.reading import composed
from tactfix.settings import Setting
from tactfix.values import frozen_value

if TYPE_CHECKING:
    from tactfix.pose_formats.pose import Pose

EVERY: Final = ""
"""The name under which an approach of all features stands."""
_APPROACH_REMEDY: Final = "write X,Y,Z such as 0,0,-1, or feature:X,Y,Z;feature:X,Y,Z"

Repeats: TypeAlias = Literal["all", "last"]


@frozen_value(eq=True)
class FeatureRun:
    """count contacts in a row on one feature."""

    feature: str
    count: int


@frozen_value(eq=True)
class WorkOffset:
    """The frame that the machine reported in, in the frame that the results shall stand in.

    rows: base_from_reported (4 x 4) with lengths in units; units None where the file of the pose does not say.
    """

    rows: tuple[tuple[float, ...], ...]
    units: str | None

    def pose(self, units: str) -> "Pose":
        """The pose with lengths in units, which stand in where none are said."""
        from tactfix.pose_formats.pose import Pose

        return Pose(np.array(self.rows), self.units or units).in_units(units)


@frozen_value(eq=True)
class LogOptions:
    """features: which contacts are on which, in order. tip_offset: the tip's centre in the frame of the poses, in the
    log's unit. approaches: by feature, or one under EVERY, for contacts whose approach the log does not tell, in the
    frame that the machine reports in. repeats: whether the last of consecutive touches of one place stands for all.
    """

    features: tuple[FeatureRun, ...] = ()
    tip_offset: Vector | None = None
    approaches: tuple[tuple[str, Vector], ...] = ()
    repeats: Repeats = "all"
    work_offset: WorkOffset | None = None

    @property
    def of_log(self) -> bool:
        """Whether anything is said that a contact file says itself."""
        return replace(self, tip_offset=None) != LogOptions()


def log_options(
    features: str | None = None,
    tip_offset: Vector | None = None,
    approach: str | None = None,
    repeats: str = "all",
    work_offset: str | None = None,
) -> LogOptions:
    """The options from their texts; UsageError for what none of them can be, FileError for a work offset's file."""
    return LogOptions(
        features=() if features is None else parse_features(features),
        tip_offset=tip_offset,
        approaches=() if approach is None else parse_approaches(approach),
        repeats=parse_repeats(repeats),
        work_offset=None if work_offset is None else read_work_offset(work_offset),
    )


def parse_features(text: str) -> tuple[FeatureRun, ...]:
    """'bar:5,ball:3' as five contacts on bar, then three on ball; UsageError for anything else."""
    runs = []
    for part in composed(text).split(","):
        match = re.fullmatch(r"\s*(.+?)\s*:\s*([0-9]{1,9})\s*", part)
        if match is None or int(match.group(2)) == 0:
            raise UsageError(
                Setting.FEATURES.word + f" has {part.strip()[:60]!r}, not NAME:COUNT; write bar:5,ball:3, in order"
            )
        runs.append(FeatureRun(match.group(1), int(match.group(2))))
    return tuple(runs)


def parse_approaches(text: str) -> tuple[tuple[str, Vector], ...]:
    """'0,0,-1' for all features, or 'top:0,0,-1;front:0,1,0', by name; UsageError for anything else."""
    # Its patterns take longer to compile than a contact file to read, which says its approaches itself.
    from tactfix.lexer import Lexer, TextError

    said: dict[str, Vector] = {}
    for part in composed(text).split(";"):
        name, colon, numbers = part.rpartition(":")
        lexer = Lexer(numbers)
        try:
            x, y, z = lexer.numbers(3, _APPROACH_REMEDY)
            lexer.end(_APPROACH_REMEDY)
        except TextError as error:
            raise UsageError(Setting.APPROACH.to(text) + f": {error.problem.what}; {_APPROACH_REMEDY}") from None
        if not (x or y or z) or name.strip() in said or (colon and not name.strip()):
            raise UsageError(
                Setting.APPROACH.to(text) + f": {part.strip()!r} is no direction, or a second one; {_APPROACH_REMEDY}"
            )
        said[name.strip()] = x, y, z
    if EVERY in said and len(said) > 1:
        raise UsageError(Setting.APPROACH.to(text) + f" names some features and not others; {_APPROACH_REMEDY}")
    return tuple(said.items())


def parse_repeats(text: str) -> Repeats:
    """'all' or 'last'."""
    if text == "last":
        return "last"
    if text == "all":
        return "all"
    raise UsageError(Setting.REPEATS.to(text) + " is not known; write all or last")


def read_work_offset(path: str) -> WorkOffset:
    """The pose in a file, in any pose format."""
    from tactfix.files.pose_file import load_pose

    pose = load_pose(path)
    return WorkOffset(tuple(map(tuple, pose.base_from_fixture.tolist())), pose.units)
