"""The domain of poses that is searched, and the residuals of a measured pose.

Near is the expected pose of the fixture. Q = R R_near^T is the rotation from near to its pose, and t - t_near the
translation of its origin, both in base axes.

1. A pose is in the domain if the axis of Q has no component along base axes with a constrained rotation, and t - t_near
   has none along base axes with a constrained translation.
2. In the unit quaternion of Q the first condition makes some components zero: the rotations are a great sphere of
   dimension 0 to 3, the number of free axes.
3. The pose equations have fixture_from_base poses y = A x + b, with A = F R^T, where F is the rotation of the frame of
   y from the fixture's. There Q = A^T A_near and t = -A^T (b - pivot), with x measured from the frame's origin in base,
   and pivot the fixture's origin in the frame of y. For a given A the condition on t is linear in b.
4. After a step a pose is projected onto the domain (`onto`). Steps are taken in a basis of its tangent space (`basis`),
   to which the Jacobian of the contacts is reduced. So every descent, every test of a zero and every covariance has
   fewer unknowns.
5. A pose that was measured beforehand gives six more residuals, W (log Q, t - t_near). W^T W is the inverse of the
   covariance of (d_rot, d_t) of the measurement, in base axes, rotation about the fixture's origin. A rotation by e in
   base axes changes log Q = d by J(d)^-1 e, with J the left Jacobian of the rotations (Chirikjian, Stochastic Models,
   Information Theory, and Lie Groups, vol. 2, section 10.6). A rotation of the contacts by w, which is opposite,
   changes it by -J(d)^-1 A^T w, and t by A^T (w x (b - pivot)).

The poses are the last axis of all arrays, as in `equations`.
"""

from functools import cached_property

import numpy as np

from tactfix.geometry.arrays import Bools, Floats, Frozen, circle_axes, cross, cross_columns
from tactfix.geometry.rigid import axial, inverse_left_jacobian, rotation_from_quaternion, rotation_vectors, skew
from tactfix.values import frozen_value

ROTATION_MARGIN = 0.3
"""Rad beyond the limit of rotation that are searched too: five sigma of most poses, and the spacing of the covering
(0.2 rad in half angles, `starts.SHARES`)."""
TRANSLATION_MARGIN = 0.5
"""Distance beyond the limit of translation that is searched too, in sizes of the search (`search_frame`): far more than
five sigma of a pose that is known to a hundredth of the fixture."""
ANGLES_AGREE = 0.25
"""Largest error in rad of rotations from features located alone (`feature_rotations`): twelve times
`feature_rotations.WELL_LOCATED`, the largest sigma of such features."""


@frozen_value
class PoseDomain:
    """Where poses are searched, in the frames of the pose equations, lengths in their unit.

    near (3, 3): A_near. turns, shifts (3,): base axes with free rotation and with free translation. pivot (3,): the
    fixture's origin in the frame of y; place (3,): the same point at near, in the frame of x. angle (rad), distance:
    limits from near within which all poses are searched; looks_beyond: other poses are searched less densely.
    """

    near: Frozen
    turns: Bools
    shifts: Bools
    pivot: Frozen
    place: Frozen
    angle: float = np.pi
    distance: float = np.inf
    looks_beyond: bool = False

    @cached_property
    def dimension(self) -> int:
        """The number of unknowns of a pose."""
        return int(self.turns.sum() + self.shifts.sum())

    @cached_property
    def is_free(self) -> bool:
        """Whether no direction is constrained."""
        return self.dimension == 6

    @property
    def is_limited(self) -> bool:
        """Whether poses are looked for up to a distance from near only."""
        return bool(np.isfinite(self.distance))

    @cached_property
    def search_angle(self) -> float:
        """The angle (rad) from near up to which rotations are searched."""
        return float(min(self.angle + ROTATION_MARGIN, np.pi))

    def basis(self, rotations: Floats, offsets: Floats) -> Floats:
        """Steps (6, k, N) that stay in the domain at rotations (3, 3, N), offsets (3, N), to first order.

        Turns first. A turn also moves the fixture's origin; b compensates for that along the constrained axes.
        """
        turning = np.einsum("abN,bkN->akN", rotations, self._axes(rotations))
        shifting = rotations[:, self.shifts]
        arms = (offsets - self.pivot[:, None])[:, None]
        slips = np.einsum("abN,akN->bkN", rotations, cross_columns(turning, arms))
        slips[self.shifts] = 0.0
        rest = np.einsum("abN,bkN->akN", rotations, slips)
        return np.concatenate(
            [np.concatenate([turning, np.zeros_like(shifting)], axis=1), np.concatenate([rest, shifting], axis=1)]
        )

    def onto(self, rotations: Floats, offsets: Floats) -> tuple[Floats, Floats]:
        """The poses of the domain that are nearest to these: rotations (3, 3, N), offsets (3, N)."""
        if self.is_free:
            return rotations, offsets
        # Products of turns about one axis, or about all, stay in the domain; about two axes they do not.
        if self.turns.sum() == 2:
            rotations = self.turned_from_near(self._quaternions(rotations))
        off = np.einsum("abN,aN->bN", rotations, offsets - self.pivot[:, None]) + self.place[:, None]
        off[self.shifts] = 0.0
        return rotations, offsets - np.einsum("abN,bN->aN", rotations, off)

    def has(self, rotations: Floats, offsets: Floats) -> Bools:
        """Which poses (N,) lie within the limits and their margins."""
        if not rotations.shape[2] or (self.search_angle >= np.pi and not self.is_limited):
            return np.ones(rotations.shape[2], dtype=bool)
        places = -np.einsum("abN,aN->bN", rotations, offsets - self.pivot[:, None])
        gaps = np.sqrt(((places - self.place[:, None]) ** 2).sum(axis=0))
        return np.asarray((self.angles(rotations) <= self.search_angle) & (gaps <= self.distance + TRANSLATION_MARGIN))

    def offsets_at_place(self, rotations: Floats) -> Floats:
        """The offsets (3, N) at rotations (3, 3, N) with which the fixture's origin is where it is at near."""
        return np.asarray(self.pivot[:, None] - np.einsum("abN,b->aN", rotations, self.place))

    def may_lead_into(self, rotations: Floats) -> Bools:
        """Which rotations (3, 3, N), with errors up to ANGLES_AGREE, may be those of a pose within the limits."""
        if self.search_angle >= np.pi:
            return np.ones(rotations.shape[2], dtype=bool)
        return np.asarray(self.angles(rotations) <= self.search_angle + ANGLES_AGREE)

    def angles(self, rotations: Floats) -> Floats:
        """The angles (N,) in rad by which rotations (3, 3, N) are turned from near."""
        cosine = (np.einsum("abN,ab->N", rotations, self.near) - 1) / 2
        return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))

    def turned_from_near(self, quaternions: Floats) -> Floats:
        """The rotations (3, 3, N) at unit quaternions (4, N) of Q, scalar first."""
        return np.asarray(np.einsum("ab,Ncb->acN", self.near, rotation_from_quaternion(quaternions.T)))

    def _quaternions(self, rotations: Floats) -> Floats:
        turns = np.einsum("abN,ac->Nbc", rotations, self.near)
        return nearest_quaternions(turns, self.turns)

    def _axes(self, rotations: Floats) -> Floats:
        """Orthonormal axes (3, k, N) in base about which the fixture may turn at these rotations.

        For two: a turn by d changes the constrained component h of the quaternion (w, v) by d . (w e_h + v x e_h) / 2.
        """
        if self.turns.sum() != 2:
            return np.broadcast_to(np.eye(3)[:, self.turns, None], (3, int(self.turns.sum()), rotations.shape[2]))
        w, *v = self._quaternions(rotations)
        constrained = np.eye(3)[~self.turns]
        normal = w[:, None] * constrained + cross(np.array(v).T, np.repeat(constrained, len(w), axis=0))
        return np.moveaxis(np.array(circle_axes(normal)), (0, 1, 2), (1, 2, 0))


def nearest_quaternions(turns: Floats, free: Bools) -> Floats:
    """The unit quaternions (4, N), scalar first, of the turns about free axes (3,) nearest to rotations (N, 3, 3).

    Davenport's method: the eigenvector of the largest eigenvalue of a matrix that is linear in the rotation. Any
    quaternion for an infinite matrix, from a step that diverged.
    """
    turns = np.where(np.isfinite(turns), turns, 0.0)
    trace = np.trace(turns, axis1=1, axis2=2)
    davenport = np.empty((len(turns), 4, 4))
    davenport[:, 0, 0] = trace
    davenport[:, 0, 1:] = davenport[:, 1:, 0] = 2 * axial(turns)
    davenport[:, 1:, 1:] = turns + np.swapaxes(turns, 1, 2) - trace[:, None, None] * np.eye(3)
    kept = np.flatnonzero([True, *free])
    found = np.zeros((4, len(turns)))
    found[kept] = np.linalg.eigh(davenport[:, kept[:, None], kept])[1][:, :, -1].T
    return np.asarray(found * np.where(found[0] < 0, -1.0, 1.0))


ALL_POSES = PoseDomain(np.eye(3), np.ones(3, dtype=bool), np.ones(3, dtype=bool), np.zeros(3), np.zeros(3))


@frozen_value
class MeasuredPose:
    """near, pivot, place as in PoseDomain; whitening (6, 6): W, weighted as the contacts are."""

    near: Frozen
    pivot: Frozen
    place: Frozen
    whitening: Frozen

    def evaluate(self, rotations: Floats, offsets: Floats) -> tuple[Floats, Floats]:
        """Residuals (6, N) and Jacobian (6, 6, N), unknowns first, at rotations (3, 3, N), offsets (3, N)."""
        base_from_frame = rotations.transpose(2, 1, 0)
        arms = offsets.T - self.pivot
        turns = rotation_vectors(base_from_frame @ self.near)
        shifts = -(base_from_frame @ arms[:, :, None])[..., 0] - self.place
        rows = np.zeros((len(arms), 6, 6))
        rows[:, :3, :3] = inverse_left_jacobian(turns) @ base_from_frame
        rows[:, 3:, :3] = base_from_frame @ skew(arms)
        rows[:, 3:, 3:] = base_from_frame
        residual = self.whitening @ np.concatenate([turns, shifts], axis=1).T
        return residual, -(self.whitening @ rows).transpose(2, 1, 0)
