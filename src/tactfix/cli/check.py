"""tactfix check."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tactfix.cli.exits import Exit, exit_of_status
from tactfix.cli.inputs import ContactInput, takes_groups
from tactfix.cli.options import AsJson, ContactsPath, FixturePath, Output, Quiet, ScaleSigma
from tactfix.cli.output import emit, emit_lines, print_notes, wants_json
from tactfix.errors import FileError

if TYPE_CHECKING:
    from tactfix.monitoring.check import CheckResult


@takes_groups
def command(
    fixture_path: FixturePath,
    contacts: ContactsPath,
    *,
    reference: Annotated[
        str,
        typer.Option(
            metavar="POSE",
            help="The reference pose: JSON of locate, or any pose; without a unit, in the fixture's.",
            show_default=False,
        ),
    ],
    history: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Append the check to FILE (JSON lines), and report a drift over all checks in it."
        ),
    ] = None,
    limit_translation: Annotated[
        float | None,
        typer.Option(metavar="T", min=0, help="Has moved if the origin moved more than T, in the fixture's unit."),
    ] = None,
    limit_rotation: Annotated[
        float | None, typer.Option(metavar="DEG", min=0, help="Has moved if the fixture turned more than DEG degrees.")
    ] = None,
    as_json: AsJson = False,
    output: Output = None,
    touches: ContactInput,
    scale_sigma: ScaleSigma = False,
    quiet: Quiet = False,
) -> int:
    """Check whether a fixture has moved since it was located.

    Without limits it has moved if noise alone gives such a movement less than once in a thousand checks.

    Exit status: 0 has not moved, 1 has moved, 3 a reference of another fixture, 4 to 6 not located, as locate.
    """
    import numpy as np

    from tactfix.files.check_history import append_history, read_history
    from tactfix.files.fixture_file import load_fixture
    from tactfix.files.pose_file import load_pose
    from tactfix.monitoring.check import check
    from tactfix.pose_formats.comparison import Limits

    fixture = load_fixture(fixture_path)
    before = load_pose(reference)
    records = () if history is None else read_history(history)
    read = touches.read(contacts, fixture, quiet=quiet)
    limits = Limits(limit_translation, None if limit_rotation is None else float(np.deg2rad(limit_rotation)))
    found = check(fixture, read.contacts, before, limits=limits, history=records, scale_sigma=scale_sigma)
    is_recorded = True
    if history is not None and found.record is not None:
        try:
            append_history(history, found.record)
        except FileError as error:  # the verdict is printed nevertheless
            is_recorded = False
            print_notes(error.on_command_line.splitlines())
    _emit(found, output, as_json=as_json)
    print_notes(found.warnings, quiet=quiet)
    if not is_recorded:
        return Exit.FILE
    if found.has_moved is None:
        return exit_of_status(found.result.status)
    return Exit.NOT_ACCEPTABLE if found.has_moved else Exit.DONE


def _emit(found: "CheckResult", output: Path | None, *, as_json: bool) -> None:
    """Write the JSON or the verdict; if the fixture is not located, the reason goes to standard error."""
    from tactfix.report.movement_report import check_lines

    is_json = wants_json(output, as_json=as_json)
    if is_json:
        emit(found.to_json(), output)
    if found.has_moved is None:
        print_notes(check_lines(found))
    elif not is_json:
        emit_lines(check_lines(found), output)
        print_notes(found.exceeded.values())
