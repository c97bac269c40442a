"""Rigid motions as 4x4 homogeneous matrices: x_base = R x_fixture + t, column vectors, det R = +1.

Names give the frames: base_from_fixture takes fixture coordinates to base coordinates.
A twist is (rotation (3,), translation (3,)). A small twist (d_rot, d_t) changes a pose to exp([d_rot]) R, t + d_t: base
axes, rotation about the fixture's origin. The covariance of a pose is in this order.
"""

import math

import numpy as np

from tactfix.geometry.arrays import Floats, lengths


def skew(vectors: Floats) -> Floats:
    """The matrices (..., 3, 3) with skew(v) @ u == cross(v, u), for v (..., 3)."""
    matrices = np.zeros((*vectors.shape[:-1], 3, 3))
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    matrices[..., 0, 1], matrices[..., 0, 2], matrices[..., 1, 2] = -z, y, -x
    matrices[..., 1, 0], matrices[..., 2, 0], matrices[..., 2, 1] = z, -y, x
    return matrices


def axial(matrices: Floats) -> Floats:
    """The vectors v (..., 3) of the skew part [v] of matrices (..., 3, 3); of a rotation: its axis times its sine."""
    m = matrices - np.swapaxes(matrices, -1, -2)
    return np.asarray(m[..., (2, 0, 1), (1, 2, 0)] / 2)


def rotation_from_vector(vectors: Floats) -> Floats:
    """exp([v]): rotation matrices (..., 3, 3) from rotation vectors (..., 3) in rad (Rodrigues)."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    k = skew(vectors)
    # np.sinc(x) = sin(pi x) / (pi x): both coefficients stay exact through zero.
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * k + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * (k @ k))


def rotation_from_quaternion(quaternions: Floats) -> Floats:
    """Rotation matrices (..., 3, 3) from unit quaternions (..., 4), scalar first."""
    w, v = quaternions[..., 0, None, None], quaternions[..., 1:]
    k = skew(v)
    return np.asarray(np.eye(3) + 2 * w * k + 2 * (k @ k))


def homogeneous(rotation: Floats, translation: Floats) -> Floats:
    """The matrices (..., 4, 4) of x -> rotation x + translation."""
    matrix = np.zeros((*rotation.shape[:-2], 4, 4))
    matrix[..., :3, :3], matrix[..., :3, 3], matrix[..., 3, 3] = rotation, translation, 1.0
    return matrix


def inverse(a_from_b: Floats) -> Floats:
    """b_from_a of rigid motions a_from_b (..., 4, 4)."""
    b_from_a_rotation = np.swapaxes(a_from_b[..., :3, :3], -1, -2)
    return homogeneous(b_from_a_rotation, -(b_from_a_rotation @ a_from_b[..., :3, 3:])[..., 0])


def transform_points(a_from_b: Floats, points_b: Floats) -> Floats:
    """points (..., n, 3) of frame b in frame a, for a_from_b (..., 4, 4)."""
    return np.asarray(points_b @ np.swapaxes(a_from_b[..., :3, :3], -1, -2) + a_from_b[..., None, :3, 3])


def moved_about(a_from_b: Floats, motion: Floats, centre: Floats, scale: float) -> Floats:
    """The pose (4, 4) of b after a motion (6,) of it: rotation about centre (3,) in a, units 1 / scale; translation."""
    turn = rotation_from_vector(motion[:3] / scale)
    rotation = orthonormalized(turn @ a_from_b[:3, :3])
    return homogeneous(rotation, centre + motion[3:] + turn @ (a_from_b[:3, 3] - centre))


def orthonormalized(rotation: Floats) -> Floats:
    """The nearest rotation matrices (..., 3, 3): rounding of long products is removed (polar decomposition by SVD)."""
    u, _, vt = np.linalg.svd(rotation)
    u[..., 2] *= np.linalg.det(u @ vt)[..., None]
    return np.asarray(u @ vt)


def rotation_angle(rotation: Floats) -> float:
    """The angle in rad, 0 to pi, of a rotation matrix (3, 3); accurate near 0 and near pi."""
    sine = np.linalg.norm(axial(rotation))
    return float(np.arctan2(sine, (np.trace(rotation) - 1) / 2))


def rotation_vectors(rotations: Floats) -> Floats:
    """The rotation vectors (N, 3) in rad of rotation matrices (N, 3, 3), accurate from no turn to half a turn."""
    if len(rotations) == 1:
        return _one_rotation_vector(rotations[0])[None]
    # 4 q q^T of the unit quaternion q, scalar first: its column with the largest diagonal entry is a multiple of q.
    trace = np.trace(rotations, axis1=1, axis2=2)
    squared = np.empty((len(rotations), 4, 4))
    squared[:, 0, 0] = 1 + trace
    squared[:, 0, 1:] = squared[:, 1:, 0] = 2 * axial(rotations)
    squared[:, 1:, 1:] = rotations + np.swapaxes(rotations, 1, 2) + (1 - trace)[:, None, None] * np.eye(3)
    largest = np.argmax(np.einsum("Nii->Ni", squared), axis=1)
    quaternions = squared[np.arange(len(rotations)), largest]
    scalar, vector = quaternions[:, 0], quaternions[:, 1:]
    sine = lengths(vector)
    angle = 2 * np.arctan2(sine, np.abs(scalar)) * np.where(scalar < 0, -1.0, 1.0)
    return np.asarray(vector * (angle / np.where(sine > 0, sine, 1.0))[:, None])


def _one_rotation_vector(rotation: Floats) -> Floats:
    """The same of one matrix (3, 3) in Python's numbers, in a fifth of the time."""
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    products = (
        (1 + a + e + i, h - f, c - g, d - b),
        (h - f, 1 + a - e - i, b + d, c + g),
        (c - g, b + d, 1 - a + e - i, f + h),
        (d - b, c + g, f + h, 1 - a - e + i),
    )
    largest = max(range(4), key=lambda row: products[row][row])
    scalar, *vector = products[largest]
    sine = math.hypot(*vector)
    angle = 2 * math.copysign(math.atan2(sine, abs(scalar)), scalar)
    # Of no turn at all the vector is zero, whatever it is multiplied by.
    return np.array(vector) * (angle / (sine or 1.0))


SERIES_ENDS = 1e-4
"""Angle a in rad below which the series ends after 1 / 12: the next term, a^2 / 720, is 1e-11, and the formula loses
eps / a^2 = 2e-8 above it."""


def inverse_left_jacobian(vectors: Floats) -> Floats:
    """J(d)^-1 (N, 3, 3) of rotation vectors d (N, 3): log(exp([e]) exp([d])) = d + J(d)^-1 e to first order in e.

    J(d)^-1 = I - [d] / 2 + (1 - (a / 2) cot(a / 2)) / a^2 [d]^2 with a = |d|.
    """
    angle = lengths(vectors)
    half = np.where(angle > SERIES_ENDS, angle, 1.0) / 2
    bend = np.where(angle > SERIES_ENDS, (1 - half / np.tan(half)) / (4 * half**2), 1 / 12)
    turned = skew(vectors)
    return np.asarray(np.eye(3) - turned / 2 + bend[:, None, None] * (turned @ turned))
