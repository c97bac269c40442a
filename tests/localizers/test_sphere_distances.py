"""Spheres through one or two contacts with known distances of the centre."""

import numpy as np
import pytest

from tactfix.errors import DegenerateContactsError
from tactfix.localizers.sphere_distances import (
    AxisDistance,
    CenterDistance,
    PlaneDistance,
    localize_sphere_at_distances,
)
from tests.support.touched_surfaces import on_sphere, random_rotation


def _unit(rng):
    return random_rotation(rng)[:, 0]


def _axis(rng, center, direction=None):
    point, direction = rng.normal(size=3) * 3, _unit(rng) if direction is None else np.array(direction, float)
    return AxisDistance(point, direction, float(np.linalg.norm(np.cross(center - point, direction))))


def _plane(rng, center):
    point, normal = rng.normal(size=3) * 3, _unit(rng)
    return PlaneDistance(point, normal, float((center - point) @ normal))


def _center(rng, center):
    other = rng.normal(size=3) * 3
    return CenterDistance(other, float(np.linalg.norm(center - other)))


def _on_axis(rng, center):
    direction = _unit(rng)
    return AxisDistance(center + 2 * direction, direction, 0.0)


KINDS = {
    "two contacts, axis": (2, [_axis], 4),
    "two contacts, plane": (2, [_plane], 2),
    "two contacts, centre": (2, [_center], 2),
    "one contact, two axes": (1, [_axis, _axis], 8),
    "one contact, parallel axes": (1, [lambda r, c: _axis(r, c, [0, 0, 1])] * 2, 4),
    "one contact, square axes": (1, [lambda r, c: _axis(r, c, [0, 0, 1]), lambda r, c: _axis(r, c, [1, 0, 0])], 8),
    "one contact, axis, plane": (1, [_axis, _plane], 4),
    "one contact, axis, centre": (1, [_axis, _center], 4),
    "one contact, two planes": (1, [_plane, _plane], 2),
    "one contact, plane, centre": (1, [_plane, _center], 2),
    "one contact, two centres": (1, [_center, _center], 2),
    "one contact, on an axis": (1, [_on_axis], 2),
    "three contacts, axis": (3, [_axis], 1),
    "two contacts, axis, plane": (2, [_axis, _plane], 1),
}


def _miss(distance, c):
    """The independently computed distance of a centre, minus the known one."""
    if isinstance(distance, AxisDistance):
        return np.linalg.norm(np.cross(distance.direction, c - distance.point)) - distance.distance
    if isinstance(distance, PlaneDistance):
        return (c - distance.point) @ distance.normal - distance.distance
    return np.linalg.norm(c - distance.center) - distance.distance


@pytest.mark.parametrize("kind", KINDS)
def test_truth_is_among_the_candidates_and_each_keeps_the_distances(kind):
    contacts, makers, most = KINDS[kind]
    rng = np.random.default_rng(len(kind))
    for _ in range(25):
        center = rng.normal(size=3) * 3
        points = on_sphere(rng, contacts, center, 2.0)
        distances = tuple(make(rng, center) for make in makers)
        found = [c.surface.center for c in localize_sphere_at_distances(points, 2.0, distances, 1e-10)]
        assert min(np.linalg.norm(c - center) for c in found) < 1e-6
        assert len(found) <= most
        for c in found:
            assert np.linalg.norm(points - c, axis=1) == pytest.approx(np.full(contacts, 2.0), abs=1e-8)
            assert all(abs(_miss(d, c)) < 1e-8 for d in distances)


@pytest.mark.parametrize("kind", ["two contacts, axis", "one contact, two axes"])
def test_every_real_centre_is_found(kind):
    # Newton's method from a grid of starts: every root that it finds must be among the candidates.
    contacts, makers, _ = KINDS[kind]
    rng = np.random.default_rng(17)
    for _ in range(4):
        center = rng.normal(size=3)
        points, distances = on_sphere(rng, contacts, center, 2.0), tuple(make(rng, center) for make in makers)
        found = np.array([c.surface.center for c in localize_sphere_at_distances(points, 2.0, distances)])
        for c in _newton(points, distances, points[0] + on_sphere(rng, 300, radius=2.0)):
            assert np.linalg.norm(found - c, axis=1).min() < 1e-6


def _newton(points, distances, starts):
    """The roots found from all starts (n, 3), which are iterated together."""
    c = starts
    for _ in range(60):
        arms = [c - x for x in points]
        sizes = [2.0 for _ in points]
        for d in distances:
            arm = c - d.point
            arms.append(arm - (arm @ d.direction)[:, None] * d.direction)
            sizes.append(d.distance)
        f = np.stack([np.sum(arm**2, axis=1) - size**2 for arm, size in zip(arms, sizes, strict=True)], axis=1)
        c = c - np.einsum("bij,bj->bi", np.linalg.pinv(2 * np.stack(arms, axis=1)), f)
    roots = c[np.abs(f).max(axis=1) < 1e-12]
    assert len(roots) > 50
    return roots


def test_tangency_is_kept_within_noise_and_marked():
    # Possible centres: a circle of radius sqrt 3 in the plane x = 0, tangent to the cylinder of the known distance.
    points = np.array([[1.0, 0, 0], [-1, 0, 0]])
    for gap, left in ((0.0, 1), (5e-6, 1), (1e-3, 0)):
        axis = AxisDistance(np.array([0.0, 5, 0]), np.array([1.0, 0, 0]), 5 - np.sqrt(3) - gap)
        found = localize_sphere_at_distances(points, 2.0, (axis,), 2e-6)
        assert len(found) == left
        assert all(c.poorly_determined for c in found)


def test_more_than_enough_is_least_squares():
    rng = np.random.default_rng(3)
    center = np.array([1.0, 2, 3])
    points = on_sphere(rng, 6, center, 2.0) + rng.normal(size=(6, 3)) * 1e-4
    distances = (_axis(rng, center), _plane(rng, center))
    (only,) = localize_sphere_at_distances(points, 2.0, distances, 1e-4)
    assert np.linalg.norm(only.surface.center - center) < 5e-4
    # Distances without a sigma are weighted as a thousand times more accurate than contacts.
    assert all(abs(_miss(d, only.surface.center)) < 1e-6 for d in distances)


@pytest.mark.parametrize(("scale", "away"), [(1e-3, 0), (1e3, 0), (1.0, 1e4)])
def test_unit_and_place_do_not_matter(scale, away):
    rng = np.random.default_rng(4)
    center = rng.normal(size=3)
    points, axis = on_sphere(rng, 2, center, 2.0), _axis(rng, center)
    moved = AxisDistance(axis.point * scale + away, axis.direction, axis.distance * scale)
    here = localize_sphere_at_distances(points, 2.0, (axis,), 1e-9)
    there = localize_sphere_at_distances(points * scale + away, 2.0 * scale, (moved,), 1e-9 * scale)
    assert len(here) == len(there)
    for c in here:
        assert min(np.linalg.norm(t.surface.center - c.surface.center * scale - away) for t in there) < 1e-6 * scale


def test_refusals():
    points = np.array([[1.0, 0, 0], [-1, 0, 0]])
    coaxial = AxisDistance(np.zeros(3), np.array([1.0, 0, 0]), np.sqrt(3))
    with pytest.raises(DegenerateContactsError, match="whole circle"):
        localize_sphere_at_distances(points, 2.0, (coaxial,))
    with pytest.raises(DegenerateContactsError, match="leave the centre free"):
        localize_sphere_at_distances(points, 2.0, ())
    twice = PlaneDistance(np.zeros(3), np.array([1.0, 0, 0]), 0.0)
    with pytest.raises(DegenerateContactsError, match="two conditions on the centre are the same"):
        localize_sphere_at_distances(points, 2.0, (twice,))
    with pytest.raises(DegenerateContactsError, match="both axes coincide"):
        localize_sphere_at_distances(points[:1], 2.0, (coaxial, coaxial))
