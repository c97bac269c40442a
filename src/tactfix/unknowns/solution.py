"""One pose with the tip that belongs to it, and how sure all of it is together."""

from functools import cached_property

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import TINY, Bools, Floats
from tactfix.geometry.rigid import skew
from tactfix.poses.pose_fit import SMALLEST_RATIO
from tactfix.poses.solution import Solution
from tactfix.unknowns.equations import TipEquations, Trials
from tactfix.values import frozen_value

TELLS_NOTHING = 0.1
"""A motion that is known only to this, in rad or lengths of the problem, one sigma, tells nothing: as good as free."""

TIP_AT_REST = 1e-6
"""Share of a free motion, in rad and lengths of the problem, up to which it moves the tip by rounding only."""
HARDLY_MOVED = 1e-3
"""The same of a motion that is weak: what it does to the tip is in the covariance, to first order."""


@frozen_value
class TipSolution:
    """A pose of least chi-square. solution: as for a known tip, with the contacts as this tip makes them.

    tip (3,): how far the tip's centre is off that of the contacts, flange frame. factor (u, m): S of the covariance
    S S^T of rotation (rad) and place of the fixture's origin in base axes, then of what of tip and radius is unknown,
    of what is not free. weak (k, 10): motions that are free or as good as free: rotation and translation of the fixture
    about the centre (3,) of the contacts as they were reported, tip, radius; sigmas (k,): how surely each is known, inf
    where free. tip_is_known: whether none of those moves the tip in its flange, or changes its radius.
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
    """What the equations tell at one trial: the singular values of their Jacobian, and the motions they belong to."""

    equations: TipEquations
    trials: Trials
    jacobian: Floats

    @staticmethod
    def at(equations: TipEquations, trials: Trials) -> "Knowledge":
        """That of a single trial."""
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
        """Which motions (u,) nothing resists."""
        values = self.svd[0]
        return np.asarray(values <= SMALLEST_RATIO * max(float(values[0]), TINY))

    @property
    def is_weak(self) -> Bools:
        """Which motions (u,) are free, or as good as free."""
        return np.asarray(self.is_free | (self.svd[0] * TELLS_NOTHING < 1))

    @property
    def tells_tip(self) -> bool:
        """Whether no motion that is free moves the tip or changes its radius, and none that is weak does so much."""
        motions = np.zeros((len(self.svd[1]), 10))
        motions[:, self.equations.columns] = self.svd[1]
        moved = np.abs(motions[:, 6:]).max(axis=1)
        return bool((moved[self.is_free] < TIP_AT_REST).all() and (moved[self.is_weak] < HARDLY_MOVED).all())

    def motions(self, which: Bools) -> Floats:
        """Those motions (k, 10) in rad and fixture units, about the contacts' centre, not known ones 0."""
        whole = np.zeros((int(which.sum()), 10))
        whole[:, self.equations.columns] = self.svd[1][which]
        whole[:, 3:] *= self.equations.length
        return whole

    def sigmas(self, which: Bools) -> Floats:
        """One standard deviation (k,) of those motions, in rad or lengths of the problem."""
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
