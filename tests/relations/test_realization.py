"""All rigid shapes that distances and angles allow, and none if a motion is free."""

import numpy as np
import pytest

from tactfix.relations.realization import realize
from tests.support.problems import (
    BALLS,
    BALLS_RECIPE,
    CORNER,
    CYLINDER_SPHERE,
    CYLINDER_SPHERE_RECIPE,
    Patch,
    angle,
    ball_distances,
    distance,
    placed,
    recipe,
    related,
)

CORNER_RECIPE = recipe(("meet_of", "right", "back", "top"), ("x", "along", "right"), ("y", "along", "back"))
SQUARE = [angle("right", "back", 90), angle("right", "top", 90), angle("back", "top", 90)]
FOUR = {**BALLS, "d": Patch("sphere", (60, 50, 90), radius=10.0)}
FOUR_DISTANCES = [
    distance(m, n, float(np.linalg.norm(np.subtract(FOUR[m].at, FOUR[n].at))))
    for m, n in (("a", "b"), ("a", "c"), ("b", "c"), ("a", "d"), ("b", "d"), ("c", "d"))
]


def test_bar_and_ball_are_one_shape():
    (shape,) = realize(related(CYLINDER_SPHERE, [distance("bar", "ball", 3.0)], CYLINDER_SPHERE_RECIPE))
    np.testing.assert_allclose(shape["ball"].center, [3, 0, 0], atol=1e-7)
    np.testing.assert_allclose(abs(shape["bar"].direction), [0, 1, 0], atol=1e-7)
    np.testing.assert_allclose(shape["bar"].point, 0, atol=1e-7)


def test_three_balls_are_one_shape_because_their_mirror_image_is_a_turn():
    (shape,) = realize(related(BALLS, ball_distances(), BALLS_RECIPE))
    for name, patch in BALLS.items():
        np.testing.assert_allclose(shape[name].center, patch.at, atol=1e-6)


def test_four_balls_have_a_mirror_image():
    shapes = realize(related(FOUR, FOUR_DISTANCES, BALLS_RECIPE))
    heights = sorted(shape["d"].center[2] for shape in shapes)
    np.testing.assert_allclose(heights, [-90, 90], atol=1e-5)
    for shape in shapes:
        np.testing.assert_allclose(shape["d"].center[:2], [60, 50], atol=1e-5)


def test_a_corner_known_by_its_angles_has_a_mirror_image():
    """With x and y given, z out of the top is right-handed or left-handed: a corner and its mirror image."""
    shapes = realize(related(CORNER, SQUARE, CORNER_RECIPE))
    normals = sorted(tuple(np.round(shape["top"].normal, 6)) for shape in shapes)
    assert normals == [(0, 0, -1), (0, 0, 1)]
    for shape in shapes:
        np.testing.assert_allclose(shape["right"].normal, [1, 0, 0], atol=1e-8)
        np.testing.assert_allclose(shape["back"].normal, [0, 1, 0], atol=1e-8)
        assert all(abs(s.point @ s.normal) < 1e-8 for s in shape.values())


@pytest.mark.parametrize(
    "fixture",
    [
        related(CYLINDER_SPHERE, [], CYLINDER_SPHERE_RECIPE),
        related(BALLS, ball_distances()[:2], BALLS_RECIPE),
        related(CORNER, SQUARE[:2], CORNER_RECIPE),
        related(FOUR, FOUR_DISTANCES[:5], BALLS_RECIPE),
    ],
    ids=["no distance", "two of three distances", "two of three angles", "five of six distances"],
)
def test_relations_that_leave_a_motion_free_have_no_shape(fixture):
    assert realize(fixture) == ()


def test_contradictory_relations_have_no_shape():
    assert (
        realize(related(BALLS, [distance("a", "b", 10), distance("a", "c", 10), distance("b", "c", 30)], BALLS_RECIPE))
        == ()
    )


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_the_unit_changes_nothing(scale):
    relations = [type(r)(r.kind, r.between, r.value * scale, 0.0) for r in FOUR_DISTANCES]
    shapes = realize(related(FOUR, relations, BALLS_RECIPE, scale=scale))
    heights = sorted(shape["d"].center[2] / scale for shape in shapes)
    np.testing.assert_allclose(heights, [-90, 90], atol=1e-5)


SLAB = {
    "top": Patch("plane", (0, -60, 0), (0, 0, 1), length=40.0),
    "bottom": Patch("plane", (0, -10, -25), (0, 0, -1), length=40.0),
    "end": Patch("plane", (-50, -10, -12), (-1, 0, 0), length=12.0),
    "hole": Patch("cylinder", (0, 0, 0), (0, 0, 1), 12.0, side="inner", length=8.0, middle=-12.0),
}


def test_a_slab_may_also_be_a_slot():
    """A distance of planes has no sign: bottom 25 below or above the top, end 50 before or behind the hole."""
    relations = [angle("top", "bottom", 180), distance("bottom", "top", 25.0), angle("top", "end", 90)]
    relations += [angle("hole", "top", 0), distance("hole", "end", 50.0)]
    fixture = related(
        SLAB, relations, recipe(("meet_of", "hole", "top"), ("z", "along", "top"), ("x", "-along", "end"))
    )
    shapes = realize(fixture)
    found = {(round(float(s["bottom"].point[2])), round(float(s["end"].point[0]))) for s in shapes}
    assert found == {(-25, -50), (25, -50), (-25, 50), (25, 50)}


def test_a_fixture_by_geometry_is_its_own_shape():
    fixture = placed(CYLINDER_SPHERE)
    (shape,) = realize(fixture)
    assert shape["ball"] is fixture.features["ball"].surface


def test_an_axis_has_the_same_sign_in_every_shape():
    """The axis points up, whichever sense the random starts had."""
    two_bars = {
        "pin": Patch("cylinder", (0, 0, 0), (0, 0, 1), 9.0),
        "bar": Patch("cylinder", (0, 40, 5), (1, 0, 0), 5.0),
    }
    fixture = related(
        two_bars,
        [distance("pin", "bar", 40.0), angle("pin", "bar", 90.0)],
        recipe(("foot_of", "bar", "pin"), ("z", "along", "pin"), ("y", "from_to", "pin", "bar")),
    )
    shapes = realize(fixture)
    assert shapes
    for axis in ("pin", "bar"):
        assert all(shape[axis].direction @ [0.092, 0.188, 1.0] > 0 for shape in shapes)
