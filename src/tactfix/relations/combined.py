"""Features that were located alone, fitted together: steps 2 to 5 of `assembly`, where its step 1 does not do.

A module of its own because it needs every localizer and all that fits branches: fixtures of step 1, such as the
paper's, locate without importing them.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Surface
from tactfix.noise import chi_square_limit
from tactfix.poses.solution import Solutions
from tactfix.relations.branch_fits import Start, Starts, branch_fit, starts_from
from tactfix.relations.branches import BRANCH_FITS
from tactfix.relations.broken_relations import broken_candidates
from tactfix.relations.combinations import Combinations, combinations, located_alone
from tactfix.relations.joint_problem import JointFit, JointProblem
from tactfix.relations.joint_solutions import joint_solutions
from tactfix.relations.realization import bodies, body_number, fixture_scale
from tactfix.relations.rigid_bodies import Body, body_solutions
from tactfix.relations.samples import sampled_solutions
from tactfix.results import Candidate

SHAPE_LIMIT = 10.0
"""Times the limit of chi-square that a fit may have for its shape to be searched."""
FEW_COMBINATIONS = 64
"""Beyond so many combinations a rigid fixture is searched as one body, which costs the same however many there are."""
SHAPE_COMBINATIONS = 4096
"""Combinations of surfaces and signs that start a fit each; beyond, the result is said not to be complete."""
FEW_FITS = 12
"""Starts that are followed where contacts are as good as flat, and whatever is found says next to nothing."""
MOST_FALLEN = 32
"""Combinations that fell because of a relation and are listed."""
SLACK_FACTOR = 3.0
"""Times the slack of the relations, added to the contacts' sigma while a fixture is searched as if it were rigid."""


def combined_solutions(
    fixture: Fixture, contacts: Contacts, sigmas: Floats, shapes: Sequence[Body], is_exact: bool, with_misses: bool
) -> Solutions:
    """The poses of a fixture whose relations leave these shapes (none where they are free), exactly or with a sigma."""
    problem = JointProblem(contacts, sigmas, fixture.relations, fixture_scale(fixture))
    alone = located_alone(fixture, contacts, sigmas)  # step 2
    located = combinations(fixture, contacts, alone, SHAPE_COMBINATIONS + 1)
    if located is None and not shapes:
        return sampled_solutions(fixture, problem, alone.candidates)
    if located is None or (shapes and (located.weak or len(located.surfaces) > FEW_COMBINATIONS)):
        if is_exact:  # step 3
            return body_solutions(fixture, shapes, contacts, sigmas, with_misses)
        return _loosened(fixture, problem, with_misses)
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
    """Combinations that explain the contacts of each feature but break a relation, where others do not."""
    kept = {start.number for start, fit in zip(starts, fits, strict=True) if fit.chi2 <= limit}
    broken = [surfaces for number, surfaces in enumerate(found) if number not in kept] if kept else []
    return broken_candidates(fixture, problem, broken[:MOST_FALLEN])


def _loosened(fixture: Fixture, problem: JointProblem, with_misses: bool) -> Solutions:
    """The joint fits next to every pose of the rigid shapes with contacts as unsure as the shapes.

    Where none explains even these, next to the nearest miss; samples where they leave a motion free.
    """
    loose = np.hypot(problem.sigmas, SLACK_FACTOR * _slack(fixture, problem.scale))
    rigid = body_solutions(fixture, bodies(fixture), problem.contacts, loose, with_misses)
    starts, fits = _fits(problem, [solution.surfaces for solution in rigid.found], with_misses)
    solutions = joint_solutions(fixture, problem, fits, rigid.continuum)
    return replace(solutions, complete=rigid.complete and starts.left_out > solutions.limit)


def _slack(fixture: Fixture, scale: float) -> float:
    """How far (length) the relations let the features be from where their values put them, one standard deviation."""
    return float(np.linalg.norm([r.sigma * (1.0 if r.kind == "distance" else scale) for r in fixture.relations]))
