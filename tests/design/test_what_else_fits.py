"""Margins of a plan: competing poses, contacts whose loss leaves a motion free, and misplaced features."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from tactfix.design.margins import margins
from tactfix.design.nominal_contacts import Touched
from tactfix.design.wrong_files import misplaced
from tactfix.files.fixture_file import load_fixture
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tactfix.localization.locate import locate
from tests.support.plans import contacts_of, plan_at
from tests.support.project import BAD_DESIGNS, ROOT


def touched_of(fixture, plan):
    surfaces = {name: f.surface for name, f in fixture.features.items()}
    corners = np.array([[70.0, 60.0, 10.0], [-10.0, -20.0, -10.0]])
    return Touched(surfaces, plan, np.full(len(plan), 0.01), corners)


def test_the_half_turn_is_a_competing_pose_at_distance_zero():
    fixture = load_fixture(BAD_DESIGNS / "ball-beside-bar.yaml")
    found = margins(touched_of(fixture, plan_at((20, 40))), partial(locate, fixture, explain=False))
    assert not found.is_unique
    np.testing.assert_allclose(found.rival.image_from_fixture, np.diag([1.0, -1, -1, 1]), atol=1e-6)
    assert found.rival.sigmas_behind == pytest.approx(0, abs=1e-4)


def test_the_margin_of_a_competing_pose_is_that_of_its_residuals():
    """Few contacts on one side: chi-square of the nearest wrong pose, recomputed from the pose."""
    fixture = load_fixture(BAD_DESIGNS / "box-across-the-middle.yaml")
    plan = plan_at((-19, 19)).subset([0, 1, 2, 3, 6, 7, 8])
    found = margins(touched_of(fixture, plan), partial(locate, fixture, explain=False))
    assert found.rival is not None
    pose = found.rival.image_from_fixture
    chi2 = 0.0
    for name, p in zip(plan.features, plan.points, strict=True):
        x = pose[:3, :3].T @ (p - pose[:3, 3])
        r = np.hypot(x[0], x[2]) - 9 if name == "bar" else np.linalg.norm(x - [60, 0, 0]) - 11
        chi2 += (r / 0.01) ** 2
    assert found.rival.sigmas_behind == pytest.approx(np.sqrt(chi2), abs=1e-4)


def test_a_contact_that_alone_constrains_a_motion_is_critical():
    """Plate, pin, and one contact on the ball: without it the fixture turns about the pin."""
    fixture = load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")
    plate = [[0.0, 0, 3], [300, 0, 3], [0, 200, 3], [300, 200, 3]]
    pin = [[13.0 * np.cos(a), 13.0 * np.sin(a), z] for a, z in ((0.3, 10), (1.9, 30), (3.5, 20), (5.0, 40))]
    side = np.array([0.6, -0.8, 0])
    points = np.array([*plate, *pin, [300, 180, 60] + 22.05 * side])
    approaches = [[0, 0, -1.0]] * 4 + [[-p[0] / 13, -p[1] / 13, 0] for p in pin] + [list(-side)]
    plan = contacts_of(["plate"] * 4 + ["pin"] * 4 + ["ball"], points, np.array(approaches), 0.08, 3.0)
    found = margins(touched_of(fixture, plan), partial(locate, fixture, explain=False))
    if found.is_unique:
        assert ("row 9", "free") in {(f.label, f.outcome) for f in found.fragile}
    else:
        pytest.fail("the plan should be unique")


ALMOST = """tactfix: 1
name: almost-symmetric
units: mm
probe: {tip_radius: 1.0, sigma: 0.01}
features:
  bar: {type: cylinder, radius: 8.0, point: [0.0, 0.0, 0.0], direction: [0.0, 1.0, 0.0]}
  ball: {type: sphere, radius: 10.0, center: [60.0, 0.0, 0.0]}
  mark: {type: sphere, radius: 10.0, center: [-60.0, 2.0, 0.0]}
"""


def test_a_distant_competing_pose_is_found_and_measured(tmp_path):
    """The half-turn about x moves mark, which is 2 mm off the line, by 4 mm: in total about 400 sigma."""
    (tmp_path / "f.yaml").write_text(ALMOST)
    fixture = load_fixture(tmp_path / "f.yaml")
    plan = plan_at((20, 40))
    ball = plan.on("ball")
    mark = ball.points + np.array([-120.0, 2.0, 0.0])
    points, approaches = np.vstack([plan.points, mark]), np.vstack([plan.approaches, ball.approaches])
    plan = contacts_of(plan.features + ("mark",) * 6, points, approaches, 0.01, 1.0)
    found = margins(touched_of(fixture, plan), partial(locate, fixture, explain=False), with_losses=False)
    assert found.is_unique
    assert 100 < found.rival.sigmas_behind < found.reach
    pose = found.rival.image_from_fixture
    assert pose[1, 1] == pytest.approx(-1, abs=0.01)
    chi2 = 0.0
    for name, p in zip(plan.features, plan.points, strict=True):
        x = pose[:3, :3].T @ (p - pose[:3, 3])
        center = [60, 0, 0] if name == "ball" else [-60, 2, 0]
        r = np.hypot(x[0], x[2]) - 9 if name == "bar" else np.linalg.norm(x - center) - 11
        chi2 += (r / 0.01) ** 2
    assert found.rival.sigmas_behind == pytest.approx(np.sqrt(chi2), rel=1e-6)


def test_a_pose_excluded_by_a_touch_box_is_no_competitor():
    """At y = 22 the half-turn leaves the box (from -20) by 200 sigma, which a widened tolerance would hide."""
    fixture = load_fixture(BAD_DESIGNS / "box-across-the-middle.yaml")
    found = margins(touched_of(fixture, plan_at((-15, 22))), partial(locate, fixture, explain=False), with_losses=False)
    assert found.is_unique
    assert found.rival is None
    assert found.reach > 500


def test_one_critical_contact_of_many_is_found():
    """Of 27 contacts, more than are deleted one by one, the one on the ball must be among those deleted."""
    fixture = load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")
    plate = [[x, y, 3.0] for x in (10.0, 100, 200, 290) for y in (60.0, 100, 150, 190)]
    angles = np.radians([0, 70, 140, 210, 280, 350, 40, 110, 190, 320])
    pin = [[13 * np.cos(a), 13 * np.sin(a), 10.0 + 3 * k] for k, a in enumerate(angles)]
    side = np.array([0.6, -0.8, 0])
    points = np.array([*plate, *pin, [300, 180, 60] + 22.05 * side])
    approaches = [[0, 0, -1.0]] * 16 + [[-p[0] / 13, -p[1] / 13, 0] for p in pin] + [list(-side)]
    plan = contacts_of(["plate"] * 16 + ["pin"] * 10 + ["ball"], points, np.array(approaches), 0.08, 3.0)

    def locator(contacts):
        # The stub only checks whether the ball is still touched.
        status = "located" if "ball" in contacts.features else "underdetermined"
        return Answer(status)

    found = margins(touched_of(fixture, plan), locator)
    assert found.losses == 24
    assert [(f.label, f.feature, f.outcome) for f in found.fragile] == [("row 27", "ball", "free")]


class Answer:
    """The attributes of a result that the margins use."""

    candidates = ()
    chi2_limit = 40.0

    def __init__(self, status):
        self.status = status


def test_wrong_poses_are_looked_for_with_every_residual_ten_times_as_uncertain():
    """The form error of a feature is widened together with the probe's sigma, whatever their ratio."""
    fixture = load_fixture(BAD_DESIGNS / "ball-beside-bar.yaml")
    form = {"bar": 0.03, "ball": 0.0}
    fixture = replace(fixture, features={n: replace(f, sigma=form[n]) for n, f in fixture.features.items()})
    plan = plan_at((20, 40))
    own = np.array([form[name] for name in plan.features])
    searched = []

    def locator(contacts):
        searched.append(contacts)
        return locate(fixture, contacts, explain=False)

    margins(replace(touched_of(fixture, plan), sigmas=np.hypot(0.01, own)), locator)
    np.testing.assert_allclose(np.hypot(searched[0].sigmas, own), 10 * np.hypot(0.01, own), rtol=1e-12)


def distance(a, b):
    match a, b:
        case Sphere(), Sphere():
            return np.linalg.norm(a.center - b.center)
        case (Sphere() as ball, Cylinder() as bar) | (Cylinder() as bar, Sphere() as ball):
            return np.linalg.norm(np.cross(ball.center - bar.point, bar.direction))
        case (Plane() as plane, Sphere() as ball) | (Sphere() as ball, Plane() as plane):
            return abs((ball.center - plane.point) @ plane.normal)
        case Cylinder(), Cylinder():
            square = np.cross(a.direction, b.direction)
            return abs((b.point - a.point) @ square) / np.linalg.norm(square)
        case (Plane() as plane, other) | (other, Plane() as plane):
            return abs((other.point - plane.point) @ plane.normal)


def test_each_misplaced_feature_has_one_distance_off():
    x, z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    surfaces = {
        "plane": Plane(np.zeros(3), z),
        "ball": Sphere(np.array([30.0, 40, 50]), 5.0),
        "bar": Cylinder(np.array([0, 10.0, 20]), x, 4.0),
        "post": Cylinder(np.array([70.0, -20, 0]), z, 4.0),
    }
    pairs = set()
    for wrong in misplaced(surfaces, 0.25):
        moved = [n for n in surfaces if wrong.surfaces[n] is not surfaces[n]]
        assert len(moved) == 1
        one, other = wrong.message.split(" ")[0], wrong.message.split("from ")[1].split(" ")[0]
        assert moved == [one]
        before, after = (distance(s[one], s[other]) for s in (surfaces, wrong.surfaces))
        assert abs(after - before) == pytest.approx(0.25)
        pairs.add((one, other))
    # There is no distance between a plane and an axis perpendicular to it.
    assert pairs == {(a, b) for a in surfaces for b in surfaces if a != b} - {("plane", "post"), ("post", "plane")}
