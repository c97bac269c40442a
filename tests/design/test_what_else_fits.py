"""Margins, misplaced features, numbers of poses, and the study of random layouts."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from design.plans import BAD, ROOT, contacts_of, plan_at

from tactfix.design.blind_spots import Touched
from tactfix.design.margins import margins
from tactfix.design.misplaced import misplaced
from tactfix.design.pose_numbers import COMPLEX_POSES, Study, complex_poses, unique_shares
from tactfix.files.fixture_file import load_fixture
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tactfix.locate import locate

COUNTS = json.loads((Path(__file__).parent / "data" / "pose_counts.json").read_text())["rows"]


def touched_of(fixture, plan):
    surfaces = {name: f.surface for name, f in fixture.features.items()}
    corners = np.array([[70.0, 60.0, 10.0], [-10.0, -20.0, -10.0]])
    return Touched(surfaces, plan, np.full(len(plan), 0.01), corners)


def test_the_half_turn_is_a_rival_at_no_distance():
    fixture = load_fixture(BAD / "ball-beside-bar.yaml")
    found = margins(touched_of(fixture, plan_at((20, 40))), partial(locate, fixture, explain=False))
    assert not found.is_unique
    np.testing.assert_allclose(found.rival.image_from_fixture, np.diag([1.0, -1, -1, 1]), atol=1e-6)
    assert found.rival.sigmas_behind == pytest.approx(0, abs=1e-4)


def test_a_rival_lies_as_far_behind_as_its_residuals_say():
    """Few contacts on one side: the nearest wrong pose, its chi-square computed by hand from its pose."""
    fixture = load_fixture(BAD / "box-across-the-middle.yaml")
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


def test_a_contact_that_alone_holds_a_motion_is_fragile():
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


def test_wrong_poses_are_looked_for_with_every_residual_ten_times_as_uncertain():
    """A feature's own form error is widened with the probe's sigma, whatever share of the two it has."""
    fixture = load_fixture(BAD / "ball-beside-bar.yaml")
    form = {"bar": 0.03, "ball": 0.0}
    fixture = replace(fixture, features={n: replace(f, sigma=form[n]) for n, f in fixture.features.items()})
    plan = plan_at((20, 40))
    own = np.array([form[name] for name in plan.features])
    asked = []

    def locator(contacts):
        asked.append(contacts)
        return locate(fixture, contacts, explain=False)

    margins(replace(touched_of(fixture, plan), sigmas=np.hypot(0.01, own)), locator)
    np.testing.assert_allclose(np.hypot(asked[0].sigmas, own), 10 * np.hypot(0.01, own), rtol=1e-12)


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
    seen = set()
    for wrong in misplaced(surfaces, 0.25):
        moved = [n for n in surfaces if wrong.surfaces[n] is not surfaces[n]]
        assert len(moved) == 1
        one, other = wrong.message.split(" ")[0], wrong.message.split("from ")[1].split(" ")[0]
        assert moved == [one]
        before, after = (distance(s[one], s[other]) for s in (surfaces, wrong.surfaces))
        assert abs(after - before) == pytest.approx(0.25)
        seen.add((one, other))
    # No distance between a plane and an axis that stands on it.
    assert seen == {(a, b) for a in surfaces for b in surfaces if a != b} - {("plane", "post"), ("post", "plane")}


def test_complex_poses_are_those_of_the_reference():
    kinds = ("plane", "sphere", "cylinder")
    for row in COUNTS:
        pairs = sorted((kinds.index(f), n) for f, n in zip(row["features"], row["contacts"], strict=True))
        assert COMPLEX_POSES[", ".join(f"{kinds[k]} {n}" for k, n in pairs)] == row["complex_poses"]
    fixture = load_fixture(BAD / "ball-beside-bar.yaml")
    assert complex_poses(fixture, {"bar": 4, "ball": 2}) == 96
    assert complex_poses(fixture, {"bar": 5, "ball": 1}) is None


def test_the_study_of_layouts_is_seeded_and_ends_where_all_are_unique():
    fixture = load_fixture(ROOT / "fixtures" / "three-spheres.yaml")
    told = []

    def study():
        locator = partial(locate, fixture, explain=False)
        return unique_shares(fixture, Study(2, 4, 0.01, 2.0), locator, lambda share, what: told.append(share))

    shares = study()
    assert [s.contacts for s in shares] == list(range(6, 6 + len(shares)))
    assert shares[-1].ambiguous == shares[-1].underdetermined == 0
    assert all(s.ambiguous + s.underdetermined > 0 for s in shares[:-1])
    assert told == sorted(told)
    assert 0 <= told[0] <= told[-1] < 1
