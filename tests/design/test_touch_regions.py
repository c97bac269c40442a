"""Intersection of two touchable regions, against dense sampling of the surface."""

import numpy as np
import pytest

from tactfix.design.touch_regions import regions_meet
from tactfix.fixture import TouchBox
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere


def random_motion(rng):
    q = rng.normal(size=4)
    w, x, y, z = q / np.linalg.norm(q)
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = 0.5 * rng.normal(size=3)
    return pose


def random_box(rng):
    a, b = rng.uniform(-2, 2, 3), rng.uniform(-2, 2, 3)
    low, high = np.minimum(a, b), np.maximum(a, b)
    low[rng.random(3) < 0.3], high[rng.random(3) < 0.3] = -np.inf, np.inf
    return TouchBox(low, high)


def samples(kind, rng):
    """A surface around the origin, and many of its points (in the part where the boxes are)."""
    v = rng.normal(size=(20_000, 3))
    n = v / np.linalg.norm(v, axis=1)[:, None]
    d = random_motion(rng)[:3, 0]
    if kind == "sphere":
        return Sphere(np.zeros(3), 1.2), 1.2 * n
    if kind == "plane":
        offsets = 4 * (v - np.outer(v @ d, d))
        return Plane(0.3 * d, d), 0.3 * d + offsets
    out = v - np.outer(v @ d, d)
    out /= np.linalg.norm(out, axis=1)[:, None]
    return Cylinder(np.zeros(3), d, 0.8), 0.8 * out + np.outer(rng.uniform(-8, 8, len(v)), d)


def inside(box, x):
    return ((x >= box.low) & (x <= box.high)).all(axis=1)


@pytest.mark.parametrize("kind", ["plane", "sphere", "cylinder"])
def test_against_sampling(kind):
    rng = np.random.default_rng(6)
    wrong_apart, meet, unconfirmed = 0, 0, 0
    for _ in range(60):
        surface, x = samples(kind, rng)
        motion, one, other = random_motion(rng), random_box(rng), random_box(rng)
        image = x @ motion[:3, :3].T + motion[:3, 3]
        sampled = bool((inside(one, x) & inside(other, image)).any())
        predicted = regions_meet(surface, one, other, motion, 1.0)
        wrong_apart += sampled and not predicted
        meet += predicted
        unconfirmed += predicted and not sampled
    assert wrong_apart == 0
    assert 10 < meet < 55, "the test sees both answers"
    # Small intersections may contain no sample; but most intersections must be confirmed.
    assert unconfirmed <= 0.1 * meet


def test_boxes_that_only_touch_do_not_meet():
    bar = Cylinder(np.zeros(3), np.array([0.0, 1.0, 0.0]), 8.0)
    half_turn = np.diag([1.0, -1.0, -1.0, 1.0])

    def box(low, high):
        return TouchBox(np.array([-np.inf, low, -np.inf]), np.array([np.inf, high, np.inf]))

    assert not regions_meet(bar, box(0.0, 60.0), box(0.0, 60.0), half_turn, 30.0)
    assert not regions_meet(bar, box(5.0, np.inf), box(5.0, np.inf), half_turn, 30.0)
    assert regions_meet(bar, box(-0.1, 60.0), box(-0.1, 60.0), half_turn, 30.0)
    assert regions_meet(bar, None, box(5.0, 60.0), half_turn, 30.0)


def test_a_touch_box_without_thickness_is_kept():
    top = Plane(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    box = TouchBox(np.array([0.0, 0.0, 0.0]), np.array([50.0, 50.0, 0.0]))
    assert regions_meet(top, box, box, np.eye(4), 50.0)
    above = TouchBox(np.array([0.0, 0.0, 1.0]), np.array([50.0, 50.0, 2.0]))
    assert not regions_meet(top, above, above, np.eye(4), 50.0)


@pytest.mark.parametrize("direction", [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]])
def test_a_box_inside_a_ball_or_bar_does_not_meet_its_surface(direction):
    small = TouchBox(np.full(3, -0.1), np.full(3, 0.1))
    wide = TouchBox(np.full(3, -0.1), np.full(3, 5.0))
    for surface in (Sphere(np.zeros(3), 1.2), Cylinder(np.zeros(3), np.array(direction), 1.2)):
        assert not regions_meet(surface, small, small, np.eye(4), 1.2)
        assert regions_meet(surface, wide, wide, np.eye(4), 1.2)
