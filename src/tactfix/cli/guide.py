"""tactfix guide."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from tactfix.cli.exits import Exit, exit_of_status
from tactfix.cli.inputs import ContactInput, Gates, read_contacts, takes_groups
from tactfix.cli.options import FixturePath, Quiet
from tactfix.cli.output import emit, emit_lines, print_notes
from tactfix.errors import FileError, UsageError

if TYPE_CHECKING:
    from tactfix.contacts import Contacts
    from tactfix.files.contact_options import FeatureRun
    from tactfix.fixture import Fixture


@takes_groups
def command(
    fixture_path: FixturePath,
    *,
    contacts: Annotated[
        str,
        typer.Argument(metavar="[CONTACTS]", help="Contact file (CSV) or machine log; - is standard input."),
    ] = "-",
    follow: Annotated[
        bool, typer.Option("--follow", help="Wait for touches appended to CONTACTS until the fixture is located.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="A line of JSON after each touch.")] = False,
    touches: ContactInput,
    gates: Gates,
    quiet: Quiet = False,
) -> int:
    """Report after each touch what is still free or ambiguous, and where to touch next.

    Ends when the fixture is located within the gates, or when the touches end. For a machine log --features gives the
    features of all planned touches, in order; the log may contain fewer so far.

    Exit status: 0 located, 1 a gate is exceeded, 4 underdetermined or no touch, 5 ambiguous, 6 inconsistent.
    """
    from tactfix.files.fixture_file import load_fixture
    from tactfix.monitoring.guide import guide
    from tactfix.report.movement_report import guide_line

    if follow and contacts == "-":
        raise UsageError("standard input is always followed to its end; leave --follow out")
    fixture = load_fixture(fixture_path)
    point = gates.point
    status = Exit.UNDERDETERMINED
    for so_far in _touches(fixture, contacts, touches, follow=follow):
        step = guide(fixture, so_far, point_fixture=point, max_sigma=gates.max_sigma, max_rms=gates.max_rms)
        if as_json:
            emit(step.to_json())
        else:
            emit_lines([guide_line(step)])
        if step.is_done:
            print_notes(step.result.warnings, quiet=quiet)
            return Exit.DONE
        status = Exit.NOT_ACCEPTABLE if step.exceeded else exit_of_status(step.result.status)
    if status == Exit.UNDERDETERMINED:
        print_notes(["the touches ended before the fixture is located"], quiet=quiet)
    return status


def _touches(fixture: "Fixture", path: str, given: ContactInput, *, follow: bool) -> "Iterator[Contacts]":
    """The touches so far, each time that there is one more."""
    from tactfix.files.contact_source import contacts_in, growing_text

    count = 0
    options, wanted, format_name = given.options(), given.log_options(), given.contacts_format
    repeats_units = (options.units or "mm") if wanted.repeats == "last" else None
    for text in growing_text(path, follow=follow):
        try:
            found, contacts_so_far = contacts_in(text, format_name, repeats_units)
            if found > count:
                begun = replace(wanted, features=_first(wanted.features, contacts_so_far))
                # The notes on a log would be repeated at each touch.
                contacts = read_contacts(text, format_name, fixture, options, begun, quiet=True).contacts
                count = found
                yield contacts
        except FileError as error:
            raise FileError("standard input" if path == "-" else path, error.problems) from None


def _first(runs: "Sequence[FeatureRun]", count: int) -> "tuple[FeatureRun, ...]":
    """The features of the first count contacts."""
    begun = []
    for run in runs:
        taken = min(run.count, count)
        count -= taken
        if taken:
            begun.append(replace(run, count=taken))
    return tuple(begun)
