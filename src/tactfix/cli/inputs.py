"""Groups of options that several commands take: how contacts are read, the fixture's placement, limits.

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
from tactfix.cli.output import note, print_notes
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
            help="Approach for a machine log that has none: for all features, or feature:X,Y,Z;... for each.",
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
        typer.Option(metavar="POSE", help="The frame in which the machine reported: a file, any pose format."),
    ] = None

    def options(self, unknown: "frozenset[Unknown]" = frozenset()) -> "ContactOptions":
        """What takes precedence over the contact file; unknown: what of the tip is to be determined."""
        from tactfix.files.contact_options import ContactOptions

        return ContactOptions(self.units, self.tip_radius, self.sigma, unknown=unknown)

    def log_options(self) -> "LogOptions":
        """What a machine log does not contain, and the tip's offset."""
        from tactfix.files.contact_options import log_options

        offset = None if self.tip_offset is None else vector(self.tip_offset, "--tip-offset")
        return log_options(self.features, offset, self.approach, self.repeats, self.work_offset)

    def read(
        self, source: str, fixture: "Fixture", unknown: "frozenset[Unknown]" = frozenset(), *, quiet: bool
    ) -> "ContactFile":
        """The contacts in a file; skipped lines of a log are reported unless quiet."""
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
    print_notes(notes, quiet=quiet)
    return read


@dataclass(frozen=True, slots=True)
class Gates:
    """The limits that a located pose must satisfy, and the point at which they apply."""

    max_sigma: Annotated[
        float | None,
        typer.Option(metavar="S", min=0, help="Exit 1 if the worst sigma of the origin (or of --at) exceeds S."),
    ] = None
    max_rms: Annotated[
        float | None, typer.Option(metavar="R", min=0, help="Exit 1 if the rms of the residuals exceeds R.")
    ] = None
    at: Annotated[
        str | None, typer.Option(metavar="X,Y,Z", help="Also report sigma at this point of the fixture frame.")
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
    """What is known beforehand of the fixture's pose; each option replaces its part of the fixture file."""

    near: Annotated[
        str | None,
        typer.Option(
            metavar="POSE", help="Approximate pose of the fixture: a file, any pose format; replaces placement."
        ),
    ] = None
    within: Annotated[
        str | None,
        typer.Option(metavar="T,R", help="Largest distance and rotation from --near: fixture's units, degrees."),
    ] = None
    near_sigma: Annotated[
        str | None,
        typer.Option(
            metavar="T,R", help="--near is a measurement with this sigma per component: fixture's units, degrees."
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

        alone: near is of use without the others. A pose of another fixture is reported, unless quiet. Raises UsageError
        if they cannot be combined, FileError if the pose cannot be read.
        """
        if self.near is self.within is self.near_sigma is self.free is None:
            return fixture
        if self.within is not None and self.near_sigma is not None:
            raise UsageError("--within and --near-sigma cannot be combined: limits, or a measurement; leave one out")
        if self.near is None and fixture.placement is None:
            raise UsageError("--within, --near-sigma and --free are relative to a pose; give the pose with --near")
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
                "--near alone has no effect; limit the deviation with --within T,R, --near-sigma T,R or --free x,y,rz"
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
        note(f"{path} is a pose of {pose.fixture}, and this is {fixture.name}: is it the right pose?", quiet=quiet)
    return pose.base_from_fixture


def _near(path: str, fixture: "Fixture", *, quiet: bool) -> "Placement":
    """The placement with the pose of a file, and everything else from the fixture file."""
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
        raise UsageError(f"{option} {text!r}: no rotation exceeds 180 degrees; 180 means no limit")
    return translation, math.radians(rotation)


def _directions(text: str) -> "frozenset[Direction]":
    """'x,y,rz' as the directions that are free."""
    from tactfix.placement import DIRECTIONS

    names = [part.strip().lower() for part in text.split(",")]
    wrong = next((name for name in names if name not in DIRECTIONS), None)
    if wrong is not None:
        raise UsageError(f"--free {text!r}: {wrong!r} is not a direction; {did_you_mean(wrong, DIRECTIONS)}")
    return frozenset(cast("Direction", name) for name in names)
