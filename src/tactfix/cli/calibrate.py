"""tactfix calibrate."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tactfix.cli import completion
from tactfix.cli.exits import Exit, exit_of_status
from tactfix.cli.options import AsJson, Output, Quiet, Verbose
from tactfix.cli.output import emit, note, tell, wants_summary
from tactfix.cli.streams import standard_error

if TYPE_CHECKING:
    from tactfix.calibration.result import Calibration
    from tactfix.files.cell_file import CellFile


def command(
    cell_path: Annotated[Path, typer.Argument(metavar="CELL", help="Cell file (YAML).", show_default=False)],
    touches_path: Annotated[
        str, typer.Argument(metavar="TOUCHES", help="Touch file (CSV); - is standard input.", show_default=False)
    ],
    hold_out: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PLACE",
            help="Keep this place out of all of it and tell its residuals; repeatable.",
            autocompletion=completion.places,
        ),
    ] = None,
    unchecked: Annotated[
        bool, typer.Option("--unchecked", help="Let touches at one place do, which nothing can check.")
    ] = False,
    output: Output = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Calibrate a robot from touches on fixtures that stand at unknown places.

    Prints the corrected URDF or Denavit-Hartenberg rows. How much of what the touches say is believed is chosen by
    leaving out one place after the other.

    Exit status: 0 calibrated, 4 underdetermined (no robot is written), 6 inconsistent.
    """
    from tactfix.calibration.calibrate import calibrate
    from tactfix.files.cell_file import load_cell
    from tactfix.files.robot_file import check_output
    from tactfix.files.touch_file import load_touches

    file = load_cell(cell_path)
    check_output(file, output)
    touches = load_touches(touches_path, file.cell, file.sigma)
    result = calibrate(file.cell, touches, tuple(hold_out or ()), unchecked)
    _write(file, result, output, as_json=as_json)
    tell(f"{result.status}: {reason}" for reason in result.reasons if result.status != "calibrated")
    tell(result.warnings, quiet=quiet)
    if wants_summary(quiet=quiet, verbose=verbose):
        from tactfix.report.calibration_summary import print_calibration

        print_calibration(result, standard_error())
    return Exit.DONE if result.status == "calibrated" else exit_of_status(result.status)


def _write(file: "CellFile", result: "Calibration", output: Path | None, *, as_json: bool) -> None:
    """The robot to standard output or to output; with --json the JSON to standard output, and the robot to output."""
    from tactfix.files.robot_file import robot_text
    from tactfix.report.calibration_json import calibration_json
    from tactfix.report.json_report import text_of

    to_json = output is not None and output.suffix.lower() == ".json"
    if as_json:
        emit(text_of(calibration_json(result)))
    if to_json:
        emit(text_of(calibration_json(result)), output)
    elif result.is_written and (output is not None or not as_json):
        emit(robot_text(file, result), output)
    elif output is not None:
        note(f"{output} is not written: the robot is {result.status}")
