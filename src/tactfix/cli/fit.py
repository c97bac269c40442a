"""tactfix fit."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from tactfix.cli import completion
from tactfix.cli.exits import exit_of_status
from tactfix.cli.options import AsJson, ContactsPath, Output, Quiet, Sigma, TipRadius, Units, Verbose
from tactfix.cli.output import LISTED_BY_JSON, emit, on_screen, print_notes, standard_error, wants_json, wants_summary
from tactfix.errors import DegenerateContactsError, UsageError
from tactfix.units import LEAST_LENGTH, MOST_LENGTH

if TYPE_CHECKING:
    from tactfix.contacts import Contacts
    from tactfix.fitting.fit import FitResult


class Kind(StrEnum):
    """What is fitted."""

    PLANE = "plane"
    SPHERE = "sphere"
    CYLINDER = "cylinder"


class Side(StrEnum):
    """Where the material is."""

    OUTER = "outer"
    INNER = "inner"


def command(
    kind: Annotated[Kind, typer.Argument(help="The kind of surface.", show_default=False)],
    contacts: ContactsPath,
    radius: Annotated[
        float | None, typer.Option(metavar="R", help="Known radius, in the contact file's unit; found if not given.")
    ] = None,
    side: Annotated[Side, typer.Option(help="outer: touched from outside; inner: a bore or socket.")] = Side.OUTER,
    feature: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Only the contacts on this feature, in a file that names several.",
            autocompletion=completion.features,
        ),
    ] = None,
    output: Output = None,
    as_json: AsJson = False,
    units: Units = None,
    tip_radius: TipRadius = None,
    sigma: Sigma = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Find one plane, sphere or cylinder from contacts, without a fixture.

    All lengths are in the contact file's unit. Exit status as for locate.
    """
    from tactfix.files.contact_file import read_contact_file
    from tactfix.files.contact_options import ContactOptions
    from tactfix.report.text_report import fit_status_lines, surface_text

    if radius is not None and (kind is Kind.PLANE or not LEAST_LENGTH <= radius <= MOST_LENGTH):
        raise UsageError(f"--radius {radius:g} is not a radius of a {kind.value}")
    if kind is Kind.PLANE and side is Side.INNER:
        raise UsageError("--side inner is for a bore or socket; the side of a plane follows from the approaches")
    read = read_contact_file(contacts, None, ContactOptions(units, tip_radius, sigma))
    chosen = _one_feature(read.contacts, feature)
    result = _fit(kind, chosen, radius, side)
    for_people = wants_summary(quiet=quiet, verbose=verbose)
    if for_people and result.surface is not None:
        from tactfix.report.fit_summary import print_fit_sentence

        print_fit_sentence(result, standard_error())
    if wants_json(output, as_json=as_json):
        emit(result.to_json(), output)
    elif result.surface is not None:
        emit(surface_text(result.surface, result.sigma if on_screen(output) else None), output)
    size = "" if radius is None else f" of radius {radius:g} {read.units}"
    print_notes(fit_status_lines(result, LISTED_BY_JSON, size))
    print_notes(result.warnings, quiet=quiet)
    if for_people:
        from tactfix.report.fit_summary import print_fit

        print_fit(result, standard_error())
    return exit_of_status(result.status)


def _fit(kind: Kind, contacts: "Contacts", radius: float | None, side: Side) -> "FitResult":
    """What fit finds; contacts that leave the surface free give a result too."""
    from tactfix.fitting.fit import FitResult, fit

    try:
        return fit(kind.value, contacts, radius, side.value)
    except DegenerateContactsError as error:
        return FitResult(kind.value, "underdetermined", dof=0, warnings=(str(error),), units=contacts.units)


def _one_feature(contacts: "Contacts", feature: str | None) -> "Contacts":
    """The contacts on one feature; for a file with several the option must choose one."""
    from tactfix.files.reading import composed

    names = list(contacts.by_feature)
    feature = None if feature is None else composed(feature)
    if feature is None and len(names) == 1:
        return contacts
    if feature not in names:
        given = "several features" if feature is None else f"no feature {feature!r}"
        raise UsageError(f"the contact file has {given}; choose one with --feature: {', '.join(names)}")
    return contacts.on(feature)
