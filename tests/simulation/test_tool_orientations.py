"""Simulated flange poses: tool orientations, a wrong tip offset, and the prediction of design-check."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.cli.app import run
from tactfix.design.design_check import design_check
from tactfix.design.design_report import Wishes
from tactfix.errors import UsageError
from tactfix.files.contact_source import load_contacts
from tactfix.localization.locate import locate
from tactfix.simulation.faults import Fault
from tactfix.simulation.simulate import simulate
from tests.support.placed_cells import plate_with_all
from tests.support.project import ROOT

QUICK = Wishes(layouts=0)


def distinct(rotations):
    return np.unique(np.round(rotations, 9), axis=0)


@pytest.mark.parametrize("count", [1, 2, 4, 7])
def test_every_feature_gets_the_orientations_in_turn(count):
    contacts = simulate(plate_with_all(), seed=1, orientations=count).contacts
    rotations = distinct(contacts.flange_rotations)
    assert len(rotations) == count
    for rotation in rotations:
        assert np.allclose(rotation @ rotation.T, np.eye(3))
        assert np.linalg.det(rotation) == pytest.approx(1.0)
    axes = rotations[:, :, 2]
    assert (axes @ axes.T > np.cos(np.radians(61))).all()
    for index in contacts.by_feature.values():
        assert len(distinct(contacts.flange_rotations[index])) == min(count, len(index))


def test_with_orientations_the_touches_are_the_same():
    plain, turned = (simulate(plate_with_all(), seed=3, orientations=count).contacts for count in (None, 3))
    assert np.array_equal(plain.points, turned.points)
    assert plain.flange_rotations is None


def test_a_wrong_tip_is_constant_in_the_flange():
    right = simulate(plate_with_all(), seed=3, orientations=3).contacts
    wrong = simulate(plate_with_all(), seed=3, orientations=3, fault=Fault("wrong-tip", 0.7)).contacts
    moved = np.einsum("nji,nj->ni", wrong.flange_rotations, wrong.points - right.points)
    assert np.ptp(moved, axis=0).max() < 1e-9
    assert np.linalg.norm(moved[0]) == pytest.approx(0.7)
    assert abs(moved[0, 2]) < 1e-9
    with pytest.raises(UsageError, match="tool orientations"):
        simulate(plate_with_all(), fault=Fault("wrong-tip"))


def test_an_unknown_tip_is_found_back():
    simulation = simulate(plate_with_all(), seed=4, orientations=4, fault=Fault("wrong-tip", 0.7))
    found = locate(plate_with_all(), simulation.contacts, unknown=["tip"])
    assert found.status == "located"
    off = found.base_from_fixture[:3, 3] - simulation.base_from_fixture[:3, 3]
    assert np.linalg.norm(off) < 5 * np.sqrt(np.trace(found.covariance[3:, 3:]))
    assert np.linalg.norm(found.tip.offset) == pytest.approx(0.7, abs=0.3)


def spot(fixture, contacts):
    report = design_check(fixture, contacts, QUICK)
    return next(one for one in report.blind_spots if one.error == "tip_offset"), report


@pytest.mark.parametrize("count", [1, 2])
def test_one_orientation_never_shows_a_wrong_tip_and_two_not_along_an_axis(count):
    contacts = simulate(plate_with_all(), seed=2, orientations=count).contacts
    one, report = spot(plate_with_all(), contacts)
    assert not one.detectable
    assert one.power < 0.01
    # The pose is off by the error of the tip.
    assert one.pose_shift == pytest.approx(10 * plate_with_all().probe.sigma, rel=1e-3)
    assert any(finding.code == "blind_tip_offset" and finding.status == "warning" for finding in report.findings)


def test_four_orientations_show_what_many_simulations_show():
    """The predicted power against the share of simulations with this tip error that locate doubts."""
    contacts = simulate(plate_with_all(), seed=2, orientations=4).contacts
    one, _ = spot(plate_with_all(), contacts)
    assert one.power > 0.5
    none = design_check(plate_with_all(), simulate(plate_with_all(), seed=2).contacts, QUICK)
    assert not any(spot.error == "tip_offset" for spot in none.blind_spots)


def test_spread_contacts_of_a_robot_are_in_one_orientation(tmp_path, capsys):
    text = (ROOT / "fixtures" / "robot-cell-plate.yaml").read_text()
    (tmp_path / "f.yaml").write_text(text.replace("  tip_radius:", "  tip_offset: [0, 0, 150]\n  tip_radius:", 1))
    assert run(["design-check", str(tmp_path / "f.yaml"), "--study", "0", "--json"]) in (0, 1)
    assert '"error": "tip_offset", "detectable": false' in " ".join(capsys.readouterr().out.split())


def test_the_command_writes_what_locate_reads(tmp_path, capsys):
    fixture = str(ROOT / "fixtures" / "robot-cell-plate.yaml")
    file = tmp_path / "t.csv"
    words = ["simulate", fixture, "--seed", "5", "--orientations", "4", "--fault", "wrong-tip:1.5"]
    assert run([*words, "--output", str(file)]) == 0
    assert "off by" in file.read_text()
    from tactfix.files.fixture_file import load_fixture

    read = load_contacts(str(file), load_fixture(fixture))
    expected = simulate(load_fixture(fixture), seed=5, orientations=4, fault=Fault("wrong-tip", 1.5)).contacts
    between = Rotation.from_matrix(read.flange_rotations).inv() * Rotation.from_matrix(expected.flange_rotations)
    assert between.magnitude().max() < 1e-8
    assert np.array_equal(read.tip_offset, np.zeros(3))
    assert run(["locate", fixture, str(file), "--unknown", "tip", "--json"]) == 0
    capsys.readouterr()
    assert run(["locate", fixture, str(file)]) in (0, 6)
    assert "tip" in capsys.readouterr().err
    assert run(["simulate", fixture, "--orientations", "0"]) == 2
