"""tactfix locate."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tactfix.cli import completion
from tactfix.cli.exits import Exit, exit_of_status
from tactfix.cli.inputs import ContactInput, Gates, PlacementInput, takes_groups
from tactfix.cli.options import AsJson, ContactsPath, FixturePath, Output, Quiet, ScaleSigma, Verbose
from tactfix.cli.output import LISTED_BY_JSON, emit, note, on_screen, print_notes, standard_error, wants_summary
from tactfix.errors import UsageError

if TYPE_CHECKING:
    from tactfix.contacts import Contacts, Unknown
    from tactfix.locate_result import LocateResult


def _explained(code: str | None) -> None:
    """Print the explanation of a code and end: this needs no file."""
    if code is not None:
        from tactfix.explanations import explanation

        emit(explanation("localization", code))
        raise typer.Exit


@takes_groups
def command(
    fixture_path: FixturePath,
    contacts: ContactsPath,
    *,
    format: Annotated[  # noqa: A002 - the name of the option
        str | None,
        typer.Option(
            "--format",
            "-f",
            metavar="F",
            help="How the pose is written: matrix, json, or a dialect (see README).",
            autocompletion=completion.pose_formats,
        ),
    ] = None,
    output: Output = None,
    as_json: AsJson = False,
    touches: ContactInput,
    placement: PlacementInput,
    gates: Gates,
    scale_sigma: ScaleSigma = False,
    force: Annotated[
        bool, typer.Option("--force", help="Write a dialect although it rounds more than a tenth of sigma.")
    ] = False,
    unknown: Annotated[
        str | None,
        typer.Option(
            metavar="WHAT",
            help="Also determine the tip: tip (its offset, from flange poses), tip-radius, or tip,tip-radius.",
            autocompletion=completion.unknowns,
        ),
    ] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Exit 1 if there is any warning about the pose.")] = False,
    explain: Annotated[
        str | None,
        typer.Option(
            "--explain",
            metavar="CODE",
            help="Explain a status, a reason or a diagnosis, and do nothing else.",
            autocompletion=completion.verdict_codes,
            callback=_explained,
            is_eager=True,
        ),
    ] = None,
    next_contact: Annotated[
        Path | None,
        typer.Option(
            "--next-contact", metavar="FILE", help="If contacts are missing: write those to make next, as plan does."
        ),
    ] = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Find the pose of a fixture: base_from_fixture, with x_base = R x_fixture + t.

    Prints the 4x4 matrix, or the format of --format. All results are in the fixture's units.

    Exit status: 0 located, 1 a gate is exceeded (or --strict and a warning), 4 underdetermined, 5 ambiguous,
    6 inconsistent.
    """
    from tactfix.acceptance import shown_sigma
    from tactfix.cli.pose_output import chosen_format, render_pose
    from tactfix.files.fixture_file import load_fixture
    from tactfix.localization.locate import locate
    from tactfix.report.text_report import status_lines

    point = gates.point
    style = chosen_format(format, as_json, output)
    fixture = placement.placed(load_fixture(fixture_path), quiet=quiet)
    sought = _unknowns(unknown)
    read = touches.read(contacts, fixture, sought, quiet=quiet)
    result = locate(fixture, read.contacts, scale_sigma=scale_sigma, unknown=sought)
    for_people = wants_summary(quiet=quiet, verbose=verbose)
    if for_people and result.status == "located":
        # rich takes as long to import as everything else: only for people who see it.
        from tactfix.report.summary import print_sentence

        print_sentence(result, standard_error())
    text = render_pose(result, style, point, force=force, quiet=quiet, for_screen=on_screen(output))
    if text is not None:
        emit(text, output)
    print_notes(status_lines(result, LISTED_BY_JSON))
    if next_contact is not None:
        _write_next(result, read.contacts, next_contact)
    print_notes([] if result.tip is None else [result.tip.message], quiet=quiet)
    print_notes(result.warnings, quiet=quiet)
    if for_people:
        from tactfix.report.summary import print_summary

        print_summary(result, standard_error(), point)
    elif point is not None:
        note(f"worst sigma at {gates.at}: {shown_sigma(result, point)}", quiet=quiet)
    if result.status != "located":
        return exit_of_status(result.status)
    exceeded = gates.exceeded(result)
    if strict and result.warnings:
        exceeded.append("not acceptable: there is a warning about the pose, and --strict allows none")
    print_notes(exceeded)
    return Exit.NOT_ACCEPTABLE if exceeded else Exit.DONE


def _write_next(result: "LocateResult", contacts: "Contacts", output: Path) -> None:
    """Write the contacts to make next to a file, if any are named."""
    from tactfix.report.plan_report import next_contact_csv

    text = next_contact_csv(result, contacts.tip_radius, float(contacts.sigmas.max()))
    if text is None:
        print_notes([f"there is no next contact; {output} is not written"])
    else:
        emit(text, output)


def _unknowns(text: str | None) -> "frozenset[Unknown]":
    """'tip', 'tip-radius' or both, separated by a comma; nothing for None."""
    choices: dict[str, Unknown] = {"tip": "tip", "tip-radius": "tip-radius"}
    names = [] if text is None else [part.strip() for part in text.split(",")]
    for name in names:
        if name not in choices:
            raise UsageError(f"--unknown {name!r}: write tip, tip-radius, or tip,tip-radius")
    return frozenset(choices[name] for name in names)
