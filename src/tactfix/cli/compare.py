"""tactfix compare."""

from pathlib import Path
from typing import Annotated

import typer

from tactfix.cli import completion
from tactfix.cli.exits import Exit
from tactfix.cli.options import AsJson, Output
from tactfix.cli.output import emit, emit_lines, print_notes, wants_json


def command(
    before: Annotated[str, typer.Argument(metavar="BEFORE", help="The earlier pose: output of locate, or any pose.")],
    after: Annotated[str, typer.Argument(metavar="AFTER", help="The later pose; - is standard input.")],
    limit_translation: Annotated[
        float | None,
        typer.Option(metavar="L", min=0, help="Exit 1 if the origin moved more than L, in the unit of BEFORE."),
    ] = None,
    limit_rotation: Annotated[
        float | None, typer.Option(metavar="DEG", min=0, help="Exit 1 if the fixture turned more than DEG degrees.")
    ] = None,
    units: Annotated[
        str | None,
        typer.Option(
            metavar="U",
            help="Unit of a pose whose file gives none: mm, m, um or in.",
            autocompletion=completion.units,
        ),
    ] = None,
    as_json: AsJson = False,
    junit: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Also write the verdict to FILE as JUnit XML.")
    ] = None,
    output: Output = None,
) -> int:
    """Compute how far a fixture has moved between two poses, in base and in its own frame.

    Exit status: 0 within the limits, 1 beyond one of them.
    """
    import numpy as np

    from tactfix.files.pose_file import load_pose
    from tactfix.files.writing import write_whole
    from tactfix.pose_formats.comparison import Limits, compare, exceeded
    from tactfix.report.json_report import text_of
    from tactfix.report.movement_report import compare_json, compare_junit, compare_lines

    limits = Limits(limit_translation, None if limit_rotation is None else float(np.deg2rad(limit_rotation)))
    movement = compare(load_pose(before, default_units=units), load_pose(after, default_units=units))
    if junit is not None:
        write_whole(junit, compare_junit(movement, limits))
    if wants_json(output, as_json=as_json):
        emit(text_of(compare_json(movement, limits)), output)
    else:
        emit_lines(compare_lines(movement), output)
    beyond = exceeded(movement, limits)
    print_notes(beyond.values())
    return Exit.NOT_ACCEPTABLE if beyond else Exit.DONE
