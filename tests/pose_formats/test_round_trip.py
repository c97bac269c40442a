"""Any rotation, singular ones included, survives writing and reading in every format."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.convert import write_pose
from tactfix.pose_formats.dialect import Dialect
from tactfix.pose_formats.pose import Pose
from tests.support.plain_poses import pose, turn

FULL = [name for name in DIALECTS if name != "g10"]


def off_by(a, b):
    """The angle (rad) between two rotations, from the chord, which is accurate for small angles."""
    return 2 * np.arcsin(min(1.0, np.linalg.norm(a - b) / np.sqrt(8)))


def assert_survives(dialect: Dialect, original: Pose):
    back = dialect.read(write_pose(dialect.name, original).text)
    length, angle = dialect.most_rounding
    here = original.in_units(dialect.units) if dialect.units else original
    assert off_by(back.rotation, here.rotation) <= angle + 1e-12
    assert np.abs(back.translation - here.translation).max() <= length * (1 + 1e-9) + 1e-12


coarse = st.sampled_from([0.0, 90.0, -90.0, 180.0, 1e-3, 90.001, 89.999, 179.999, -179.9999999, 1e-7, 90 - 4e-6, 45.0])
angles = st.one_of(coarse, st.floats(-180, 180))


@pytest.mark.parametrize("name", FULL)
@settings(deadline=None, max_examples=20)
@given(order=st.permutations("xyz"), a=angles, b=angles, c=angles, t=st.tuples(*[st.floats(-5000, 5000)] * 3))
@example(order=list("zyx"), a=30.0, b=90.0, c=20.0, t=[0.0, 0.0, 0.0])
@example(order=list("xyz"), a=30.0, b=-90.0, c=20.0, t=[1.0, 2.0, 3.0])
@example(order=list("xyz"), a=180.0, b=0.0, c=180.0, t=[-0.0, -1e-9, 0.0])
def test_every_rotation_survives(name, order, a, b, c, t):
    rotation = turn(order[0], a) @ turn(order[1], b) @ turn(order[2], c)
    assert_survives(DIALECTS[name], pose(rotation, t))


@pytest.mark.parametrize("name", FULL)
@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize("upright", [np.eye(3), turn("x", 180), turn("y", 90), turn("x", 90), turn("z", 180)])
def test_a_tilt_of_a_millidegree_survives(name, axis, upright):
    tilted = turn(axis, 1e-3) @ upright
    back = DIALECTS[name].read(write_pose(name, pose(tilted)).text)
    digits = {"fanuc": 0.6e-3}.get(name, 1.2e-4)  # fanuc prints no more than millidegrees
    assert np.rad2deg(off_by(back.rotation, tilted)) < digits
    assert np.rad2deg(off_by(back.rotation, upright)) > 1e-3 - digits


@pytest.mark.parametrize("name", FULL)
@pytest.mark.parametrize("units", ["mm", "m", "um", "in"])
def test_units_of_the_pose_become_those_of_the_dialect(name, units):
    in_mm = {"mm": 1.0, "m": 1000.0, "um": 1e-3, "in": 25.4}
    original = pose(turn("z", 30) @ turn("x", 12), np.array([812.5, -33.0, 120.25]) / in_mm[units], units)
    written = write_pose(name, original)
    back = DIALECTS[name].read(written.text)
    unit = back.units or units
    np.testing.assert_allclose(back.translation * in_mm[unit], [812.5, -33.0, 120.25], atol=1e-3)


@pytest.mark.parametrize("axis", [(1, 0, 0), (-1, 2, 0), (0, -1, 2), (0, 0, -1), (-2, -1, 3), (1, -5, 0)])
def test_of_two_rotation_vectors_of_a_half_turn_the_first_positive_one_is_written(axis):
    unit = np.array(axis) / np.linalg.norm(axis)
    canonical = unit * np.sign(next(value for value in axis if value))
    numbers = DIALECTS["ur"].numbers.of(pose(2 * np.outer(unit, unit) - np.eye(3)).base_from_fixture)
    np.testing.assert_allclose(numbers[3:], np.pi * canonical, atol=1e-9)


@pytest.mark.parametrize("degrees", [0.0, 17.5, -90.0, 180.0, -180.0, 179.99999])
def test_g10_accepts_a_rotation_about_z(degrees):
    assert_survives(DIALECTS["g10"], pose(turn("z", degrees), (1.0, 2.0, 3.0)))


def test_no_angle_is_minus_180_and_no_zero_is_negative():
    nearly = turn("z", -179.99999999)
    for name in ("kuka", "fanuc", "yaskawa", "g68.2", "g10", "heidenhain"):
        text = write_pose(name, pose(nearly, (-1e-9, 0.0, -0.0))).text
        assert "-180.0" not in text
        assert "-0.000 " not in text.replace(",", " ")
        assert "180.0" in text
