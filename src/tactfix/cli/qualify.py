"""tactfix qualify."""

from pathlib import Path
from typing import Annotated

import typer

from tactfix.cli.fit import Side
from tactfix.cli.options import AsJson, ContactsPath, Output, Quiet, Units
from tactfix.cli.output import emit, emit_lines, print_notes, wants_json
from tactfix.errors import UsageError
from tactfix.units import LEAST_LENGTH, MOST_LENGTH


def command(
    contacts: ContactsPath,
    radius: Annotated[
        float | None,
        typer.Option(metavar="R", help="Radius of the reference ball that is touched, in the contact file's unit."),
    ] = None,
    side: Annotated[Side, typer.Option(help="outer: a ball; inner: a socket or ring.")] = Side.OUTER,
    fixture_path: Annotated[
        Path | None,
        typer.Option(
            "--fixture", metavar="FIXTURE", help="Fixture file whose ball is the reference: its radius and side."
        ),
    ] = None,
    feature: Annotated[
        str | None, typer.Option(metavar="NAME", help="The ball of the fixture, if several are touched.")
    ] = None,
    output: Output = None,
    as_json: AsJson = False,
    units: Units = None,
    quiet: Quiet = False,
) -> int:
    """Determine sigma of a probe from repeated touches of the same places, with drift, steps and outliers.

    Touches of one feature, and of one target if there is a column target, are of one place. With --radius they are
    touches of a reference ball, and the effective radius of the tip is determined too; with --fixture they are those
    of a ball of that fixture, in the fixture's units; touches of other features are ignored.

    Exit status: 0 qualified, 4 too few touches.
    """
    from tactfix.files.contact_file import read_contact_file
    from tactfix.files.contact_options import ContactOptions
    from tactfix.files.fixture_file import load_fixture
    from tactfix.qualification.ball import touches_of_ball
    from tactfix.qualification.qualify import qualify
    from tactfix.report.qualify_report import qualify_lines

    if radius is not None and not LEAST_LENGTH <= radius <= MOST_LENGTH:
        raise UsageError(f"--radius {radius:g} is not a radius of a ball")
    if (radius if fixture_path is not None else feature) is not None:
        raise UsageError("the ball is given by --radius, or by --fixture with --feature; use one of the two")
    # Sigma and tip are to be determined: those of the file are not used.
    options = ContactOptions(units, tip_radius=0.0, sigma=1.0)
    if fixture_path is not None:
        fixture = load_fixture(fixture_path)
        ball, touches = touches_of_ball(fixture, read_contact_file(contacts, fixture, options).contacts, feature)
        found = qualify(touches, radius=ball.radius, side=ball.side, units=fixture.units)
    else:
        read = read_contact_file(contacts, None, options)
        found = qualify(read.contacts, targets=read.targets, radius=radius, side=side.value, units=read.units)
    if wants_json(output, as_json=as_json):
        emit(found.to_json(), output)
    else:
        emit_lines(qualify_lines(found), output)
    print_notes(found.warnings, quiet=quiet)
    return 0
