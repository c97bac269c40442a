"""tactfix import."""

from dataclasses import dataclass
from typing import Annotated

import typer

from tactfix.cli import completion
from tactfix.cli.inputs import ContactInput, takes_groups
from tactfix.cli.options import Output, Quiet
from tactfix.cli.output import emit, print_notes
from tactfix.errors import UsageError
from tactfix.formats import LOG_NAMES


@dataclass(frozen=True, slots=True)
class LogInput(ContactInput):
    """How the log of a machine is read."""

    units: Annotated[
        str | None,
        typer.Option(
            metavar="U",
            help="Unit of the log and of the lengths below: mm, m, um or in.",
            autocompletion=completion.units,
        ),
    ] = None
    contacts_format: Annotated[
        str,
        typer.Option(
            "--contacts-format",
            metavar="NAME",
            help=f"What LOG is: {', '.join(LOG_NAMES)}.",
            show_default=False,
            autocompletion=completion.log_formats,
        ),
    ] = ""


@takes_groups
def command(
    log: Annotated[str, typer.Argument(metavar="LOG", help="The log of a machine; - is standard input.")],
    *,
    touches: LogInput,
    output: Output = None,
    quiet: Quiet = False,
) -> int:
    """Write the log of a machine as a contact file (CSV), in the log's own unit.

    Options give what the log does not contain: --features bar:5,ball:4 (in order), --units. Tip radius and sigma may be
    given later, with the contact file. Skipped lines are listed on standard error.
    """
    from tactfix.files.logs.export import contact_csv
    from tactfix.files.logs.load import read_log

    if not touches.contacts_format:
        raise UsageError(f"which format? give --contacts-format {', '.join(LOG_NAMES)}")
    read = read_log(touches.contacts_format, log, None, touches.options(), touches.log_options(), complete=False)
    emit(contact_csv(read), output)
    print_notes(read.notes, quiet=quiet)
    return 0
