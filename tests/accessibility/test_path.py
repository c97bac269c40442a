"""Straight approaches: the closed form against small steps along the approach."""

import numpy as np
import pytest

from tactfix.accessibility.approach_path import path_blocked
from tactfix.geometry.arrays import unit
from tactfix.geometry.rigid import rotation_from_vector
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tests.support.placed_cells import box
from tests.support.ray_walk import deepest, depth_in_ball, depth_in_bar

SURFACES = {
    "bar": Cylinder([1, 0, 2], [0, 1, 0], 1.5),
    "ball": Sphere([5, 1, 0], 2.0),
    "wall": Plane([-9, 0, 0], [1, 0, 0]),
}
BOXES = {"bar": box(y=(-3, 4))}


def random_approaches(count, seed=3):
    rng = np.random.default_rng(seed)
    return rng.uniform(-8, 8, (count, 3)), unit(rng.standard_normal((count, 3)))


@pytest.mark.parametrize("margin", [0.0, 0.3, -0.4])
@pytest.mark.parametrize("length", [6.0, 40.0])
def test_balls_and_bars_block_as_small_steps_show(margin, length):
    points, approaches = random_approaches(400)
    blocked = path_blocked(SURFACES, BOXES, "wall", points, approaches, length, margin)
    unclear = 0.02
    blocking = set()
    for point, approach, name in zip(points, approaches, blocked, strict=True):
        bar = deepest(lambda x: depth_in_bar(SURFACES["bar"], -3, 4, x), point, approach, length)
        ball = deepest(lambda x: depth_in_ball(SURFACES["ball"], x), point, approach, length)
        if min(abs(bar - margin), abs(ball - margin)) < unclear:
            continue
        expected = "bar" if bar > margin else "ball" if ball > margin else None
        assert name == expected, (point, approach, bar, ball)
        blocking.add(name)
    assert blocking == {"bar", "ball", None}


def test_an_unlimited_approach_equals_a_very_long_one():
    points, approaches = random_approaches(200)
    endless = path_blocked(SURFACES, BOXES, "wall", points, approaches)
    assert endless == path_blocked(SURFACES, BOXES, "wall", points, approaches, 1e4)
    assert any(endless)


def test_the_touched_feature_and_inner_surfaces_never_block():
    surfaces = {"ball": Sphere([0, 0, 0], 1.0), "bore": Cylinder([0, 0, 0], [0, 0, 1], 5.0, "inner")}
    far_side = np.array([[1.0, 0, 0]]), np.array([[1.0, 0, 0]])
    assert path_blocked(surfaces, {}, "ball", *far_side) == [None]
    assert path_blocked({**surfaces, "other": Sphere([-3, 0, 0], 1.0)}, {}, "ball", *far_side) == ["other"]


def test_a_contact_without_approach_is_not_blocked():
    nothing = np.full((1, 3), np.nan)
    assert path_blocked(SURFACES, BOXES, "wall", np.array([[5.0, 1, 0]]), nothing) == [None]


def test_an_unbounded_bar_does_not_cover_a_contact():
    surfaces = {"bar": Cylinder([0, 0, 0], [0, 1, 0], 1.0), "tip": Sphere([0, 5, 0], 1.2)}
    pole = np.array([[0.0, 6.2, 0.0]]), np.array([[0.0, -1.0, 0.0]])
    assert path_blocked(surfaces, {}, "tip", *pole) == [None]
    assert path_blocked(surfaces, {}, "tip", *pole, strict=True) == ["bar"]
    assert path_blocked(surfaces, {"bar": box(y=(-20, 20))}, "tip", *pole) == ["bar"]
    assert path_blocked(surfaces, {"bar": box(y=(-20, 4))}, "tip", *pole, strict=True) == [None]


def test_a_touch_box_limits_the_length_of_a_bar():
    surfaces = {"bar": Cylinder([0, 0, 0], [0, 1, 0], 1.0), "ball": Sphere([5, 10, 0], 1.0)}
    touch = np.array([[4.0, 10.0, 0.0]]), np.array([[1.0, 0.0, 0.0]])
    assert path_blocked(surfaces, {}, "ball", *touch) == ["bar"]
    assert path_blocked(surfaces, {"bar": box(y=(0, 9))}, "ball", *touch) == [None]
    assert path_blocked(surfaces, {"bar": box(y=(0, 11))}, "ball", *touch) == ["bar"]
    # A box that covers half of the bar's side does not limit its length.
    assert path_blocked(surfaces, {"bar": box(x=(0, 1))}, "ball", *touch) == ["bar"]


FACE = {"face": Plane([0, 0, 0], [0, 0, 1]), "ball": Sphere([0, 0, 10], 1.0)}
UP = np.array([[0.0, 0, 9]]), np.array([[0.0, 0, 1]])


def test_a_face_blocks_what_comes_out_of_its_material():
    small = {"face": box((-2, 2), (-2, 2))}
    assert path_blocked(FACE, small, "ball", *UP) == ["face"]
    assert path_blocked(FACE, small, "ball", *UP, 8.0) == [None]
    assert path_blocked(FACE, small, "ball", UP[0] + [3.0, 0, 0], UP[1]) == [None]
    assert path_blocked(FACE, small, "ball", UP[0] + [1.9, 0, 0], UP[1], margin=0.2) == [None]


def test_only_a_bounded_face_blocks():
    assert path_blocked(FACE, {}, "ball", *UP) == [None]
    assert path_blocked(FACE, {"face": box((-2, 2))}, "ball", *UP) == [None]
    assert path_blocked(FACE, {"face": box((-2, 2), (-2, 2), (-1, 1))}, "ball", *UP) == ["face"]


def test_a_hole_in_a_face_is_open():
    holed = {**FACE, "hole": Cylinder([0, 0, 0], [0, 0, 1], 1.0, "inner")}
    small = {"face": box((-2, 2), (-2, 2))}
    assert path_blocked(holed, small, "ball", *UP) == [None]
    assert path_blocked(holed, small, "ball", UP[0] + [1.5, 0, 0], UP[1]) == ["face"]


def test_a_face_blocks_what_is_behind_it_only_when_strict():
    surfaces = {"face": FACE["face"], "under": Sphere([0, 0, -10], 1.0)}
    down = np.array([[0.0, 0, -9]]), np.array([[0.0, 0, -1]])
    small = {"face": box((-2, 2), (-2, 2))}
    assert path_blocked(surfaces, small, "under", *down) == [None]
    assert path_blocked(surfaces, small, "under", *down, strict=True) == ["face"]
    # Touched from below, the face lies ahead of the probe and does not block the approach.
    assert path_blocked(surfaces, small, "under", np.array([[0.0, 0, -11]]), np.array([[0.0, 0, 1]])) == [None]


def test_a_rigid_motion_without_boxes_changes_nothing():
    points, approaches = random_approaches(300)
    rotation, shift = rotation_from_vector(np.array([0.3, -1.1, 0.7])), np.array([4000.0, -900.0, 77.0])
    ball, bar = SURFACES["ball"], SURFACES["bar"]
    moved = {
        "bar": Cylinder(rotation @ bar.point + shift, rotation @ bar.direction, bar.radius),
        "ball": Sphere(rotation @ ball.center + shift, ball.radius),
        "wall": SURFACES["wall"],
    }
    blocking = path_blocked(moved, {}, "wall", points @ rotation.T + shift, approaches @ rotation.T)
    assert blocking == path_blocked(SURFACES, {}, "wall", points, approaches)
