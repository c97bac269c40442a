"""Simulated contacts: on the surface except for noise, in the box, reachable, reproducible by their seed."""

from dataclasses import replace

import numpy as np
import pytest

from tactfix.accessibility.touchable import within_box
from tactfix.contacts import Contacts
from tactfix.errors import TipDoesNotFitError, UsageError
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tactfix.localization.locate import locate
from tactfix.simulation.poses import random_pose
from tactfix.simulation.simulate import simulate, streams
from tactfix.simulation.touches import CONE_DEG
from tests.support.placed_cells import all_cells, ball_and_bar, box, placed, plate_with_all, surfaces_of, three_balls
from tests.support.ray_walk import deepest, depth_in_ball


def in_fixture(simulation):
    rotation, shift = simulation.base_from_fixture[:3, :3], simulation.base_from_fixture[:3, 3]
    return (simulation.contacts.points - shift) @ rotation, simulation.contacts.approaches @ rotation


def distance_off(surface, point):
    """Signed distance from the surface, positive outside the material, written out."""
    if isinstance(surface, Plane):
        return (point - surface.point) @ surface.normal
    if isinstance(surface, Sphere):
        away = np.linalg.norm(point - surface.center)
    else:
        away = np.linalg.norm(np.cross(point - surface.point, surface.direction))
    return (away - surface.radius) * (1 if surface.side == "outer" else -1)


@pytest.mark.parametrize("fixture", all_cells(), ids=lambda fixture: fixture.name)
def test_contacts_are_tip_centres_with_the_noise_they_say(fixture):
    surfaces = surfaces_of(fixture)
    off = []
    for seed in range(30):
        simulation = simulate(fixture, seed=seed)
        points, _ = in_fixture(simulation)
        off += [
            distance_off(surfaces[name], point) - fixture.probe.tip_radius
            for name, point in zip(simulation.contacts.features, points, strict=True)
        ]
    off = np.array(off) / fixture.probe.sigma
    assert abs(off.mean()) < 5 / np.sqrt(len(off))
    assert 0.9 < off.std() < 1.1


@pytest.mark.parametrize("fixture", all_cells(), ids=lambda fixture: fixture.name)
def test_touches_are_in_the_box_and_come_from_the_cone(fixture):
    surfaces = surfaces_of(fixture)
    for seed in range(5):
        points, approaches = in_fixture(simulate(fixture, seed=seed))
        for name, point, approach in zip(
            simulate(fixture, seed=seed).contacts.features, points, approaches, strict=True
        ):
            steps = 1e-4 * np.vstack([np.eye(3), -np.eye(3)])
            gradient = np.array([distance_off(surfaces[name], point + step) for step in steps])
            normal = (gradient[:3] - gradient[3:]) / 2e-4
            assert -approach @ normal >= np.cos(np.radians(CONE_DEG)) - 1e-6
            foot = point - distance_off(surfaces[name], point) * normal
            assert within_box(fixture.touch.get(name), foot, 1e-3)


def test_no_approach_runs_through_another_ball():
    crowd = {"a": Sphere([0, 0, 0], 10.0), "b": Sphere([25, 0, 0], 10.0), "c": Sphere([12, 22, 0], 10.0)}
    fixture = placed("crowd", crowd, {}, 1.0, 0.01)
    for seed in range(10):
        simulation = simulate(fixture, seed=seed)
        points, approaches = in_fixture(simulation)
        for name, point, approach in zip(simulation.contacts.features, points, approaches, strict=True):
            for other in crowd.keys() - {name}:
                assert deepest(lambda x, o=other: depth_in_ball(crowd[o], x), point, approach, 200.0) < -1.0


def test_one_seed_gives_one_set_and_another_another():
    first, again, other = (simulate(plate_with_all(), seed=seed) for seed in (3, 3, 4))
    assert np.array_equal(first.contacts.points, again.contacts.points)
    assert np.array_equal(first.base_from_fixture, again.base_from_fixture)
    assert np.abs(first.contacts.points - other.contacts.points).min() > 1e-3


def test_a_given_pose_changes_neither_touches_nor_noise():
    free, given = simulate(three_balls(), seed=2), simulate(three_balls(), base_from_fixture=np.eye(4), seed=2)
    assert np.allclose(in_fixture(free)[0], given.contacts.points, atol=1e-9)


def test_random_poses_are_proper_far_and_all_around():
    poses = [random_pose(streams(seed, 1)[0], 1000.0) for seed in range(200)]
    for pose in poses:
        assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
        assert np.linalg.det(pose[:3, :3]) > 0
        assert 1000 <= np.linalg.norm(pose[:3, 3]) <= 3000
    assert np.abs(np.mean([pose[:3, :3] for pose in poses], axis=0)).max() < 0.15


@pytest.mark.parametrize("count", [1, 6, 7, 25])
def test_as_many_contacts_as_asked_for(count):
    contacts = simulate(plate_with_all(), count=count).contacts
    assert len(contacts) == count
    assert count < 4 or len(set(contacts.features)) == 4


def test_a_plan_is_followed():
    points = np.array([[30.0, 0, 11.0], [41.0, 0, 0], [0.0, 20, 9.0]])
    approaches = np.array([[0, 0, -1.0], [np.nan] * 3, [0, 0.6, -0.8]])
    plan = Contacts(("ball", "ball", "bar"), points, approaches, np.full(3, 1e-6), 1.0, (1, 2, 3), ("p", None, "q"))
    simulation = simulate(ball_and_bar(), plan, base_from_fixture=np.eye(4), seed=1)
    assert np.allclose(simulation.contacts.points, points, atol=1e-5)
    assert np.allclose(simulation.contacts.approaches, [[0, 0, -1], [-1, 0, 0], [0, 0.6, -0.8]])
    assert simulation.contacts.ids == ("p", None, "q")
    larger = simulate(ball_and_bar(), plan, base_from_fixture=np.eye(4), tip_radius=2.0)
    assert np.allclose(larger.contacts.points, [[30, 0, 12], [42, 0, 0], [0, 20, 10]], atol=1e-4)
    with pytest.raises(UsageError, match="leave out"):
        simulate(ball_and_bar(), plan, count=5)
    with pytest.raises(UsageError, match=r"^row 2: this touch is 500 off ball in the fixture frame, so"):
        simulate(ball_and_bar(), replace(plan, points=points + np.array([500.0, 0, 0])))


@pytest.mark.parametrize("fixture", all_cells(), ids=lambda fixture: fixture.name)
def test_locate_gives_the_pose_back(fixture):
    for seed in range(3):
        simulation = simulate(fixture, seed=seed)
        result = locate(fixture, simulation.contacts)
        assert result.status == "located", result.warnings
        assert result.covariance is not None
        off = result.base_from_fixture[:3, 3] - simulation.base_from_fixture[:3, 3]
        assert off @ np.linalg.solve(result.covariance[3:, 3:], off) < 30


def test_missing_probe_settings_are_asked_for():
    silent = placed("silent", {"ball": Sphere([0, 0, 0], 5.0)}, {}, None, 0.01)
    with pytest.raises(UsageError, match="tip radius"):
        simulate(silent)
    with pytest.raises(UsageError, match="sigma"):
        simulate(ball_and_bar(), sigma=0.0)


def test_a_tip_larger_than_the_bore_is_refused():
    with pytest.raises(TipDoesNotFitError):
        simulate(plate_with_all(), tip_radius=15.0)


def test_a_feature_that_cannot_be_reached_is_named():
    walled = {"inside": Sphere([0, 0, 0], 1.0), "shell": Sphere([0, 0, 0], 4.0)}
    with pytest.raises(UsageError, match="inside cannot be touched"):
        simulate(placed("walled", walled, {}, 0.1, 0.01))
    hidden = {"bar": Cylinder([0, 0, 0], [0, 0, 1], 1.0)}
    with pytest.raises(UsageError, match="bar cannot be touched"):
        simulate(placed("hidden", hidden, {"bar": box(x=(3, 4))}, 0.1, 0.01))
