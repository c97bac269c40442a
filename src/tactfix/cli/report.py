"""tactfix report."""

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tactfix.cli.completion import pose_formats
from tactfix.cli.exits import Exit, exit_of_status
from tactfix.cli.inputs import ContactInput, Gates, PlacementInput, given_options, input_files, takes_groups
from tactfix.cli.options import FixturePath, Quiet, ScaleSigma
from tactfix.cli.output import emit, print_notes, standard_error, wants_summary
from tactfix.errors import UsageError

if TYPE_CHECKING:
    from tactfix.report.html_page import Record


@takes_groups
def command(
    fixture_path: FixturePath,
    *,
    contacts: Annotated[
        str | None,
        typer.Argument(metavar="[CONTACTS]", help="Contact file (CSV) or machine log; none: the fixture's design."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="Write to FILE, whole or not at all: .html; .pdf, .png by Chromium.",
        ),
    ] = None,
    touches: ContactInput,
    placement: PlacementInput,
    scale_sigma: ScaleSigma = False,
    format_name: Annotated[
        str | None,
        typer.Option(
            "--format", "-f", metavar="F", help="Also give the pose in a dialect.", autocompletion=pose_formats
        ),
    ] = None,
    gates: Gates,
    notes: Annotated[
        list[str] | None,
        typer.Option(
            "--note", metavar="KEY=VALUE", help="A note on the record, such as operator or machine; repeatable."
        ),
    ] = None,
    quiet: Quiet = False,
) -> int:
    """Locate a fixture, or check its design, and write the record as one HTML page that works offline.

    With CONTACTS: fixture and contacts in 3D, candidates and why they are rejected, residuals, uncertainty. Without:
    the findings of design-check. Both contain the conventions, and all inputs with their checksums. Needs the extra
    'report': pip install '.[report]'. Exit status as of locate or design-check.
    """
    from tactfix.cli.pose_output import render_pose
    from tactfix.files.fixture_file import load_fixture
    from tactfix.localization.locate import locate
    from tactfix.pose_formats import find_dialect
    from tactfix.report.browser_print import in_form
    from tactfix.report.html_page import Judgement, Record, locate_page
    from tactfix.report.text_report import status_lines

    suffix = _ending(output)
    given_notes = _notes(notes or [])
    point = gates.point
    dialect = None if format_name is None else find_dialect(format_name).name
    fixture = placement.placed(load_fixture(fixture_path), quiet=quiet)
    settings = given_options(replace(touches, contacts_format="csv"), placement)
    if scale_sigma:
        settings["--scale-sigma"] = "yes"
    record = Record(fixture, input_files(fixture=str(fixture_path)), settings, datetime.now(UTC), given_notes)
    if contacts is None:
        if touches.contacts_format != "csv" or set(settings) - {"--sigma", "--tip-radius"}:
            raise UsageError("without contacts only --sigma and --tip-radius can be given")
        if dialect or given_options(gates):
            raise UsageError("--format, --at and the gates are for a located pose; give the contacts too")
        return _design(record, touches.sigma, touches.tip_radius, output)
    if contacts == "-":
        raise UsageError("a record names its inputs; give the contacts as a file")
    record.inputs.extend(input_files(contacts=contacts))
    record.settings["contacts format"] = touches.contacts_format
    read = touches.read(contacts, fixture, quiet=quiet)
    result = locate(fixture, read.contacts, scale_sigma=scale_sigma)
    located = result.status == "located"
    limits = {"--max-sigma": gates.max_sigma, "--max-rms": gates.max_rms}
    judgement = Judgement(
        written={dialect: str(render_pose(result, dialect, None, force=False, quiet=quiet))}
        if dialect and located
        else {},
        at=point,
        gates={name: f"{limit:g} {result.units}" for name, limit in limits.items() if limit is not None},
        exceeded=gates.exceeded(result),
    )
    if located and wants_summary(quiet=quiet, verbose=False):
        from tactfix.report.summary import print_sentence

        print_sentence(result, standard_error())
    emit(in_form(locate_page(record, read.contacts, result, judgement), suffix), output)
    print_notes(status_lines(result))
    print_notes(result.warnings, quiet=quiet)
    print_notes(judgement.exceeded)
    return Exit.NOT_ACCEPTABLE if judgement.exceeded else exit_of_status(result.status)


def _ending(output: Path | None) -> str:
    """The suffix of the output; UsageError for one in which no report is written."""
    suffix = ".html" if output is None else output.suffix.lower()
    if suffix not in (".html", ".htm", ".pdf", ".png"):
        raise UsageError(f"{output}: a report is written as .html, .pdf or .png; choose one of these endings")
    return suffix


def _notes(texts: list[str]) -> dict[str, str]:
    """KEY=VALUE each."""
    pairs = [text.partition("=") for text in texts]
    wrong = next(
        (text for text, (key, equals, _) in zip(texts, pairs, strict=True) if not (key.strip() and equals)), None
    )
    if wrong is not None:
        raise UsageError(f"--note {wrong!r} has no key and value; write KEY=VALUE such as operator=Ada")
    return {key.strip(): value.strip() for key, _, value in pairs}


def _design(record: "Record", sigma: float | None, tip_radius: float | None, output: Path | None) -> Exit:
    """The page of a design check, and its exit status."""
    from tactfix.design.design_check import design_check
    from tactfix.design.design_report import Wishes
    from tactfix.report.browser_print import in_form
    from tactfix.report.html_design import design_page

    report = design_check(record.fixture, None, Wishes(sigma=sigma, tip_radius=tip_radius))
    emit(in_form(design_page(record, report), _ending(output)), output)
    return Exit.NOT_ACCEPTABLE if report.status == "error" else Exit.DONE
