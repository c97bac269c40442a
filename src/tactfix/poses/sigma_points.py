"""The covariance of a pose by sigma points, also if the residuals are not linear within the noise.

At the true pose the residuals are the noise. So the true pose is one at which the residuals differ from those of the
best pose by an amount that noise may have. If the residuals are linear in the pose, this gives the linear covariance.
If not, a weakly determined motion follows a curve, and leaves the linear ellipsoid by many sigmas in directions that
are determined well.

1. The linear model gives the principal axes. With a sigma of rotation above MOST_ROTATION_SIGMA it is all there is.
2. If the residuals at SIGMA_POINT_DISTANCE along each axis, both ways, are nearly linear, the linear covariance is
   used.
3. Else the poses are solved for at which the residuals are those of the linear model at these points (sigma points).
4. The second moment of their motions about the best pose is the covariance: exact to second order along each axis.
5. The covariance is not trusted if a sigma point has no such pose, or if it is many times the linear one. Then a fold
   of the equations is near, and no covariance describes the pose.
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
"""Sigmas to each sigma point: the root mean square distance of the true pose from the best one in six dimensions. So
the 2 x 6 points have equal weights and no central one."""

NEARLY_LINEAR = 0.3
"""Sigmas by which the residuals at the sigma points may differ from linear ones: standard deviations grow by less than
4 per cent there."""

FOLDED = 6.0
"""Ratio of the covariance's standard deviation to the linear one beyond which it is not trusted. Random minimal
layouts of six kinds were covered in 93 to 95 per cent below it, and in 40 to 75 per cent beyond a ratio of ten."""

MOST_ROTATION_SIGMA = 1.0
"""Linear sigma of rotation in rad beyond which no sigma points are computed: they would be 2.4 rad away or more,
where the linear model of a rotation is meaningless."""

MOST_MISSING = 1.0
"""Largest chi-square of the difference at the pose of a sigma point: one sigma, a sixth of the squared distance."""

SigmaPointSolver: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]
"""Poses (m, 4, 4), in any order, at which the residuals are those of the linear model after steps (u, m), and the
chi-squares (m,) of the remaining differences."""


@frozen_value
class Spread:
    """factor (6, m): of the covariance factor factor^T of rotation (rad) and translation about the fixture's origin.

    free (6, k): free motions there. trusted: whether the covariance describes the pose; false near a fold.
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
    solve: SigmaPointSolver,
    nearer: float = SIGMA_POINT_DISTANCE,
) -> Spread:
    """The spread of a pose (4, 4) on which no motion is free.

    centre (3,): of the contacts. linear (6, u): motions of one sigma along each principal axis; steps (u, u'): the same
    as steps of the unknowns, a column each. bend: the distance (m,) in sigma of the residuals after steps (u, m) from
    linear ones. solve: the poses at the sigma points, with an infinite chi-square where there is none. nearer: the
    distance in sigma at which sigma points are tried if some at SIGMA_POINT_DISTANCE miss their residuals.
    """
    both = SIGMA_POINT_DISTANCE * np.concatenate([steps, -steps], axis=1)
    nothing_free = np.zeros((6, 0))
    if np.linalg.svd(linear[:3], compute_uv=False)[0] > MOST_ROTATION_SIGMA:  # step 1
        return Spread(linear, nothing_free, trusted=False)
    arm = centre - base_from_fixture[:3, 3]
    # A rotation moves an origin that is far from the contacts along an arc.
    sag = float(np.linalg.norm(arm)) * (SIGMA_POINT_DISTANCE * np.linalg.norm(linear[:3])) ** 2 / 2
    is_straight = sag < NEARLY_LINEAR * np.linalg.svd(linear[3:], compute_uv=False)[-1]
    bends = bend(both)
    if is_straight and bends.max(initial=0.0) < NEARLY_LINEAR:  # step 2
        return Spread(linear, nothing_free, trusted=True)
    # The most curved first: where one misses, the solver need not look for the others.
    both = both[:, np.argsort(-bends, kind="stable")]
    distance, (poses, missing) = SIGMA_POINT_DISTANCE, solve(both)  # step 3
    if missing.max() > MOST_MISSING and nearer < distance:
        distance, (poses, missing) = nearer, solve(nearer / distance * both)
    if not np.isfinite(missing).all():
        return Spread(linear, nothing_free, trusted=False)
    share = 1 / np.sqrt(2 * distance**2)
    factor = share * motions_between(base_from_fixture, poses)  # step 4
    # Step 5: at the contacts, so that the distance of the origin does not matter.
    middle = base_from_fixture[:3, :3].T @ arm
    here = share * motions_between(_at(base_from_fixture[None], middle)[0], _at(poses, middle))
    linear_here = np.concatenate([linear[:3], linear[3:] + np.cross(linear[:3].T, arm).T])
    most_missing = MOST_MISSING * (distance / SIGMA_POINT_DISTANCE) ** 2
    trusted = bool(missing.max() <= most_missing) and _inflation(linear_here, here) <= FOLDED
    return Spread(factor, nothing_free, trusted)


def _at(poses: Floats, point: Floats) -> Floats:
    """The poses (m, 4, 4) of a frame with the same axes whose origin is at a point (3,) of the fixture."""
    moved = poses.copy()
    moved[:, :3, 3] += poses[:, :3, :3] @ point
    return moved


def most_bend(move: float, contacts: Contacts, sigmas: Floats, surfaces: Iterable[Surface], origin: Floats) -> float:
    """An upper bound of the bend at the sigma points, in sigma, if one sigma moves no contact farther than move.

    The second-order term of a distance is the square of the move over twice the radius, or over twice the arm of a
    rotation; that of the fixture's origin (3,) is the square of the turn times half its distance. Well determined poses
    pass by this bound alone.
    """
    spread = contacts.spread
    smallest = min([radius_of(surface, spread) for surface in surfaces], default=spread)
    far = float(np.linalg.norm(origin - contacts.centre))
    sharpest = max(1 / smallest, 1 / spread, far / spread**2)
    return float(np.sqrt(len(contacts)) * (SIGMA_POINT_DISTANCE * move) ** 2 * sharpest / sigmas.min())


def _inflation(linear: Floats, factor: Floats) -> float:
    """The largest ratio of the standard deviations of factor and linear in one direction."""
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
