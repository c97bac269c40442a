"""The inputs that a command line names: contacts, from a contact file or the log of a machine, and what options say of
where the fixture stands, which takes precedence over the placement of the fixture file.
"""

import math
from dataclasses import replace
from typing import cast

from tactfix.cli.output import note
from tactfix.decimal_text import numbers_of
from tactfix.errors import UsageError
from tactfix.files.contact_file import ContactFile, read_contact_file
from tactfix.files.contact_options import ContactOptions, LogOptions
from tactfix.fixture import Fixture
from tactfix.placement import DIRECTIONS, Direction, Placement
from tactfix.settings import FOR_LOGS
from tactfix.wording import did_you_mean


def read_contacts(
    source: str | bytes,
    format_name: str,
    fixture: Fixture,
    options: ContactOptions,
    log_options: LogOptions,
    *,
    quiet: bool,
) -> ContactFile:
    """The contacts in source, a path or what was read of it; format_name as in --contacts-format."""
    if format_name == "csv":
        refuse_log_options(log_options)
        return read_contact_file(source, fixture, replace(options, tip_offset=log_options.tip_offset))
    from tactfix.files.logs.load import load_log

    read, notes = load_log(format_name, source, fixture, options, log_options)
    for line in notes:
        note(line, quiet=quiet)
    return read


def refuse_log_options(log_options: LogOptions) -> None:
    """A contact file says itself what these options say of a machine log."""
    if log_options.of_log:
        raise UsageError(FOR_LOGS)


def placed(
    fixture: Fixture,
    near: str | None,
    within: str | None,
    near_sigma: str | None,
    free: str | None,
    *,
    alone: bool = False,
) -> Fixture:
    """The fixture with what --near, --within, --near-sigma and --free say; each replaces its part of the file's.

    alone: near is of use without the others. Raises UsageError where they do not go together, FileError where the pose
    cannot be read.
    """
    if near is within is near_sigma is free is None:
        return fixture
    if within is not None and near_sigma is not None:
        raise UsageError("--within and --near-sigma do not go together: limits, or a measurement; leave one out")
    if near is None and fixture.placement is None:
        raise UsageError("--within, --near-sigma and --free say how far from a pose; give the pose with --near")
    said = fixture.placement if near is None else _near(near, fixture)
    assert said is not None
    if within is not None:
        said = replace(said, within=_translation_and_rotation(within, "--within"), sigma=None)
    if near_sigma is not None:
        said = replace(said, sigma=_translation_and_rotation(near_sigma, "--near-sigma"), within=None)
    if free is not None:
        said = replace(said, free=_directions(free))
    if not said.is_known and not alone:
        raise UsageError(
            "--near alone decides nothing; say how far with --within T,R, --near-sigma T,R or --free x,y,rz"
        )
    return replace(fixture, placement=said)


def _near(path: str, fixture: Fixture) -> Placement:
    """The placement with the pose of a file, all else as the fixture file has it."""
    from tactfix.files.pose_file import load_pose

    pose = load_pose(path, default_units=fixture.units).in_units(fixture.units).base_from_fixture
    return Placement(pose) if fixture.placement is None else replace(fixture.placement, near=pose)


def _translation_and_rotation(text: str, option: str) -> tuple[float, float]:
    """'T,R' as a length and an angle (rad)."""
    numbers = numbers_of(text)
    translation, rotation = numbers if len(numbers) == 2 else (None, None)
    if translation is None or rotation is None or translation < 0 or not 0 <= rotation <= 180:
        raise UsageError(f"{option} {text!r}: write a length in the fixture's units and degrees, such as 20,5")
    return translation, math.radians(rotation)


def _directions(text: str) -> frozenset[Direction]:
    """'x,y,rz' as the directions that are free."""
    names = [part.strip().lower() for part in text.split(",")]
    wrong = next((name for name in names if name not in DIRECTIONS), None)
    if wrong is not None:
        raise UsageError(f"--free {text!r}: {wrong!r} is no direction; {did_you_mean(wrong, DIRECTIONS)}")
    return frozenset(cast(Direction, name) for name in names)
