"""Combinations of surfaces that explain the contacts of each feature but violate a relation, as candidates."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from tactfix.fixture import Fixture
from tactfix.frame import FrameError, frames, recipe_of
from tactfix.geometry.surfaces import Surface
from tactfix.poses.pose_fit import contact_residuals
from tactfix.relations.branches import least_cost, nearest_branch
from tactfix.relations.equations import Equation
from tactfix.relations.joint_problem import JointProblem
from tactfix.results import Candidate, Reason


def broken_candidates(
    fixture: Fixture, problem: JointProblem, combinations: Sequence[Mapping[str, Surface]]
) -> Iterator[Candidate]:
    """Combinations that violate relations, as candidates; chi2: with the relations, by the linear model."""
    for surfaces in combinations:
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
