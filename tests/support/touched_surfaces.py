"""Contacts on known surfaces, computed with scipy and numpy, without the package."""

import numpy as np
from scipy.spatial.transform import Rotation

DEGREE = np.pi / 180


def random_rotation(rng):
    return Rotation.from_quat(rng.normal(size=4)).as_matrix()


def turned_to(direction, rng=None):
    """A rotation matrix whose third column is direction; with rng the rotation about it is random."""
    direction = np.asarray(direction, float) / np.linalg.norm(direction)
    rotation, _ = Rotation.align_vectors(direction[None], [[0, 0, 1.0]])
    turn = 0.0 if rng is None else rng.uniform(0, 2 * np.pi)
    return rotation.as_matrix() @ Rotation.from_rotvec([0, 0, turn]).as_matrix()


def on_cylinder(rng, n, radius=1.0, length=2.0, sector=2 * np.pi):
    """n random contacts on a cylinder along z through the origin."""
    angle, z = rng.uniform(0, sector, n), rng.uniform(-0.5, 0.5, n) * length
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])


def on_sphere(rng, n, center=(0, 0, 0), radius=1.0):
    v = rng.normal(size=(n, 3))
    return np.asarray(center) + radius * v / np.linalg.norm(v, axis=1, keepdims=True)


def ring(degrees, z=0.0, radius=1.0):
    """Contacts at these angles on a circle at height z about the z axis."""
    angle = np.atleast_1d(degrees) * DEGREE
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(len(angle), float(z))])


AXES = np.array(
    [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 0, 1], [0, 1, 1], [1, -2, 0], [3, 0, 1], [0, 1, -2], [1, 1, 1]],
    dtype=float,
)
"""Axes along x, y, z, one in each coordinate plane, and one in general direction."""

TIDY_FIVES = {
    "three and two, staggered": np.vstack([ring([0, 120, 240], -0.7), ring([60, 180], 0.7)]),
    "three and two, aligned": np.vstack([ring([0, 120, 240], -0.7), ring([0, 120], 0.7)]),
    "rectangle and one": np.vstack([ring([0, 90], -1), ring([0, 90], 1), ring([225], 0.4)]),
    "rectangle and one half-way": np.vstack([ring([0, 90], -1), ring([0, 90], 1), ring([225], 0)]),
    "one side, 120 degrees": np.vstack([ring([-60, 0, 60], -1), ring([-30, 30], 1)]),
    "one side, aligned": np.vstack([ring([-60, 0, 60], -1), ring([-60, 60], 1)]),
    "close pairs": np.vstack([ring([0, 2], -1), ring([120, 122], 1), ring([240], 0)]),
    "long and thin": np.vstack([ring([0, 120, 240], -50), ring([60, 180], 50)]),
    "short and fat": np.vstack([ring([0, 120, 240], -0.05), ring([60, 180], 0.05)]),
    "five in one plane": np.array([[np.cos(a), np.sin(a), 0.7 * np.cos(a)] for a in (0, 1, 2.2, 3, 5)]),
}
"""Regular layouts as people and robots make them, on a cylinder of radius 1 along z, with simple roots."""

TIDY_FIVES_WITH_MULTIPLE_ROOTS = {
    "four on a circle and one": np.vstack([ring([0, 70, 180, 250]), ring([33], 1)]),
    "square on a circle and one": np.vstack([ring([0, 90, 180, 270]), ring([45], 1)]),
    "rectangle through the axis and one": np.vstack([ring([0, 180], -1), ring([0, 180], 1), ring([90], 0)]),
    "three on one line and two": np.vstack([ring([0], -1), ring([0], 0), ring([0], 1), ring([100, 220], 0.3)]),
    "three and one above and below": np.vstack([ring([0, 120, 240]), ring([0], 1.3), ring([0], -1.3)]),
    "five on a circle": ring([0, 60, 150, 200, 300]),
}
"""Layouts whose true cylinder is a multiple root, accurate only to a root of the rounding."""


def axis_error(cylinder, point, direction, radius):
    """The largest difference in angle, offset and radius from the cylinder through point along direction."""
    direction = np.asarray(direction, float) / np.linalg.norm(direction)
    tilt = np.linalg.norm(np.cross(cylinder.direction, direction))
    shift = np.linalg.norm(np.cross(cylinder.point - point, direction))
    return max(tilt, shift, abs(cylinder.radius - radius))
