"""Options for a contact file or a machine log, and the settings that follow from options, file and fixture."""

import re
from dataclasses import replace
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from tactfix.contacts import Unknown
from tactfix.errors import UsageError
from tactfix.files.reading import composed
from tactfix.fixture import Probe
from tactfix.settings import Setting
from tactfix.units import LEAST_LENGTH, MOST_LENGTH, UNITS, factor, which_unit
from tactfix.values import frozen_value

if TYPE_CHECKING:
    from tactfix.pose_formats.pose import Pose


Vector: TypeAlias = tuple[float, float, float]


@frozen_value(eq=True)
class ContactOptions:
    """Options for a contact file. They take precedence over the file, and the file over the fixture's probe block.

    Parameters
    ----------
    units : {"mm", "m", "um", "in"}, optional
        The unit of all lengths in the contact file, and of tip_radius, sigma and tip_offset here.
    tip_radius : float, optional
        Radius of the probe tip.
    sigma : float, optional
        One standard deviation of a contact along the surface normal.
    tip_offset : tuple of three floats, optional
        The tip centre (3,) in the flange frame.
    unknown : frozenset of {"tip", "tip-radius"}
        What is estimated from the contacts, and need not be given.
    of_flange : bool
        Whether x, y, z are the origin of the flange (set by the file).

    Raises
    ------
    UsageError
        A value that is not valid in a file.

    Examples
    --------
    >>> tactfix.ContactOptions(units="in", sigma=0.0002).units
    'in'
    """

    units: str | None = None
    tip_radius: float | None = None
    sigma: float | None = None
    tip_offset: Vector | None = None
    unknown: frozenset[Unknown] = frozenset()
    of_flange: bool = False

    def __post_init__(self) -> None:
        if self.units is not None and self.units not in UNITS:
            raise UsageError(f"units is {self.units!r}; {which_unit(self.units)}")
        if self.tip_radius is not None and not 0 <= self.tip_radius <= MOST_LENGTH:
            raise UsageError(f"tip radius {self.tip_radius:g} is not a length; write 0 for points of the surface")
        if self.sigma is not None and not self.sigma > 0:
            raise UsageError(f"sigma {self.sigma:g} is not above zero; no probe is exact")
        if self.sigma is not None and not LEAST_LENGTH <= self.sigma <= MOST_LENGTH:
            raise UsageError(
                f"sigma {self.sigma:g} is no length; write the standard deviation of a contact, such as 0.005"
            )


@frozen_value(eq=True)
class Settings:
    """Resolved settings of a contact file: units of the file; tip radius, sigma and tip offset in target_units."""

    units: str
    target_units: str
    tip_radius: float | None
    sigma: float | None
    tip_offset: Vector | None = None

    @property
    def scale(self) -> float:
        """Factor from the file's unit to target_units."""
        return factor(self.units, self.target_units)


def settle(options: ContactOptions, header: ContactOptions, probe: Probe, fixture_units: str | None) -> Settings | None:
    """Options override the file's header, and the header the fixture's probe; None if the units are not given."""
    units = options.units or header.units or fixture_units
    if units is None:
        return None
    scale = factor(units, fixture_units or units)

    def first(option: float | None, in_file: float | None, in_fixture: float | None) -> float | None:
        value = in_file if option is None else option
        return in_fixture if value is None else value * scale

    def first_offset(option: Vector | None, in_file: Vector | None) -> Vector | None:
        value = in_file if option is None else option
        return probe.tip_offset if value is None else (value[0] * scale, value[1] * scale, value[2] * scale)

    return Settings(
        units,
        fixture_units or units,
        first(options.tip_radius, header.tip_radius, probe.tip_radius),
        first(options.sigma, header.sigma, probe.sigma),
        first_offset(options.tip_offset, header.tip_offset),
    )


EVERY: Final = ""
"""Key of an approach for all features."""
_APPROACH_REMEDY: Final = "write X,Y,Z such as 0,0,-1, or feature:X,Y,Z;feature:X,Y,Z"

Repeats: TypeAlias = Literal["all", "last"]


@frozen_value(eq=True)
class FeatureRun:
    """A run of count consecutive contacts on one feature."""

    feature: str
    count: int


@frozen_value(eq=True)
class WorkOffset:
    """Pose of the machine's reported frame in the frame wanted for the results.

    rows: base_from_reported (4 x 4) with lengths in units; units: None if its file does not give them.
    """

    rows: tuple[tuple[float, ...], ...]
    units: str | None

    def pose(self, units: str) -> "Pose":
        """The pose (4, 4) with lengths in units, which are also the default for a pose without a unit."""
        from tactfix.pose_formats.pose import Pose

        return Pose(np.array(self.rows), self.units or units).in_units(units)


@frozen_value(eq=True)
class LogOptions:
    """features: runs of contacts, in order. tip_offset (3,): tip centre in the frame of the poses, in the log's unit.
    approaches: by feature, or one under EVERY, in the reported frame, for contacts without an approach in the log.
    repeats: "last" keeps only the last of consecutive touches of one point.
    """

    features: tuple[FeatureRun, ...] = ()
    tip_offset: Vector | None = None
    approaches: tuple[tuple[str, Vector], ...] = ()
    repeats: Repeats = "all"
    work_offset: WorkOffset | None = None

    @property
    def of_log(self) -> bool:
        """Whether any option is given that a contact file does not need."""
        return replace(self, tip_offset=None) != LogOptions()


def log_options(
    features: str | None = None,
    tip_offset: Vector | None = None,
    approach: str | None = None,
    repeats: str = "all",
    work_offset: str | None = None,
) -> LogOptions:
    """Parse the options; UsageError for an invalid one, FileError for the file of the work offset."""
    return LogOptions(
        features=() if features is None else parse_features(features),
        tip_offset=tip_offset,
        approaches=() if approach is None else parse_approaches(approach),
        repeats=parse_repeats(repeats),
        work_offset=None if work_offset is None else read_work_offset(work_offset),
    )


def parse_features(text: str) -> tuple[FeatureRun, ...]:
    """Parse 'bar:5,ball:3': five contacts on bar, then three on ball; UsageError for anything else."""
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
    """Parse '0,0,-1' for all features, or 'top:0,0,-1;front:0,1,0' by name; UsageError for anything else."""
    # Imported late: compiling its patterns takes longer than reading a contact file, which needs none of this.
    from tactfix.lexer import Lexer, TextError

    approaches: dict[str, Vector] = {}
    for part in composed(text).split(";"):
        name, colon, numbers = part.rpartition(":")
        lexer = Lexer(numbers)
        try:
            x, y, z = lexer.numbers(3, _APPROACH_REMEDY)
            lexer.end(_APPROACH_REMEDY)
        except TextError as error:
            raise UsageError(Setting.APPROACH.to(text) + f": {error.problem.what}; {_APPROACH_REMEDY}") from None
        if not (x or y or z) or name.strip() in approaches or (colon and not name.strip()):
            raise UsageError(
                Setting.APPROACH.to(text) + f": {part.strip()!r} is no direction, or a second one; {_APPROACH_REMEDY}"
            )
        approaches[name.strip()] = x, y, z
    if EVERY in approaches and len(approaches) > 1:
        raise UsageError(Setting.APPROACH.to(text) + f" names some features and not others; {_APPROACH_REMEDY}")
    return tuple(approaches.items())


def parse_repeats(text: str) -> Repeats:
    """Parse 'all' or 'last'."""
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
