"""Places with a known placement: limits, measurements and constrained directions are used and checked."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.calibration.calibrate import calibrate
from tactfix.calibration.cell import Cell, Place, Touches
from tactfix.geometry.arrays import Floats
from tactfix.placement import Placement
from tests.support.arms import PLACES, SEATS, arm_cell, fixture, random_errors, touched_seats


@pytest.fixture(scope="module")
def simulated() -> tuple[Cell, Touches]:
    rng = np.random.default_rng(7)
    cell = arm_cell(("joint_offsets", "tip"), {name: fixture(dict(SEATS)) for name in ("front", "high")})
    errors = {name: e for name, e in random_errors(cell, rng).items() if "offset" in name or "tip" in name}
    # The zero of the first joint cannot be told from a turn of the base: without it, places have their stated poses.
    errors["joint_1.offset"] = 0.0
    return cell, touched_seats(cell, errors, 4, 0.03, rng)


def true_pose(name: str) -> Floats:
    origin, turns = PLACES[name]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_euler("xyz", turns).as_matrix(), origin
    return pose


def known(cell: Cell, placements: Mapping[str, Placement]) -> Cell:
    places = {name: Place(name, place.fixture, placements.get(name)) for name, place in cell.places.items()}
    return replace(cell, places=places)


def shifted(pose: Floats, by: tuple[float, float, float], turn_z: float = 0.0) -> Floats:
    moved = pose.copy()
    moved[:3, :3] = Rotation.from_euler("z", turn_z).as_matrix() @ pose[:3, :3]
    moved[:3, 3] += by
    return moved


def test_constrained_directions_are_fixed_and_certain(simulated: tuple[Cell, Touches]) -> None:
    cell, touches = simulated
    near = shifted(true_pose("front"), (8.0, -5.0, 0.0), 0.1)
    result = calibrate(known(cell, {"front": Placement(near, free=frozenset(("x", "y", "rz")))}), touches)
    assert result.status == "calibrated"
    (front,) = [place for place in result.places if place.name == "front"]
    assert front.base_from_fixture[2, 3] == pytest.approx(near[2, 3], abs=1e-9)
    turn = front.base_from_fixture[:3, :3] @ near[:3, :3].T
    assert turn[2] == pytest.approx([0, 0, 1], abs=1e-9)
    assert front.base_from_fixture[:3] == pytest.approx(true_pose("front")[:3], abs=1.0)
    assert front.covariance is not None
    assert np.sqrt(np.diag(front.covariance))[[0, 1, 5]] == pytest.approx(0, abs=1e-9)
    assert np.sqrt(np.diag(front.covariance))[[2, 3, 4]].min() > 1e-5


def test_limits_are_compared_with_the_pose_of_the_place(simulated: tuple[Cell, Touches]) -> None:
    cell, touches = simulated
    near = shifted(true_pose("front"), (30.0, 0.0, 0.0))
    wide, narrow = (
        calibrate(known(cell, {"front": Placement(near, within=(limit, 0.1))}), touches) for limit in (35.0, 20.0)
    )
    assert wide.status == "calibrated"
    assert narrow.status == "inconsistent"
    assert "'front' contradicts the touches: it would be 30." in narrow.reasons[0]
    assert "limit 20 mm: off by -30." in narrow.reasons[0]
    assert "along x" in narrow.reasons[0]


def test_a_measured_place_determines_the_first_joints_zero(simulated: tuple[Cell, Touches]) -> None:
    cell, touches = simulated
    measured = {name: Placement(true_pose(name), sigma=(0.05, 1e-3)) for name in cell.places}
    result = calibrate(known(cell, measured), touches)
    assert result.status == "calibrated"
    first = next(item for item in result.parameters if item.name == "joint_1.offset")
    assert first.identified
    assert first.sigma > 0
    assert abs(first.value) < 4 * first.sigma
    assert not any("joint_1.offset" in words for words in result.not_identified)


def test_a_wrongly_measured_place_is_reported(simulated: tuple[Cell, Touches]) -> None:
    cell, touches = simulated
    measured = {
        "front": Placement(shifted(true_pose("front"), (0.0, 0.0, 25.0)), sigma=(0.05, 1e-3)),
        "high": Placement(true_pose("high"), sigma=(0.05, 1e-3)),
    }
    result = calibrate(known(cell, measured), touches)
    assert result.status == "inconsistent"
    assert not result.is_written
    assert any("what is known of 'front' contradicts the touches" in reason for reason in result.reasons)
