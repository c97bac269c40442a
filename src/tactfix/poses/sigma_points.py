"""How far a fixture may truly stand from its best pose, also where contacts are so few that curvature counts.

At the true pose the residuals are the noise. So the true pose is where the residuals differ from those of the best pose
by what the noise may be, and the linear covariance is what that gives where the residuals are linear in the pose. Where
they are not, a weakly held motion runs along a curve, and leaves the linear ellipsoid by many of its sigmas in
directions that are held well. Then the poses are solved for at which the residuals have changed by as many sigma as
SIGMA_POINT_DISTANCE says along each principal axis of the linear model, both ways (sigma points): the second moment of
their motions about the best pose is the covariance, exact to second order along each axis. Where no pose has those
residuals, or the covariance is many times what the linear one says, there is a fold close by and no covariance is true.
"""

from collections.abc import Callable, Iterable
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats, lengths
from tactfix.geometry.rigid import axial
from tactfix.geometry.surfaces import Surface, radius_of
from tactfix.values import frozen_value

SIGMA_POINT_DISTANCE = 6**0.5
"""Sigmas to each sigma point: the distance of a pose from the best one, root mean square, in the six of a pose."""

NEARLY_LINEAR = 0.3
"""Sigmas by which the residuals at the sigma points may differ from linear ones: standard deviations grow by less than
4 per cent there."""

FOLDED = 6.0
"""Times the linear standard deviation, beyond which sigma points no longer cover what they promise. Random minimal
layouts of six kinds covered 93 to 95 per cent below, and 40 to 75 beyond ten."""

MOST_ROTATION_SIGMA = 1.0
"""Rad: one linear sigma of rotation beyond which the sigma points are more than half a turn away, and mean nothing."""

MOST_MISSING = 1.0
"""Chi-square by which a pose may miss the residuals it is asked for."""

Reach: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]
"""Poses (m, 4, 4), in any order, at which the residuals are what the linear model has after steps (u, m), and the
chi-squares (m,) by which they are not."""


@frozen_value
class Spread:
    """factor (6, m): of the covariance factor factor^T of rotation (rad) and translation about the fixture's origin.

    free (6, k): motions there that nothing resists. trusted: whether the covariance is true; false next to a fold.
    """

    factor: Floats
    free: Floats
    trusted: bool


def curved_spread(
    base_from_fixture: Floats,
    centre: Floats,
    linear: Floats,
    steps: Floats,
    bend: Callable[[Floats], Floats],
    reach: Reach,
) -> Spread:
    """The spread of a pose (4, 4) on which no motion is free.

    centre (3,): of the contacts. linear (6, u): motions of one sigma along each principal axis; steps (u, u'): the same
    as steps of the unknowns, a column each. bend tells by how many sigma (m,) the residuals after steps (u, m) differ
    from linear ones; reach solves for the poses, and gives an infinite chi-square for those that it does not.
    """
    both = SIGMA_POINT_DISTANCE * np.concatenate([steps, -steps], axis=1)
    nothing_free = np.zeros((6, 0))
    if np.linalg.svd(linear[:3], compute_uv=False)[0] > MOST_ROTATION_SIGMA:
        return Spread(linear, nothing_free, trusted=False)
    arm = centre - base_from_fixture[:3, 3]
    # Far from the contacts the fixture's origin itself runs along an arc when the fixture turns.
    sag = float(np.linalg.norm(arm)) * (SIGMA_POINT_DISTANCE * np.linalg.norm(linear[:3])) ** 2 / 2
    is_straight = sag < NEARLY_LINEAR * np.linalg.svd(linear[3:], compute_uv=False)[-1]
    if is_straight and bend(both).max(initial=0.0) < NEARLY_LINEAR:
        return Spread(linear, nothing_free, trusted=True)
    poses, missing = reach(both)
    if not np.isfinite(missing).all():
        return Spread(linear, nothing_free, trusted=False)
    share = 1 / np.sqrt(2 * SIGMA_POINT_DISTANCE**2)
    factor = share * motions_between(base_from_fixture, poses)
    # Whether there is a fold is asked at the contacts, where it does not matter how far away the origin is.
    middle = base_from_fixture[:3, :3].T @ arm
    here = share * motions_between(_at(base_from_fixture[None], middle)[0], _at(poses, middle))
    linear_here = np.concatenate([linear[:3], linear[3:] + np.cross(linear[:3].T, arm).T])
    trusted = bool(missing.max() <= MOST_MISSING) and _inflation(linear_here, here) <= FOLDED
    return Spread(factor, nothing_free, trusted)


def _at(poses: Floats, point: Floats) -> Floats:
    """The poses (m, 4, 4) of a frame with the same axes whose origin is at a point (3,) of the fixture."""
    moved = poses.copy()
    moved[:, :3, 3] += poses[:, :3, :3] @ point
    return moved


def most_bend(move: float, contacts: Contacts, sigmas: Floats, surfaces: Iterable[Surface], origin: Floats) -> float:
    """More sigma than anything bends by at the sigma points, where one sigma moves no contact farther than move.

    The second-order term of a distance is the square of the move over twice the radius, or over twice the arm of a
    rotation; that of the fixture's origin (3,) the square of the turn times half its distance. Poses that are held well
    need no closer look.
    """
    spread = contacts.spread
    smallest = min([radius_of(surface, spread) for surface in surfaces], default=spread)
    far = float(np.linalg.norm(origin - contacts.centre))
    sharpest = max(1 / smallest, 1 / spread, far / spread**2)
    return float(np.sqrt(len(contacts)) * (SIGMA_POINT_DISTANCE * move) ** 2 * sharpest / sigmas.min())


def _inflation(linear: Floats, factor: Floats) -> float:
    """The most by which a standard deviation of factor exceeds that of linear in the same direction."""
    scaled = np.linalg.pinv(linear, rcond=1e-12) @ factor
    return float(np.linalg.norm(scaled, 2))


def motions_between(base_from_fixture: Floats, others: Floats) -> Floats:
    """Motions (6, m) of rotation vector and translation of the origin, base axes, from one pose to others (m, 4, 4)."""
    turns = others[:, :3, :3] @ base_from_fixture[:3, :3].T
    axis = axial(turns)
    sine = lengths(axis)
    angle = np.arctan2(sine, (np.trace(turns, axis1=1, axis2=2) - 1) / 2)
    vectors = axis * np.where(sine > 0, angle / np.where(sine > 0, sine, 1.0), 1.0)[:, None]
    return np.concatenate([vectors, others[:, :3, 3] - base_from_fixture[:3, 3]], axis=1).T
