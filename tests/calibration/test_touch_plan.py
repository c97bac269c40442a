"""Planned touches: they reach their features, their predicted sigmas are correct, and they beat random touches."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.calibration.cell import Cell, Place
from tactfix.calibration.touch_plan import TouchPlan, plan_touches
from tactfix.errors import UsageError
from tactfix.geometry.arrays import Floats
from tactfix.placement import Placement
from tests.support.arms import PLACES, SEATS, arm_cell, fixture, tips

SIGMA = 0.05


@pytest.fixture(scope="module")
def cell() -> Cell:
    """Two places whose pose is roughly known, and joints within the limits of the arm."""
    seats = fixture(dict(SEATS))
    bare = arm_cell(("joint_offsets", "tip"), dict.fromkeys(("front", "left"), seats))
    places = {name: Place(name, seats, Placement(pose(name))) for name in bare.places}
    ranges = np.deg2rad([[-100, 100], [-60, 80], [-60, 80], [-150, 150], [-110, 110], [-170, 170]])
    return replace(bare, places=places, joint_ranges=ranges)


def pose(name: str) -> Floats:
    origin, turns = PLACES[name]
    base_from_fixture = np.eye(4)
    base_from_fixture[:3, :3], base_from_fixture[:3, 3] = Rotation.from_euler("xyz", turns).as_matrix(), origin
    return base_from_fixture


def covariance(
    cell: Cell,
    joints: Floats,
    places: tuple[str, ...],
    names: tuple[str, ...],
    widths: Mapping[str, float] | None = None,
) -> Floats:
    """Parameter covariance from touches of seats at places of unknown pose, by finite differences of `tips`."""
    step = 1e-6
    columns = [(tips({name: step}, joints) - tips({name: -step}, joints)).ravel() / (2 * step) for name in names]
    x = tips({}, joints)
    for place in dict.fromkeys(places):
        here = np.array([p == place for p in places])[:, None]
        columns += [(np.broadcast_to(axis, x.shape) * here).ravel() for axis in np.eye(3)]
        columns += [(np.cross(axis, x) * here).ravel() for axis in np.eye(3)]
    rows = np.stack(columns, axis=1) / SIGMA
    robot, where = rows[:, : len(names)], rows[:, len(names) :]
    basis, sizes, _ = np.linalg.svd(where, full_matrices=False)
    basis = basis[:, sizes > 1e-9 * sizes[0]]
    robot = robot - basis @ (basis.T @ robot)
    by_name = widths or {parameter.name: cell.prior.sigma(parameter) for parameter in cell.parameters}
    return np.linalg.inv(robot.T @ robot + np.diag([1 / by_name[name] ** 2 for name in names]))


def left_undetermined(cell: Cell, plan: TouchPlan) -> float:
    """The undetermined share of the errors (a tenth of the prior), rms over new postures, for the best base and tip."""
    names = tuple(item.name for item in plan.parameters)
    widths = {p.name: cell.prior.sigma(p) * (1.0 if p.name.startswith("tip") else 0.1) for p in cell.parameters}
    expected = np.array([widths[name] for name in names])
    joints = np.random.default_rng(8).uniform(*cell.joint_ranges.T, (2000, 6))
    x, step = tips({}, joints), 1e-6
    by = [(tips({name: step}, joints) - tips({name: -step}, joints)).ravel() / (2 * step) for name in names]
    made_good = [(np.broadcast_to(axis, x.shape)).ravel() for axis in np.eye(3)]
    made_good += [np.cross(axis, x).ravel() for axis in np.eye(3)]
    made_good += [column for name, column in zip(names, by, strict=True) if name.startswith("tip")]
    basis = np.linalg.qr(np.stack(made_good, axis=1))[0]
    moves = np.stack([column - basis @ (basis.T @ column) for column in by], axis=1)
    moves[:, [name.startswith("tip") for name in names]] = 0.0
    spread = covariance(cell, plan.added.joints, plan.added.places, names, widths)
    after = np.einsum("ij,jk,ik->", moves, spread, moves)
    return float(np.sqrt(after / ((moves * expected) ** 2).sum()))


def test_added_touches_reach_their_seats_with_the_predicted_sigmas(cell: Cell) -> None:
    plan = plan_touches(cell, None, 12, SIGMA)
    assert plan.planned == 0
    assert len(plan.added) == 12
    assert [plan.added.places.count(name) for name in ("front", "left")] == [6, 6]
    for place, feature, tip in zip(plan.added.places, plan.added.features, tips({}, plan.added.joints), strict=True):
        seat = pose(place) @ [*SEATS[feature].point, 1.0]
        assert tip == pytest.approx(seat[:3], abs=2e-3)
    assert (plan.added.joints >= cell.joint_ranges[:, 0]).all()
    assert (plan.added.joints <= cell.joint_ranges[:, 1]).all()
    names = tuple(item.name for item in plan.parameters)
    sigmas = np.sqrt(np.diag(covariance(cell, plan.added.joints, plan.added.places, names)))
    scale = [np.rad2deg(1.0) if item.unit == "deg" else 1.0 for item in plan.parameters]
    assert [item.with_added for item in plan.parameters] == pytest.approx(sigmas * scale, rel=1e-3)
    assert plan.undetermined == pytest.approx((1.0, left_undetermined(cell, plan)), rel=0.03)


def test_added_touches_determine_more_than_random_ones(cell: Cell) -> None:
    many = plan_touches(cell, None, 40, SIGMA).added
    rng = np.random.default_rng(3)
    others = [plan_touches(cell, many.subset(rng.permutation(len(many))[:8]), 0, SIGMA) for _ in range(4)]
    best = plan_touches(cell, None, 8, SIGMA)
    assert best.worst[2] < 0.8 * np.mean([other.worst[1] for other in others])
    by_determinant = plan_touches(cell, None, 8, SIGMA, "d")
    names = tuple(item.name for item in best.parameters)
    sizes = [
        np.linalg.slogdet(covariance(cell, touches.joints, touches.places, names))[1]
        for touches in (by_determinant.added, *(many.subset(rng.permutation(len(many))[:8]) for _ in range(4)))
    ]
    assert sizes[0] < min(sizes[1:])
    # Planned touches count: existing touches with added ones determine more than the existing ones alone.
    more = plan_touches(cell, best.added, 4, SIGMA)
    assert more.planned == 8
    assert more.prediction[1] == pytest.approx(best.prediction[2], rel=1e-6)
    assert more.worst[2] < more.worst[1] < more.worst[0]


def test_places_without_a_known_pose_are_reported(cell: Cell) -> None:
    places = {**cell.places, "left": Place("left", cell.places["left"].fixture)}
    plan = plan_touches(replace(cell, places=places), None, 3, SIGMA)
    assert plan.unplaced == ("left",)
    assert set(plan.added.places) == {"front"}
    moved = np.eye(4)
    moved[0, 3] = 5000.0
    far = replace(cell, places={"front": Place("front", cell.places["front"].fixture, Placement(moved))})
    with pytest.raises(UsageError, match="nothing to plan with"):
        plan_touches(far, None, 3, SIGMA)
    with pytest.raises(UsageError, match="the pose of left is not known"):
        plan_touches(replace(cell, places={"left": places["left"]}), None, 3, SIGMA)
