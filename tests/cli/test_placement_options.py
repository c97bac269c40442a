"""The options --near, --within, --near-sigma and --free: prior knowledge, which overrides the fixture file."""

import json

import numpy as np
import pytest

from tactfix.cli.app import run
from tests.support.project import ROOT

FIXTURE = ROOT / "fixtures" / "three-planes.yaml"
TRUTH = np.array([[0, -1, 0, 120.0], [1, 0, 0, -40.0], [0, 0, 1, 300.0], [0, 0, 0, 1]])


@pytest.fixture
def cell(tmp_path):
    """Six touches of a cube at a known pose, without approaches, and a rough pose close to it."""
    places = {
        "right": [(1.5, -20, -20), (1.5, -80, -20), (1.5, -50, -80)],
        "back": [(-50, 1.5, -15), (-50, 1.5, -85)],
        "top": [(-50, -50, 1.5)],
    }
    rows = [
        f"{name},{','.join(repr(float(v)) for v in TRUTH[:3, :3] @ point + TRUTH[:3, 3])}"
        for name, points in places.items()
        for point in points
    ]
    (tmp_path / "c.csv").write_text("# tip_radius: 1.5\n# sigma: 0.01\nfeature,x,y,z\n" + "\n".join(rows) + "\n")
    rough = TRUTH.copy()
    rough[:3, 3] += [4.0, -3.0, 2.0]
    np.savetxt(tmp_path / "near.txt", rough, fmt="%.17g")
    return tmp_path


def located(cell, capsys, *words, fixture=FIXTURE):
    status = run(["locate", str(fixture), str(cell / "c.csv"), "--json", *words])
    return status, json.loads(capsys.readouterr().out)


def test_limits_leave_the_pose_that_is_near(cell, capsys):
    # Without its touch boxes the cube has mirror-like poses that only the rough pose excludes.
    (cell / "f.yaml").write_text(FIXTURE.read_text().partition("touch:")[0])
    status, alone = located(cell, capsys, fixture=cell / "f.yaml")
    assert (status, alone["status"]) == (5, "ambiguous")
    words = ("--near", str(cell / "near.txt"), "--within", "20,10")
    status, found = located(cell, capsys, *words, fixture=cell / "f.yaml")
    assert (status, found["status"]) == (0, "located")
    np.testing.assert_allclose(found["transform"], TRUTH, atol=1e-9)
    assert found["without_prior"]["status"] == "ambiguous"
    assert any(reason["code"] == "prior" for candidate in found["candidates"] for reason in candidate["reasons"])


def test_a_rough_pose_that_is_wrong_is_contradicted(cell, capsys):
    status, found = located(cell, capsys, "--near", str(cell / "near.txt"), "--within", "0.5,10")
    assert (status, found["transform"]) == (6, None)


def test_near_is_read_in_its_own_unit(cell, capsys):
    in_metres = TRUTH.copy()
    in_metres[:3, 3] /= 1000
    (cell / "near.json").write_text(json.dumps({"status": "located", "transform": in_metres.tolist(), "units": "m"}))
    status, found = located(cell, capsys, "--near", str(cell / "near.json"), "--within", "1,1")
    assert (status, found["status"]) == (0, "located")


def test_the_command_line_beats_the_file(cell, capsys):
    far = TRUTH.copy()
    far[0, 3] += 500
    text = (
        FIXTURE.read_text()
        + f"placement: {{near: {{matrix: {far.tolist()}}}, within: {{translation: 5, rotation: 5}}}}\n"
    )
    (cell / "f.yaml").write_text(text)
    assert located(cell, capsys, fixture=cell / "f.yaml")[0] == 6
    words = ("--near", str(cell / "near.txt"), "--within", "20,10")
    assert located(cell, capsys, *words, fixture=cell / "f.yaml")[0] == 0


def test_three_contacts_are_enough_where_three_directions_are_free(cell, capsys):
    lines = (cell / "c.csv").read_text().splitlines()
    rows = [line for line in lines[3:] if not line.startswith("top")]
    (cell / "c.csv").write_text("\n".join([*lines[:3], *rows[:2], rows[3]]) + "\n")
    turned = TRUTH.copy()
    angle = np.deg2rad(3.0)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turned[:2, :2] = turn @ TRUTH[:2, :2]
    turned[:2, 3] += [4.0, -3.0]
    np.savetxt(cell / "near.txt", turned, fmt="%.17g")
    words = ("--near", str(cell / "near.txt"), "--within", "20,10")
    assert located(cell, capsys, *words)[0] == 4
    status, found = located(cell, capsys, *words, "--free", "x,y,rz")
    assert (status, found["status"]) == (0, "located")
    np.testing.assert_allclose(found["transform"], TRUTH, atol=1e-9)
    spread = np.array(found["covariance"])
    assert np.abs(spread[[0, 1, 5]]).max() < 1e-12 < spread[2, 2]


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--within", "1,1"), "give the pose with --near"),
        (("--near", "NEAR"), "alone has no effect"),
        (("--near", "NEAR", "--within", "1,1", "--near-sigma", "1,1"), "cannot be combined"),
        (("--near", "NEAR", "--within", "1"), "such as 20,5"),
        (("--near", "NEAR", "--within=-1,5"), "is negative"),
        (("--near", "NEAR", "--within", "1,181"), "no rotation exceeds 180"),
        (("--near", "NEAR", "--within", "1_0,5"), "such as 20,5"),
        (("--near", "NEAR", "--free", "x,q"), "is not a direction"),
        (("--near", "NEAR", "--near-sigma", "0,1"), "above zero"),
    ],
)
def test_options_that_exclude_each_other(words, says, cell, capsys):
    words = [str(cell / "near.txt") if word == "NEAR" else word for word in words]
    assert run(["locate", str(FIXTURE), str(cell / "c.csv"), *words]) == 2
    assert says in capsys.readouterr().err


@pytest.mark.parametrize(("name", "times"), [(None, 0), ("another", 1), ("three-planes", 0)])
def test_the_pose_of_another_fixture_is_reported(name, times, cell, tmp_path, capsys):
    pose = {"schema": "tactfix/pose/1", "fixture": name, "units": "mm", "transform": TRUTH.tolist()}
    (tmp_path / "near.json").write_text(json.dumps(pose), encoding="utf-8")
    words = ["locate", str(FIXTURE), str(cell / "c.csv"), "--near", str(tmp_path / "near.json"), "--within", "20,10"]
    assert run(words) == 0
    assert capsys.readouterr().err.count("is a pose of another, and this is") == times
    assert run([*words, "--quiet"]) == 0
    assert capsys.readouterr().err == ""


def test_a_pose_that_cannot_be_read_is_named(cell, capsys):
    assert run(["locate", str(FIXTURE), str(cell / "c.csv"), "--near", str(cell / "no.txt"), "--within", "1,1"]) == 3
    assert "no.txt" in capsys.readouterr().err


def test_batch_and_report_accept_placement_options(cell, capsys):
    words = ("--near", str(cell / "near.txt"), "--within", "20,10")
    out = cell / "r.jsonl"
    assert run(["batch", str(FIXTURE), str(cell / "c.csv"), *words, "--jobs", "1", "--output", str(out)]) == 0
    assert json.loads(out.read_text())["status"] == "located"
    assert run(["report", str(FIXTURE), str(cell / "c.csv"), *words, "--output", str(cell / "r.html")]) == 0
    assert "--within" in (cell / "r.html").read_text()
