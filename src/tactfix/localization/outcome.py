"""What the contacts leave of a fixture's poses: every solution, what speaks against each, and the status."""

from collections.abc import Sequence
from dataclasses import replace

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.localization.elimination import Verdict, judge
from tactfix.localization.fit_test import misfit_of
from tactfix.localization.free_motions import is_worthless
from tactfix.poses.solution import Solution, Solutions, in_order
from tactfix.results import Status
from tactfix.values import frozen_value


@frozen_value
class Outcome:
    """solutions, the verdict on each, those that are left, and the status."""

    solutions: Solutions
    verdicts: tuple[Verdict, ...]
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
    verdicts = [verdict_of(fixture, contacts, solution, solutions.limit) for solution in solutions.found]
    verdicts = _without_impossible_path(fixture, contacts, solutions, verdicts)
    left = tuple(s for s, v in zip(solutions.found, verdicts, strict=True) if not v.reasons)
    return Outcome(solutions, tuple(verdicts), left, status_of(contacts, solutions, left))


def solve(
    fixture: Fixture, contacts: Contacts, sigmas: Floats, with_misses: bool = True, thorough: bool = True
) -> Solutions:
    """Every solution, by the way that fits the fixture: rigid, or feature by feature with relations.

    Where there is none the nearest miss, unless without with_misses; samples where relations leave something free.
    Without thorough a rigid fixture is searched at half the cost, and may keep a pose to itself.

    Raises UsageError where the file's relations leave the shape open, and the pose is restricted or was measured.
    """
    # Each way is imported by the fixtures that take it: at the prompt importing takes longer than locating.
    if fixture.is_placed:
        from tactfix.poses.rigid import rigid_solutions

        surfaces = {name: f.surface for name, f in fixture.features.items() if f.surface is not None}
        return rigid_solutions(surfaces, contacts, sigmas, with_misses, fixture.placement, thorough)
    if fixture.placement is not None and fixture.placement.is_in_fit:
        from tactfix.relations.rigid_bodies import placed_solutions

        return placed_solutions(fixture, contacts, sigmas, with_misses)
    from tactfix.relations.assembly import assembled_solutions

    return assembled_solutions(fixture, contacts, sigmas, with_misses)


def verdict_of(
    fixture: Fixture, contacts: Contacts, solution: Solution, limit: float, use_path: bool = True
) -> Verdict:
    """What speaks against a solution: its fit first, then approach, touch box and path."""
    misfit = misfit_of(fixture, contacts, solution, limit)
    return judge(fixture, contacts, solution, use_path) if misfit is None else Verdict((misfit,), ())


NO_PATH = "no pose lets the probe come in a straight line; the test of the path is left out"


def _without_impossible_path(
    fixture: Fixture, contacts: Contacts, solutions: Solutions, verdicts: Sequence[Verdict]
) -> list[Verdict]:
    """The verdicts; where only the path speaks against every pose that is left, the path cannot be right.

    A probe need not come from far away: then the straight line that the path test assumes is not the one it took.
    """
    codes = [{reason.code for reason in verdict.reasons} for verdict in verdicts]
    if {"path"} not in codes or set() in codes:
        return list(verdicts)
    again = [verdict_of(fixture, contacts, s, solutions.limit, use_path=False) for s in solutions.found]
    blocked = next(v.reasons[0].message for v, c in zip(verdicts, codes, strict=True) if c == {"path"})
    doubt = (
        f"{blocked}, and so for every pose: {NO_PATH}. If the probe starts closer, say so with probe.approach_distance"
    )
    return [v if v.reasons else replace(v, doubts=(*v.doubts, doubt)) for v in again]


def status_of(contacts: Contacts, solutions: Solutions, left: Sequence[Solution]) -> Status:
    """The status where these solutions are left."""
    if not left:
        # Too few contacts to be inconsistent: a continuum of which no sample passed.
        return "underdetermined" if solutions.continuum or solutions.dof < 0 else "inconsistent"
    if solutions.continuum or solutions.dof < 0 or all(is_worthless(solution, contacts) for solution in left):
        return "underdetermined"
    return "located" if len(left) == 1 else "ambiguous"
