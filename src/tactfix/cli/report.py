"""tactfix report."""

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tactfix.cli.exits import Exit, exit_of_status
from tactfix.cli.options import (
    ContactsFormat,
    Features,
    FixturePath,
    Quiet,
    ScaleSigma,
    Sigma,
    TipOffset,
    TipRadius,
    Units,
)
from tactfix.cli.output import emit, tell
from tactfix.errors import UsageError

if TYPE_CHECKING:
    from tactfix.report.html_page import InputFile, Record


def command(
    fixture_path: FixturePath,
    contacts: Annotated[
        str | None,
        typer.Argument(metavar="[CONTACTS]", help="Contact file (CSV) or machine log; none: the fixture's design."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE", help="Write the page to FILE, whole or not at all.")
    ] = None,
    units: Units = None,
    tip_radius: TipRadius = None,
    sigma: Sigma = None,
    contacts_format: ContactsFormat = "csv",
    features: Features = None,
    tip_offset: TipOffset = None,
    scale_sigma: ScaleSigma = False,
    quiet: Quiet = False,
) -> int:
    """Locate a fixture, or check its design, and write the record as one HTML page that works offline.

    With CONTACTS: fixture and contacts in 3D, candidates and why they fell, residuals, uncertainty. Without: what
    design-check finds. Conventions, and all inputs with their checksums, in both. Needs the extra: pip install
    'tactfix[report]'. Exit status as of locate or design-check.
    """
    from tactfix.cli.contacts_input import read_contacts
    from tactfix.files.contact_options import ContactOptions
    from tactfix.files.fixture_file import load_fixture
    from tactfix.localization.locate import locate
    from tactfix.report.html_page import Record, locate_page
    from tactfix.report.text_report import verdict_lines

    fixture = load_fixture(fixture_path)
    said = {
        "--features": features,
        "--units": units,
        "--tip-radius": tip_radius,
        "--sigma": sigma,
        "--tip-offset": tip_offset,
        "--scale-sigma": "yes" if scale_sigma else None,
    }
    settings = {name: str(value) for name, value in said.items() if value is not None}
    record = Record(fixture, [_input("fixture", str(fixture_path))], settings, datetime.now(UTC))
    if contacts is None:
        if contacts_format != "csv" or set(settings) - {"--sigma", "--tip-radius"}:
            raise UsageError("without contacts only --sigma and --tip-radius can be given")
        return _design(record, sigma, tip_radius, output)
    if contacts == "-":
        raise UsageError("a record names its inputs; give the contacts as a file")
    record.inputs.append(_input("contacts", contacts))
    record.settings["contacts format"] = contacts_format
    options = ContactOptions(units, tip_radius, sigma)
    read = read_contacts(contacts, contacts_format, fixture, options, features, tip_offset, quiet=quiet)
    result = locate(fixture, read.contacts, scale_sigma=scale_sigma)
    emit(locate_page(record, read.contacts, result), output)
    tell(verdict_lines(result))
    tell(result.warnings, quiet=quiet)
    return exit_of_status(result.status)


def _input(role: str, path: str) -> "InputFile":
    from tactfix.files.reading import read_bytes
    from tactfix.report.html_page import InputFile

    return InputFile(role, path, read_bytes(path))


def _design(record: "Record", sigma: float | None, tip_radius: float | None, output: Path | None) -> Exit:
    """The page of a design check, and its exit status."""
    from tactfix.design.design_check import Wishes, design_check
    from tactfix.report.html_design import design_page

    report = design_check(record.fixture, None, Wishes(sigma=sigma, tip_radius=tip_radius))
    emit(design_page(record, report), output)
    return Exit.NOT_ACCEPTABLE if report.status == "error" else Exit.DONE
