"""Poses turned round and set one upon the other, with what is known of their errors.

Covariances are those of `Pose`: of (d_rot, d_t) with R_true = exp([d_rot]) R and t_true = t + d_t, base axes. First
order in the errors; those of two poses are taken as independent.
"""

import numpy as np

from tactfix.errors import UsageError
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import homogeneous, skew
from tactfix.pose_formats.pose import Pose
from tactfix.settings import Setting


def inverse(pose: Pose) -> Pose:
    """fixture_from_base: x_fixture = R^T x_base - R^T t.

    exp(-[d_rot]) on the left of R^T is exp(-[R^T d_rot]) R^T, and -R^T exp(-[d_rot]) (t + d_t) is off by
    R^T (d_rot x t - d_t).
    """
    back = pose.rotation.T
    jacobian = np.block([[-back, np.zeros((3, 3))], [-back @ skew(pose.translation), -back]])
    return Pose(
        homogeneous(back, -back @ pose.translation), pose.units, _carried(jacobian, pose.covariance), pose.fixture
    )


def on(outer: Pose, inner: Pose) -> Pose:
    """outer @ inner: the pose in the frame in which outer is given; units of inner, or of outer where it has none.

    d_rot = d_outer + R_outer d_inner, and d_t = d_t_outer + d_outer x (R_outer t_inner) + R_outer d_t_inner.
    Raises UsageError where the unit of only one of them is known.
    """
    if (outer.units is None) != (inner.units is None):
        raise UsageError("one of the two poses does not say its unit; give " + Setting.UNITS.word)
    placed = outer if inner.units is None else outer.in_units(inner.units)
    arm = placed.rotation @ inner.translation
    by_inner = np.block([[placed.rotation, np.zeros((3, 3))], [np.zeros((3, 3)), placed.rotation]])
    by_outer = np.block([[np.eye(3), np.zeros((3, 3))], [-skew(arm), np.eye(3)]])
    parts = [_carried(by_inner, inner.covariance), _carried(by_outer, placed.covariance)]
    known = [part for part in parts if part is not None]
    return Pose(
        homogeneous(placed.rotation @ inner.rotation, arm + placed.translation),
        inner.units,
        np.sum(known, axis=0) if known else None,
        inner.fixture,
    )


def _carried(jacobian: Floats, covariance: Floats | None) -> Floats | None:
    return None if covariance is None else np.asarray(jacobian @ covariance @ jacobian.T)
