"""The contacts to make next as a file: what it says is what the result says, and touching there settles the pose."""

import re

import numpy as np
import pytest

from tactfix import load_contacts, load_fixture, locate
from tactfix.simulation.simulate import simulate
from tests.support.command_line import tactfix
from tests.support.project import ROOT

FIXTURES = [
    "robot-cell-plate",
    *(pytest.param(name, marks=pytest.mark.slow) for name in ("three-planes", "three-spheres")),
]
NOISE = re.compile(r"\d[eE]-(0[5-9]|[1-9]\d)|-0\.?0*(?![.\d])")
"""Numbers that are rounding: 1.3e-13, -0.00."""


@pytest.mark.parametrize("name", FIXTURES)
def test_texts_show_the_digits_that_mean_something(name, tmp_path):
    """Of guide after each touch, of locate, and in the file: no digits below sigma, no zero with a sign."""
    path = ROOT / "fixtures" / f"{name}.yaml"
    fixture = load_fixture(path)
    touches = tmp_path / "touches.csv"
    assert tactfix("simulate", path, "--seed", 3, "--output", touches).returncode == 0
    said = tactfix("guide", path, touches).stdout
    assert "touch " in said
    assert not NOISE.findall(said), said
    sigma = fixture.probe.sigma
    for number in re.findall(r"[xyz] (-?[\d.]+)", said):
        assert len(number.partition(".")[2]) <= 2 - np.floor(np.log10(sigma)), number


def test_the_file_holds_the_next_contacts_and_they_hold_the_pose(tmp_path):
    path = ROOT / "fixtures" / "robot-cell-plate.yaml"
    fixture = load_fixture(path)
    right = simulate(fixture, seed=5)
    few = right.contacts.subset([0, 1, 2, 4])
    result = locate(fixture, few)
    lines = [
        f"{feature},{','.join(map(repr, point.tolist()))},{','.join(map(repr, way.tolist()))}"
        for feature, point, way in zip(few.features, few.points, few.approaches, strict=True)
    ]
    made, missing = tmp_path / "made.csv", tmp_path / "next.csv"
    made.write_text("# units: mm\nfeature,x,y,z,ax,ay,az\n" + "\n".join(lines) + "\n")
    assert tactfix("locate", path, made, "--next-contact", missing).returncode == 4
    assert "in the fixture frame" in missing.read_text()
    touches = [result.next_contact, *result.next_contact.further]
    written = load_contacts(missing, fixture)
    assert written.features == tuple(touch.feature for touch in touches)
    for point, way, touch in zip(written.points, written.approaches, touches, strict=True):
        centre = touch.point_in_fixture - written.tip_radius * touch.approach_in_fixture
        assert point == pytest.approx(centre, abs=1e-3)
        assert way == pytest.approx(touch.approach_in_fixture, abs=1e-8)
    # A robot that goes there, where the fixture truly stands, leaves no motion free.
    touched = simulate(fixture, written, right.base_from_fixture, seed=6).contacts
    assert locate(fixture, few + touched).status != "underdetermined"
    # Nothing is missing: no file.
    missing.unlink()
    sample = ROOT / "samples" / "robot-cell-plate" / "contacts.csv"
    done = tactfix("locate", path, sample, "--next-contact", missing)
    assert done.returncode == 0
    assert "is not written" in done.stderr
    assert not missing.exists()
