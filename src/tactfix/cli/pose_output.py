"""The located pose as the text that a command line asks for."""

import sys
from pathlib import Path

from tactfix.cli.output import print_notes, program_for_people
from tactfix.errors import UsageError
from tactfix.geometry.arrays import Floats
from tactfix.locate_result import LocateResult
from tactfix.report.text_report import matrix_text, rounded_matrix_text

# The endings of the two formats that need no dialect, so that the common cases do not import all of them.
_PLAIN_SUFFIXES = {"": "matrix", ".txt": "matrix", ".json": "json"}


def chosen_format(format_name: str | None, as_json: bool, output: Path | None) -> str:
    """matrix, json or the name of a dialect: as given, or by the suffix of the output, or matrix.

    Raises UsageError for a name or a contradiction before anything has been computed.
    """
    if as_json and format_name not in (None, "json"):
        raise UsageError(f"--json and --format {format_name} cannot be combined; leave one of them out")
    if as_json:
        return "json"
    suffix = "" if output is None else output.suffix.lower()
    name = format_name or _PLAIN_SUFFIXES.get(suffix)
    if name in ("matrix", "json"):
        return name
    from tactfix.formats import SUFFIXES
    from tactfix.pose_formats import find_dialect

    if name is None and suffix not in SUFFIXES:
        known = ", ".join(SUFFIXES)
        raise UsageError(f"{output}: no format is known for the suffix {suffix!r}; use --format, or one of {known}")
    return find_dialect(name or SUFFIXES[suffix]).name


def render_pose(
    result: LocateResult, format_name: str, at: Floats | None, *, force: bool, quiet: bool, for_screen: bool = False
) -> str | bytes | None:
    """The result in that format; None if there is no pose to write. JSON is always written.

    at: a point (3,) of the fixture frame that the JSON contains too. for_screen: the matrix with the digits that its
    sigma justifies, long comments in several lines; a pipe or a file gets every digit.
    """
    if format_name == "json":
        from tactfix.report.json_report import locate_json, text_of

        return text_of(locate_json(result, at))
    if result.base_from_fixture is None:
        return None
    if format_name == "matrix":
        if for_screen:
            return rounded_matrix_text(result.base_from_fixture, result.covariance)
        return matrix_text(result.base_from_fixture)
    from tactfix.pose_formats.convert import write_pose
    from tactfix.pose_formats.pose import Pose

    pose = Pose(result.base_from_fixture, result.units, result.covariance, result.fixture)
    written = write_pose(format_name, pose, force=force)
    print_notes(written.notes, quiet=quiet)
    return (
        program_for_people(written.text, sys.stdout) if for_screen and isinstance(written.text, str) else written.text
    )
