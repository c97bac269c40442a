"""Touchable parts of surfaces, the extent of a fixture, and touches distributed over it."""

import numpy as np
import pytest

from tactfix.accessibility.touchable import bounds_of, extent_of, extreme_points, face, sample_touches, within_box
from tactfix.fixture import TouchBox
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tests.support.placed_cells import all_cells, ball_and_bar, box, cube_corner, surfaces_of

TILTED = np.array([2.0, 1.0, -1.0]) / np.sqrt(6)


def off_surface(surface, points):
    """Distance from the surface by its defining equation, independent of the package."""
    if isinstance(surface, Plane):
        return np.einsum("ni,i->n", points - surface.point, surface.normal)
    if isinstance(surface, Sphere):
        return np.sqrt(((points - surface.center) ** 2).sum(1)) - surface.radius
    return np.linalg.norm(np.cross(points - surface.point, surface.direction), axis=1) - surface.radius


@pytest.mark.parametrize("fixture", all_cells(), ids=lambda fixture: fixture.name)
def test_touches_lie_on_the_surface_in_the_box_with_outward_normals(fixture):
    surfaces = surfaces_of(fixture)
    centre, radius = extent_of(surfaces, fixture.touch)
    for name, surface in surfaces.items():
        points, normals = sample_touches(surface, fixture.touch.get(name), 150, centre, radius)
        assert len(points) == 150
        assert np.abs(off_surface(surface, points)).max() < 1e-9 * radius
        assert within_box(fixture.touch.get(name), points, 1e-6 * radius).all()
        outward = getattr(surface, "side", "outer") == "outer"
        out = off_surface(surface, points + 1e-3 * radius * normals)
        assert np.allclose(out, 1e-3 * radius * (1 if outward else -1), rtol=1e-2)
        assert np.linalg.norm(points - centre, axis=1).max() <= radius * (1 + 1e-9)


def test_touches_are_spread_over_a_sphere_evenly():
    points, _ = sample_touches(Sphere([0, 0, 0], 1.0), None, 2000, np.zeros(3), 1.0)
    for axis in np.eye(3):
        assert abs(((points @ axis) > 0.5).mean() - 0.25) < 0.01


def test_another_start_gives_other_points():
    first, _ = sample_touches(Sphere([0, 0, 0], 1.0), None, 50, np.zeros(3), 1.0)
    other, _ = sample_touches(Sphere([0, 0, 0], 1.0), None, 50, np.zeros(3), 1.0, (0.1, 0.7))
    assert np.abs(first[:, None] - other[None]).max(axis=2).min() > 1e-6


@pytest.mark.parametrize(
    ("surface", "limits"),
    [
        (Sphere([0, 0, 0], 10.0), box(z=(9.0, 10.0))),
        (Cylinder([0, 0, 0], TILTED, 10.0), box(x=(3.0, 9.0), z=(-20.0, 20.0))),
        (Plane([0, 0, 0], TILTED), box((-1.0, 2.0), (5.0, 6.0))),
        (Plane([0, 0, 3.0], [0, 0, 1]), box((-1.0, 2.0), (5.0, 6.0), (3.0, 3.0))),
        (Cylinder([0, 0, 0], [0, 0, 1], 10.0), box(z=(500.0, np.inf))),
    ],
    ids=["cap", "slanted bar", "slanted plane", "flat box", "beyond the extent"],
)
def test_a_small_or_slanted_box_is_filled(surface, limits):
    points, _ = sample_touches(surface, limits, 100, np.zeros(3), 20.0)
    assert len(points) == 100
    assert within_box(limits, points, 1e-6).all()
    assert np.abs(off_surface(surface, points)).max() < 1e-9


def test_a_box_that_misses_the_surface_gives_no_touches():
    surfaces = [Sphere([0, 0, 0], 1.0), Plane([0, 0, 0], [0, 0, 1]), Cylinder([0, 0, 0], [0, 0, 1], 1.0)]
    limits = [box(z=(2, 3)), box((0, 1), (0, 1), (2, 3)), box(x=(2, 3), z=(0, 1))]
    for surface, limit in zip(surfaces, limits, strict=True):
        assert sample_touches(surface, limit, 20, np.zeros(3), 5.0)[0].shape == (0, 3)


def test_the_extent_is_that_of_what_can_be_touched():
    fixture = ball_and_bar()
    low, high = bounds_of(surfaces_of(fixture), fixture.touch)
    assert np.allclose(low, [-8, -10, -10])
    assert np.allclose(high, [40, 60, 10])
    centre, radius = extent_of(surfaces_of(fixture), fixture.touch)
    assert np.allclose(centre, [16, 25, 0])
    corners = extreme_points(surfaces_of(fixture), fixture.touch)
    assert np.allclose(np.linalg.norm(corners - centre, axis=1), radius)
    assert len(np.unique(corners, axis=0)) == 8


def test_planes_reach_as_far_as_their_boxes():
    fixture = cube_corner()
    low, high = bounds_of(surfaces_of(fixture), fixture.touch)
    assert np.allclose(low, [0, 0, -75])
    assert np.allclose(high, [145, 95, 0])


def test_an_open_bar_reaches_as_far_as_the_rest():
    surfaces = {"a": Sphere([0, 0, 0], 1.0), "b": Sphere([10, 0, 0], 1.0), "bar": Cylinder([5, 0, 9e3], [0, 0, 1], 1.0)}
    low, high = bounds_of(surfaces, {})
    assert np.isfinite([low, high]).all()
    assert -12 < low[2] < -5
    assert 5 < high[2] < 12


def test_the_extent_scales_with_the_unit():
    mm, m = ball_and_bar(), ball_and_bar(1e-3)
    assert np.isclose(extent_of(surfaces_of(mm), mm.touch)[1], 1e3 * extent_of(surfaces_of(m), m.touch)[1])


def test_planes_without_boxes_have_the_size_they_are_given():
    planes = {str(i): Plane([0, 0, 0], axis) for i, axis in enumerate(np.eye(3))}
    centre, radius = extent_of(planes, {}, least=7.0)
    assert np.allclose(centre, 0)
    assert 7.0 <= radius <= 7.0 * np.sqrt(3) + 1e-9


def test_planes_that_meet_in_a_point_within_rounding_have_the_default_size():
    meet = np.array([700.1, -300.3, 1e4 / 3])
    normals = np.array([[1, 0.2, 0.3], [-0.1, 1, 0], [0.3, 0.1, 1]])
    planes = {f"p{k}": Plane(meet + np.cross(n, [30.0, 10.0, -70.0]), n) for k, n in enumerate(normals)}
    _, radius = extent_of(planes, {}, least=100.0)
    assert 100 < radius < 300


def test_the_face_of_a_plane_in_a_cube():
    corners = face(Plane([0, 0, 0], [1, 1, 1]), box((-1, 1), (-1, 1), (-1, 1)))
    assert len(corners) == 6
    assert np.allclose(corners.sum(axis=1), 0)
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    assert np.allclose(edges, np.sqrt(2), atol=1e-6)


def test_a_margin_widens_a_box_and_each_point_may_have_its_own():
    points = np.array([[1.1, 0, 0], [1.1, 0, 0], [0.5, 0, 0]])
    limits = box((0, 1))
    assert within_box(limits, points).tolist() == [False, False, True]
    assert within_box(limits, points, np.array([0.05, 0.2, -0.6])).tolist() == [False, True, False]


def test_a_plane_that_meets_its_box_in_one_point_has_no_touches():
    tangent = Plane(np.ones(3), np.ones(3) / np.sqrt(3))
    box = TouchBox(-np.ones(3), np.ones(3))
    points, normals = sample_touches(tangent, box, 10, np.zeros(3), 2.0)
    assert len(points) == len(normals) == 0
