"""The file of next contacts agrees with the result, and touching there determines the pose."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tactfix import guide, load_contacts, load_fixture, locate
from tactfix.report.html_scene import locate_figure
from tactfix.report.plan_report import contact_csv
from tactfix.simulation.simulate import simulate
from tests.support.command_line import tactfix
from tests.support.project import ROOT

FIXTURES = [
    "robot-cell-plate",
    *(pytest.param(name, marks=pytest.mark.slow) for name in ("three-planes", "three-spheres")),
]
NOISE = re.compile(r"\d[eE]-(0[5-9]|[1-9]\d)|-0\.?0*(?![.\d])")
"""Numbers that consist of rounding errors: 1.3e-13, -0.00."""


@pytest.mark.parametrize("name", FIXTURES)
def test_texts_show_the_digits_that_mean_something(name, tmp_path):
    """In the output of guide and locate, and in the file: no digits below sigma, no signed zero."""
    path = ROOT / "fixtures" / f"{name}.yaml"
    fixture = load_fixture(path)
    touches = tmp_path / "touches.csv"
    assert tactfix("simulate", path, "--seed", 3, "--output", touches).returncode == 0
    output = tactfix("guide", path, touches).stdout
    assert "touch " in output
    assert not NOISE.findall(output), output
    sigma = fixture.probe.sigma
    for number in re.findall(r"[xyz] (-?[\d.]+)", output):
        assert len(number.partition(".")[2]) <= 2 - np.floor(np.log10(sigma)), number


def test_the_next_contacts_in_the_file_determine_the_pose(tmp_path):
    path = ROOT / "fixtures" / "robot-cell-plate.yaml"
    fixture = load_fixture(path)
    right = simulate(fixture, seed=5)
    few = right.contacts.subset([0, 1, 2, 4])
    result = locate(fixture, few)
    lines = [
        f"{feature},{','.join(map(repr, point.tolist()))},{','.join(map(repr, way.tolist()))}"
        for feature, point, way in zip(few.features, few.points, few.approaches, strict=True)
    ]
    contacts_file, missing = tmp_path / "made.csv", tmp_path / "next.csv"
    contacts_file.write_text("# units: mm\nfeature,x,y,z,ax,ay,az\n" + "\n".join(lines) + "\n")
    assert tactfix("locate", path, contacts_file, "--next-contact", missing).returncode == 4
    assert "in the fixture frame" in missing.read_text()
    touches = [result.next_contact, *result.next_contact.further]
    written = load_contacts(missing, fixture)
    assert written.features == tuple(touch.feature for touch in touches)
    for point, way, touch in zip(written.points, written.approaches, touches, strict=True):
        centre = touch.point_in_fixture - written.tip_radius * touch.approach_in_fixture
        assert point == pytest.approx(centre, abs=1e-3)
        assert way == pytest.approx(touch.approach_in_fixture, abs=1e-8)
    # Contacts made there, with the fixture at its true pose, leave no motion free.
    touched = simulate(fixture, written, right.base_from_fixture, seed=6).contacts
    assert locate(fixture, few + touched).status != "underdetermined"
    # No contact is missing, so no file is written.
    missing.unlink()
    sample = ROOT / "samples" / "robot-cell-plate" / "contacts.csv"
    done = tactfix("locate", path, sample, "--next-contact", missing)
    assert done.returncode == 0
    assert "is not written" in done.stderr
    assert not missing.exists()


def test_a_point_is_touched_next_without_an_approach(tmp_path):
    """In text, JSON and report, with and without a pose; the approach is empty in the file."""
    path, few, page = tmp_path / "jig.yaml", tmp_path / "few.csv", tmp_path / "few.html"
    path.write_text(
        "tactfix: 1\nname: jig\nunits: mm\nprobe: {tip_radius: 2.0, sigma: 0.08}\nfeatures:\n"
        "  plate: {type: plane, point: [0, 0, 0], normal: [0, 0, 1]}\n"
        "  pin: {type: cylinder, radius: 5.0, point: [0, 0, 0], direction: [0, 0, 1]}\n"
        "  seat: {type: point, point: [240, 120, 12]}\n"
    )
    fixture = load_fixture(path)
    contacts = simulate(fixture, seed=2).contacts
    contacts = contacts.subset([i for i in range(len(contacts)) if contacts.features[i] != "seat"])
    result = locate(fixture, contacts)
    assert result.status == "underdetermined"
    touch = result.next_contact
    assert (touch.feature, touch.approach, touch.approach_in_fixture) == ("seat", None, None)
    assert "moving along" not in touch.message
    assert guide(fixture, contacts).advice == touch.message
    assert result.to_dict()["next_contact"]["approach_in_fixture"] is None
    few.write_text(contact_csv(contacts, "mm", []))
    assert tactfix("locate", path, few, "--next-contact", tmp_path / "next.csv").returncode == 4
    assert "\nseat,240.0,120.0,12.0,,," in (tmp_path / "next.csv").read_text()
    assert tactfix("report", path, few, "--output", page).returncode == 4
    # If several poses remain, the scene shows the point in base, without an approach.
    known = replace(result, next_contact=replace(touch, point=np.zeros(3)))
    shown = [t for t in locate_figure(fixture, contacts, known)["data"] if t.get("legendgroup") == "next contact"]
    assert [(trace["mode"], trace["x"]) for trace in shown] == [("markers", [0.0])]
