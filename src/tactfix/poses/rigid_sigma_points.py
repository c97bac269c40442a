"""How far a rigid fixture may stand from its best pose: sigma points of the contacts' residuals (`spread`)."""

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Placement
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import homogeneous, inverse
from tactfix.geometry.surfaces import rescaled
from tactfix.poses.descent import damped_step, stepped
from tactfix.poses.equations import PoseEquations, evaluate, pose_equations
from tactfix.poses.placement_terms import with_placement
from tactfix.poses.pose_fit import PoseFit
from tactfix.poses.sigma_points import NEARLY_LINEAR, Spread, curved_spread, most_bend
from tactfix.values import frozen_value

MOST_SIGMA_POINT_STEPS = 60
"""Levenberg-Marquardt steps towards a sigma point; what has not arrived then makes the covariance untrusted."""
SIGMA_POINT_REACHED = 1e-8
"""Length of a step (rad, spreads of the contacts) with which a sigma point has been reached."""


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
    """The contacts' residuals over sigma as functions of a small motion of the contacts about their centroid.

    Lengths in units of scale. best (r,): the residuals, jacobian (r, u) at no motion.
    """

    fit: PoseFit
    equations: PoseEquations
    best: Floats
    jacobian: Floats

    @staticmethod
    def of(fit: PoseFit, contacts: Contacts, sigmas: Floats, placement: Placement | None) -> "_NearPose":
        centre, scale = fit.sensitivity.centre, fit.sensitivity.scale
        names = list(contacts.by_feature)
        surfaces = [rescaled(fit.surfaces[name], centre, scale) for name in names]
        index = [names.index(name) for name in contacts.features]
        points = (contacts.points - centre) / scale
        equations = pose_equations(surfaces, index, points, scale / sigmas, contacts.tip_radius / scale)
        if placement is not None:
            frame_from_fixture = fit.base_from_fixture.copy()
            frame_from_fixture[:3, 3] -= centre
            equations = with_placement(equations, placement, centre, frame_from_fixture, scale, scale)
        best, jacobian = evaluate(equations, *_still(1), geometric=True)
        return _NearPose(fit, equations, best[:, 0], jacobian[:, :, 0].T)

    def spread(self, linear: Floats) -> Spread:
        _, values, axes = np.linalg.svd(self.jacobian, full_matrices=False)
        pose, centre = self.fit.base_from_fixture, self.fit.sensitivity.centre
        return curved_spread(pose, centre, linear, axes.T / values, self._bend, self._reach)

    def _bend(self, steps: Floats) -> Floats:
        residuals, _ = evaluate(self.equations, *self._moves(steps), geometric=True)
        return np.asarray(np.linalg.norm(residuals - self._wanted(steps), axis=0))

    def _wanted(self, steps: Floats) -> Floats:
        return np.asarray(self.best[:, None] + self.jacobian @ steps)

    def _reach(self, steps: Floats) -> tuple[Floats, Floats]:
        """Levenberg-Marquardt to the poses at which the residuals are what the linear model has after steps (u, m)."""
        wanted, (rotations, offsets) = self._wanted(steps), self._moves(steps)
        residual, jacobian = self._misses(rotations, offsets, wanted)
        damping = np.full(steps.shape[1], 1e-6)
        for _ in range(MOST_SIGMA_POINT_STEPS):
            # Next to a fold a step may lead to infinity: nan is never better.
            with np.errstate(over="ignore", invalid="ignore"):
                step = damped_step(residual, jacobian, damping, turns=self.equations.turns)
                ahead = stepped(self.equations, step, rotations, offsets)
                new_residual, new_jacobian = self._misses(*ahead, wanted)
                better = (new_residual**2).sum(axis=0) < (residual**2).sum(axis=0)
            for old, new in zip(
                (rotations, offsets, residual, jacobian), (*ahead, new_residual, new_jacobian), strict=True
            ):
                np.copyto(old, new, where=better)
            damping = np.where(better, 0.1 * damping, 10 * damping)
            if ((np.abs(step).max(axis=0) < SIGMA_POINT_REACHED) | (damping > 1e6)).all():
                break
        return self._poses(rotations, offsets), np.asarray((residual**2).sum(axis=0))

    def _moves(self, steps: Floats) -> tuple[Floats, Floats]:
        """Rotations (3, 3, m) and offsets (3, m) of motions of the contacts by steps (u, m)."""
        return stepped(self.equations, steps, *_still(steps.shape[1]))

    def _misses(self, rotations: Floats, offsets: Floats, wanted: Floats) -> tuple[Floats, Floats]:
        residual, jacobian = evaluate(self.equations, rotations, offsets, geometric=True)
        return residual - wanted, jacobian

    def _poses(self, rotations: Floats, offsets: Floats) -> Floats:
        """The poses (m, 4, 4) of the fixture from which the contacts look as they do after these motions."""
        sensitivity = self.fit.sensitivity
        to_centre = homogeneous(np.eye(3), -sensitivity.centre)
        contacts_moved = homogeneous(np.moveaxis(rotations, -1, 0), sensitivity.scale * offsets.T)
        return np.asarray(inverse(to_centre) @ inverse(contacts_moved) @ to_centre @ self.fit.base_from_fixture)


def _still(count: int) -> tuple[Floats, Floats]:
    """Rotations (3, 3, count) and offsets (3, count) of no motion."""
    return np.repeat(np.eye(3)[:, :, None], count, axis=2), np.zeros((3, count))
