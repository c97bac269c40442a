"""One pose with its tip, and their joint covariance.

1. The Jacobian of all unknowns at the solution is decomposed into singular values and motions (`Knowledge`).
2. Motions with a singular value of zero are free; those with a sigma above NEARLY_FREE are nearly free.
3. The tip is determined if no free motion moves it, and no nearly free one by more than HARDLY_MOVED.
4. The others give a factor of the joint covariance, transformed from the contacts' centre to the fixture's origin.
"""

from functools import cached_property

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import TINY, Bools, Floats
from tactfix.geometry.rigid import skew
from tactfix.poses.pose_fit import SMALLEST_RATIO
from tactfix.poses.solution import Solution
from tactfix.unknowns.equations import PosesWithTip, TipEquations
from tactfix.values import frozen_value

NEARLY_FREE = 0.1
"""Sigma of a motion, in rad or lengths of the problem, above which it counts as nearly free: as
`localization.free_motions.UNDERDETERMINED_ANGLE`."""

TIP_AT_REST = 1e-6
"""Share of a free motion (rad, lengths of the problem) up to which it leaves the tip at rest: rounding of a null
vector is 1e-9 and less (`pose_fit.SMALLEST_RATIO`)."""
HARDLY_MOVED = 1e-3
"""The same for a nearly free motion: its effect on the tip is part of the covariance, to first order."""


@frozen_value
class TipSolution:
    """A pose of least chi-square. solution: as for a known tip, with contacts corrected for this tip.

    tip (3,): displacement of the tip's centre from the reported one, flange frame. factor (u, m): S of the covariance
    S S^T of rotation (rad) and origin of the fixture in base axes, then of the unknown ones of tip and radius, without
    free motions. weak (k, 10): motions that are free or nearly free: rotation and translation of the fixture about the
    centre (3,) of the reported contacts, tip, radius; sigmas (k,): standard deviation of each, inf if free.
    tip_is_known: whether none of these moves the tip in the flange frame or changes its radius.
    """

    solution: Solution
    contacts: Contacts
    tip: Floats
    factor: Floats
    weak: Floats
    sigmas: Floats
    centre: Floats
    tip_is_known: bool

    @property
    def covariance(self) -> Floats:
        """The covariance (u, u), infinite where a motion is free."""
        if np.isinf(self.sigmas).any():
            return np.full((len(self.factor), len(self.factor)), np.inf)
        return np.asarray(self.factor @ self.factor.T)


@frozen_value
class Knowledge:
    """The singular values of the Jacobian at one trial, and their motions (step 1)."""

    equations: TipEquations
    trials: PosesWithTip
    jacobian: Floats

    @staticmethod
    def at(equations: TipEquations, trials: PosesWithTip) -> "Knowledge":
        """The decomposition at a single trial."""
        return Knowledge(equations, trials, equations.evaluate(trials)[1][0])

    @cached_property
    def svd(self) -> tuple[Floats, Floats]:
        """Singular values (u,), largest first, and motions (u, u), a row each."""
        width = self.jacobian.shape[1]
        rows = self.jacobian if len(self.jacobian) >= width else np.vstack([self.jacobian, np.zeros((width, width))])
        _, values, motions = np.linalg.svd(rows, full_matrices=False)
        return values, motions

    @property
    def is_free(self) -> Bools:
        """Which motions (u,) are free."""
        values = self.svd[0]
        return np.asarray(values <= SMALLEST_RATIO * max(float(values[0]), TINY))

    @property
    def is_weak(self) -> Bools:
        """Which motions (u,) are free or nearly free (step 2)."""
        return np.asarray(self.is_free | (self.svd[0] * NEARLY_FREE < 1))

    @property
    def determines_tip(self) -> bool:
        """Whether no free motion moves the tip or changes its radius, and no nearly free one by much (step 3)."""
        motions = np.zeros((len(self.svd[1]), 10))
        motions[:, self.equations.columns] = self.svd[1]
        moved = np.abs(motions[:, 6:]).max(axis=1)
        return bool((moved[self.is_free] < TIP_AT_REST).all() and (moved[self.is_weak] < HARDLY_MOVED).all())

    def motions(self, which: Bools) -> Floats:
        """The selected motions (k, 10) in rad and fixture units, about the contacts' centre; 0 for known parameters."""
        whole = np.zeros((int(which.sum()), 10))
        whole[:, self.equations.columns] = self.svd[1][which]
        whole[:, 3:] *= self.equations.length
        return whole

    def sigmas(self, which: Bools) -> Floats:
        """Standard deviations (k,) of the selected motions, in rad or lengths of the problem."""
        values = np.where(self.is_free, 0.0, self.svd[0])[which]
        with np.errstate(divide="ignore"):
            return np.asarray(1 / values)

    def factor(self) -> Floats:
        """A factor S (u, m) of the covariance S S^T, about the fixture's origin, of the motions that are not free."""
        known = ~self.is_free
        about_centre = self.motions(known) / self.svd[0][known][:, None]
        arm = self.equations.length * self.trials.origins[0]
        return np.asarray((about_centre @ about_origin(arm).T)[:, self.equations.columns].T)


def about_origin(arm: Floats) -> Floats:
    """The matrix (10, 10) from motions about the contacts' centre to those of a point at arm (3,) from it."""
    shift = np.eye(10)
    shift[3:6, :3] = -skew(arm)
    return shift
