"""tactfix design-check."""

import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from tactfix.cli import completion
from tactfix.cli.exits import Exit
from tactfix.cli.inputs import PlacementInput, input_files, read_contacts, takes_groups
from tactfix.cli.options import (
    AsJson,
    ContactsFormat,
    Features,
    Output,
    Quiet,
    Scheduler,
    TipOffset,
    Units,
    vector,
)
from tactfix.cli.output import emit, progress_bar, wants_json
from tactfix.errors import UsageError

if TYPE_CHECKING:
    from tactfix.contacts import Contacts
    from tactfix.design.design_report import DesignReport
    from tactfix.files.contact_options import ContactOptions
    from tactfix.fixture import Fixture

PAGES: Final = (".html", ".htm", ".pdf", ".png")
"""Endings of an output that is a page with a scene, not a text."""


@takes_groups
def command(
    *,
    fixture_path: Annotated[
        Path | None, typer.Argument(metavar="FIXTURE", help="Fixture file (YAML).", show_default=False)
    ] = None,
    contacts: Annotated[
        str | None,
        typer.Argument(
            metavar="CONTACTS-OR-PLAN",
            help="Contacts made in base, or planned in the fixture frame (CSV); - is standard input.",
            show_default=False,
        ),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="X,Y,Z", help="Also report sigma at this point of the fixture frame; may be repeated."),
    ] = None,
    sigma: Annotated[
        float | None,
        typer.Option(metavar="S", min=0, help="Sigma of a contact, in the unit of the contacts or fixture."),
    ] = None,
    tip_radius: Annotated[
        float | None, typer.Option(metavar="R", min=0, help="Radius of the probe tip, in the same unit.")
    ] = None,
    max_sigma: Annotated[
        float | None, typer.Option(metavar="S", min=0, help="An error if the sigma of an extreme point exceeds S.")
    ] = None,
    study: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=0,
            help="Locate N random layouts with six contacts, seven and so on, instead of a few; 0 omits the study.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="One seed gives one study.")] = 0,
    scheduler: Scheduler = None,
    units: Units = None,
    contacts_format: ContactsFormat = "csv",
    features: Features = None,
    tip_offset: TipOffset = None,
    placement: PlacementInput,
    as_json: AsJson = False,
    junit: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Also write the findings to FILE as JUnit XML.")
    ] = None,
    output: Output = None,
    explain: Annotated[
        str | None,
        typer.Option(
            metavar="CODE",
            help="Explain a finding, and do nothing else.",
            autocompletion=completion.finding_codes,
        ),
    ] = None,
    quiet: Quiet = False,
) -> int:
    """Check whether a fixture can be located, how accurately, and which mistakes stay undetected.

    Contacts that lie on the fixture's surfaces untransformed are a plan in the fixture frame; others are located first.
    The fixture's placement, or --near, is taken into account: the fixture is checked at that pose.

    Exit status: 0 no error (warnings are possible), 1 an error was found.
    """
    from tactfix.batching.cluster import mapping_over
    from tactfix.design.design_check import design_check
    from tactfix.design.design_report import Wishes
    from tactfix.design.random_layouts import DEFAULT_LAYOUTS
    from tactfix.explanations import explanation
    from tactfix.files.contact_options import ContactOptions
    from tactfix.files.fixture_file import load_fixture
    from tactfix.files.writing import write_whole
    from tactfix.report.design_json import design_junit

    if explain is not None:
        emit(explanation("design", explain), output)
        return Exit.DONE
    if fixture_path is None:
        raise UsageError("name a fixture file, or a finding with --explain CODE")
    if scheduler is not None and not study:
        raise UsageError("--scheduler is for a study; say how many layouts with --study N")
    points = tuple(vector(text, "--at") for text in at or ())
    fixture = placement.placed(load_fixture(fixture_path), quiet=quiet)
    options = ContactOptions(units, tip_radius, sigma)
    given = _contacts(contacts, fixture, options, contacts_format, features, tip_offset, quiet=quiet)
    own_sigma, own_tip = (sigma, tip_radius) if given is None else (None, None)
    layouts = DEFAULT_LAYOUTS if study is None else study
    wishes = Wishes(points, own_sigma, own_tip, max_sigma, layouts, seed)
    is_quick = layouts <= DEFAULT_LAYOUTS
    with progress_bar("studying", quiet=quiet or is_quick) as progress, mapping_over(scheduler) as over:
        report = design_check(fixture, given, wishes, progress, over)
    if junit is not None:
        write_whole(junit, design_junit(report))
    if output is not None and output.suffix.lower() in PAGES and not as_json:
        inputs = {"fixture": str(fixture_path)} | ({} if contacts in (None, "-") else {"contacts": str(contacts)})
        settings = {"--sigma": sigma, "--tip-radius": tip_radius, "--units": units, "--max-sigma": max_sigma}
        emit(_page(report, output, inputs, settings), output)
    else:
        emit(_text(report, output, as_json=as_json), output)
    return Exit.NOT_ACCEPTABLE if report.status == "error" else Exit.DONE


def _contacts(
    path: str | None,
    fixture: "Fixture",
    options: "ContactOptions",
    format_name: str,
    features: str | None,
    tip_offset: str | None,
    *,
    quiet: bool,
) -> "Contacts | None":
    from tactfix.files.contact_options import log_options

    if path is None:
        return None
    offset = None if tip_offset is None else vector(tip_offset, "--tip-offset")
    wanted = log_options(features, offset)
    return read_contacts(path, format_name, fixture, options, wanted, quiet=quiet).contacts


def _page(
    report: "DesignReport", output: Path, inputs: Mapping[str, str], options: Mapping[str, object]
) -> str | bytes:
    """The record of the check as a page, as `tactfix report` writes it, with its inputs and options."""
    from datetime import UTC, datetime

    from tactfix.report.browser_print import in_form
    from tactfix.report.html_design import design_page
    from tactfix.report.html_page import Record

    settings = {name: str(value) for name, value in options.items() if value is not None}
    record = Record(report.fixture, input_files(**inputs), settings, datetime.now(UTC))
    return in_form(design_page(record, report), output.suffix.lower())


def _text(report: "DesignReport", output: Path | None, *, as_json: bool) -> str:
    """JSON if requested by option or suffix, else tables, in colour on a terminal that wants it."""
    from tactfix.report.design_table import design_text

    if wants_json(output, as_json=as_json):
        return report.to_json()
    is_terminal = output is None and sys.stdout.isatty()
    width = os.get_terminal_size().columns if is_terminal else 100
    return design_text(report, max(width, 60), color=is_terminal and "NO_COLOR" not in os.environ)
