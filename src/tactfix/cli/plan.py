"""tactfix plan."""

from typing import Annotated, Literal

import typer

from tactfix.cli.exits import Exit
from tactfix.cli.inputs import PlacementInput, takes_groups
from tactfix.cli.options import AsJson, FixturePath, Output, Quiet, Scheduler, Verbose
from tactfix.cli.output import emit, emit_program, print_notes, progress_bar, wants_summary
from tactfix.errors import UsageError

MOST_STARTS = 10_000
"""Random sets of contacts; some hundred agree on the best plan."""


@takes_groups
def command(
    fixture_path: FixturePath,
    *,
    made: Annotated[
        str | None,
        typer.Argument(
            metavar="CONTACTS", help="Contacts already made (CSV); - is standard input.", show_default=False
        ),
    ] = None,
    add: Annotated[
        int | None,
        typer.Option(metavar="K", help="Number to add to CONTACTS; by default the fewest that determine the pose."),
    ] = None,
    contacts: Annotated[
        int | None,
        typer.Option(metavar="N", help="Number of contacts; by default the fewest with a unique pose."),
    ] = None,
    criterion: Annotated[
        Literal["worst", "d", "e"],
        typer.Option(help="Smallest worst sigma over the fixture, D-optimal, or largest smallest singular value."),
    ] = "worst",
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="One seed gives one plan.")] = 0,
    starts: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            min=1,
            max=MOST_STARTS,
            help="Search from N random sets, instead of a few, and report how many agree.",
        ),
    ] = None,
    scheduler: Scheduler = None,
    sigma: Annotated[float | None, typer.Option(metavar="S", help="Sigma of a contact, in the fixture's unit.")] = None,
    tip_radius: Annotated[
        float | None,
        typer.Option(metavar="R", help="Radius of the probe tip, in the fixture's unit."),
    ] = None,
    orientations: Annotated[
        int | None,
        typer.Option(
            metavar="K",
            min=1,
            help="Also plan K tool orientations, for a tip that is determined with the pose (locate --unknown tip); "
            "those of CONTACTS count.",
        ),
    ] = None,
    placement: PlacementInput,
    output: Output = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
) -> int:
    """Choose the contacts to make: reachable, unique, and as accurate as their number allows.

    Prints a contact file of nominal contacts (tip centres) in the fixture frame, or in base if CONTACTS determine the
    pose. Without --contacts: the fewest with a unique pose, and in comments the gain of each further one. With a
    placement in the fixture file or --near, comments (and the JSON) also give the contacts in base.

    Exit status: 0 a unique pose, 1 the contacts leave more than one.
    """
    from tactfix.batching.cluster import mapping_over
    from tactfix.files.contact_options import ContactOptions
    from tactfix.files.contact_source import load_contacts
    from tactfix.files.fixture_file import load_fixture
    from tactfix.planning.plan import plan
    from tactfix.report.plan_report import plan_csv, plan_lines

    if scheduler is not None and starts is None:
        raise UsageError("--scheduler is for a long search; give the number of random sets with --starts N")
    fixture = placement.placed(load_fixture(fixture_path), alone=True, quiet=quiet)
    existing = None if made is None else load_contacts(made, fixture, ContactOptions(None, tip_radius, sigma))
    with progress_bar("planning", quiet=quiet) as progress, mapping_over(scheduler) as over:
        found = plan(
            fixture,
            contacts,
            existing,
            add,
            criterion,
            seed,
            sigma,
            tip_radius,
            progress,
            starts,
            over,
            orientations,
        )
    if as_json:
        emit(found.to_json(), output)
    else:
        emit_program(plan_csv(found), output)
    if wants_summary(quiet=quiet, verbose=verbose):
        print_notes(plan_lines(found))
    if found.unique:
        return Exit.DONE
    print_notes(["not acceptable: the planned contacts leave more than one pose; plan more, or see design-check"])
    return Exit.NOT_ACCEPTABLE
