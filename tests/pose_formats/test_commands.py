"""The commands convert, compare and import: output, exit status, standard error."""

import json
from xml.etree import ElementTree

import numpy as np
import pytest

from tactfix.cli.app import run

SURE = np.diag([1e-6**2] * 3 + [1e-3**2] * 3).tolist()
TURNED = [[0.0, -1.0, 0.0, 10.123456789], [1.0, 0.0, 0.0, 20.0], [0.0, 0.0, 1.0, 30.0], [0.0, 0.0, 0.0, 1.0]]


def located(path, transform=TURNED, **more):
    document = {"schema": "tactfix/locate/1", "units": "mm", "status": "located", "transform": transform} | more
    path.write_text(json.dumps(document))
    return str(path)


def moved(dx):
    matrix = np.array(TURNED)
    matrix[0, 3] += dx
    return matrix.tolist()


def test_convert_writes_a_text_and_notes_rounding(tmp_path, capsys):
    assert run(["convert", located(tmp_path / "a.json"), "--to", "kuka"]) == 0
    out, err = capsys.readouterr()
    assert out == "{X 10.123457,Y 20.000000,Z 30.000000,A 90.000000,B 0.000000,C 0.000000}\n"
    assert "tactfix: kuka rounds the origin by" in err
    assert run(["convert", located(tmp_path / "a.json"), "--to", "kuka", "--quiet"]) == 0
    assert capsys.readouterr().err == ""


def test_convert_by_the_ending_of_the_output_and_back(tmp_path, capsys):
    out = tmp_path / "frame.src"
    assert run(["convert", located(tmp_path / "a.json"), "--output", str(out)]) == 0
    assert run(["convert", str(out), "--to", "matrix"]) == 0
    printed = np.loadtxt(capsys.readouterr().out.splitlines())
    np.testing.assert_allclose(printed, TURNED, atol=1e-6)
    assert run(["convert", str(tmp_path / "a.json"), "--output", str(tmp_path / "pose.npy")]) == 0
    assert np.array_equal(np.load(tmp_path / "pose.npy"), TURNED)


def test_convert_refuses_and_is_forced(tmp_path, capsys):
    sure = located(tmp_path / "a.json", covariance=SURE)
    assert run(["convert", sure, "--to", "fanuc"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert "tenth of sigma" in err
    assert run(["convert", sure, "--to", "fanuc", "--force"]) == 0
    assert "Y =    20.000 mm" in capsys.readouterr().out
    tilted = np.eye(4)
    tilted[1:3, 1:3] = [[0, -1], [1, 0]]
    assert run(["convert", located(tmp_path / "b.json", tilted.tolist()), "--to", "g10"]) == 1


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["--to", "cuca"], 2, "kuka"),
        ([], 2, "--to"),
        (["--output", "pose.odd"], 2, ".src"),
        (["--to", "kuka", "--units", "m"], 2, "is in mm"),
        (["--to", "kuka", "--from", "ur"], 3, "no pose of this form"),
    ],
)
def test_convert_rejects_impossible_requests(arguments, status, message, tmp_path, capsys):
    assert run(["convert", located(tmp_path / "a.json"), *arguments]) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err


def test_a_result_without_a_pose_is_a_file_that_cannot_be_used(tmp_path, capsys):
    path = located(tmp_path / "a.json", None, status="ambiguous")
    assert run(["convert", path, "--to", "kuka"]) == 3
    assert "a.json: status is 'ambiguous'" in capsys.readouterr().err


def test_compare_reports_both_frames_and_applies_the_limits(tmp_path, capsys):
    before = located(tmp_path / "a.json", covariance=SURE)
    after = located(tmp_path / "b.json", moved(0.25), covariance=SURE)
    assert run(["compare", before, after]) == 0
    out = capsys.readouterr().out
    assert "moved 0.2500 mm (sigma 0.0014 mm), turned 0.000000 deg" in out
    assert "in base:    x +0.25" in out
    assert "in fixture: x +0.0000, y -0.2500" in out
    assert run(["compare", before, after, "--limit-translation", "0.3", "--limit-rotation", "0.1"]) == 0
    assert run(["compare", before, after, "--limit-translation", "0.2"]) == 1
    assert "moved 0.25 mm, the limit is 0.2 mm" in capsys.readouterr().err
    assert run(["compare", before, after, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["schema"] == "tactfix/compare/1"
    assert report["base"]["translation"] == pytest.approx([0.25, 0, 0])
    assert report["chance"] < 1e-9
    assert report["status"] == "ok"


def test_compare_writes_junit(tmp_path, capsys):
    turned = (np.array(TURNED) @ np.diag([-1.0, -1.0, 1.0, 1.0])).tolist()
    before, after = located(tmp_path / "a.json"), located(tmp_path / "b.json", turned)
    xml = tmp_path / "verdict.xml"
    assert run(["compare", before, after, "--limit-rotation", "1", "--junit", str(xml)]) == 1
    suite = ElementTree.parse(xml).getroot()
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("2", "1", "1")
    failure = suite.find("testcase[@name='rotation']/failure")
    assert failure.get("message") == "turned 180 deg, the limit is 1 deg"


def test_compare_asks_for_a_unit_that_one_pose_does_not_say(tmp_path, capsys):
    matrix = tmp_path / "a.txt"
    matrix.write_text("\n".join(" ".join(map(str, row)) for row in TURNED))
    assert run(["compare", str(matrix), located(tmp_path / "b.json")]) == 2
    assert "--units" in capsys.readouterr().err
    assert run(["compare", str(matrix), located(tmp_path / "b.json"), "--units", "mm"]) == 0


def test_import_writes_a_contact_file(tmp_path, capsys):
    log = tmp_path / "grbl.txt"
    log.write_text("[PRB:1,2,3:1]\n[PRB:0,0,0:0]\n[PRB:4,5,6:1]\n")
    say = ["import", str(log), "--contacts-format", "grbl", "--features", "bar:1,ball:1", "--units", "mm"]
    assert run([*say, "--tip-radius", "3"]) == 0
    out, err = capsys.readouterr()
    assert out.splitlines() == [
        "# units: mm", "# tip_radius: 3.0", "feature,x,y,z,id", "bar,1.0,2.0,3.0,line 1", "ball,4.0,5.0,6.0,line 3"
    ]  # fmt: skip
    assert "line 2: the probe met nothing; dropped" in err
    assert run(["import", str(log), "--contacts-format", "grbl"]) == 3
    err = capsys.readouterr().err
    assert "--features" in err
    assert "--units" in err
    assert run(["import", str(log)]) == 2
    assert run(["import", str(tmp_path / "none"), "--contacts-format", "grbl"]) == 3
