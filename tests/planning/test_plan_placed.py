"""Plans for a fixture with a roughly known pose: fewer contacts, the effect of a measured pose, targets in base."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.cli.app import run
from tactfix.errors import UsageError
from tactfix.geometry.arrays import unit
from tactfix.localization.locate import locate
from tactfix.placement import Placement
from tactfix.planning.information import CRITERIA, Objective, known_of, rows_of
from tactfix.planning.plan import plan
from tactfix.simulation.simulate import simulate
from tests.support.placed_cells import ball_and_bar, plate_with_all
from tests.support.project import ROOT

NEAR = np.eye(4)
NEAR[:3, :3] = Rotation.from_euler("zyx", [-64, 8, 100], degrees=True).as_matrix()
NEAR[:3, 3] = [1200.0, -350.0, 400.0]
CENTRE, RADIUS, SIGMA = np.array([40.0, -20.0, 7.0]), 90.0, 0.02
FLAT = frozenset(("x", "y", "rz"))


def contacts_and_rows(count=9):
    rng = np.random.default_rng(8)
    points = CENTRE + RADIUS * rng.uniform(-1, 1, (count, 3))
    normals = unit(rng.standard_normal((count, 3)))
    return points, normals, rows_of(points, normals, np.full(count, SIGMA), CENTRE, RADIUS)


def in_base(points, normals):
    """Derivatives of the residuals by (rotation about base axes through the fixture's origin, translation)."""
    rotation, origin = NEAR[:3, :3], NEAR[:3, 3]
    places, outward = points @ rotation.T + origin, normals @ rotation.T
    return np.hstack([np.cross(places - origin, outward), outward]) / SIGMA


def at_corners(covariance, corners):
    """The largest variance of the scaled corners, for a pose covariance in base axes about the origin."""
    worst = 0.0
    for corner in (CENTRE + RADIUS * corners) @ NEAR[:3, :3].T:
        x, y, z = corner
        jacobian = np.array([[0, z, -y, 1, 0, 0], [-z, 0, x, 0, 1, 0], [y, -x, 0, 0, 0, 1]])
        worst = max(worst, np.linalg.eigvalsh(jacobian @ covariance @ jacobian.T)[-1])
    return worst


@pytest.mark.parametrize(
    "placement",
    [
        Placement(NEAR, free=FLAT),
        Placement(NEAR, free=frozenset(("rx", "z"))),
        Placement(NEAR, sigma=(0.05, 2e-4)),
        Placement(NEAR, sigma=(0.05, 2e-4), free=FLAT),
        Placement(NEAR, free=frozenset(("rz",))),
    ],
    ids=["flat", "rx z", "measured", "measured and flat", "turn"],
)
def test_the_worst_sigma_includes_prior_knowledge(placement):
    points, normals, rows = contacts_and_rows()
    corners = np.random.default_rng(5).uniform(-1, 1, (8, 3))
    plain = in_base(points, normals)
    known = plain.T @ plain
    if placement.covariance is not None:
        known = known + np.linalg.inv(placement.covariance)
    free = np.flatnonzero(np.concatenate([placement.turns, placement.shifts]))
    covariance = np.zeros((6, 6))
    covariance[np.ix_(free, free)] = np.linalg.inv(known[np.ix_(free, free)])
    objective = Objective("worst", corners, SIGMA, known_of(placement, NEAR, CENTRE, RADIUS))
    information = rows.T @ rows
    assert np.isclose(objective.score(information), at_corners(covariance, corners), rtol=1e-6)
    one = information - np.outer(rows[0], rows[0])
    assert np.isclose(objective.scores(one, rows)[0], at_corners(covariance, corners), rtol=1e-6)


@pytest.mark.parametrize("criterion", CRITERIA)
@pytest.mark.parametrize("free", [FLAT, frozenset(("rz",)), None])
def test_scores_of_more_contacts_are_those_of_the_whole_sum(criterion, free):
    _, _, rows = contacts_and_rows(20)
    placement = Placement(NEAR, sigma=(0.05, 2e-4), free=free)
    objective = Objective(criterion, np.eye(3), SIGMA, known_of(placement, NEAR, CENTRE, RADIUS))
    information = rows[:7].T @ rows[:7]
    scores = objective.scores(information, rows)
    sums = [objective.score(information + np.outer(row, row)) for row in rows]
    assert np.allclose(scores, sums, rtol=1e-5)


def test_a_fixture_that_lies_flat_takes_three_contacts():
    fixture = replace(plate_with_all(), placement=Placement(NEAR, free=FLAT))
    found = plan(fixture)
    assert found.steps[0].count == len(found.contacts) == 3
    assert found.unique
    simulation = simulate(fixture, found.contacts, seed=2)
    result = locate(fixture, simulation.contacts)
    assert result.status == "located"
    assert abs(result.base_from_fixture[2, 3] - NEAR[2, 3]) < 1e-9
    with pytest.raises(UsageError, match="2 contacts cannot be planned: the pose needs more; ask for 3 or more"):
        plan(fixture, 2)


def test_the_promised_covariance_is_that_of_locate_in_the_fixture_frame():
    fixture = replace(plate_with_all(), placement=Placement(NEAR, sigma=(0.03, 2e-4), free=FLAT))
    found = plan(fixture, 5)
    result = locate(fixture, found.in_base)
    turn = np.kron(np.eye(2), NEAR[:3, :3])
    assert np.allclose(turn @ found.covariance @ turn.T, result.covariance, atol=1e-9)
    assert found.worst_sigma < plan(plate_with_all(), 6).worst_sigma


def test_limits_resolve_a_symmetry():
    """A bar and a ball without a touch box have a half-turn that maps both onto themselves."""
    bare = replace(ball_and_bar(), touch={})
    assert plan(bare, 7).rivals
    limited = replace(bare, placement=Placement(NEAR, (5.0, np.radians(10))))
    assert plan(limited, 7).unique


def test_contacts_in_base_touch_the_fixture_at_near():
    cell = plate_with_all()
    found = plan(replace(cell, placement=Placement(NEAR)), 6)
    assert found.frame == "fixture"
    fixture_from_base = np.linalg.inv(NEAR)
    back = found.in_base.points @ fixture_from_base[:3, :3].T + fixture_from_base[:3, 3]
    assert np.allclose(back, found.contacts.points, atol=1e-9)
    assert plan(cell, 6).in_base is None
    assert locate(cell, found.in_base).status == "located"


def test_existing_contacts_override_the_placement():
    fixture = replace(plate_with_all(), placement=Placement(NEAR, (20.0, 0.1), free=FLAT))
    simulation = simulate(fixture, seed=3)
    first = simulation.contacts.subset(range(5))
    found = plan(fixture, existing=first, add=2)
    assert found.frame == "base"
    assert np.abs(found.base_from_fixture - simulation.base_from_fixture).max() < 0.5
    assert np.abs(found.base_from_fixture - NEAR).max() > 1.0
    assert np.array_equal(found.in_base.points, found.contacts.points)


def test_the_command_line_gives_targets_in_base(tmp_path, capsys):
    np.savetxt(tmp_path / "near.txt", NEAR, fmt="%.17g")
    plate = str(ROOT / "fixtures" / "robot-cell-plate.yaml")
    words = ["plan", plate, "--contacts", "6", "--near", str(tmp_path / "near.txt"), "--quiet"]
    assert run([*words, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["frame"] == "fixture"
    assert np.allclose(report["transform"], NEAR)
    for contact in report["contacts"]:
        point_in_base = NEAR[:3, :3] @ contact["point"] + NEAR[:3, 3]
        assert np.allclose(contact["point_in_base"], point_in_base)
        assert np.allclose(contact["approach_in_base"], NEAR[:3, :3] @ contact["approach"])
    assert run(words) == 0
    text = capsys.readouterr().out
    rows = [line.split(", ") for line in text.splitlines() if line.startswith("# plan: in base: ")]
    assert [row[1] for row in rows] == [contact["feature"] for contact in report["contacts"]]
    for row, contact in zip(rows, report["contacts"], strict=True):
        assert np.allclose([float(word) for word in row[2].split()], contact["point_in_base"], atol=1e-4)
    (tmp_path / "plan.csv").write_text(text)
    assert run(["simulate", plate, str(tmp_path / "plan.csv"), "--seed", "1"]) == 0
