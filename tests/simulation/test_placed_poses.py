"""Random poses drawn from a placement: within limits, with a measurement's covariance, in the free directions only."""

import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from tactfix.cli.app import run
from tactfix.placement import DIRECTIONS, Placement
from tactfix.simulation.poses import placed_pose
from tactfix.simulation.simulate import simulate
from tests.support.placed_cells import plate_with_all
from tests.support.project import ROOT

NEAR = np.eye(4)
NEAR[:3, :3] = Rotation.from_euler("zyx", [-64, 3, 100], degrees=True).as_matrix()
NEAR[:3, 3] = [1200.0, -350.0, 400.0]


def drawn(placement, count=2000, metre=1000.0):
    """Rotation vectors (count, 3) and translations (count, 3) from near."""
    rng = np.random.default_rng(5)
    poses = np.array([placed_pose(placement, rng, metre) for _ in range(count)])
    turns = Rotation.from_matrix(poses[:, :3, :3] @ NEAR[:3, :3].T).as_rotvec()
    return turns, poses[:, :3, 3] - NEAR[:3, 3]


def follows(values, cumulative):
    return stats.kstest(values, cumulative).pvalue > 1e-3


@pytest.mark.parametrize("degrees", [5.0, 60.0, 180.0])
def test_limits_are_filled_evenly(degrees):
    most = np.radians(degrees)
    turns, shifts = drawn(Placement(NEAR, (20.0, most)))
    angles, lengths = np.linalg.norm(turns, axis=1), np.linalg.norm(shifts, axis=1)
    assert angles.max() <= most + 1e-9
    assert lengths.max() <= 20.0
    # For uniform rotations the share up to an angle a is proportional to a - sin a; for a ball, to the radius cubed.
    assert follows(angles, lambda a: (a - np.sin(a)) / (most - np.sin(most)))
    assert follows(lengths, lambda r: (r / 20.0) ** 3)
    assert np.linalg.norm((turns / angles[:, None]).mean(axis=0)) < 0.1


@pytest.mark.parametrize("free", [("x", "y", "rz"), ("rx", "rz"), ("z",), ("rx", "ry", "rz", "x")])
@pytest.mark.parametrize("within", [None, (20.0, 0.3)])
def test_constrained_directions_stay_fixed(free, within):
    off = np.hstack(drawn(Placement(NEAR, within, free=frozenset(free)), count=500))
    order = ("rx", "ry", "rz", "x", "y", "z")
    is_free = np.array([name in free for name in order])
    assert set(order) == set(DIRECTIONS)
    assert np.abs(off[:, ~is_free]).max() < 1e-9
    # Every free direction varies to both sides, over a large part of its limits.
    limits = np.array([np.pi] * 3 + [1000.0] * 3) if within is None else np.array([0.3] * 3 + [20.0] * 3)
    assert (off[:, is_free].max(axis=0) > 0.7 * limits[is_free]).all()
    assert (off[:, is_free].min(axis=0) < -0.7 * limits[is_free]).all()


@pytest.mark.parametrize("free", [DIRECTIONS, ("x", "z", "ry")])
def test_poses_scatter_by_the_measurements_covariance(free):
    mixing = np.random.default_rng(3).normal(size=(6, 6)) + 2 * np.eye(6)
    scales = np.array([1e-3] * 3 + [0.5] * 3)
    covariance = np.outer(scales, scales) * (mixing @ mixing.T)
    off = np.hstack(drawn(Placement(NEAR, sigma=covariance, free=frozenset(free)), count=4000))
    index = [k for k, name in enumerate(("rx", "ry", "rz", "x", "y", "z")) if name in free]
    held = [k for k in range(6) if k not in index]
    # The conditional covariance, by the Schur complement.
    given = covariance[np.ix_(index, index)]
    if held:
        across = covariance[np.ix_(index, held)]
        given = given - across @ np.linalg.inv(covariance[np.ix_(held, held)]) @ across.T
    white = np.linalg.solve(np.linalg.cholesky(given), off[:, index].T)
    assert np.abs(np.cov(white) - np.eye(len(index))).max() < 0.12
    assert np.abs(white.mean(axis=1)).max() < 0.08


def test_near_without_limits_is_the_pose():
    turns, shifts = drawn(Placement(NEAR), count=3)
    assert np.abs(turns).max() < 1e-12
    assert not shifts.any()


def test_simulations_follow_the_placement_and_are_located():
    from dataclasses import replace

    from tactfix.localization.locate import locate

    fixture = replace(plate_with_all(), placement=Placement(NEAR, (20.0, 0.1), free=frozenset(("x", "y", "rz"))))
    first, second = (simulate(fixture, seed=seed) for seed in (1, 2))
    assert not np.array_equal(first.base_from_fixture, second.base_from_fixture)
    for simulation in (first, second):
        assert simulation.base_from_fixture[2, 3] == NEAR[2, 3]
        found = locate(fixture, simulation.contacts)
        assert found.status == "located"
        off = found.base_from_fixture[:3, 3] - simulation.base_from_fixture[:3, 3]
        assert np.linalg.norm(off) < 6 * np.sqrt(np.trace(found.covariance[3:, 3:]))
    given = simulate(fixture, base_from_fixture=np.eye(4), seed=1)
    assert np.array_equal(given.base_from_fixture, np.eye(4))


def test_simulate_follows_placement_options(tmp_path, capsys):
    np.savetxt(tmp_path / "near.txt", NEAR, fmt="%.17g")
    plate = str(ROOT / "fixtures" / "robot-cell-plate.yaml")
    words = ("--near", str(tmp_path / "near.txt"), "--within", "20,5", "--free", "x,y,rz")
    assert run(["simulate", plate, "--seed", "1", *words]) == 0
    rows = [line for line in capsys.readouterr().out.splitlines() if line.startswith("# truth: ")]
    pose = np.array([[float(word) for word in row.split()[2:]] for row in rows if len(row.split()) == 6][:4])
    assert pose[2, 3] == NEAR[2, 3]
    assert 0 < np.linalg.norm(pose[:2, 3] - NEAR[:2, 3]) < 20
    assert run(["simulate", plate, "--near", str(tmp_path / "near.txt")]) == 2
