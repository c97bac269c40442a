"""Spheres through three contacts (radius known), four (radius unknown) or more; and stacks of problems."""

import numpy as np
import pytest

from tactfix.errors import DegenerateContactsError
from tactfix.localizers.sphere import localize_sphere
from tactfix.stacks.sphere_centers import sphere_centers
from tests.support.touched_surfaces import on_sphere, random_rotation


def _nearest(candidates, center):
    return min((np.linalg.norm(c.surface.center - center) for c in candidates), default=np.inf)


@pytest.mark.parametrize("n", [3, 4, 5, 12, 400])
@pytest.mark.parametrize("radius_known", [True, False])
def test_truth_is_among_the_candidates_and_each_fits(n, radius_known):
    if n == 3 and not radius_known:
        pytest.skip("four contacts without a radius")
    rng = np.random.default_rng(n)
    for _ in range(20):
        center, radius = rng.normal(size=3) * 5, 10 ** rng.uniform(-1, 1)
        points = on_sphere(rng, n, center, radius)
        found = localize_sphere(points, radius if radius_known else None)
        assert _nearest(found, center) < 1e-8 * radius
        for c in found:
            # Eq. 3.
            assert np.linalg.norm(points - c.surface.center, axis=1) == pytest.approx(np.full(n, c.surface.radius))


def test_two_centers_are_mirror_images_in_the_plane_of_the_contacts():
    rng = np.random.default_rng(1)
    points = on_sphere(rng, 3, radius=2.0)
    first, second = (c.surface.center for c in localize_sphere(points, 2.0))
    normal = np.cross(points[1] - points[0], points[2] - points[0])
    assert np.linalg.norm(np.cross(second - first, normal)) < 1e-12
    assert (first + second - 2 * points[0]) @ normal == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("up", [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [0, 1, -1]])
def test_no_axis_is_preferred(up):
    # The paper divides by the z component of the triangle's normal: here it is zero for some of these.
    side = np.linalg.svd(np.array([up], float))[2]
    angle = np.array([0, 2, 4])[:, None]
    points = np.cos(angle) * side[1] + np.sin(angle) * side[2]
    heights = sorted(c.surface.center @ side[0] for c in localize_sphere(points, 2.0))
    assert heights == pytest.approx([-np.sqrt(3), np.sqrt(3)], abs=1e-12)


def test_great_circle_is_a_double_root_kept_and_marked():
    points = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0]])
    for radius in (1.0, 1 - 2e-6, 1 + 2e-12):
        found = localize_sphere(points, radius, 1e-6)
        assert found
        assert all(c.poorly_determined for c in found)
        assert _nearest(found, np.zeros(3)) < 5e-6
    assert localize_sphere(points, 1 - 1e-4, 1e-6) == ()
    assert not any(c.poorly_determined for c in localize_sphere(points, 1.1, 1e-6))


def test_redundant_contacts_tell_the_two_centers_apart():
    rng = np.random.default_rng(2)
    points = on_sphere(rng, 6, (1, 2, 3), 4.0) + rng.normal(size=(6, 3)) * 1e-3
    (only,) = localize_sphere(points, 4.0, 1e-3)
    assert np.linalg.norm(only.surface.center - [1, 2, 3]) < 0.01


def test_both_sides_of_a_flat_cap_are_kept_when_noise_cannot_tell():
    angle = np.linspace(0, 2 * np.pi, 7)[:-1]
    points = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(6)])
    assert len(localize_sphere(points, 3.0, 1e-3)) == 2


@pytest.mark.parametrize(("scale", "away"), [(1e-3, 0), (1e3, 0), (1.0, 1e4)])
@pytest.mark.parametrize("radius", [1.5, None])
def test_unit_place_and_rotation_do_not_matter(scale, away, radius):
    rng = np.random.default_rng(3)
    points = on_sphere(rng, 4, radius=1.5)
    rotation = random_rotation(rng)
    here = localize_sphere(points, radius)
    moved = localize_sphere(
        scale * points @ rotation.T + away, None if radius is None else radius * scale, 1e-9 * scale
    )
    assert len(here) == len(moved)
    for c in here:
        assert _nearest(moved, scale * rotation @ c.surface.center + away) < 1e-7 * scale


@pytest.mark.parametrize(("scale", "away"), [(1.0, 0.0), (1e-3, 0.0), (1e3, 0.0), (1.0, 1e4)])
@pytest.mark.parametrize(
    ("points", "radius", "why"),
    [
        ([[0, 0, 0], [0, 0, 0], [1, 0, 0]], 2.0, "different places"),
        ([[0, 0, 0], [1, 0, 0], [3, 0, 0]], 2.0, "one straight line"),
        ([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], None, "one plane"),
    ],
)
def test_refusals(points, radius, why, scale, away):
    with pytest.raises(DegenerateContactsError, match=why):
        localize_sphere(np.array(points, float) * scale + away, None if radius is None else radius * scale)


def test_stack_equals_one_at_a_time():
    rng = np.random.default_rng(4)
    points = on_sphere(rng, 600).reshape(2, 100, 3, 3)
    stack = sphere_centers(points, 1.0)
    assert stack.centers.shape == (2, 100, 2, 3)
    for index in np.ndindex(2, 100):
        one = localize_sphere(points[index], 1.0)
        assert stack.valid[index] == bool(one)
        for center in stack.centers[index]:
            assert _nearest(one, center) < 1e-7


def test_stack_marks_what_has_no_center_and_keeps_double_roots():
    circle = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0]])
    line = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    stack = sphere_centers(np.array([circle, circle, circle, line]), np.array([2.0, 1 - 1e-6, 0.5, 2.0]), 1e-5)
    assert stack.valid.tolist() == [True, True, False, False]
    assert stack.double.tolist() == [False, True, False, False]
    assert np.isnan(stack.centers[2:]).all()
