"""Poses for tests of reading and writing, with rotations written out."""

import numpy as np

from tactfix.pose_formats.pose import Pose


def turn(axis, degrees):
    """Rotation about x, y or z, written out, without code of the package."""
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def pose(rotation, translation=(0.0, 0.0, 0.0), units="mm", covariance=None):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, translation
    return Pose(matrix, units, covariance)
