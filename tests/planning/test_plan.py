"""Plans: reachable, with a unique pose and the stated worst sigma, and reproducible by their seed."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactfix.acceptance import point_covariance, worst_sigma
from tactfix.accessibility.touchable import extreme_points
from tactfix.errors import UsageError
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tactfix.localization.locate import locate
from tactfix.planning.plan import plan
from tactfix.simulation.simulate import simulate
from tests.support import problems
from tests.support.placed_cells import all_cells, ball_and_bar, placed, plate_with_all, surfaces_of, three_balls
from tests.support.ray_walk import deepest, depth_in_ball, depth_in_bar
from tests.validation.plan_against_random import plan_worst_sigma

CELLS = all_cells()


@cache
def planned(fixture, count):
    """The plan of a fixture, computed once for all tests that use it."""
    return plan(fixture, count)


@pytest.mark.parametrize("fixture", CELLS, ids=lambda fixture: fixture.name)
@pytest.mark.parametrize("count", [pytest.param(6, marks=pytest.mark.slow), 8])
def test_a_plan_is_unique_and_locate_agrees_on_its_covariance(fixture, count):
    found = planned(fixture, count)
    assert len(found.contacts) == count
    assert found.unique
    result = locate(fixture, found.contacts)
    assert result.status == "located"
    assert np.allclose(result.base_from_fixture, np.eye(4), atol=1e-6)
    assert np.allclose(result.covariance, found.covariance, rtol=1e-6)
    assert found.worst_sigma == pytest.approx(plan_worst_sigma(fixture, found), rel=1e-3)


@pytest.mark.parametrize("fixture", CELLS, ids=lambda fixture: fixture.name)
def test_noisy_contacts_of_a_plan_are_located_every_time(fixture):
    found = planned(fixture, 8)
    for seed in range(5):
        simulation = simulate(fixture, found.contacts, seed=seed)
        result = locate(fixture, simulation.contacts)
        assert result.status == "located"
        off = result.base_from_fixture[:3, 3] - simulation.base_from_fixture[:3, 3]
        assert off @ np.linalg.solve(result.covariance[3:, 3:], off) < 30


@pytest.mark.parametrize("fixture", [CELLS[0], CELLS[1], CELLS[3]], ids=lambda fixture: fixture.name)
def test_every_approach_keeps_clear_of_the_other_features(fixture):
    """By small steps along each approach: the tip's ball touches only its own feature."""
    surfaces = surfaces_of(fixture)
    found = planned(fixture, 8)
    for name, point, approach in zip(
        found.contacts.features, found.contacts.points, found.contacts.approaches, strict=True
    ):
        for other, surface in surfaces.items():
            if other == name:
                continue
            if isinstance(surface, Sphere):
                depth = deepest(lambda x, s=surface: depth_in_ball(s, x), point, approach, 400.0)
            elif isinstance(surface, Cylinder) and surface.side == "outer":
                axis = int(np.argmax(np.abs(surface.direction)))
                low, high = fixture.touch[other].low[axis], fixture.touch[other].high[axis]
                depth = deepest(lambda x, s=surface, a=low, b=high: depth_in_bar(s, a, b, x), point, approach, 400.0)
            else:
                continue
            assert depth < -fixture.probe.tip_radius


@pytest.mark.parametrize("fixture", CELLS, ids=lambda fixture: fixture.name)
def test_approaches_are_no_more_than_45_degrees_off_the_normal(fixture):
    found = planned(fixture, 6)
    for name, point, approach in zip(
        found.contacts.features, found.contacts.points, found.contacts.approaches, strict=True
    ):
        surface = surfaces_of(fixture)[name]
        if isinstance(surface, Sphere):
            normal = point - surface.center
        elif isinstance(surface, Cylinder):
            arm = point - surface.point
            normal = (arm - arm @ surface.direction * surface.direction) * (1 if surface.side == "outer" else -1)
        else:
            normal = surface.normal
        assert -approach @ normal / np.linalg.norm(normal) >= np.cos(np.radians(45)) - 1e-9


def test_a_seed_gives_one_plan():
    first, again = planned(CELLS[0], 6), plan(ball_and_bar(), 6)
    assert np.array_equal(first.contacts.points, again.contacts.points)


def test_without_a_number_the_fewest_unique_contacts_and_a_table():
    found = plan(three_balls())
    counts = [step.count for step in found.steps]
    fewest = next(step.count for step in found.steps if step.unique)
    assert counts == list(range(6, 2 * fewest + 1))
    assert len(found.contacts) == fewest
    assert found.unique
    assert found.worst_sigma == next(step.worst_sigma for step in found.steps if step.count == fewest)
    sigmas = [step.worst_sigma for step in found.steps]
    assert sigmas == sorted(sigmas, reverse=True)
    for before, step in zip(found.steps, found.steps[1:], strict=False):
        assert step.gain == pytest.approx(1 - step.worst_sigma / before.worst_sigma)


@pytest.mark.parametrize("criterion", ["worst", "d", pytest.param("e", marks=pytest.mark.slow)])
def test_of_more_starts_some_agree_and_the_best_is_no_worse(criterion):
    few, many = (plan(CELLS[2], 7, criterion=criterion, starts=starts) for starts in (2, 20))
    assert (few.starts, many.starts) == (2, 20)
    assert 1 <= many.agreeing <= 20
    if criterion == "worst":
        assert many.worst_sigma <= 1.01 * few.worst_sigma


def test_one_start_agrees_with_itself():
    found = plan(ball_and_bar(), 6, starts=1)
    assert (found.starts, found.agreeing) == (1, 1)


def test_each_criterion_is_best_at_its_own():
    def information(found):
        return np.linalg.inv(found.covariance)

    plans = {criterion: plan(CELLS[2], 8, criterion=criterion) for criterion in ("worst", "d", "e")}
    assert plans["worst"].worst_sigma == min(found.worst_sigma for found in plans.values())
    volumes = {criterion: np.linalg.slogdet(information(found))[1] for criterion, found in plans.items()}
    assert max(volumes, key=volumes.get) == "d"


def test_contacts_are_added_to_those_already_made_in_their_frame():
    fixture = CELLS[0]
    simulation = simulate(fixture, planned(fixture, 6).contacts, seed=11)
    found = plan(fixture, existing=simulation.contacts, add=3)
    assert len(found.contacts) == 3
    assert found.unique
    assert np.allclose(found.base_from_fixture, simulation.base_from_fixture, atol=0.1)
    before = locate(fixture, simulation.contacts)
    corners = extreme_points(surfaces_of(fixture), fixture.touch)
    worst = worst_sigma(point_covariance(before.base_from_fixture, before.covariance, corners)).max()
    assert found.worst_sigma < 0.95 * worst
    # In base coordinates: a probe that goes there touches the fixture at its true pose.
    rotation, shift = simulation.base_from_fixture[:3, :3], simulation.base_from_fixture[:3, 3]
    for name, point in zip(found.contacts.features, (found.contacts.points - shift) @ rotation, strict=True):
        surface = surfaces_of(fixture)[name]
        off = (
            np.linalg.norm(point - surface.center)
            if isinstance(surface, Sphere)
            else np.linalg.norm(np.cross(point - surface.point, surface.direction))
        )
        assert off == pytest.approx(surface.radius + 1.0, abs=0.1)


def test_existing_contacts_that_give_no_pose_are_refused():
    fixture = ball_and_bar()
    existing = simulate(fixture, seed=1).contacts
    far = existing.points.copy()
    far[0] += 5.0
    with pytest.raises(UsageError, match="inconsistent"):
        plan(fixture, existing=replace(existing, points=far), add=1)


@pytest.mark.parametrize("rows", [[0, 1, 2], *(pytest.param(r, marks=pytest.mark.slow) for r in ([0], [0, 1, 2, 7]))])
def test_contacts_that_leave_motions_free_are_extended_to_constrain_them(rows):
    """As many contacts as there are free motions, in the fixture frame; made at the true pose they locate it."""
    fixture = plate_with_all()
    right = simulate(fixture, seed=1)
    existing = right.contacts.subset(rows)
    found = plan(fixture, existing=existing)
    assert (found.frame, found.base_from_fixture) == ("fixture", None)
    assert len(found.contacts) == 6 - len(rows)
    with pytest.raises(UsageError, match=f"leave free need more; ask for {6 - len(rows)} or more"):
        plan(fixture, existing=existing, add=5 - len(rows))
    more = plan(fixture, existing=existing, add=9 - len(rows))
    touched = simulate(fixture, more.contacts, right.base_from_fixture, seed=2).contacts
    result = locate(fixture, existing + replace(touched, units=existing.units))
    assert result.status == "located"
    assert np.allclose(result.base_from_fixture, right.base_from_fixture, atol=0.5)


def test_ambiguous_contacts_are_extended_so_that_one_pose_is_left():
    fixture = problems.placed(problems.PLATE)
    for seed in range(30):
        rng = np.random.default_rng([9, seed])
        truth = problems.touch_all(problems.PLATE, {"plate": 3, "pin": 2, "ball": 1}, rng, sigma=0.02, tip=2.0)
        existing = truth.contacts(rng)
        result = locate(fixture, existing)
        if result.status == "ambiguous":
            break
    found = plan(fixture, existing=existing, add=2)
    assert (found.frame, found.unique) == ("base", True)
    # The pose that the plan assumes need not be the true one.
    poses = [c.base_from_fixture for c in result.candidates if c.accepted]
    assert any(np.allclose(found.base_from_fixture, pose) for pose in poses)


def test_touches_on_open_surfaces_stay_within_the_fixture():
    """Planes without boxes are unbounded: the contacts of the plan must stay near the other features."""
    planes = {name: Plane([0, 0, 0], axis) for name, axis in zip("abc", np.eye(3), strict=True)}
    for unit, metre in (("mm", 1000.0), ("m", 1.0)):
        found = plan(placed("open-cube", planes, {}, 1e-3 * metre, 1e-5 * metre, units=unit), 6)
        assert found.unique
        assert 0.05 * metre <= np.abs(found.contacts.points).max() <= 0.1 * metre * 1.02
    bar = {"bar": Cylinder([0, 0, 0], [0, 1, 0], 8.0), "ball": Sphere([30, 0, 0], 10.0)}
    found = plan(placed("open-bar", bar, {}, 1.0, 0.01), 8)
    assert np.abs(found.contacts.points[:, 1]).max() < 60
    assert not found.unique


@pytest.mark.parametrize(
    ("options", "pattern"),
    [
        ({"contacts": 5}, "6 or more"),
        ({"add": 2}, "nothing to add to"),
        ({"contacts": 8, "sigma": 0.0}, "sigma"),
        ({"starts": 0}, "1 or more"),
    ],
)
def test_refusals(options, pattern):
    with pytest.raises(UsageError, match=pattern):
        plan(ball_and_bar(), **options)


def test_features_that_leave_a_motion_free_are_refused():
    balls = {"a": Sphere([0, 0, 0], 5.0), "b": Sphere([50, 0, 0], 5.0)}
    with pytest.raises(UsageError, match="motion stays free"):
        plan(placed("two-balls", balls, {}, 1.0, 0.01), 8)


def test_progress_runs_from_the_beginning_to_the_end():
    updates = []
    plan(ball_and_bar(), 6, progress=lambda share, stage: updates.append((share, stage)))
    shares = [share for share, _ in updates]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert all(stage for _, stage in updates)
