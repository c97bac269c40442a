"""Rigid motions against scipy's Rotation and plain arithmetic."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tactfix.geometry.arrays import basis_across, cross_columns, dot_columns, farthest_first, unit
from tactfix.geometry.rigid import (
    homogeneous,
    inverse,
    inverse_left_jacobian,
    moved_about,
    orthonormalized,
    rotation_angle,
    rotation_from_quaternion,
    rotation_from_vector,
    rotation_vectors,
    skew,
    transform_points,
)
from tests.support.problems import random_pose

number = st.floats(-10, 10, allow_nan=False).map(lambda x: 0.0 if abs(x) < 1e-100 else x)
vectors = st.tuples(number, number, number).map(np.array)


@given(vectors, vectors)
def test_skew_is_the_cross_product(v, u):
    np.testing.assert_allclose(skew(v) @ u, np.cross(v, u), atol=1e-12)


@settings(max_examples=50)
@given(vectors)
def test_rotation_vector_agrees_with_scipy(v):
    np.testing.assert_allclose(rotation_from_vector(v), Rotation.from_rotvec(v).as_matrix(), atol=1e-13)


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-12, 1e-8, 1e-4, np.pi - 1e-9, np.pi, 2 * np.pi])
def test_rotation_is_exact_at_zero_and_at_a_half_turn(angle):
    axis = np.array([2.0, -1.0, 2.0]) / 3
    found = rotation_from_vector(angle * axis)
    np.testing.assert_allclose(found, Rotation.from_rotvec(angle * axis).as_matrix(), atol=2e-15)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-15)
    assert rotation_angle(found) == pytest.approx(min(angle, 2 * np.pi - angle), abs=1e-8 if angle > 3 else 1e-15)


def test_small_angles_are_not_lost():
    for angle in (1e-12, 1e-7, 1e-3):
        assert rotation_angle(rotation_from_vector(np.array([0.0, angle, 0.0]))) == pytest.approx(angle, rel=1e-6)


def test_quaternions_agree_with_scipy_and_stack():
    rng = np.random.default_rng(0)
    turns = Rotation.random(50, random_state=rng)
    scalar_first = np.roll(turns.as_quat(), 1, axis=1)
    np.testing.assert_allclose(rotation_from_quaternion(scalar_first), turns.as_matrix(), atol=1e-14)


def test_inverse_undoes_far_from_the_origin():
    rng = np.random.default_rng(1)
    pose = random_pose(rng, 1e4)
    points = rng.normal(size=(20, 3))
    moved = transform_points(pose, points)
    np.testing.assert_allclose(moved[3], pose[:3, :3] @ points[3] + pose[:3, 3])
    np.testing.assert_allclose(transform_points(inverse(pose), moved), points, atol=1e-11)
    np.testing.assert_allclose(inverse(pose) @ pose, np.eye(4), atol=1e-11)


def test_transform_and_inverse_work_on_stacks():
    rng = np.random.default_rng(2)
    poses = np.array([random_pose(rng) for _ in range(4)])
    points = rng.normal(size=(4, 7, 3))
    moved = transform_points(poses, points)
    for pose, before, after, back in zip(poses, points, moved, inverse(poses), strict=True):
        np.testing.assert_allclose(after, before @ pose[:3, :3].T + pose[:3, 3])
        np.testing.assert_allclose(back, np.linalg.inv(pose), atol=1e-11)


def test_orthonormalized_is_the_nearest_rotation_and_never_a_reflection():
    rng = np.random.default_rng(3)
    for _ in range(50):
        true = Rotation.random(random_state=rng).as_matrix()
        off = true + 1e-3 * rng.normal(size=(3, 3))
        found = orthonormalized(off)
        np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-14)
        assert np.linalg.det(found) > 0
        # Nearest: no small rotation brings it nearer to the matrix.
        for step in 1e-4 * np.vstack([np.eye(3), -np.eye(3)]):
            other = Rotation.from_rotvec(step).as_matrix() @ found
            assert np.linalg.norm(found - off) < np.linalg.norm(other - off)
    assert np.linalg.det(orthonormalized(np.diag([1.0, 1.0, -0.1]))) == pytest.approx(1)


def test_homogeneous_puts_rotation_and_translation_where_they_belong():
    pose = homogeneous(np.diag([1.0, -1.0, -1.0]), np.array([1.0, 2.0, 3.0]))
    assert pose.tolist() == [[1, 0, 0, 1], [0, -1, 0, 2], [0, 0, -1, 3], [0, 0, 0, 1]]


@given(vectors.filter(lambda v: np.linalg.norm(v) > 1e-6))
def test_a_basis_across_is_orthonormal_and_right_handed(v):
    direction = unit(v)
    frame = np.vstack([basis_across(direction), direction])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=4e-15)
    assert np.linalg.det(frame) > 0


def test_a_basis_across_is_exact_along_the_axes_and_noise_does_not_turn_it():
    rng = np.random.default_rng(4)
    nice = [d for d in np.ndindex(7, 7, 7) if d != (3, 3, 3)]
    for direction in unit(np.array(nice) - 3.0):
        off = unit(direction + 1e-6 * rng.standard_normal((20, 3)))
        assert np.abs(basis_across(off) - basis_across(direction)).max() < 1e-4
    for axis in (*np.eye(3), *-np.eye(3)):
        assert set(np.abs(basis_across(axis)).ravel()) == {0.0, 1.0}


def test_rotation_vectors_agree_with_scipy_from_no_turn_to_half_a_turn():
    rng = np.random.default_rng(5)
    sizes = np.array([0.0, 1e-12, 1e-6, 0.1, 2.0, np.pi - 1e-6, np.pi])
    vectors = unit(rng.normal(size=(len(sizes), 3))) * sizes[:, None]
    matrices = Rotation.from_rotvec(vectors).as_matrix()
    one_by_one = np.concatenate([rotation_vectors(matrix[None]) for matrix in matrices])
    for found in (rotation_vectors(matrices), one_by_one):
        np.testing.assert_allclose(found[:-1], vectors[:-1], atol=1e-9)
        # A half-turn has two rotation vectors.
        np.testing.assert_allclose(np.abs(found[-1] @ vectors[-1]), np.pi**2, rtol=1e-9)


@pytest.mark.parametrize("size", [0.0, 1e-5, 2e-4, 0.3, 2.5])
def test_inverse_left_jacobian_against_differences_of_the_logarithm(size):
    direction, h = np.array([2.0, -1.0, 2.0]) / 3, 1e-6
    turn = rotation_from_vector(size * direction)
    ends = [rotation_vectors(rotation_from_vector(sign * h * np.eye(3)) @ turn) for sign in (1, -1)]
    np.testing.assert_allclose(
        inverse_left_jacobian(size * direction[None])[0], (ends[0] - ends[1]).T / (2 * h), atol=1e-8
    )


def test_a_pose_moves_about_a_centre():
    rng = np.random.default_rng(6)
    pose, centre, motion, scale = random_pose(rng), rng.normal(size=3), rng.normal(size=6), 7.0
    moved = moved_about(pose, motion, centre, scale)
    turn = Rotation.from_rotvec(motion[:3] / scale).as_matrix()
    points = rng.normal(size=(5, 3))
    expected = (transform_points(pose, points) - centre) @ turn.T + centre + motion[3:]
    np.testing.assert_allclose(transform_points(moved, points), expected, atol=1e-12)


def test_products_of_columns():
    a, b = np.random.default_rng(7).normal(size=(2, 3, 8))
    np.testing.assert_allclose(cross_columns(a, b), np.cross(a, b, axis=0), atol=1e-15)
    np.testing.assert_allclose(dot_columns(a, b), (a * b).sum(axis=0))


@pytest.mark.parametrize("length", [1e-3, 1.0, 1e3])
def test_the_farthest_points_come_first_in_any_unit(length):
    """Ties, which arise here by symmetry, are broken by the order of the points, not by rounding."""
    corners = np.array([[x, y, 0.1] for x in (0, 1) for y in (0, 1)]) * 0.7 + 0.3
    points = np.vstack([corners, corners.mean(axis=0)]) * length
    assert farthest_first(points, 5) == [0, 3, 1, 2, 4]
    assert farthest_first(points, 9) == [0, 3, 1, 2, 4]
    assert farthest_first(np.zeros((0, 3)), 2) == []


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 0.3, 2.0, 3.0, np.pi - 1e-9, np.pi])
def test_the_rotation_vector_of_one_matrix(angle: float) -> None:
    """Against scipy."""
    for axis in np.vstack([np.eye(3), -np.eye(3), np.random.default_rng(2).normal(size=(20, 3))]):
        vector = angle * axis / np.linalg.norm(axis)
        rotation = Rotation.from_rotvec(vector)
        found = rotation_vectors(rotation.as_matrix()[None])[0]
        assert np.abs(found - vector).max() < 1e-14 or np.abs(found + vector).max() < 1e-7 * (angle > 3.1)
        assert (rotation.inv() * Rotation.from_rotvec(found)).magnitude() < 1e-14
