"""tactfix report."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from tactfix.cli.contacts_input import read_contacts
from tactfix.cli.exits import exit_of_status
from tactfix.cli.options import (
    ContactsFormat,
    ContactsPath,
    Features,
    FixturePath,
    Quiet,
    Sigma,
    TipOffset,
    TipRadius,
    Units,
)
from tactfix.cli.output import emit, tell
from tactfix.errors import UsageError
from tactfix.files.contact_options import ContactOptions
from tactfix.files.fixture_file import load_fixture
from tactfix.files.reading import read_bytes
from tactfix.locate import locate
from tactfix.report.html_page import InputFile, locate_page
from tactfix.report.text_report import verdict_lines


def command(
    fixture: FixturePath,
    contacts: ContactsPath,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="Write the page to FILE, whole or not at all.")
    ] = None,
    units: Units = None,
    tip_radius: TipRadius = None,
    sigma: Sigma = None,
    contacts_format: ContactsFormat = "csv",
    features: Features = None,
    tip_offset: TipOffset = None,
    scale_sigma: Annotated[
        bool, typer.Option("--scale-sigma", help="Scale the covariance by the residuals instead of trusting sigma.")
    ] = False,
    quiet: Quiet = False,
) -> int:
    """Locate a fixture and write the record as one HTML page that works offline.

    Fixture and contacts in 3D, candidates and why they fell, residuals, uncertainty, conventions, and all inputs with
    their checksums. Needs the extra: pip install 'tactfix[report]'. Exit status as of locate.
    """
    if contacts == "-":
        raise UsageError("a record names its inputs; give the contacts as a file")
    there = load_fixture(fixture)
    options = ContactOptions(units, tip_radius, sigma)
    read = read_contacts(contacts, contacts_format, there, options, features, tip_offset, quiet=quiet)
    result = locate(there, read.contacts, scale_sigma=scale_sigma)
    said = {
        "contacts format": contacts_format,
        "--features": features,
        "--units": units,
        "--tip-radius": tip_radius,
        "--sigma": sigma,
        "--tip-offset": tip_offset,
        "--scale-sigma": "yes" if scale_sigma else None,
    }
    files = {"fixture": str(fixture), "contacts": contacts}
    inputs = [InputFile(role, path, read_bytes(path)) for role, path in files.items()]
    settings = {name: str(value) for name, value in said.items() if value is not None}
    emit(locate_page(there, read.contacts, result, inputs, settings, datetime.now(UTC)), output)
    tell(verdict_lines(result))
    tell(result.warnings, quiet=quiet)
    return exit_of_status(result.status)
