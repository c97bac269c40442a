"""The covariance of the frame of a fixture by relations, from sigma points (`poses.sigma_points`).

The features have more displacements than the frame has degrees of freedom. Sigma points lie along the six combinations
that move the frame to first order; the others move it to second order at most.

1. The factor of the covariance of the displacements is multiplied by the Jacobian of the frame.
2. This linear spread is used if a motion of the frame is free, or if the residuals are nearly linear within it.
3. Otherwise the right singular vectors of that product are the displacements that move the frame.
4. A joint fit gives the sigma point of each of them (`poses.sigma_points`): its targets are the residuals of the
   linear model after that step. If one misses them, a fold is near, and all are computed at a smaller distance.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np

from tactfix.fixture import FrameRecipe
from tactfix.frame import FrameError, frames
from tactfix.geometry.arrays import Floats
from tactfix.poses.sigma_points import MOST_MISSING, NEARLY_LINEAR, SigmaPointSolver, Spread, curved_spread, most_bend
from tactfix.relations.joint import fit_at, joint_fit
from tactfix.relations.joint_problem import JointFit, JointProblem
from tactfix.values import frozen_value

JOINT_SIGMA_POINT_STEPS = 20
"""Steps of the fit of one sigma point. If it does not converge, the frame is too nonlinear for a covariance, and the
remaining points are not computed."""
NEARER_POINTS = 1.0
"""Distance in sigma of the sigma points if some at SIGMA_POINT_DISTANCE miss their residuals. The second moment is
exact to second order at any distance, and a fold within one sigma still makes the covariance untrusted. Contacts on
a small cap of a ball have a fold at two sigma, with which the frame hardly moves. They are needed once in 1,500
problems of `tests.validation.relations_study`. Of 39 located with contacts of 0.2 mm 35 are covered (76 to 97 per cent,
94.7 of 2,854 others: `tests.validation.nearer_points`)."""
FRAME_AT_REST = 1e-9
"""A free displacement leaves the frame at rest if it moves it by less than this share of the largest derivative of the
frame: the rounding of the derivatives is 1e-16 / `joint_solutions.FRAME_STEP` = 1e-9."""


@frozen_value
class JointSpread:
    """The spread of the frames of one fit of a fixture by relations.

    frame_jacobian (6, width): derivatives of the frame by the displacements of the features.
    """

    problem: JointProblem
    recipe: FrameRecipe
    fit: JointFit
    frame_jacobian: Floats

    @cached_property
    def linear(self) -> Spread:
        """The spread of the linear model, the same for each of the frames, marked as trusted."""
        factor, free = self.fit.spread()
        return Spread(self.frame_jacobian @ factor, self.frame_jacobian @ free.T, trusted=True)  # step 1

    def at(self, base_from_fixture: Floats) -> Spread:
        """The spread of one of the frames (4, 4)."""
        linear, factor = self.linear.factor, self.fit.spread()[0]
        is_free = np.abs(self.linear.free).max(initial=0.0) > FRAME_AT_REST * np.abs(self.frame_jacobian).max()
        if is_free or self._most_bend(factor, base_from_fixture[:3, 3]) < NEARLY_LINEAR:
            return self.linear  # step 2
        centre = self.problem.contacts.centre
        # Only directions that move the frame: a fold of another feature does not concern it.
        along = np.linalg.svd(linear, full_matrices=False)[2].T  # step 3
        solver = self._solver(base_from_fixture, self.fit.jacobian @ factor)  # step 4
        return curved_spread(
            base_from_fixture, centre, linear @ along, factor @ along, self._bend, solver, NEARER_POINTS
        )

    def _most_bend(self, factor: Floats, origin: Floats) -> float:
        contacts = self.problem.contacts
        arm = float(np.abs(contacts.points - contacts.centre).max())
        lengths = np.where(self.fit.lengths == 1.0, arm, self.fit.lengths)
        moves = np.linalg.norm(lengths[:, None] * factor, axis=1)
        surfaces = self.fit.surfaces.values()
        return most_bend(2 * float(moves.max()), contacts, self.problem.sigmas, surfaces, origin)

    def _bend(self, steps: Floats) -> Floats:
        """The distance of the residuals after steps (width, m), relations kept, from those of the linear model."""
        bends = []
        for step in steps.T:
            observed = fit_at(self.problem, self.fit, step).observed
            bends.append(np.linalg.norm(observed - self.fit.observed - self.fit.jacobian @ step))
        return np.array(bends)

    def _solver(self, base_from_fixture: Floats, tangents: Floats) -> SigmaPointSolver:
        """The solver for `curved_spread`; tangents (m, k): an orthonormal basis of the residuals' tangent space.

        The missing chi-square is that along the tangents: with more observations than unknowns the residuals also bend
        away from the tangent space, without any fold.
        """

        def solve(steps: Floats) -> tuple[Floats, Floats]:
            solved = np.repeat(base_from_fixture[None], steps.shape[1], axis=0)
            missing = np.full(steps.shape[1], np.inf)
            for number, step in enumerate(steps.T):
                wanted = self.fit.observed + self.fit.jacobian @ step
                problem = replace(self.problem, wanted=wanted)
                # From the point of the linear model: on the way to it small sigmas of relations allow short steps only.
                start = fit_at(self.problem, self.fit, step).surfaces
                fit = joint_fit(problem, start, self.fit.equations, JOINT_SIGMA_POINT_STEPS)
                along = tangents.T @ fit.observed
                if along @ along > MOST_MISSING:
                    break
                try:
                    poses = np.array(frames(self.recipe, fit.surfaces))
                except FrameError:
                    continue
                # The frame with the same axis signs, of those that the recipe allows.
                alike = np.einsum("mij,ij->m", poses[:, :3, :3], base_from_fixture[:3, :3])
                solved[number] = poses[np.argmax(alike)]
                missing[number] = along @ along
            return solved, missing

        return solve
