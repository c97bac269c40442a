"""The outcome of locating: every solution, the assessment of each, and the status.

1. All solutions are computed (`solve`).
2. Each is assessed: fit, then approach, touch box, prior and path (`elimination`).
3. If only the path rejects every remaining pose, the path was not straight: the test is left out.
4. The solutions that no test rejects give the status.
"""

from collections.abc import Sequence
from dataclasses import replace

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.localization.elimination import Assessment, assess
from tactfix.localization.fit_test import misfit_of
from tactfix.localization.free_motions import is_underdetermined
from tactfix.poses.solution import Solution, Solutions, in_order
from tactfix.results import Status
from tactfix.values import frozen_value


@frozen_value
class Outcome:
    """solutions, the assessment of each, the solutions that are left, and the status."""

    solutions: Solutions
    assessments: tuple[Assessment, ...]
    left: tuple[Solution, ...]
    status: Status


def outcome_of(
    fixture: Fixture, contacts: Contacts, sigmas: Floats, with_misses: bool = True, thorough: bool = True
) -> Outcome:
    """The outcome for contacts with sigmas (n,) of the residuals; with_misses and thorough as in `solve`."""
    return outcome_from(fixture, contacts, solve(fixture, contacts, sigmas, with_misses, thorough))


def outcome_from(fixture: Fixture, contacts: Contacts, solutions: Solutions) -> Outcome:
    """The outcome of these solutions."""
    solutions = replace(solutions, found=in_order(solutions.found))
    # Steps 2 and 3.
    assessments = [assessment_of(fixture, contacts, solution, solutions.limit) for solution in solutions.found]
    assessments = _without_impossible_path(fixture, contacts, solutions, assessments)
    left = tuple(s for s, v in zip(solutions.found, assessments, strict=True) if not v.reasons)
    return Outcome(solutions, tuple(assessments), left, status_of(contacts, solutions, left))


def solve(
    fixture: Fixture, contacts: Contacts, sigmas: Floats, with_misses: bool = True, thorough: bool = True
) -> Solutions:
    """Every solution, by the way that fits the fixture: rigid, or feature by feature with relations.

    If there is none, the nearest miss, unless without with_misses; samples if relations leave a motion free. Without
    thorough a rigid fixture is searched at half the cost, and a pose may be missed.

    Raises UsageError if the file's relations leave the shape open, and the pose is constrained or was measured.
    """
    # Imported only when used: for the command, the imports take longer than the location.
    if fixture.is_placed:
        from tactfix.poses.rigid import rigid_solutions

        surfaces = {name: f.surface for name, f in fixture.features.items() if f.surface is not None}
        return rigid_solutions(surfaces, contacts, sigmas, with_misses, fixture.placement, thorough)
    if fixture.placement is not None and fixture.placement.is_in_fit:
        from tactfix.relations.rigid_bodies import placed_solutions

        return placed_solutions(fixture, contacts, sigmas, with_misses)
    from tactfix.relations.assembly import assembled_solutions

    return assembled_solutions(fixture, contacts, sigmas, with_misses)


def assessment_of(
    fixture: Fixture, contacts: Contacts, solution: Solution, limit: float, use_path: bool = True
) -> Assessment:
    """The assessment of a solution: its fit first, then approach, touch box, prior and path."""
    misfit = misfit_of(fixture, contacts, solution, limit)
    return assess(fixture, contacts, solution, use_path) if misfit is None else Assessment((misfit,), ())


NO_PATH = "no pose lets the probe come in a straight line; the test of the path is left out"


def _without_impossible_path(
    fixture: Fixture, contacts: Contacts, solutions: Solutions, assessments: Sequence[Assessment]
) -> list[Assessment]:
    """The assessments, without the path test if it alone rejects every remaining pose (step 3).

    A probe that starts close by did not move along the whole straight line that the test assumes.
    """
    codes = [{reason.code for reason in assessment.reasons} for assessment in assessments]
    if {"path"} not in codes or set() in codes:
        return list(assessments)
    again = [assessment_of(fixture, contacts, s, solutions.limit, use_path=False) for s in solutions.found]
    blocked = next(v.reasons[0].message for v, c in zip(assessments, codes, strict=True) if c == {"path"})
    warning = (
        f"{blocked}, and so for every pose: {NO_PATH}. If the probe starts closer, say so with probe.approach_distance"
    )
    return [v if v.reasons else replace(v, warnings=(*v.warnings, warning)) for v in again]


def status_of(contacts: Contacts, solutions: Solutions, left: Sequence[Solution]) -> Status:
    """The status if these solutions are left (step 4)."""
    if not left:
        # Too few contacts to be inconsistent: no sample of the continuum, or of the many poses, passed the tests.
        is_open = solutions.continuum or solutions.partial or solutions.dof < 0
        return "underdetermined" if is_open else "inconsistent"
    if solutions.continuum or solutions.dof < 0 or all(is_underdetermined(solution, contacts) for solution in left):
        return "underdetermined"
    if len(left) == 1:
        # Of many poses that the contacts leave, only some were fitted: the one that passed need not be the right one.
        return "underdetermined" if solutions.partial else "located"
    return "ambiguous"
