"""Simulated robots with known errors: found within their sigmas; rejected without an independent check."""

from dataclasses import replace

import numpy as np
import pytest

from tactfix.calibration.calibrate import calibrate
from tactfix.calibration.cell import Cell, Place, Touches
from tactfix.calibration.independence import independent
from tactfix.calibration.result import Calibration
from tactfix.errors import UsageError
from tests.support.arms import PRIOR, SEATS, arm_cell, fixture, random_errors, touched_seats


@pytest.fixture(scope="module")
def simulated() -> tuple[Cell, Touches, dict[str, float]]:
    rng = np.random.default_rng(11)
    cell = arm_cell(("all",), {name: fixture(dict(SEATS)) for name in ("front", "left", "high")})
    errors = random_errors(cell, rng)
    return cell, touched_seats(cell, errors, 5, 0.03, rng), errors


@pytest.fixture(scope="module")
def calibrated(simulated: tuple[Cell, Touches, dict[str, float]]) -> Calibration:
    return calibrate(*simulated[:2])


@pytest.fixture(scope="module")
def offsets(simulated: tuple[Cell, Touches, dict[str, float]]) -> tuple[Cell, Touches]:
    """The same cell with a robot whose only errors are joint offsets and the tip."""
    rng = np.random.default_rng(12)
    cell = replace(simulated[0], unknown=("joint_offsets", "tip"))
    errors = {name: e for name, e in simulated[2].items() if "offset" in name or "tip" in name}
    return cell, touched_seats(cell, errors, 4, 0.03, rng)


def test_a_robot_with_errors_is_found(
    simulated: tuple[Cell, Touches, dict[str, float]], calibrated: Calibration
) -> None:
    cell, _, errors = simulated
    assert calibrated.status == "calibrated"
    assert calibrated.reasons == ()
    assert all(place.rms_after < 0.08 and place.rms_before > 0.3 for place in calibrated.places)
    # Tip positions relative to the best-fitting base do not depend on the choice of parameters.
    joints = np.random.default_rng(1).uniform(-1, 1, (200, 6))
    true = cell.chain.points(joints, np.array([errors[name] for name in cell.chain.names()]))
    found = cell.chain.points(joints, calibrated.values[:-1])
    nominal = cell.chain.points(joints, np.zeros(len(errors)))
    assert off(found, true) < 3 * calibrated.prediction[1]
    assert off(found, true) < 0.1 * off(nominal, true)


def off(points: np.ndarray, true: np.ndarray) -> float:
    """The rms distance of points from the true ones after the best rigid motion (Kabsch)."""
    a, b = points - points.mean(axis=0), true - true.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    turn = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return float(np.sqrt(((a @ turn - b) ** 2).sum(axis=1).mean()))


def test_the_number_of_parameters_is_that_of_theory(simulated: tuple[Cell, Touches, dict[str, float]]) -> None:
    """4 R + 6 for R revolute joints, base and tool (Everett and Hsu), less 3 (no tip orientation), less 6 (base)."""
    free, held = independent(simulated[0], None)
    assert free.sum() == 4 * 6 + 6 - 3 - 6
    assert free.sum() + len(held) == len(simulated[0].chain.parameters)
    by_name = {simulated[0].parameters[item.index].name: item.message for item in held}
    assert "the poses of the fixtures" in by_name["joint_1.offset"]
    assert "tip" in by_name["joint_6.offset"]


def test_the_width_of_the_prior_does_not_decide_what_is_determined(offsets: tuple[Cell, Touches]) -> None:
    """The prior is scaled by the nominal robot's residuals, except the tip's, which is small here."""
    cell, touches = offsets
    few = touches.subset(np.flatnonzero(np.arange(len(touches)) % 4 < 2))
    p = cell.prior
    wide = replace(cell, prior=replace(p, joint_offset=5 * p.joint_offset, length=5 * p.length, angle=5 * p.angle))
    narrow, wider = (calibrate(cell, few).undetermined for cell in (cell, wide))
    assert 0 < narrow < 0.5
    assert wider == pytest.approx(narrow, rel=0.05)


def test_the_tip_alone_is_calibrated(simulated: tuple[Cell, Touches, dict[str, float]]) -> None:
    rng = np.random.default_rng(13)
    cell = replace(simulated[0], unknown=("tip",))
    errors = {"tip.x": 1.5, "tip.y": -0.8, "tip.z": 2.1}
    result = calibrate(cell, touched_seats(cell, errors, 2, 0.03, rng))
    assert result.status == "calibrated"
    assert result.shrinkage > 0
    for item in result.parameters:
        assert item.value == pytest.approx(errors[item.name], abs=4 * item.sigma)
    assert all(left.rms_after < 0.1 < left.rms_before for left in result.left_out)


def test_a_place_held_out_has_no_influence(offsets: tuple[Cell, Touches]) -> None:
    cell, touches = offsets
    spoilt = replace(touches, joints=touches.joints + np.array([p == "high" for p in touches.places])[:, None] * 0.3)
    whole, other = (calibrate(cell, t, hold_out=("high",)) for t in (touches, spoilt))
    assert np.array_equal(whole.values, other.values)
    (held,) = [item for item in whole.left_out if item.held_out]
    assert held.place == "high"
    assert held.rms_after < 0.2 * held.rms_before


def test_one_place_cannot_check_a_calibration(offsets: tuple[Cell, Touches]) -> None:
    cell, touches = offsets
    alone = touches.at(["front"])
    refused = calibrate(cell, alone)
    assert refused.status == "underdetermined"
    assert not refused.is_written
    assert "another place" in refused.reasons[0]
    trusted = calibrate(cell, alone, unchecked=True)
    assert trusted.status == "calibrated"
    assert trusted.reasons == ()
    assert sum("another place" in warning for warning in trusted.warnings) == 1


def test_directions_undetermined_by_one_place_are_not_waived(simulated: tuple[Cell, Touches, dict[str, float]]) -> None:
    cell, touches, _ = simulated
    one_seat = touches.subset(
        [i for i in range(len(touches)) if (touches.places[i], touches.features[i]) == ("front", "a")]
    )
    result = calibrate(cell, one_seat.subset([0, 1, 2]), unchecked=True)
    assert result.undetermined > 0.5
    assert result.status == "underdetermined"
    assert len(result.reasons) == 1
    assert "reduce the unknown parameters" in result.reasons[0]


@pytest.mark.slow
def test_noise_alone_is_not_calibrated() -> None:
    rng = np.random.default_rng(5)
    cell = arm_cell(("joint_offsets", "tip"), {name: fixture(dict(SEATS)) for name in ("front", "high")})
    result = calibrate(cell, touched_seats(cell, {}, 3, 0.05, rng))
    assert np.abs(result.values).max() < 0.2
    assert result.status == "underdetermined" or result.prediction[1] < result.prediction[0]


def test_a_bad_touch_is_named(offsets: tuple[Cell, Touches]) -> None:
    cell, touches = offsets
    joints = touches.joints.copy()
    joints[16, 1] += 0.01
    result = calibrate(cell, replace(touches, joints=joints))
    assert result.status == "inconsistent"
    assert result.outliers == (17,)
    assert "row 17" in result.reasons[0]


def test_a_parameter_requested_by_name_must_be_determined(offsets: tuple[Cell, Touches]) -> None:
    cell, touches = offsets
    still = replace(touches, joints=touches.joints.copy())
    named = replace(cell, unknown=("joint_1.offset", "joint_3.offset", "tip"), prior=replace(PRIOR, joint_offset=1e-6))
    result = calibrate(named, still)
    assert result.status == "underdetermined"
    assert any("joint_3.offset" in reason for reason in result.reasons)
    # The offset of the first joint is a common turn of the places: it is fixed, and no reason to reject.
    assert not any("joint_1.offset" in reason for reason in result.reasons)


@pytest.mark.slow
def test_places_joined_rigidly_share_their_pose(offsets: tuple[Cell, Touches]) -> None:
    from scipy.spatial.transform import Rotation

    from tests.support.arms import PLACES

    cell, touches = offsets
    frames = {}
    for name, (origin, turns) in PLACES.items():
        frames[name] = np.eye(4)
        frames[name][:3, :3], frames[name][:3, 3] = Rotation.from_euler("xyz", turns).as_matrix(), origin
    joined = Place(
        "left", cell.places["left"].fixture, of="front", of_from_place=np.linalg.inv(frames["front"]) @ frames["left"]
    )
    result = calibrate(replace(cell, places={**cell.places, "left": joined}), touches)
    assert result.status == "calibrated"
    poses = {place.name: place.base_from_fixture for place in result.places}
    assert np.linalg.inv(poses["front"]) @ poses["left"] == pytest.approx(joined.of_from_place, abs=1e-9)


def test_unknown_places_are_rejected(offsets: tuple[Cell, Touches]) -> None:
    with pytest.raises(UsageError, match="no touch is at 'back'"):
        calibrate(*offsets, hold_out=("back",))
    with pytest.raises(UsageError, match="leave at least one"):
        calibrate(*offsets, hold_out=("front", "left", "high"))
