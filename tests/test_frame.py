"""The frame recipe: every rule against values computed by hand; right-handed orthonormal frames; rejected recipes."""

from itertools import permutations

import numpy as np
import pytest

from tactfix.frame import FrameError, frames
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, moved
from tests.support.problems import random_pose, recipe

SURFACES = {
    "ball": Sphere([3.0, 4.0, 5.0], 1.0),
    "far": Sphere([13.0, 4.0, 5.0], 1.0),
    "low": Sphere([0.0, 0.0, -7.0], 1.0),
    "bar": Cylinder([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 2.0),
    "post": Cylinder([8.0, 0.0, 2.0], [0.0, 0.0, 1.0], 2.0),
    "beam": Cylinder([1.0, 6.0, 3.0], [1.0, 0.0, 0.0], 2.0),
    "top": Plane([9.0, 9.0, 5.0], [0.0, 0.0, 1.0]),
    "side": Plane([2.0, 9.0, 9.0], [1.0, 0.0, 0.0]),
    "front": Plane([9.0, 1.0, 9.0], [0.0, 1.0, 0.0]),
    "oblique": Plane([0.0, 0.0, 5.0], [0.0, 0.6, 0.8]),
}
AXES = (("x", "along", "side"), ("y", "along", "front"))


@pytest.mark.parametrize(
    ("origin", "expected"),
    [
        (("center_of", "ball"), (3, 4, 5)),
        (("foot_of", "ball", "bar"), (0, 0, 5)),
        (("foot_of", "ball", "side"), (2, 4, 5)),
        (("foot_of", "beam", "bar"), (0, 0, 3)),
        (("foot_of", "bar", "beam"), (0, 6, 3)),
        (("meet_of", "top", "side", "front"), (2, 1, 5)),
        (("meet_of", "post", "top"), (8, 0, 5)),
        (("meet_of", "bar", "oblique"), (0, 0, 5)),
        (("meet_of", "post", "oblique"), (8, 0, 5)),
    ],
)
def test_origins(origin, expected):
    for pose in [np.eye(4), random_pose(np.random.default_rng(0))]:
        surfaces = {name: moved(pose, surface) for name, surface in SURFACES.items()}
        (frame,) = frames(recipe(origin, *AXES), surfaces)
        np.testing.assert_allclose(np.linalg.solve(pose, frame)[:3, 3], expected, atol=1e-9)


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        (("along", "top"), (0, 0, 1)),
        (("-along", "top"), (0, 0, -1)),
        (("from_to", "ball", "far"), (1, 0, 0)),
        (("-from_to", "ball", "far"), (-1, 0, 0)),
        (("from_to", "bar", "ball"), (0.6, 0.8, 0)),
        (("from_to", "ball", "bar"), (-0.6, -0.8, 0)),
        (("from_to", "bar", "beam"), (0, 1, 0)),
        (("from_to", "bar", "post"), (1, 0, 0)),
        (("from_to", "side", "ball"), (1, 0, 0)),
        (("from_to", "low", "top"), (0, 0, 1)),
    ],
)
def test_directions(rule, expected):
    other = ("y", "along", "oblique")
    for pose in [np.eye(4), random_pose(np.random.default_rng(1))]:
        surfaces = {name: moved(pose, surface) for name, surface in SURFACES.items()}
        (frame,) = frames(recipe(("center_of", "ball"), ("z", *rule), other), surfaces)
        np.testing.assert_allclose(pose[:3, :3].T @ frame[:3, 2], expected, atol=1e-12)


@pytest.mark.parametrize("axes", list(permutations("xyz", 2)))
def test_first_axis_is_exact_second_square_third_right_handed(axes):
    rng = np.random.default_rng(2)
    for _ in range(20):
        pose = random_pose(rng, 1e4)
        surfaces = {name: moved(pose, surface) for name, surface in SURFACES.items()}
        rules = ((axes[0], "along", "oblique"), (axes[1], "from_to", "ball", "low"))
        (frame,) = frames(recipe(("center_of", "ball"), *rules), surfaces)
        turn = frame[:3, :3]
        np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=4e-16 * 4)
        assert np.linalg.det(turn) == pytest.approx(1, abs=1e-15)
        i, j = ("xyz".index(a) for a in axes)
        np.testing.assert_allclose(turn[:, i], surfaces["oblique"].normal, atol=4e-16)
        wish = surfaces["low"].center - surfaces["ball"].center
        wish = wish - (wish @ turn[:, i]) * turn[:, i]
        np.testing.assert_allclose(turn[:, j], wish / np.linalg.norm(wish), atol=1e-11)


def test_an_axis_has_no_sign_and_every_choice_is_given():
    rule = recipe(("foot_of", "ball", "bar"), ("y", "along", "bar"), ("x", "from_to", "bar", "ball"))
    found = frames(rule, SURFACES)
    assert sorted(frame[2, 1] for frame in found) == [-1.0, 1.0]
    for frame in found:
        np.testing.assert_allclose(frame[:3, 0], [0.6, 0.8, 0.0], atol=1e-15)
        assert np.linalg.det(frame) == pytest.approx(1)
    both = frames(recipe(("center_of", "ball"), ("y", "along", "bar"), ("x", "along", "beam")), SURFACES)
    assert len({tuple(np.round(frame[:3, :3], 9).ravel()) for frame in both}) == 4


@pytest.mark.parametrize(
    ("rules", "words"),
    [
        ((("center_of", "ball"), ("x", "along", "bar"), ("y", "along", "post")), "parallel"),
        ((("center_of", "ball"), ("x", "along", "top"), ("y", "from_to", "low", "top")), "parallel"),
        ((("meet_of", "top", "top", "side"), *AXES), "do not meet"),
        ((("meet_of", "bar", "side"), *AXES), "parallel"),
        ((("foot_of", "post", "bar"), *AXES), "no foot"),
        ((("center_of", "ball"), ("x", "along", "ball"), ("y", "along", "top")), "no direction"),
    ],
)
def test_recipes_that_give_no_frame(rules, words):
    with pytest.raises(FrameError, match=words):
        frames(recipe(*rules), SURFACES)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_features_that_coincide_within_a_millionth_have_no_direction(scale):
    rule = recipe(("center_of", "a"), ("x", "from_to", "a", "b"), ("z", "along", "top"))

    def surfaces(gap):
        return {"a": Sphere([0, 0, 0], scale), "b": Sphere([gap * scale, 0, 0], scale), "top": SURFACES["top"]}

    frames(rule, surfaces(1e-3))
    with pytest.raises(FrameError, match="coincide"):
        frames(rule, surfaces(1e-7))
