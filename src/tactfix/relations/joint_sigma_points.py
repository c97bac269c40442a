"""How far a fixture by relations may stand from its best pose: sigma points (`poses.sigma_points`).

Features have more displacements than the frame has motions. Sigma points lie along the six that move the frame, to
first order; the others move it in second order at most.

1. The displacements that contacts and relations leave, in sigmas, are carried to the frame by its derivatives.
2. That linear spread is trusted where the frame is free, or the surfaces bend next to nothing as far as it reaches.
3. Else singular vectors say along which displacements the frame moves.
4. A joint fit leads to each sigma point there (`poses.sigma_points`): it is asked for the residuals that the linear
   model has after that step.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tactfix.fixture import FrameRecipe
from tactfix.frame import FrameError, frames
from tactfix.geometry.arrays import Floats
from tactfix.poses.sigma_points import MOST_MISSING, NEARLY_LINEAR, Spread, curved_spread, most_bend
from tactfix.relations.joint import fit_at, joint_fit
from tactfix.relations.joint_problem import JointFit, JointProblem
from tactfix.values import frozen_value

JOINT_SIGMA_POINT_STEPS = 20
"""Steps to a sigma point: where more would be needed it is too far off for a covariance to mean anything, and so are
those after it, which are not asked for."""
FRAME_AT_REST = 1e-9
"""Share of the largest free motion below which a free displacement does not move the frame."""


@frozen_value
class JointSpread:
    """One fit of a fixture by relations: the spread of each frame that the recipe makes of it.

    frame_jacobian (6, width): how the frame moves with the displacements of the features.
    """

    problem: JointProblem
    recipe: FrameRecipe
    fit: JointFit
    frame_jacobian: Floats

    def at(self, base_from_fixture: Floats, curved: bool = True) -> Spread:
        """The spread of one of the frames (4, 4); without curved that of the linear model, which is trusted."""
        factor, free = self.fit.spread()
        linear, moving = self.frame_jacobian @ factor, self.frame_jacobian @ free.T  # step 1
        is_free = np.abs(moving).max(initial=0.0) > FRAME_AT_REST * np.abs(self.frame_jacobian).max()
        if is_free or not curved or self._most_bend(factor, base_from_fixture[:3, 3]) < NEARLY_LINEAR:
            return Spread(linear, moving, trusted=True)  # step 2
        centre = self.problem.contacts.centre
        # Of all directions those along which the frame moves: a fold of a feature aside from it is none of its own.
        along = np.linalg.svd(linear, full_matrices=False)[2].T  # step 3
        reach = self._reach(base_from_fixture, self.fit.jacobian @ factor)  # step 4
        return curved_spread(base_from_fixture, centre, linear @ along, factor @ along, self._bend, reach)

    def _most_bend(self, factor: Floats, origin: Floats) -> float:
        contacts = self.problem.contacts
        arm = float(np.abs(contacts.points - contacts.centre).max())
        lengths = np.where(self.fit.lengths == 1.0, arm, self.fit.lengths)
        moves = np.linalg.norm(lengths[:, None] * factor, axis=1)
        surfaces = self.fit.surfaces.values()
        return most_bend(2 * float(moves.max()), contacts, self.problem.sigmas, surfaces, origin)

    def _bend(self, steps: Floats) -> Floats:
        """By how much the residuals after steps (width, m), relations kept, differ from linear ones."""
        bends = []
        for step in steps.T:
            there = fit_at(self.problem, self.fit, step).observed
            bends.append(np.linalg.norm(there - self.fit.observed - self.fit.jacobian @ step))
        return np.array(bends)

    def _reach(self, base_from_fixture: Floats, tangents: Floats) -> Callable[[Floats], tuple[Floats, Floats]]:
        """As `curved_spread` wants it; tangents (m, k): an orthonormal basis of how the residuals move.

        Missing is only what displacements might make up for: of more observations than unknowns the residuals also bend
        away from the tangents, without any fold.
        """

        def reach(steps: Floats) -> tuple[Floats, Floats]:
            reached = np.repeat(base_from_fixture[None], steps.shape[1], axis=0)
            missing = np.full(steps.shape[1], np.inf)
            for number, step in enumerate(steps.T):
                wanted = self.fit.observed + self.fit.jacobian @ step
                problem = replace(self.problem, wanted=wanted)
                there = joint_fit(problem, self.fit.surfaces, self.fit.equations, JOINT_SIGMA_POINT_STEPS)
                along = tangents.T @ there.observed
                if along @ along > MOST_MISSING:
                    break
                try:
                    poses = np.array(frames(self.recipe, there.surfaces))
                except FrameError:
                    continue
                # Of the frames that the recipe allows the one with the same signs.
                alike = np.einsum("mij,ij->m", poses[:, :3, :3], base_from_fixture[:3, :3])
                reached[number] = poses[np.argmax(alike)]
                missing[number] = along @ along
            return reached, missing

        return reach
