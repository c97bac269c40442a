"""Steps 2 to 5 of `assembly`: features that are located alone, and then fitted together.

This is a separate module because it imports every localizer and the branch fits. A fixture that step 1 handles, such as
the paper's, is located without these imports.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.frame import FrameError, frames, recipe_of
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Surface
from tactfix.noise import chi_square_limit
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.solution import Solutions
from tactfix.relations.branch_fits import Start, Starts, branch_fit, starts_from
from tactfix.relations.branches import BRANCH_FITS, least_cost, nearest_branch
from tactfix.relations.combinations import Combinations, combinations, located_alone, without_weak
from tactfix.relations.equations import Equation
from tactfix.relations.joint_problem import JointFit, JointProblem
from tactfix.relations.joint_solutions import joint_solutions
from tactfix.relations.realization import Body, body_number, fixture_scale, searchable_bodies, shape_sigma
from tactfix.relations.rigid_bodies import body_solutions
from tactfix.relations.samples import sampled_solutions
from tactfix.results import Candidate, Reason

SHAPE_LIMIT = 10.0
"""Multiple of the limit of chi-square up to which a fit counts as near a shape, which is then searched: fits of weakly
determined features may stop above their limit. 1 and 5 change none of the 200 contact sets of
`tests.benchmarks.bench_relations`, 1000 none of every fifth of them."""
FEW_COMBINATIONS = 64
"""Combinations of candidates above which a fixture with a fixed shape is searched as one body: 64 joint fits of some
milliseconds each take as long as such a search."""
SHAPE_COMBINATIONS = 4096
"""Combinations of candidates that are used at most; with more the result is not complete. They bound the time: their
costs are computed before any of them is fitted."""
FEW_FITS = 12
"""Starts that are fitted if contacts on a feature are flat within noise (`features_alone.is_flat`): its candidates
are then thinned, and the result is not complete anyway. 4 change none of every tenth of the 200 contact sets of
`tests.benchmarks.bench_relations`."""
MOST_FALLEN = 32
"""Combinations that violate a relation and are listed as candidates: more than anybody reads."""
SLACK_FACTOR = 3.0
"""Sigmas of the shape that are added to those of the contacts while a fixture with measured relations is searched as
rigid: its true shape is within three sigma, and too large a sum only admits wrong poses, which cost fits. 1.5
and 6 change none of every fifth of the 200 contact sets of `tests.benchmarks.bench_relations`."""


def combined_solutions(
    fixture: Fixture, contacts: Contacts, sigmas: Floats, shapes: Sequence[Body], is_exact: bool, with_misses: bool
) -> Solutions:
    """The poses of a fixture with these shapes (empty: it is free); is_exact: it is fixed without any sigma."""
    problem = JointProblem(contacts, sigmas, fixture.relations, fixture_scale(fixture))
    alone = located_alone(fixture, contacts, sigmas)  # step 2
    located = combinations(fixture, contacts, alone, SHAPE_COMBINATIONS + 1)
    if not shapes and (located is None or located.weak):
        sampled = sampled_solutions(fixture, problem, without_weak(alone.candidates))
        return replace(sampled, complete=sampled.complete and not alone.thinned)
    if located is None or (shapes and (located.weak or len(located.surfaces) > FEW_COMBINATIONS)):
        if is_exact:  # step 3
            return body_solutions(fixture, shapes, contacts, sigmas, with_misses)
        return _searched_as_rigid(fixture, problem, with_misses)
    most = FEW_FITS if located.thinned else BRANCH_FITS
    starts, fits = _fits(problem, located.surfaces[:SHAPE_COMBINATIONS], with_misses, most)  # step 4
    if is_exact:  # step 5
        searched = {body_number(fixture, fit.surfaces) for fit in fits if _is_near(fit)} - {None}
        if searched:
            chosen = [body for number, body in enumerate(shapes) if number in searched]
            of_bodies = body_solutions(fixture, chosen, contacts, sigmas, with_misses)
            return replace(of_bodies, complete=of_bodies.complete and _are_all(located, starts, of_bodies.limit))
    solutions = joint_solutions(fixture, problem, fits)
    fallen = _fallen(fixture, problem, located.surfaces, starts.followed, fits, solutions.limit)
    complete = _are_all(located, starts, solutions.limit)
    return replace(solutions, complete=complete, fallen=tuple(fallen))


def _fits(
    problem: JointProblem, found: Sequence[Mapping[str, Surface]], with_misses: bool, most: int = BRANCH_FITS
) -> tuple[Starts, list[JointFit]]:
    """The joint fits next to combinations of features in base, one for each branch, and where each started."""
    starts = starts_from(problem, found, with_misses)
    starts = replace(starts, followed=starts.followed[:most])
    return starts, [branch_fit(problem, start) for start in starts.followed]


def _are_all(located: Combinations, starts: Starts, limit: float) -> bool:
    """Whether every combination of features and every branch that may explain the contacts was followed."""
    return len(located.surfaces) <= SHAPE_COMBINATIONS and not located.thinned and starts.left_out > limit


def _is_near(fit: JointFit) -> bool:
    return fit.chi2 <= SHAPE_LIMIT * chi_square_limit(fit.dof)


def _fallen(
    fixture: Fixture,
    problem: JointProblem,
    found: Sequence[Mapping[str, Surface]],
    starts: Sequence[Start],
    fits: Sequence[JointFit],
    limit: float,
) -> Iterator[Candidate]:
    """Combinations that explain the contacts of each feature but violate a relation, if others do not."""
    kept = {start.number for start, fit in zip(starts, fits, strict=True) if fit.chi2 <= limit}
    broken = [surfaces for number, surfaces in enumerate(found) if number not in kept] if kept else []
    return _broken_candidates(fixture, problem, broken[:MOST_FALLEN])


def _searched_as_rigid(fixture: Fixture, problem: JointProblem, with_misses: bool) -> Solutions:
    """The joint fits near every pose of the rigid shapes, searched with the sigma of the contacts widened by the
    shape's.

    If no pose explains even these, the nearest miss without a joint fit; samples if they leave a motion free.
    """
    widened = np.hypot(problem.sigmas, SLACK_FACTOR * shape_sigma(fixture))
    rigid = body_solutions(fixture, searchable_bodies(fixture), problem.contacts, widened, with_misses)
    if not rigid.continuum and all(solution.chi2 > rigid.limit for solution in rigid.found):
        misses = (replace(s, chi2=float(((s.residuals / problem.sigmas) ** 2).sum())) for s in rigid.found)
        return replace(rigid, found=tuple(misses))
    starts, fits = _fits(problem, [solution.surfaces for solution in rigid.found], with_misses)
    solutions = joint_solutions(fixture, problem, fits, rigid.continuum)
    return replace(solutions, complete=rigid.complete and starts.left_out > solutions.limit)


def _broken_candidates(
    fixture: Fixture, problem: JointProblem, broken: Sequence[Mapping[str, Surface]]
) -> Iterator[Candidate]:
    """Combinations that violate relations, as candidates; chi2: with the relations, by the linear model."""
    for surfaces in broken:
        values, _ = contact_residuals(surfaces, problem.contacts)
        try:
            pose = frames(recipe_of(fixture), surfaces)[0]
        except FrameError:
            continue
        chi2 = float(((values / problem.sigmas) ** 2).sum()) + least_cost(problem, surfaces)
        rms = float(np.sqrt((values**2).mean()))
        yield Candidate(pose, surfaces, chi2, rms, (_broken_relation(fixture, problem, surfaces),))


def _broken_relation(fixture: Fixture, problem: JointProblem, surfaces: Mapping[str, Surface]) -> Reason:
    """The relation that is violated most, in words."""

    def missing(equation: Equation) -> float:
        residual, *_ = equation.linear(surfaces)
        return float(np.abs(residual).max(initial=0.0)) / equation.unit(problem.scale)

    worst = max(nearest_branch(problem.relations, surfaces), key=missing)
    relation = worst.relation
    one, other = relation.between
    size = missing(worst) * (problem.scale if relation.kind == "distance" else 180 / np.pi)
    unit = fixture.units if relation.kind == "distance" else "deg"
    message = f"the {relation.kind} between {one} and {other} would be {size:.4g} {unit} off"
    return Reason("relation", other, None, message)
