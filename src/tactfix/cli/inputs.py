"""Options that belong together and that several commands take: how contacts are read, where the fixture stands, limits.

A command names such a group as one parameter, `touches: ContactInput`, and is decorated with `takes_groups`: typer then
sees the fields of the group as options of the command.
"""

import functools
import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from tactfix.cli import completion
from tactfix.cli.options import ContactsFormat, Features, Sigma, TipOffset, TipRadius, Units, vector
from tactfix.cli.output import note, tell
from tactfix.decimal_text import numbers_of
from tactfix.errors import UsageError
from tactfix.settings import FOR_LOGS
from tactfix.wording import did_you_mean

if TYPE_CHECKING:
    from tactfix.contacts import Unknown
    from tactfix.files.contact_file import ContactFile
    from tactfix.files.contact_options import ContactOptions, LogOptions
    from tactfix.fixture import Fixture
    from tactfix.geometry.arrays import Floats
    from tactfix.locate_result import LocateResult
    from tactfix.placement import Direction, Placement
    from tactfix.report.html_page import InputFile


def takes_groups(command: Callable[..., int]) -> Callable[..., int]:
    """The command with the fields of each parameter that is a group, a dataclass, as parameters of their own."""
    signature = inspect.signature(command, eval_str=True)
    groups: dict[str, Any] = {
        name: given.annotation for name, given in signature.parameters.items() if is_dataclass(given.annotation)
    }

    @functools.wraps(command)
    def run(**values: Any) -> int:
        for name, group in groups.items():
            values[name] = group(**{field.name: values.pop(field.name) for field in fields(group)})
        return command(**values)

    parameters: list[inspect.Parameter] = []
    for name, given in signature.parameters.items():
        if name in groups:
            parameters += inspect.signature(groups[name], eval_str=True).parameters.values()
        else:
            parameters.append(given)
    parameters = [each.replace(kind=inspect.Parameter.KEYWORD_ONLY) for each in parameters]
    run.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {each.name: each.annotation for each in parameters}
    return run


@dataclass(frozen=True, slots=True)
class ContactInput:
    """How the contacts of a contact file, or of the log of a machine, are read."""

    units: Units = None
    tip_radius: TipRadius = None
    sigma: Sigma = None
    contacts_format: ContactsFormat = "csv"
    features: Features = None
    tip_offset: TipOffset = None
    approach: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z",
            help="Approach for a machine log that has none, for all features, or feature:X,Y,Z;... each.",
        ),
    ] = None
    repeats: Annotated[
        str,
        typer.Option(
            metavar="all|last",
            help="Of consecutive touches of one place in a log: all, or the last.",
            autocompletion=completion.repeats,
        ),
    ] = "all"
    work_offset: Annotated[
        str | None,
        typer.Option(metavar="POSE", help="The frame that the machine reported in: a file, any pose format."),
    ] = None

    def options(self, unknown: "frozenset[Unknown]" = frozenset()) -> "ContactOptions":
        """What takes precedence over the contact file; unknown: what of the tip is to be found."""
        from tactfix.files.contact_options import ContactOptions

        return ContactOptions(self.units, self.tip_radius, self.sigma, unknown=unknown)

    def log_options(self) -> "LogOptions":
        """What a machine log cannot say itself, and the tip's offset."""
        from tactfix.files.contact_options import log_options

        offset = None if self.tip_offset is None else vector(self.tip_offset, "--tip-offset")
        return log_options(self.features, offset, self.approach, self.repeats, self.work_offset)

    def read(
        self, source: str, fixture: "Fixture", unknown: "frozenset[Unknown]" = frozenset(), *, quiet: bool
    ) -> "ContactFile":
        """The contacts in a file; what is passed over of a log is told unless quiet."""
        return read_contacts(
            source, self.contacts_format, fixture, self.options(unknown), self.log_options(), quiet=quiet
        )


def read_contacts(
    source: str | bytes,
    format_name: str,
    fixture: "Fixture",
    options: "ContactOptions",
    log_options: "LogOptions",
    *,
    quiet: bool,
) -> "ContactFile":
    """The contacts in source, a path or what was read of it; format_name as in --contacts-format."""
    if format_name == "csv":
        from tactfix.files.contact_file import read_contact_file

        if log_options.of_log:
            raise UsageError(FOR_LOGS)
        return read_contact_file(source, fixture, replace(options, tip_offset=log_options.tip_offset))
    from tactfix.files.logs.load import load_log

    read, notes = load_log(format_name, source, fixture, options, log_options)
    tell(notes, quiet=quiet)
    return read


@dataclass(frozen=True, slots=True)
class Gates:
    """The limits that a located pose must keep to, and the point at which they hold."""

    max_sigma: Annotated[
        float | None,
        typer.Option(metavar="S", min=0, help="Exit 1 where the worst sigma of the origin (or of --at) exceeds S."),
    ] = None
    max_rms: Annotated[
        float | None, typer.Option(metavar="R", min=0, help="Exit 1 where the rms of the residuals exceeds R.")
    ] = None
    at: Annotated[
        str | None, typer.Option(metavar="X,Y,Z", help="Tell sigma at this point of the fixture frame too.")
    ] = None

    @property
    def point(self) -> "Floats | None":
        """The point (3,) of the fixture frame; None for its origin."""
        import numpy as np

        return None if self.at is None else np.array(vector(self.at, "--at"))

    def exceeded(self, result: "LocateResult") -> list[str]:
        """What the result exceeds, in words; nothing unless it is located."""
        from tactfix.acceptance import exceeded_gates

        if result.status != "located":
            return []
        return exceeded_gates(result, self.point, self.max_sigma, self.max_rms)


@dataclass(frozen=True, slots=True)
class PlacementInput:
    """Where the fixture stands as far as it is known beforehand; each option replaces its part of the fixture file."""

    near: Annotated[
        str | None,
        typer.Option(
            metavar="POSE", help="Roughly where the fixture stands: a file, any pose format; beats placement."
        ),
    ] = None
    within: Annotated[
        str | None,
        typer.Option(metavar="T,R", help="How far from --near it can stand at most: fixture's units, degrees."),
    ] = None
    near_sigma: Annotated[
        str | None,
        typer.Option(
            metavar="T,R", help="--near is a measurement with this sigma a component: fixture's units, degrees."
        ),
    ] = None
    free: Annotated[
        str | None,
        typer.Option(
            metavar="x,y,rz",
            help="Only these may differ from --near: along and about base axes.",
            autocompletion=completion.free_directions,
        ),
    ] = None

    def placed(self, fixture: "Fixture", *, alone: bool = False, quiet: bool) -> "Fixture":
        """The fixture with this placement.

        alone: near is of use without the others. A pose of another fixture is told, unless quiet. Raises UsageError
        where they do not go together, FileError where the pose cannot be read.
        """
        if self.near is self.within is self.near_sigma is self.free is None:
            return fixture
        if self.within is not None and self.near_sigma is not None:
            raise UsageError("--within and --near-sigma do not go together: limits, or a measurement; leave one out")
        if self.near is None and fixture.placement is None:
            raise UsageError("--within, --near-sigma and --free say how far from a pose; give the pose with --near")
        known = fixture.placement if self.near is None else _near(self.near, fixture, quiet=quiet)
        assert known is not None
        if self.within is not None:
            known = replace(known, within=_translation_and_rotation(self.within, "--within"), sigma=None)
        if self.near_sigma is not None:
            known = replace(known, sigma=_translation_and_rotation(self.near_sigma, "--near-sigma"), within=None)
        if self.free is not None:
            known = replace(known, free=_directions(self.free))
        if not known.is_known and not alone:
            raise UsageError(
                "--near alone decides nothing; say how far with --within T,R, --near-sigma T,R or --free x,y,rz"
            )
        return replace(fixture, placement=known)


def given_options(*groups: Any) -> dict[str, str]:
    """The options of these groups that were given, by name, as a record names them."""
    values = {
        "--" + field.name.replace("_", "-"): getattr(group, field.name)
        for group in groups
        for field in fields(group)
        if getattr(group, field.name) != field.default
    }
    return {name: str(value) for name, value in values.items()}


def input_files(**paths: str) -> "list[InputFile]":
    """The files that a record names, by their role, as they are now."""
    from tactfix.files.reading import read_bytes
    from tactfix.report.html_page import InputFile

    return [InputFile(role, path, read_bytes(path)) for role, path in paths.items()]


def read_pose(path: str, fixture: "Fixture", *, quiet: bool) -> "Floats":
    """The pose (4, 4) of the fixture in a file, in the fixture's units, which are also those of a file without units.

    A pose of another fixture is noted, unless quiet. The file may name the fixture or the fixture's file.
    """
    from tactfix.files.pose_file import load_pose

    pose = load_pose(path, default_units=fixture.units).in_units(fixture.units)
    if pose.fixture not in ("", fixture.name) and Path(pose.fixture).stem != fixture.name:
        note(f"{path} is where {pose.fixture} stands, and this is {fixture.name}: is it the right pose?", quiet=quiet)
    return pose.base_from_fixture


def _near(path: str, fixture: "Fixture", *, quiet: bool) -> "Placement":
    """The placement with the pose of a file, all else as the fixture file has it."""
    from tactfix.placement import Placement

    near = read_pose(path, fixture, quiet=quiet)
    return Placement(near) if fixture.placement is None else replace(fixture.placement, near=near)


def _translation_and_rotation(text: str, option: str) -> tuple[float, float]:
    """'T,R' as a length and an angle (rad)."""
    numbers = numbers_of(text)
    translation, rotation = numbers if len(numbers) == 2 else (None, None)
    if translation is None or rotation is None:
        raise UsageError(f"{option} {text!r}: write a length in the fixture's units and degrees, such as 20,5")
    if min(translation, rotation) < 0:
        raise UsageError(f"{option} {text!r}: neither the length nor the angle is negative")
    if rotation > 180:
        raise UsageError(f"{option} {text!r}: no pose is turned by more than 180 degrees; 180 leaves the turn open")
    return translation, math.radians(rotation)


def _directions(text: str) -> "frozenset[Direction]":
    """'x,y,rz' as the directions that are free."""
    from tactfix.placement import DIRECTIONS

    names = [part.strip().lower() for part in text.split(",")]
    wrong = next((name for name in names if name not in DIRECTIONS), None)
    if wrong is not None:
        raise UsageError(f"--free {text!r}: {wrong!r} is no direction; {did_you_mean(wrong, DIRECTIONS)}")
    return frozenset(cast("Direction", name) for name in names)
