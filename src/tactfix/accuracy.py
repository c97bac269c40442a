"""How surely a point of the fixture is known, from the covariance of its pose."""

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import skew


def point_covariance(base_from_fixture: Floats, covariance: Floats, points_fixture: Floats) -> Floats:
    """Covariances (..., 3, 3) in base axes of points (..., 3) of the fixture frame.

    x = R p + t moves by d_x = d_rot x (R p) + d_t, so that cov_x = J cov J^T with J = [-[R p]x, I].
    """
    arms = points_fixture @ base_from_fixture[:3, :3].T
    jacobian = np.concatenate([-skew(arms), np.broadcast_to(np.eye(3), (*arms.shape[:-1], 3, 3))], axis=-1)
    return np.asarray(jacobian @ covariance @ np.swapaxes(jacobian, -1, -2))


def worst_sigma(covariances: Floats) -> Floats:
    """One standard deviation (...,) along the direction that is known worst, of covariances (..., 3, 3)."""
    return np.asarray(np.sqrt(np.maximum(np.linalg.eigvalsh(covariances)[..., -1], 0.0)))
