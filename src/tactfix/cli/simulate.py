"""tactfix simulate."""

from typing import Annotated

import typer

from tactfix.cli import completion
from tactfix.cli.inputs import PlacementInput, read_pose, takes_groups
from tactfix.cli.options import AsJson, FixturePath, Output
from tactfix.cli.output import emit, emit_program
from tactfix.errors import FileError
from tactfix.mistakes import FAULT_KINDS


@takes_groups
def command(
    fixture_path: FixturePath,
    *,
    plan: Annotated[
        str | None,
        typer.Argument(
            metavar="PLAN", help="Contacts to make, as plan writes them (CSV, fixture frame); - is standard input."
        ),
    ] = None,
    pose: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="Pose of the fixture; by default random, within the placement."),
    ] = None,
    placement: PlacementInput,
    sigma: Annotated[
        float | None,
        typer.Option(metavar="S", help="Noise along the normal, in the fixture's unit."),
    ] = None,
    tip_radius: Annotated[
        float | None,
        typer.Option(metavar="R", help="Radius of the probe tip, in the fixture's unit."),
    ] = None,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="One seed gives one file.")] = 0,
    contacts: Annotated[
        int | None,
        typer.Option(metavar="N", help="Number of random touches; by default enough for each feature alone."),
    ] = None,
    fault: Annotated[
        str | None,
        typer.Option(
            metavar="NAME[:VALUE]",
            help=f"One mistake of a cell: {', '.join(FAULT_KINDS)}.",
            autocompletion=completion.fault_names,
        ),
    ] = None,
    orientations: Annotated[
        int | None,
        typer.Option(metavar="K", min=1, help="Also write flange orientations, cycling through K tool orientations."),
    ] = None,
    output: Output = None,
    as_json: AsJson = False,
) -> int:
    """Make a contact file as a probe would report it, with the true pose in its comments.

    Without PLAN the touches are random: inside the touch boxes, reachable in a straight line, with approaches near the
    surface normal. tactfix simulate FIXTURE | tactfix locate FIXTURE - recovers the pose. The pose is random too: one
    that the fixture's placement (or --near with --within, --near-sigma, --free) allows, or any.

    Faults, and what VALUE is: outlier (length; default 20 sigma), outliers (how many; 2), reversed-approach (row),
    reversed-approaches, swapped-labels, wrong-label, exchanged-features, wrong-unit (factor; 25.4), forgotten-tip and
    tip-sign (radius), late-trigger (length; 20 sigma), thermal-growth (share; 2.3e-4), wrong-sigma (factor; 10),
    wrong-tip (length; 20 sigma; needs --orientations). Mistakes in the fixture file: wrong-radius (length; 20
    sigma), diameters, wrong-side, wrong-place (length; 20 sigma), exchanged-axes, mirrored.
    """
    from tactfix.files.contact_options import ContactOptions
    from tactfix.files.contact_source import load_contacts
    from tactfix.files.fixture_file import load_fixture
    from tactfix.report.plan_report import simulation_csv
    from tactfix.simulation.faults import parse_fault
    from tactfix.simulation.simulate import simulate
    from tactfix.simulation.touches import NoPlanError

    asked = None if fault is None else parse_fault(fault)
    fixture = placement.placed(load_fixture(fixture_path), quiet=False)
    planned = None if plan is None else load_contacts(plan, fixture, ContactOptions(None, tip_radius, sigma))
    base_from_fixture = None if pose is None else read_pose(pose, fixture, quiet=False)
    try:
        simulation = simulate(
            fixture, planned, base_from_fixture, sigma, tip_radius, seed, contacts, asked, orientations
        )
    except NoPlanError as error:
        raise FileError("standard input" if plan == "-" else str(plan), [error.problem]) from None
    if as_json:
        emit(simulation.to_json(), output)
    else:
        emit_program(simulation_csv(simulation), output)
    return 0
