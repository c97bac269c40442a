"""tactfix qualify."""

from typing import Annotated

import typer

from tactfix.cli.fit import Side
from tactfix.cli.options import AsJson, ContactsPath, Output, Quiet, Units
from tactfix.cli.output import emit, emit_lines, tell
from tactfix.errors import UsageError
from tactfix.units import LEAST_LENGTH, MOST_LENGTH


def command(
    contacts: ContactsPath,
    radius: Annotated[
        float | None,
        typer.Option(metavar="R", help="Radius of the reference ball that is touched, in the contact file's unit."),
    ] = None,
    side: Annotated[Side, typer.Option(help="outer: a ball; inner: a socket or ring.")] = Side.OUTER,
    output: Output = None,
    as_json: AsJson = False,
    units: Units = None,
    quiet: Quiet = False,
) -> int:
    """Tell what a probe is good for: sigma from repeated touches of the same places, with drift, steps and outliers.

    Touches of one feature, and of one target where there is a column target, are of one place. With --radius they are
    touches of a reference ball, and the effective radius of the tip is told too.

    Exit status: 0 qualified, 4 too few touches.
    """
    from tactfix.files.contact_file import read_contact_file
    from tactfix.files.contact_options import ContactOptions
    from tactfix.qualification.qualify import qualify
    from tactfix.report.json_report import text_of
    from tactfix.report.qualify_report import qualify_json, qualify_lines

    if radius is not None and not LEAST_LENGTH <= radius <= MOST_LENGTH:
        raise UsageError(f"--radius {radius:g} is no radius of a ball")
    # Sigma and tip are what is asked for: what the file says of them is not used.
    read = read_contact_file(contacts, None, ContactOptions(units, tip_radius=0.0, sigma=1.0))
    found = qualify(read.contacts, targets=read.targets, radius=radius, side=side.value, units=read.units)
    if as_json or (output is not None and output.suffix.lower() == ".json"):
        emit(text_of(qualify_json(found)), output)
    else:
        emit_lines(qualify_lines(found), output)
    tell(found.warnings, quiet=quiet)
    return 0
