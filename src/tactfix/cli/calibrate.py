"""tactfix calibrate."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

from tactfix.cli import completion
from tactfix.cli.exits import Exit, exit_of_status
from tactfix.cli.inputs import input_files
from tactfix.cli.options import AsJson, Output, Quiet, Verbose
from tactfix.cli.output import emit, note, print_notes, standard_error, wants_json, wants_summary
from tactfix.errors import UsageError

if TYPE_CHECKING:
    from tactfix.calibration.result import Calibration
    from tactfix.files.cell_file import CellFile

MOST_ADDED: Final = 1000
"""Touches that --plan adds at most, more than anybody makes."""


def command(
    cell_path: Annotated[Path, typer.Argument(metavar="CELL", help="Cell file (YAML).", show_default=False)],
    touches_path: Annotated[
        str | None,
        typer.Argument(
            metavar="TOUCHES",
            help="Touch file (CSV); - is standard input. With --plan: touches planned, or none.",
            show_default=False,
        ),
    ] = None,
    hold_out: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PLACE",
            help="Leave this place out of the calibration and report its residuals; repeatable.",
            autocompletion=completion.places,
        ),
    ] = None,
    unchecked: Annotated[
        bool,
        typer.Option("--unchecked", help="Accept touches at one place, although nothing can then check the result."),
    ] = False,
    tip_format: Annotated[
        str | None,
        typer.Option(
            "--tip-format",
            metavar="F",
            help="Print the tip in its flange in this pose format instead of the robot.",
            autocompletion=completion.pose_formats,
        ),
    ] = None,
    plan: Annotated[
        int | None,
        typer.Option(
            "--plan",
            metavar="N",
            min=0,
            max=MOST_ADDED,
            help="Before touching: report what TOUCHES would determine, and print N touches to add.",
        ),
    ] = None,
    criterion: Annotated[
        Literal["worst", "d"],
        typer.Option(help="With --plan: the worst sigma of the tip over the joint ranges, or D-optimal."),
    ] = "worst",
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="With --plan: one seed gives one plan.")] = 0,
    output: Output = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Calibrate a robot from touches on fixtures at unknown places.

    Prints the corrected URDF or Denavit-Hartenberg rows; --output writes them, or the JSON (.json) or a report (.html).
    The factor on the prior is chosen by leaving out one place after the other.

    --plan reports which parameters planned touches would determine and prints touches to add, as a touch file. It needs
    approximate poses of the places: from their placement in the cell file, or from touches planned there.

    Exit status: 0 calibrated, 4 underdetermined (no robot is written), 6 inconsistent.
    """
    from tactfix.calibration.calibrate import calibrate
    from tactfix.files.cell_file import load_cell
    from tactfix.files.robot_file import check_output
    from tactfix.files.touch_file import load_touches

    if tip_format is not None and as_json:
        raise UsageError("--json and --tip-format cannot be combined; the JSON contains the tip too")
    file = load_cell(cell_path)
    if plan is not None:
        if hold_out or unchecked or tip_format:
            raise UsageError("--plan cannot be combined with --hold-out, --unchecked and --tip-format")
        return _plan(file, touches_path, plan, criterion, seed, output, as_json=as_json, quiet=quiet, verbose=verbose)
    if touches_path is None:
        raise UsageError("no TOUCHES are given; name a touch file, or plan touches with --plan N")
    check_output(file, output, is_printed=not as_json and tip_format is None)
    dialect = None if tip_format is None else _dialect(tip_format)
    touches = load_touches(touches_path, file.cell, file.sigma)
    result = calibrate(file.cell, touches, tuple(hold_out or ()), unchecked)
    if output is not None and output.suffix.lower() == ".html":
        settings = {"--hold-out": ", ".join(hold_out or ()), "--unchecked": "yes" if unchecked else ""}
        emit(_page(result, cell_path, touches_path, settings), output)
    elif output is not None:
        _write(file, result, output)
    for_people = wants_summary(quiet=quiet, verbose=verbose)
    if for_people:
        from tactfix.report.calibration_summary import print_calibration_sentence

        print_calibration_sentence(result, standard_error())
    _print(file, result, dialect, as_json=as_json, is_written=output is not None)
    print_notes(f"{result.status}: {reason}" for reason in result.reasons if result.status != "calibrated")
    print_notes(result.warnings, quiet=quiet)
    if for_people:
        from tactfix.report.calibration_summary import print_calibration

        print_calibration(result, standard_error())
    return Exit.DONE if result.status == "calibrated" else exit_of_status(result.status)


def _plan(
    file: "CellFile",
    touches: str | None,
    add: int,
    criterion: Literal["worst", "d"],
    seed: int,
    output: Path | None,
    *,
    as_json: bool,
    quiet: bool,
    verbose: bool,
) -> int:
    """Assess planned touches and print those to add."""
    from tactfix.calibration.touch_plan import plan_touches
    from tactfix.files.touch_file import load_touches
    from tactfix.report.calibration_report import plan_csv, touch_plan_json, touch_plan_lines
    from tactfix.report.json_report import text_of

    endings = (".csv", ".json")
    if output is not None and output.suffix.lower() not in endings:
        raise UsageError(f"{output}: touches to add are written as .csv or .json")
    planned = None if touches is None else load_touches(touches, file.cell, file.sigma)
    if file.sigma is None and add and planned is None:
        raise UsageError("the sigma of a touch is not given; write probe: {sigma: ...} in the cell file")
    sigma = file.sigma or float(planned.sigmas.mean())  # type: ignore[union-attr]
    result = plan_touches(file.cell, planned, add, sigma, criterion, seed)
    text = text_of(touch_plan_json(result)) if wants_json(output, as_json=as_json) else None
    emit(plan_csv(result) if text is None else text, output)
    print_notes(touch_plan_lines(result), quiet=quiet)
    if wants_summary(quiet=quiet, verbose=verbose):
        from tactfix.report.calibration_summary import print_touch_plan

        print_touch_plan(result, standard_error())
    return Exit.DONE


def _dialect(name: str) -> str:
    from tactfix.pose_formats import find_dialect

    return find_dialect(name).name


def _print(file: "CellFile", result: "Calibration", dialect: str | None, *, as_json: bool, is_written: bool) -> None:
    """What goes to standard output: the JSON, the tip, or the robot if it is not written to a file."""
    from tactfix.files.robot_file import robot_text

    if as_json:
        emit(result.to_json())
    elif dialect is not None and result.is_written:
        emit(_tip_text(result, dialect))
    elif dialect is None and result.is_written and not is_written:
        emit(robot_text(file, result))


def _write(file: "CellFile", result: "Calibration", output: Path) -> None:
    """Write the JSON or the robot to a file; a robot only if it is calibrated."""
    from tactfix.files.robot_file import robot_text

    if output.suffix.lower() == ".json":
        emit(result.to_json(), output)
    elif result.is_written:
        emit(robot_text(file, result), output)
    else:
        note(f"{output} is not written: the robot is {result.status}")


def _tip_text(result: "Calibration", dialect: str) -> str | bytes:
    """The calibrated tip in a pose format."""
    from tactfix.pose_formats.convert import write_pose
    from tactfix.pose_formats.pose import Pose

    written = write_pose(dialect, Pose(result.tip.flange_from_tip, result.units))
    print_notes(written.notes)
    return written.text


def _page(result: "Calibration", cell: Path, touches: str, settings: dict[str, str]) -> str:
    """The report, a record of its inputs."""
    from datetime import UTC, datetime

    from tactfix.report.html_calibration import calibration_page
    from tactfix.report.html_page import Provenance

    if touches == "-":
        raise UsageError("a report names its inputs; give the touches as a file")
    inputs = input_files(cell=str(cell), touches=touches)
    given = {name: value for name, value in settings.items() if value}
    return calibration_page(Provenance(inputs, given, datetime.now(UTC)), result, cell.stem)
