"""Conversion of poses: rounding errors reported or rejected, and sigmas of the numbers that a format writes."""

import numpy as np
import pytest

from tactfix.errors import PoseRefusedError, UsageError
from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.convert import sigmas_of_numbers, write_pose
from tests.support.plain_poses import pose, turn

TILTED = turn("z", 33.3333333) @ turn("y", 12.3456789) @ turn("x", -71.1111111)
SPOT = (812.3456789, -33.9876543, 120.1234567)


def covariance(sigma_rot, sigma_t):
    return np.diag([sigma_rot**2] * 3 + [sigma_t**2] * 3)


def test_rounding_is_reported_at_a_lever_arm():
    (note,) = write_pose("fanuc", pose(TILTED, SPOT)).notes
    assert "rounds" in note
    assert "at 500 mm from the fixture's origin" in note
    back = DIALECTS["fanuc"].read(write_pose("fanuc", pose(TILTED, SPOT)).text)
    shift = np.linalg.norm(back.translation - SPOT)
    assert f"the origin by {shift:.2g} mm" in note


def test_lever_arm_is_in_the_units_of_the_dialect():
    (note,) = write_pose("ur", pose(TILTED, SPOT)).notes
    assert "at 0.5 m from the fixture's origin" in note


def test_an_exact_format_gives_no_note():
    assert write_pose("json", pose(TILTED, SPOT)).notes == ()
    assert write_pose("kuka", pose(np.eye(3), (1.0, 2.0, 3.0))).notes == ()


def test_rounding_beyond_a_tenth_of_sigma_is_refused_unless_forced():
    # fanuc rounds to 0.0005 mm and 0.0005 deg (8.7e-6 rad)
    precise = pose(TILTED, SPOT, covariance=covariance(2e-6, 0.001))
    with pytest.raises(PoseRefusedError, match="tenth of sigma"):
        write_pose("fanuc", precise)
    assert write_pose("fanuc", precise, force=True).text == write_pose("fanuc", pose(TILTED, SPOT)).text
    assert "sigma" in write_pose("fanuc", pose(TILTED, SPOT, covariance=covariance(2e-4, 0.01))).notes[0]


def test_negligible_rounding_is_not_reported():
    # The rounding of fanuc is reported without a covariance, and above with a tenth of this sigma.
    notes = write_pose("fanuc", pose(TILTED, SPOT, covariance=covariance(2e-3, 0.1))).notes
    assert not any("rounds" in note for note in notes)


@pytest.mark.parametrize(("sigma_rot", "sigma_t"), [(1e-1, 1e-3), (1e-6, 10.0)])
def test_either_part_of_the_rounding_is_enough_to_refuse(sigma_rot, sigma_t):
    with pytest.raises(PoseRefusedError):
        write_pose("fanuc", pose(TILTED, SPOT, covariance=covariance(sigma_rot, sigma_t)), lever_arm_mm=1e7 * sigma_t)


def test_a_forced_tilt_states_what_is_lost():
    written = write_pose("g10", pose(turn("x", 0.5)), force=True)
    assert "G10 L2 P1" in written.text
    assert "0.5 deg of tilt" in written.notes[0]


@pytest.mark.parametrize("name", ["g10", "kuka", "ur"])
def test_an_unstated_unit_is_asked_for(name):
    with pytest.raises(UsageError, match="give units"):
        write_pose(name, pose(np.eye(3), units=None))


def test_an_unknown_dialect_is_answered_with_all_names():
    with pytest.raises(UsageError, match="kuka"):
        write_pose("cuca", pose(np.eye(3)))


# One format for each kind of numbers; g10 has no tilt.
UNLIKE = {
    (dialect.numbers.orientation, dialect.numbers.units): name
    for name, dialect in DIALECTS.items()
    if dialect.numbers and name != "g10"
}


@pytest.mark.parametrize("name", UNLIKE.values())
@pytest.mark.parametrize("rotation", [TILTED, turn("x", 180), turn("z", 179.9999999), np.eye(3), turn("y", 180)])
def test_sigmas_are_the_scatter_of_poses(name, rotation):
    """Poses at one sigma to either side along each principal error have the scatter of random errors."""
    numbers = DIALECTS[name].numbers
    rng = np.random.default_rng(7)
    root = rng.normal(size=(6, 6)) * np.r_[1e-5, 1e-5, 1e-5, 1e-2, 1e-2, 1e-2][:, None]
    original = pose(rotation, SPOT, numbers.units, root @ root.T)
    sigmas = sigmas_of_numbers(numbers, original)
    samples = []
    here = numbers.of(original.base_from_fixture)
    for error in np.sqrt(6) * np.hstack([root, -root]).T:
        # exp([d]) to second order is enough for 1e-5 rad
        x, y, z = error[:3]
        k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        drawn = pose((np.eye(3) + k + k @ k / 2) @ rotation, np.array(SPOT) + error[3:]).base_from_fixture
        got = numbers.of(drawn)
        samples.append(np.r_[got[:3], numbers.orientation.nearest(got[3:], here[3:])])
    scatter = np.std(samples, axis=0)
    known = ~np.isnan(sigmas)
    np.testing.assert_allclose(scatter[known], sigmas[known], rtol=1e-3, atol=1e-9)
    assert known[:3].all()
    assert known.all() or "gimbal" in write_pose(name, original, force=True).text + str(
        write_pose(name, original, force=True).notes
    )


def test_sigmas_are_written_as_comments():
    sure = covariance(1e-3, 0.1)
    kuka = write_pose("kuka", pose(np.eye(3), covariance=sure)).text
    assert kuka.splitlines()[0] == "; sigma: X 0.1 mm, Y 0.1 mm, Z 0.1 mm, A 0.057 deg, B 0.057 deg, C 0.057 deg"
    yaskawa = write_pose("yaskawa", pose(np.eye(3), covariance=sure))
    assert "sigma" not in yaskawa.text
    assert "Rx 0.057 deg" in yaskawa.notes[-1]
    assert "<!-- sigma: x 0.0001 m" in write_pose("urdf", pose(np.eye(3), covariance=sure)).text


def test_gimbal_lock_is_named_instead_of_a_sigma_without_bounds():
    for name, rotation in [("kuka", turn("y", 90)), ("kuka", turn("y", -89.8)), ("kawasaki", np.eye(3))]:
        text = write_pose(name, pose(rotation, covariance=covariance(1e-3, 0.1))).text
        assert "Z 0.1 mm, rotation 0.057 deg, no angle for itself in gimbal lock" in text
    assert "gimbal" not in write_pose("kuka", pose(turn("y", 89), covariance=covariance(1e-3, 0.1))).text


@pytest.mark.parametrize("name", [name for name, dialect in DIALECTS.items() if dialect.comments and dialect.numbers])
def test_a_remark_cannot_end_its_comment(name):
    text = write_pose(name, pose(np.eye(3), covariance=covariance(1e-3, 0.1)), force=True).text
    remark = next(line for line in text.splitlines() if "sigma: " in line)
    assert remark.count("(") <= 1
    assert remark.count(")") <= 1
    assert remark.removeprefix("<!--").removesuffix("-->").count("--") == remark.startswith("--")


def test_a_covariance_follows_the_units():
    at_home = pose(TILTED, SPOT, covariance=covariance(1e-3, 0.1))
    assert at_home.in_units("m").covariance[3, 3] == pytest.approx(1e-8)
    assert at_home.in_units("m").covariance[0, 0] == 1e-6
