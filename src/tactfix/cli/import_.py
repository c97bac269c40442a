"""tactfix import."""

from typing import Annotated

import typer

from tactfix.cli.options import (
    Approach,
    Features,
    Output,
    Quiet,
    Repeats,
    Sigma,
    TipOffset,
    TipRadius,
    WorkOffset,
    vector,
)
from tactfix.cli.output import emit, tell
from tactfix.errors import UsageError
from tactfix.formats import LOG_NAMES


def command(
    log: Annotated[str, typer.Argument(metavar="LOG", help="The log of a machine; - is standard input.")],
    contacts_format: Annotated[
        str | None,
        typer.Option("--contacts-format", metavar="NAME", help=f"What LOG is: {', '.join(LOG_NAMES)}."),
    ] = None,
    features: Features = None,
    units: Annotated[
        str | None, typer.Option(metavar="U", help="Unit of the log and of the lengths below: mm, m, um or in.")
    ] = None,
    tip_radius: TipRadius = None,
    sigma: Sigma = None,
    tip_offset: TipOffset = None,
    approach: Approach = None,
    repeats: Repeats = "all",
    work_offset: WorkOffset = None,
    output: Output = None,
    quiet: Quiet = False,
) -> int:
    """Write the log of a machine as a contact file (CSV), in the log's own unit.

    What the log cannot say, options must: --features bar:5,ball:4 (in order), --units. Tip radius and sigma may be left
    to whoever reads the contact file. What was dropped or passed over is told on standard error.
    """
    from tactfix.files.contact_options import ContactOptions, log_options
    from tactfix.files.logs.export import contact_csv
    from tactfix.files.logs.load import read_log

    if contacts_format is None:
        raise UsageError(f"which format? give --contacts-format {', '.join(LOG_NAMES)}")
    offset = None if tip_offset is None else vector(tip_offset, "--tip-offset")
    wanted = log_options(features, offset, approach, repeats, work_offset)
    read = read_log(contacts_format, log, None, ContactOptions(units, tip_radius, sigma), wanted, complete=False)
    emit(contact_csv(read), output)
    tell(read.notes, quiet=quiet)
    return 0
