"""tactfix convert."""

from typing import Annotated

import typer

from tactfix.cli import completion
from tactfix.cli.options import Output, Quiet
from tactfix.cli.output import emit, print_notes
from tactfix.errors import UsageError
from tactfix.formats import LEVER_ARM_MM, POSE_FORMATS, SUFFIXES

_DIALECT_NAMES = ", ".join(POSE_FORMATS)
"""As --help and error messages list them."""


def command(
    pose: Annotated[
        str,
        typer.Argument(metavar="POSE", help="Output of locate, or a pose in any dialect; - is standard input."),
    ],
    to: Annotated[
        str | None,
        typer.Option(
            "--to",
            metavar="NAME",
            help=f"The dialect to write: {_DIALECT_NAMES}.",
            show_default=False,
            autocompletion=completion.pose_formats,
        ),
    ] = None,
    from_: Annotated[
        str | None,
        typer.Option(
            "--from",
            metavar="NAME",
            help="The dialect of POSE; by default recognized by suffix or content.",
            autocompletion=completion.pose_formats,
        ),
    ] = None,
    units: Annotated[
        str | None,
        typer.Option(
            metavar="U",
            help="Unit of POSE if its file gives none: mm, m, um or in.",
            autocompletion=completion.units,
        ),
    ] = None,
    inverse: Annotated[
        bool,
        typer.Option("--inverse", help="Invert POSE first: base in the fixture frame instead of the fixture in base."),
    ] = False,
    on: Annotated[
        str | None,
        typer.Option(
            "--on", metavar="POSE", help="Compose POSE with this one, the pose of the frame in which POSE is given."
        ),
    ] = None,
    lever_arm: Annotated[
        float,
        typer.Option(
            metavar="MM", min=0, help="Distance from the fixture's origin at which rounding is judged, in mm."
        ),
    ] = LEVER_ARM_MM,
    force: Annotated[
        bool, typer.Option("--force", help="Write it although it loses more than a tenth of sigma, or a tilt.")
    ] = False,
    output: Output = None,
    quiet: Quiet = False,
) -> int:
    """Write a pose in the format of a controller, a machine tool or ROS.

    Every text is read back and compared before it is written; rounding is reported on standard error, and refused if it
    exceeds a tenth of the pose's own sigma (exit 1).
    """
    from tactfix.files.pose_file import load_pose
    from tactfix.pose_formats import find_dialect
    from tactfix.pose_formats.convert import write_pose
    from tactfix.pose_formats.pose import composed, inverted

    name = find_dialect(_wanted(to, None if output is None else output.suffix.lower())).name
    given = load_pose(pose, units=units, dialect=from_)
    given = inverted(given) if inverse else given
    if on is not None:
        given = composed(load_pose(on, default_units=units), given)
    written = write_pose(name, given, force=force, lever_arm_mm=lever_arm)
    emit(written.text, output)
    print_notes(written.notes, quiet=quiet)
    return 0


def _wanted(to: str | None, suffix: str | None) -> str:
    """The dialect that --to names, else that of the output's suffix."""
    if to is not None:
        return to
    if suffix is None or suffix not in SUFFIXES:
        raise UsageError(
            f"which dialect? give --to {_DIALECT_NAMES}, or an --output that ends with {', '.join(SUFFIXES)}"
        )
    return SUFFIXES[suffix]
