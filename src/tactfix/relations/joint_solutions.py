"""Solutions from joint fits: indistinct ones are merged, and each is given in the frames that the recipe allows."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture, FrameRecipe
from tactfix.frame import FrameError, frame, frames, recipe_of, sign_choices
from tactfix.geometry.arrays import Floats
from tactfix.geometry.charts import displaced
from tactfix.noise import SURE, chi_square_limit
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.sigma_points import FOLDED, Spread, motions_between
from tactfix.poses.solution import Solution, Solutions, solution_from
from tactfix.relations.branches import are_same_branches
from tactfix.relations.joint_problem import JointFit, JointProblem
from tactfix.relations.joint_sigma_points import JointSpread
from tactfix.relations.unresolved import are_one, weight
from tactfix.values import frozen_value

RELATIONS_HOLD = 1e-9
"""Largest violation of an exact relation (rad, fixture sizes) in a solution: a thousand times `joint.KEPT`, so that
only fits fail that have not converged onto the relations at all."""
FRAME_STEP = 1e-7
"""Step (rad, fixture sizes) of the forward differences of the frame: near the root of the rounding of doubles, 1.5e-8,
where rounding (2e-9) and second order (1e-7) are far below what a covariance needs."""

SURE_IF_CURVED = SURE * FOLDED
"""Sigmas of the linear model by which an approach that comes out of the material rejects a solution: those of a curved
spread are FOLDED times as large at most, or it is not trusted. Without sigma points for these solutions
`tests.validation.relations_study` takes three quarters of the time, and its results are the same."""


@frozen_value
class Group:
    """The best of some indistinct fits, and the others."""

    best: JointFit
    others: list[JointFit]


def joint_solutions(
    fixture: Fixture, problem: JointProblem, fits: Sequence[JointFit], continuum: bool = False, curved: bool = True
) -> Solutions:
    """The frames of each fit within its limit; of the best fit if none is.

    curved False, a fit above its limit, or one whose normals contradict the approaches: the covariance is that of the
    linear model.

    Raises FrameError if the recipe has no frame for any fit that explains the contacts.
    """
    groups = grouped(fits, problem)
    dof = groups[0].best.dof if groups else fixture.equations(problem.contacts.features) - 6
    limit = chi_square_limit(dof)
    explaining = [group for group in groups if group.best.chi2 <= limit]
    found: list[Solution] = []
    refusal: FrameError | None = None
    for group in explaining or groups[:1]:
        try:
            found += _framed(fixture, problem, group, curved and bool(explaining))
        except FrameError as error:
            refusal = error
    if refusal is not None and explaining and not found and not continuum:
        raise refusal
    return Solutions(tuple(found), dof, limit, complete=True, continuum=continuum)


def grouped(fits: Sequence[JointFit], problem: JointProblem) -> list[Group]:
    """Groups of indistinct fits, best first."""
    groups: list[Group] = []
    for fit in sorted((fit for fit in fits if fit.missing < RELATIONS_HOLD), key=lambda fit: fit.chi2):
        group = next((group for group in groups if _are_one(group.best, fit, problem)), None)
        if group is None:
            groups.append(Group(fit, []))
        else:
            group.others.append(fit)
    return groups


def _are_one(one: JointFit, other: JointFit, problem: JointProblem) -> bool:
    same_branch = are_same_branches(one.equations, other.equations, one.surfaces, other.surfaces)
    return are_one(one.surfaces, other.surfaces, problem.contacts, problem.sigmas, problem.scale, same_branch)


def _framed(fixture: Fixture, problem: JointProblem, group: Group, curved: bool) -> list[Solution]:
    """One solution per frame that the recipe allows; their spread is the same, since it is in base axes."""
    recipe, fit = recipe_of(fixture), group.best
    pose, *others = frames(recipe, fit.surfaces)
    values, normals = contact_residuals(fit.surfaces, problem.contacts)
    aside = [np.sqrt(weight(fit.chi2, other.chi2)) * _motion_to(recipe, pose, other) for other in group.others]

    def of(spread: Spread) -> Solution:
        spread = replace(spread, factor=np.hstack([spread.factor, *aside]))
        return solution_from(pose, fit.surfaces, problem.contacts, values, normals, fit.chi2, spread)

    joint = JointSpread(problem, recipe, fit, _frame_jacobian(recipe, fit))
    solution = of(joint.linear)
    if curved and not _comes_out(problem.contacts, solution):
        solution = of(joint.at(pose))
    return [solution, *(replace(solution, base_from_fixture=other) for other in others)]


def _comes_out(contacts: Contacts, solution: Solution) -> bool:
    """Whether the probe came out of the material at some contact, whatever the curved spread."""
    cosine = np.einsum("ij,ij->i", contacts.approaches, solution.normals)
    return bool((contacts.has_approach & (cosine > SURE_IF_CURVED * solution.normal_sigmas)).any())


def _motion_to(recipe: FrameRecipe, pose: Floats, other: JointFit) -> Floats:
    """The motion (6, 1) from a pose to the nearest frame of another fit."""
    poses = np.array(frames(recipe, other.surfaces))
    alike = np.einsum("mij,ij->m", poses[:, :3, :3], pose[:3, :3])
    return motions_between(pose, poses[[np.argmax(alike)]])


def _frame_jacobian(recipe: FrameRecipe, fit: JointFit) -> Floats:
    """Derivatives (6, width) of the frame, rotation and origin, by the displacements, by forward differences."""
    steps = FRAME_STEP * np.diag(fit.lengths)
    steps = np.vstack([np.zeros(len(steps)), steps])
    moved = {name: displaced(surface, steps[:, fit.columns[name]]) for name, surface in fit.surfaces.items()}
    still, *others = frame(recipe, moved, sign_choices(recipe, fit.surfaces)[0])
    return motions_between(still, np.array(others)) / FRAME_STEP
