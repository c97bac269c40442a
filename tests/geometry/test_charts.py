"""Displacements of surfaces: every derivative against finite differences."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.geometry.charts import (
    dimension,
    displaced,
    material_displacement,
    residual_jacobian,
    rigid_displacements,
)
from tactfix.geometry.nearest import direction_of
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, moved, residuals
from tests.support.plain_surfaces import KINDS, any_surface

H = 1e-6


def steps(surface):
    return H * np.eye(dimension(surface))


@pytest.mark.parametrize(("kind", "side"), KINDS)
def test_residual_jacobian(kind, side):
    rng = np.random.default_rng(0)
    for _ in range(5):
        surface = any_surface(kind, rng, side)
        points = rng.normal(size=(8, 3)) * 20
        numeric = [
            (residuals(displaced(surface, s), points, 1.0) - residuals(displaced(surface, -s), points, 1.0)) / (2 * H)
            for s in steps(surface)
        ]
        np.testing.assert_allclose(residual_jacobian(surface, points), np.array(numeric).T, atol=1e-7)


@pytest.mark.parametrize(("kind", "side"), KINDS)
def test_a_displacement_of_zero_changes_nothing_and_size_stays(kind, side):
    surface = any_surface(kind, np.random.default_rng(1), side)
    points = np.random.default_rng(2).normal(size=(5, 3))
    same = displaced(surface, np.zeros(dimension(surface)))
    np.testing.assert_allclose(residuals(same, points, 0.0), residuals(surface, points, 0.0), atol=1e-12)
    far = displaced(surface, np.ones(dimension(surface)))
    assert getattr(far, "radius", None) == getattr(surface, "radius", None)
    assert getattr(far, "side", None) == getattr(surface, "side", None)


@pytest.mark.parametrize(("kind", "side"), KINDS)
def test_displacements_of_a_rigid_motion(kind, side):
    """The charts reproduce the derivatives of the residuals by a rotation about a centre and a translation."""
    rng = np.random.default_rng(3)
    surface, centre = any_surface(kind, rng, side), rng.normal(size=3) * 10
    points = rng.normal(size=(8, 3)) * 20
    jacobian = residual_jacobian(surface, points) @ rigid_displacements(surface, centre)
    for k in range(6):
        changes = []
        for sign in (1, -1):
            twist = np.zeros(6)
            twist[k] = sign * H
            pose = np.eye(4)
            pose[:3, :3] = Rotation.from_rotvec(twist[:3]).as_matrix()
            pose[:3, 3] = centre - pose[:3, :3] @ centre + twist[3:]
            changes.append(residuals(moved(pose, surface), points, 0.0))
        np.testing.assert_allclose(jacobian[:, k], (changes[0] - changes[1]) / (2 * H), atol=1e-7)


@pytest.mark.parametrize("kind", ["plane", "sphere", "cylinder"])
def test_a_point_carried_by_the_surface(kind):
    """A point of an axis or a centre moves with it; a point of a plane moves along the normal with the plane there."""
    rng = np.random.default_rng(4)
    surface = any_surface(kind, rng)
    if isinstance(surface, Sphere):
        np.testing.assert_array_equal(material_displacement(surface, surface.center), np.eye(3))
        return
    direction = surface.normal if isinstance(surface, Plane) else surface.direction
    arm = rng.normal(size=3) * 5
    arm = arm - (arm @ direction) * direction if isinstance(surface, Plane) else 7.0 * direction
    point = surface.point + arm
    for k, step in enumerate(steps(surface)):
        ahead, behind = displaced(surface, step), displaced(surface, -step)
        if isinstance(surface, Plane):
            rise = [(p.normal @ (p.point - point)) / (p.normal @ surface.normal) for p in (ahead, behind)]
            expected = (rise[0] - rise[1]) / (2 * H)
            assert material_displacement(surface, point)[:, k] @ surface.normal == pytest.approx(expected, abs=1e-6)
        else:
            assert isinstance(ahead, Cylinder)
            expected = ((ahead.point + 7 * ahead.direction) - (behind.point + 7 * behind.direction)) / (2 * H)
            np.testing.assert_allclose(material_displacement(surface, point)[:, k], expected, atol=1e-6)


@pytest.mark.parametrize("surface", [Plane((1, 2, 3), (0, 0, 1)), Cylinder((1, 2, 3), (0.6, 0, 0.8), 2.0, "outer")])
def test_a_stack_of_displacements_gives_the_stack_of_surfaces(surface):
    steps = np.vstack([np.zeros(dimension(surface)), 0.1 * np.eye(dimension(surface))])
    stack = displaced(surface, steps)
    for number, step in enumerate(steps):
        alone = displaced(surface, step)
        assert direction_of(stack)[number] == pytest.approx(direction_of(alone), abs=1e-15)
        assert stack.point[number] == pytest.approx(alone.point, abs=1e-15)
