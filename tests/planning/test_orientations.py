"""Plans with tool orientations: the predicted sigma of the tip against an independent information matrix and locate."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tactfix.cli.app import run
from tactfix.errors import UsageError
from tactfix.localization.locate import locate
from tactfix.placement import Placement
from tactfix.planning.plan import plan
from tactfix.simulation.simulate import simulate
from tests.support.placed_cells import plate_with_all
from tests.support.project import ROOT

CELL = plate_with_all()


@pytest.fixture(scope="module")
def four():
    return plan(CELL, 12, starts=1, orientations=4)


def information(contacts):
    """The information matrix of pose and tip (9, 9), written out; the approaches are the normals."""
    normals = -contacts.approaches
    tip = np.einsum("nij,ni->nj", contacts.flange_rotations, normals)
    rows = np.hstack([np.cross(contacts.points, normals), normals, tip]) / CELL.probe.sigma
    return rows.T @ rows


def test_the_sigma_of_the_tip_is_that_of_an_independent_matrix(four):
    covariance = np.linalg.inv(information(four.contacts))[6:, 6:]
    assert four.tip_sigma == pytest.approx(np.sqrt(np.linalg.eigvalsh(covariance)[-1]), rel=1e-6)
    assert len(np.unique(np.round(four.contacts.flange_rotations, 9), axis=0)) == 4


def test_no_other_orientation_of_one_contact_is_better(four):
    rotations = np.unique(np.round(four.contacts.flange_rotations, 12), axis=0)
    for i in range(len(four.contacts)):
        for rotation in rotations:
            tried = four.contacts.flange_rotations.copy()
            tried[i] = rotation
            covariance = np.linalg.inv(information(replace(four.contacts, flange_rotations=tried)))[6:, 6:]
            assert np.sqrt(np.linalg.eigvalsh(covariance)[-1]) >= four.tip_sigma * (1 - 1e-5)


def test_simulated_touches_give_the_predicted_sigma_of_the_tip(four):
    off = []
    for seed in range(30):
        simulation = simulate(CELL, four.contacts, seed=seed)
        found = locate(CELL, simulation.contacts, unknown=["tip"])
        assert found.status == "located"
        off.append(found.tip.offset)
    # The sigma of the worst direction, estimated from thirty draws.
    spread = np.sqrt(np.linalg.eigvalsh(np.cov(np.array(off).T))[-1])
    assert 0.6 < spread / four.tip_sigma < 1.5


def test_one_and_two_orientations_do_not_tell_the_tip_unless_a_measurement_does():
    for count in (1, 2):
        assert plan(CELL, 9, starts=1, orientations=count).tip_sigma == np.inf
    known = replace(CELL, placement=Placement(np.eye(4), sigma=(0.1, 1e-3)))
    assert np.isfinite(plan(known, 9, starts=1, orientations=1).tip_sigma)


def test_impossible_requests_are_rejected():
    with pytest.raises(UsageError, match="one or more"):
        plan(CELL, 9, starts=1, orientations=0)
    with pytest.raises(UsageError, match="flange orientations"):
        plan(CELL, existing=simulate(CELL, seed=1).contacts, orientations=3, starts=1)


@pytest.mark.parametrize("error", [0.0, 2.0])
def test_contacts_already_made_count_with_their_orientations(error):
    """Nine contacts in two orientations leave the tip free; if it is grossly wrong, they fit only with it unknown."""
    existing = simulate(CELL, plan(CELL, 9, starts=1).contacts, seed=1, orientations=2).contacts
    existing = replace(existing, points=existing.points - existing.flange_rotations @ [error, -error, 0.0])
    assert (locate(CELL, existing, explain=False).status == "inconsistent") == bool(error)
    added = plan(CELL, existing=existing, add=3, orientations=3, starts=1)
    assert added.frame == "base"
    assert len(added.contacts) == 3
    joined = replace(existing + replace(added.contacts, units=existing.units), tip_offset=existing.tip_offset)
    covariance = np.linalg.inv(information(joined))[6:, 6:]
    # Simulated touches are nominal except for noise; a wrong tip rotates their normals slightly.
    assert added.tip_sigma == pytest.approx(np.sqrt(np.linalg.eigvalsh(covariance)[-1]), rel=0.01 + 0.05 * error)
    assert np.isfinite(added.tip_sigma)


def test_the_command_writes_orientations_that_simulate_takes(tmp_path, capsys):
    fixture, file = str(ROOT / "fixtures" / "robot-cell-plate.yaml"), tmp_path / "plan.csv"
    words = ["plan", fixture, "--orientations", "4", "--contacts", "12", "--starts", "1", "--quiet"]
    assert run([*words, "--output", str(file)]) == 0
    assert "an unknown tip is determined by locate to" in file.read_text()
    assert (
        run(
            [
                "simulate",
                fixture,
                str(file),
                "--seed",
                "2",
                "--fault",
                "wrong-tip:1",
                "--output",
                str(tmp_path / "t.csv"),
            ]
        )
        == 0
    )
    assert run(["locate", fixture, str(tmp_path / "t.csv"), "--unknown", "tip", "--json"]) == 0
    offset = json.loads(capsys.readouterr().out)["tip"]["offset"]
    assert np.linalg.norm(offset) == pytest.approx(1.0, abs=0.6)
    assert run([*words, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["tip_sigma"] > 0
    assert np.shape(report["contacts"][0]["flange_in_fixture"]) == (3, 3)
