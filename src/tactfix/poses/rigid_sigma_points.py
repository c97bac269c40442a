"""How far a rigid fixture may stand from its best pose: sigma points of the contacts' residuals (`spread`)."""

from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Placement
from tactfix.geometry.arrays import Floats
from tactfix.poses.descent import descend, stepped
from tactfix.poses.equations import PoseEquations, evaluate
from tactfix.poses.pose_fit import PoseFit, equations_near, moved_poses, no_motion
from tactfix.poses.sigma_points import NEARLY_LINEAR, Spread, curved_spread, most_bend
from tactfix.values import frozen_value

MOST_SIGMA_POINT_STEPS = 60
"""Steps of a descent towards a sigma point; what has not arrived then makes the covariance untrusted."""


def rigid_spread(fit: PoseFit, contacts: Contacts, sigmas: Floats, placement: Placement | None = None) -> Spread:
    """The spread of a rigid fixture's pose; sigmas (n,) of the residuals, placement: what is known beforehand."""
    origin = fit.base_from_fixture[:3, 3]
    values, motions = fit.sensitivity.svd()
    known = ~fit.sensitivity.free(values)
    linear = fit.sensitivity.twists(motions[known] / values[known][:, None], origin).T
    if not known.all():
        return Spread(linear, fit.sensitivity.twists(motions[~known], origin).T, trusted=True)
    # The weakest motion, rotation and translation together, moves contacts by about twice its length.
    if most_bend(2 / values[-1], contacts, sigmas, fit.surfaces.values(), origin) < NEARLY_LINEAR:
        return Spread(linear, np.zeros((6, 0)), trusted=True)
    return _NearPose.of(fit, contacts, sigmas, placement).spread(linear)


@frozen_value
class _NearPose:
    """The residuals near a fit (`pose_fit.equations_near`): best (r,) and jacobian (r, u) at no motion."""

    fit: PoseFit
    equations: PoseEquations
    best: Floats
    jacobian: Floats

    @staticmethod
    def of(fit: PoseFit, contacts: Contacts, sigmas: Floats, placement: Placement | None) -> "_NearPose":
        equations = equations_near(fit, contacts, sigmas, placement)
        best, jacobian = evaluate(equations, *no_motion(1), geometric=True)
        return _NearPose(fit, equations, best[:, 0], jacobian[:, :, 0].T)

    def spread(self, linear: Floats) -> Spread:
        _, values, axes = np.linalg.svd(self.jacobian, full_matrices=False)
        pose, centre = self.fit.base_from_fixture, self.fit.sensitivity.centre
        return curved_spread(pose, centre, linear, axes.T / values, self._bend, self._reach)

    def _bend(self, steps: Floats) -> Floats:
        off, _ = evaluate(self._towards(steps), *self._moves(steps), geometric=True)
        return np.asarray(np.linalg.norm(off, axis=0))

    def _towards(self, steps: Floats) -> PoseEquations:
        """The equations of the poses at which the residuals are what the linear model has after steps (u, m)."""
        return replace(self.equations, targets=self.best[:, None] + self.jacobian @ steps)

    def _reach(self, steps: Floats) -> tuple[Floats, Floats]:
        equations, starts = self._towards(steps), self._moves(steps)
        ends = descend(equations, *starts, np.inf, geometric=True, most_steps=MOST_SIGMA_POINT_STEPS)
        # A descent from where the residuals are no numbers has no end.
        lost = np.full(steps.shape[1] - len(ends), np.inf)
        return moved_poses(self.fit, ends.rotations, ends.offsets), np.append(ends.costs, lost)

    def _moves(self, steps: Floats) -> tuple[Floats, Floats]:
        """Rotations (3, 3, m) and offsets (3, m) of motions of the contacts by steps (u, m)."""
        return stepped(self.equations, steps, *no_motion(steps.shape[1]))
