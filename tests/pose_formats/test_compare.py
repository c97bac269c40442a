"""The movement of a fixture against movements composed by hand, and its sigma against random poses."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.errors import UsageError
from tactfix.pose_formats.comparison import compare
from tests.support.plain_poses import pose, turn

BEFORE = turn("z", 90)


def test_a_known_movement_in_both_frames():
    moved = compare(pose(BEFORE, (10, 0, 0)), pose(turn("x", 0.2) @ BEFORE, (10, 0.5, 0)))
    np.testing.assert_allclose(moved.translation, [0, 0.5, 0], atol=1e-15)
    np.testing.assert_allclose(moved.translation_in_fixture, [0.5, 0, 0], atol=1e-15)
    np.testing.assert_allclose(np.rad2deg(moved.rotation), [0.2, 0, 0], atol=1e-13)
    np.testing.assert_allclose(np.rad2deg(moved.rotation_in_fixture), [0, -0.2, 0], atol=1e-13)
    assert moved.distance == pytest.approx(0.5)
    assert np.rad2deg(moved.angle) == pytest.approx(0.2)
    assert moved.covariance is moved.distance_sigma is moved.angle_sigma is moved.chance is None


def test_nothing_moved():
    still = compare(pose(BEFORE, (1, 2, 3), covariance=np.eye(6)), pose(BEFORE, (1, 2, 3), covariance=3 * np.eye(6)))
    assert still.distance == still.angle == 0
    assert still.chance == 1
    assert still.distance_sigma == pytest.approx(2)
    assert still.angle_sigma == pytest.approx(2)


def test_the_units_are_those_of_the_first_pose():
    moved = compare(pose(BEFORE, (0.01, 0, 0), "m"), pose(BEFORE, (11, 0, 0), "mm", covariance=np.eye(6)))
    assert moved.units == "m"
    assert moved.distance == pytest.approx(0.001)
    with pytest.raises(UsageError, match="give units"):
        compare(pose(BEFORE, units=None), pose(BEFORE))
    assert compare(pose(BEFORE, units=None), pose(BEFORE, (3, 4, 0), None)).distance == 5


@pytest.mark.parametrize("degrees", [0.0, 1e-5, 0.5, 40.0, 170.0])
def test_covariance_is_that_of_random_poses(degrees):
    rng = np.random.default_rng(3)
    roots = [rng.normal(size=(6, 6)) * 1e-5 for _ in "ab"]
    first, second = turn("y", 35), turn("x", degrees) @ turn("y", 35)
    comparison = compare(pose(first, covariance=roots[0] @ roots[0].T), pose(second, covariance=roots[1] @ roots[1].T))
    errors = [rng.normal(size=(4000, 6)) @ root.T for root in roots]
    drawn = [
        Rotation.from_rotvec(e[:, :3]) * Rotation.from_matrix(r) for e, r in zip(errors, (first, second), strict=True)
    ]
    differences = np.hstack([(drawn[1] * drawn[0].inv()).as_rotvec(), errors[1][:, 3:] - errors[0][:, 3:]])
    sigma = np.sqrt(np.diag(comparison.covariance))
    scale = np.outer(sigma, sigma)
    np.testing.assert_allclose(np.cov(np.transpose(differences)) / scale, comparison.covariance / scale, atol=0.09)


def test_chance_distinguishes_noise_from_movement():
    rng = np.random.default_rng(5)
    sure = np.diag([1e-4**2] * 3 + [0.01**2] * 3)
    chances = []
    for _ in range(200):
        turns = [Rotation.from_rotvec(1e-4 * rng.normal(size=3)).as_matrix() for _ in "ab"]
        poses = [pose(turned @ BEFORE, 0.01 * rng.normal(size=3), covariance=sure) for turned in turns]
        chances.append(compare(*poses).chance)
    assert 0.42 < np.mean(chances) < 0.58  # uniform if nothing moved
    assert compare(pose(BEFORE, covariance=sure), pose(BEFORE, (0.1, 0, 0), covariance=sure)).chance < 1e-6
    assert compare(pose(BEFORE, covariance=0 * sure), pose(BEFORE, covariance=0 * sure)).chance is None
