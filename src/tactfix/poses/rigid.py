"""Solutions for a rigid fixture: every pose of `all_poses`, with its uncertainty (`sigma_points`)."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import axial
from tactfix.geometry.surfaces import Surface, moved
from tactfix.placement import Placement
from tactfix.poses.all_poses import all_poses
from tactfix.poses.descent import descend, stepped
from tactfix.poses.equations import PoseEquations, evaluate
from tactfix.poses.points_as_planes import Equations, one_equation_each
from tactfix.poses.pose_fit import PoseFit, contact_residuals, equations_near, fit_at, moved_poses, no_motion
from tactfix.poses.sigma_points import NEARLY_LINEAR, Spread, curved_spread, most_bend
from tactfix.poses.solution import Solution, Solutions, solution_from
from tactfix.values import frozen_value

UNRESOLVED = 0.5
"""Change of all residuals, in sigma, below which two poses are one: no test of the contacts distinguishes half a
sigma."""
MOST_SIGMA_POINT_STEPS = 60
"""Most steps of the descent to a sigma point. If it has not converged, there is no such pose, and the covariance is
not trusted."""


def rigid_solutions(
    surfaces: Mapping[str, Surface],
    contacts: Contacts,
    sigmas: Floats,
    with_misses: bool = True,
    placement: Placement | None = None,
    thorough: bool = True,
    most_starts: int | None = None,
) -> Solutions:
    """Every pose of a rigid fixture that explains the contacts, with its uncertainty; arguments as of `all_poses`."""
    single = one_equation_each(surfaces, contacts, sigmas)
    search = all_poses(single.surfaces, single.contacts, single.sigmas, with_misses, placement, thorough, most_starts)
    found = [_solution(fit, surfaces, contacts, single, placement) for fit in distinct(search.found)]
    solutions = Solutions(tuple(found), search.dof, search.limit, search.complete, search.continuum)
    if search.aside is None:
        return solutions
    aside = [_solution(fit, surfaces, contacts, single, None) for fit in distinct(search.aside)]
    return replace(solutions, aside=tuple(aside))


def distinct(fits: Sequence[PoseFit]) -> list[PoseFit]:
    """The fits, best first, without those that the contacts do not distinguish from a better one close by."""
    kept: list[PoseFit] = []
    for fit in sorted(fits, key=lambda fit: fit.chi2):
        if not any(_unresolved(other, fit) for other in kept):
            kept.append(fit)
    return kept


def _unresolved(one: PoseFit, other: PoseFit) -> bool:
    """Whether the motion from one pose to the other is small and changes the residuals by less than UNRESOLVED."""
    turn = other.base_from_fixture[:3, :3] @ one.base_from_fixture[:3, :3].T
    if np.trace(turn) < 2.99:
        return False
    centre = one.sensitivity.centre
    one_origin, other_origin = one.base_from_fixture[:3, 3], other.base_from_fixture[:3, 3]
    shift = other_origin + turn @ (centre - one_origin) - centre
    change = one.sensitivity.jacobian @ np.concatenate([axial(turn) * one.sensitivity.scale, shift])
    return bool(np.linalg.norm(change) < UNRESOLVED)


def solution_at(
    base_from_fixture: Floats, surfaces: Mapping[str, Surface], contacts: Contacts, sigmas: Floats
) -> Solution:
    """The solution at a pose (4, 4) that is a minimum of chi-square; surfaces in the fixture's frame."""
    single = one_equation_each(surfaces, contacts, sigmas)
    fit = fit_at(single.surfaces, single.contacts, single.sigmas, base_from_fixture)
    return _solution(fit, surfaces, contacts, single, None)


def _solution(
    fit: PoseFit, surfaces: Mapping[str, Surface], contacts: Contacts, single: Equations, placement: Placement | None
) -> Solution:
    """The fit with its uncertainty, for the given contacts and surfaces; single: the same with one equation each."""
    in_fit = placement if placement is not None and placement.is_in_fit else None
    spread = rigid_spread(fit, single.contacts, single.sigmas, in_fit)
    in_base = {name: moved(fit.base_from_fixture, surface) for name, surface in surfaces.items()}
    values, normals = contact_residuals(in_base, contacts)
    return solution_from(fit.base_from_fixture, in_base, contacts, values, normals, fit.chi2, spread)


def rigid_spread(fit: PoseFit, contacts: Contacts, sigmas: Floats, placement: Placement | None = None) -> Spread:
    """The spread of a rigid fixture's pose; sigmas (n,) of the residuals, placement: prior knowledge of the pose."""
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
        """The equations of the poses at which the residuals are those of the linear model after steps (u, m)."""
        return replace(self.equations, targets=self.best[:, None] + self.jacobian @ steps)

    def _reach(self, steps: Floats) -> tuple[Floats, Floats]:
        equations, starts = self._towards(steps), self._moves(steps)
        ends = descend(equations, *starts, np.inf, geometric=True, most_steps=MOST_SIGMA_POINT_STEPS)
        # A descent that starts from residuals of nan has no end.
        lost = np.full(steps.shape[1] - len(ends), np.inf)
        return moved_poses(self.fit, ends.rotations, ends.offsets), np.append(ends.costs, lost)

    def _moves(self, steps: Floats) -> tuple[Floats, Floats]:
        """Rotations (3, 3, m) and offsets (3, m) of motions of the contacts by steps (u, m)."""
        return stepped(self.equations, steps, *no_motion(steps.shape[1]))
