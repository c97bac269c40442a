"""A pose that was measured before the contacts were made: six more residuals of the fit.

With Q = R R_near^T and t - t_near as in `pose_domain`, the residuals are W (log Q, t - t_near), where W^T W is the
inverse of the covariance of (d_rot, d_t) that the measurement has: base axes, rotation about the fixture's origin. A
turn by e in base axes changes log Q = d by J(d)^-1 e, J the left Jacobian of the rotations (Chirikjian, Stochastic
Models, Information Theory, and Lie Groups, vol. 2, section 10.6); a turn of the contacts by w, the other way, by
-J(d)^-1 A^T w, and t by A^T (w x (b - pivot)).
"""

import numpy as np

from tactfix.geometry.arrays import Floats, Frozen, lengths
from tactfix.geometry.rigid import axial, skew
from tactfix.values import frozen_value


@frozen_value
class MeasuredPose:
    """near, pivot, place as in `pose_domain.PoseDomain`; whitening (6, 6): W, weighted as the contacts are."""

    near: Frozen
    pivot: Frozen
    place: Frozen
    whitening: Frozen

    def evaluate(self, rotations: Floats, offsets: Floats) -> tuple[Floats, Floats]:
        """Residuals (6, N) and Jacobian (6, 6, N), unknowns first, at rotations (3, 3, N), offsets (3, N)."""
        base_from_frame = np.moveaxis(rotations, -1, 0).swapaxes(1, 2)
        arms = (offsets - self.pivot[:, None]).T
        turns = turn_vectors(base_from_frame @ self.near)
        shifts = -(base_from_frame @ arms[:, :, None])[..., 0] - self.place
        rows = np.zeros((len(arms), 6, 6))
        rows[:, :3, :3] = -inverse_left_jacobian(turns) @ base_from_frame
        rows[:, 3:, :3] = -base_from_frame @ skew(arms)
        rows[:, 3:, 3:] = -base_from_frame
        residual = self.whitening @ np.concatenate([turns, shifts], axis=1).T
        return residual, np.moveaxis(self.whitening @ rows, (0, 1, 2), (2, 1, 0))


def turn_vectors(turns: Floats) -> Floats:
    """The rotation vectors (N, 3) of rotations (N, 3, 3), up to pi long, accurate there too."""
    # 4 q q^T of the unit quaternion q, scalar first: its column with the largest diagonal entry is q but for a factor.
    trace = np.trace(turns, axis1=1, axis2=2)
    squared = np.empty((len(turns), 4, 4))
    squared[:, 0, 0] = 1 + trace
    squared[:, 0, 1:] = squared[:, 1:, 0] = 2 * axial(turns)
    squared[:, 1:, 1:] = turns + np.swapaxes(turns, 1, 2) + (1 - trace)[:, None, None] * np.eye(3)
    largest = np.argmax(np.einsum("Nii->Ni", squared), axis=1)
    quaternions = squared[np.arange(len(turns)), largest]
    scalar, vector = quaternions[:, 0], quaternions[:, 1:]
    sine = lengths(vector)
    angle = 2 * np.arctan2(sine, np.abs(scalar)) * np.where(scalar < 0, -1.0, 1.0)
    # Of no turn at all the vector is zero, whatever it is multiplied by.
    return np.asarray(vector * (angle / np.where(sine > 0, sine, 1.0))[:, None])


def inverse_left_jacobian(vectors: Floats) -> Floats:
    """J(d)^-1 (N, 3, 3) = I - [d] / 2 + (1 - (a / 2) cot(a / 2)) / a^2 [d]^2 for rotation vectors d (N, 3), a = |d|."""
    angle = lengths(vectors)
    half = np.where(angle > SERIES_ENDS, angle, 1.0) / 2
    bend = np.where(angle > SERIES_ENDS, (1 - half / np.tan(half)) / (4 * half**2), 1 / 12)
    turned = skew(vectors)
    return np.asarray(np.eye(3) - turned / 2 + bend[:, None, None] * (turned @ turned))


SERIES_ENDS = 1e-4
"""Rad below which the next term of the series, a^2 / 720, is less than rounding."""
