"""Surfaces: residuals, normals and feet against their definitions by distance, written out here."""

import copy
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.errors import TipDoesNotFitError
from tactfix.geometry.nearest import angle_between, distance_between, foot, nearest_points
from tactfix.geometry.surfaces import (
    Cylinder,
    Plane,
    Sphere,
    feet,
    moved,
    offset_radius,
    outward_normals,
    residuals,
    residuals_and_normals,
    signed_axis,
)
from tests.support.plain_surfaces import KINDS, any_surface, depth
from tests.support.problems import random_pose, rotation

SIDES = ["outer", "inner"]


@pytest.mark.parametrize(("kind", "side"), KINDS)
def test_residual_is_how_far_the_tip_is_from_touching(kind, side):
    rng = np.random.default_rng(0)
    surface = any_surface(kind, rng, side)
    points = rng.normal(size=(40, 3)) * 20
    for tip in (0.0, 1.5):
        expected = [depth(surface, p) - tip for p in points]
        np.testing.assert_allclose(residuals(surface, points, tip), expected, atol=1e-12)
        np.testing.assert_array_equal(residuals_and_normals(surface, points, tip)[0], residuals(surface, points, tip))


@pytest.mark.parametrize(("kind", "side"), KINDS)
def test_normal_is_the_gradient_of_the_depth_and_the_foot_lies_on_the_surface(kind, side):
    rng = np.random.default_rng(1)
    surface = any_surface(kind, rng, side)
    points = rng.normal(size=(20, 3)) * 20
    normals, on_surface = outward_normals(surface, points), feet(surface, points)
    np.testing.assert_array_equal(residuals_and_normals(surface, points, 1.5)[1], normals)
    for point, normal, below in zip(points, normals, on_surface, strict=True):
        steps = 1e-5 * np.eye(3)
        gradient = [(depth(surface, point + s) - depth(surface, point - s)) / 2e-5 for s in steps]
        np.testing.assert_allclose(normal, gradient, atol=1e-8)
        assert abs(depth(surface, below)) < 1e-12
        assert np.linalg.norm(point - below) == pytest.approx(abs(depth(surface, point)), abs=1e-12)


@pytest.mark.parametrize(("kind", "side"), KINDS[1:])
def test_a_point_on_the_axis_or_centre_has_a_normal_too(kind, side):
    surface = any_surface(kind, np.random.default_rng(3), side)
    at = surface.center if kind == "sphere" else surface.point
    normals = outward_normals(surface, np.array([at, at + np.array([1.0, 2.0, 3.0])]))
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    if kind == "cylinder":
        np.testing.assert_allclose(normals @ surface.direction, 0.0, atol=1e-12)


@pytest.mark.parametrize(("kind", "side"), KINDS)
def test_surfaces_and_points_move_together(kind, side):
    rng = np.random.default_rng(2)
    surface, pose = any_surface(kind, rng, side), random_pose(rng)
    points = rng.normal(size=(20, 3)) * 20
    moved_points = points @ pose[:3, :3].T + pose[:3, 3]
    np.testing.assert_allclose(
        residuals(moved(pose, surface), moved_points, 0.3), residuals(surface, points, 0.3), atol=1e-11
    )
    np.testing.assert_allclose(
        outward_normals(moved(pose, surface), moved_points),
        outward_normals(surface, points) @ pose[:3, :3].T,
        atol=1e-12,
    )


def test_the_offset_surface_is_where_the_centre_of_the_tip_lies():
    assert offset_radius("ball", 5.0, "outer", 2.0) == 7.0
    assert offset_radius("bore", 5.0, "inner", 2.0) == 3.0
    for tip in (5.0, 6.0):
        with pytest.raises(TipDoesNotFitError, match=r"bore.*radius 5"):
            offset_radius("bore", 5.0, "inner", tip)


def test_surfaces_cannot_be_changed_and_do_not_share_their_arrays():
    point = np.array([1.0, 2.0, 3.0])
    surface = Sphere(point, 1.0)
    point[0] = 9.0
    assert surface.center[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        surface.center[0] = 5.0


# Nearest points, distances, angles. ---------------------------------------------------------------------------------


def brute_distance(one, other):
    """Shortest distance between two axes or centres by a search over both lines."""
    from scipy.optimize import minimize

    def on(surface, s):
        return surface.center if isinstance(surface, Sphere) else surface.point + s * surface.direction

    found = minimize(lambda s: float(((on(one, s[0]) - on(other, s[1])) ** 2).sum()), [0.0, 0.0], tol=1e-14)
    return np.sqrt(found.fun)


@pytest.mark.parametrize("kinds", [("sphere", "sphere"), ("sphere", "cylinder"), ("cylinder", "cylinder")])
def test_distances_are_the_shortest_there_are(kinds):
    rng = np.random.default_rng(3)
    for _ in range(10):
        one, other = (any_surface(kind, rng) for kind in kinds)
        assert distance_between(one, other) == pytest.approx(brute_distance(one, other), abs=1e-5)
        assert distance_between(other, one) == pytest.approx(distance_between(one, other), abs=1e-12)
        a, b = nearest_points(one, other)
        np.testing.assert_allclose(foot(one, b), a, atol=1e-10)
        np.testing.assert_allclose(foot(other, a), b, atol=1e-10)


def test_distance_from_a_plane_is_positive_on_its_outward_side():
    plane = Plane([0, 0, 5], [0, 0, 1])
    assert distance_between(plane, Sphere([7, 8, 9], 1.0)) == 4.0
    assert distance_between(Sphere([7, 8, 1], 1.0), plane) == -4.0
    assert distance_between(Cylinder([7, 8, 9], [1, 0, 0], 1.0), plane) == 4.0
    assert distance_between(plane, Plane([3, 3, 7], [0, 0, 1])) == 2.0


@pytest.mark.parametrize("degrees", [1e-7, 1e-3, 0.1, 45.0])
def test_nearly_parallel_axes_have_the_distance_of_their_common_perpendicular(degrees):
    turn = Rotation.from_euler("x", degrees, degrees=True).as_matrix()
    one, other = Cylinder([0, 0, 0], [0, 0, 1], 1.0), Cylinder([40, 0, 0], turn @ [0, 0, 1], 1.0)
    assert distance_between(one, other) == pytest.approx(40.0, abs=1e-6)


def test_parallel_axes_have_the_distance_of_their_spacing_even_next_to_rounding():
    rng = np.random.default_rng(4)
    for _ in range(50):
        direction = rotation(rng)[0]
        across = np.cross(direction, rotation(rng)[0])
        across *= 40 / np.linalg.norm(across)
        off = direction + 1e-16 * rng.normal(size=3)
        one, other = Cylinder([0, 0, 0], direction, 1.0), Cylinder(across + 70 * direction, off, 1.0)
        assert distance_between(one, other) == pytest.approx(40.0, abs=1e-9)


def test_angles_of_normals_run_to_180_and_of_axes_to_90():
    up, tilted = np.array([0, 0, 1.0]), np.array([np.sin(2.5), 0, np.cos(2.5)])
    assert angle_between(Plane([0, 0, 0], up), Plane([0, 0, 0], tilted)) == pytest.approx(2.5)
    assert angle_between(Cylinder([0, 0, 0], up, 1), Plane([0, 0, 0], tilted)) == pytest.approx(np.pi - 2.5)
    assert angle_between(Cylinder([0, 0, 0], up, 1), Cylinder([0, 0, 0], tilted, 1)) == pytest.approx(np.pi - 2.5)
    tiny = np.array([1e-9, 0, 1.0])
    assert angle_between(Plane([0, 0, 0], up), Plane([0, 0, 0], tiny)) == pytest.approx(1e-9)


def ordinary_directions():
    """Axes every five degrees of longitude and latitude, and of whole numbers up to five."""
    longitude, latitude = np.radians(np.meshgrid(np.arange(0, 360, 5), np.arange(-90, 91, 5))).reshape(2, -1)
    angles = [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)]
    whole = np.array([v for v in product(range(-5, 6), repeat=3) if any(v)], dtype=float)
    return np.vstack([np.transpose(angles), whole / np.linalg.norm(whole, axis=1, keepdims=True)])


def test_both_senses_of_an_axis_give_one_direction():
    for direction in ordinary_directions():
        np.testing.assert_array_equal(signed_axis(direction), signed_axis(-direction))
        assert np.abs(signed_axis(direction)).tolist() == np.abs(direction).tolist()
    np.testing.assert_array_equal(signed_axis(np.array([0.0, 0.0, -1.0])), [0.0, 0.0, 1.0])


def test_no_rounding_turns_an_ordinary_axis_round():
    rng = np.random.default_rng(5)
    for direction in ordinary_directions():
        for shake in rng.normal(size=(5, 3)):
            shaken = signed_axis(direction + 1e-3 * shake / np.linalg.norm(shake))
            assert shaken @ signed_axis(direction) > 0, direction


def test_a_copy_of_a_surface_is_the_same_to_the_last_digit():
    """Normalising a unit vector again would change the last digit, here in one of five normals."""
    normals = np.random.default_rng(0).normal(size=(1000, 3))
    for plane in (Plane(np.zeros(3), normal) for normal in normals):
        assert abs(np.linalg.norm(plane.normal) - 1) < 1e-15
        assert np.array_equal(Plane(plane.point, plane.normal).normal, plane.normal)
        assert np.array_equal(copy.copy(plane).normal, plane.normal)


def test_a_direction_of_another_length_is_scaled():
    for length in (1e-100, 1 - 1e-12, 1 + 1e-12, 3.0, 1e100):
        direction = Cylinder(np.zeros(3), np.array([0.6, 0.0, 0.8]) * length, 1.0).direction
        assert np.allclose(direction, [0.6, 0.0, 0.8], rtol=0, atol=2e-16)
