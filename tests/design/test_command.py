"""The command design-check: exit status, JSON, tables, JUnit, explanations."""

import json
from xml.etree import ElementTree

import numpy as np
import pytest

from tactfix.cli import main
from tactfix.report.design_table import design_text
from tests.support.plans import quick_report
from tests.support.project import BAD_DESIGNS, FIXTURES


def run(capsys, *arguments):
    status = main(["design-check", *map(str, arguments)])
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def test_json_has_the_documented_keys(capsys):
    status, out, err = run(capsys, BAD_DESIGNS / "ball-beside-bar.yaml", "--json", "--at", "1,2,3", "--study", "0")
    report = json.loads(out)
    assert status == 1
    assert err == ""
    assert report["schema"] == "tactfix/design-check/1"
    assert report["status"] == "error"
    (symmetry,) = report["symmetries"]
    assert symmetry["broken_by"] is None
    np.testing.assert_allclose(symmetry["transform"], np.diag([1, -1, -1, 1]), atol=1e-12)
    contacts = report["contacts"]
    assert contacts["minimum_total"] == 6
    assert contacts["alone"] == {"bar": 4, "ball": 3}
    assert contacts["paper"] == {"bar": 5, "ball": 2}
    assert contacts["minimal_sets"] == [{"bar": 4, "ball": 2}, {"bar": 3, "ball": 3}]
    assert contacts["complex_poses"] == [96, 48]
    assert np.shape(report["accuracy"]["covariance"]) == (6, 6)
    assert report["accuracy"]["at"][0]["point"] == [1.0, 2.0, 3.0]
    assert contacts["complex_poses_source"] == ["reference", "reference"]
    assert contacts["alone_radius_unknown"] == {"bar": 5, "ball": 4}
    assert contacts["paper_radius_unknown"] == {"bar": 6, "ball": 4}
    assert contacts["with_distances"] == {"bar": 3, "ball": 2}
    assert {"O1", "O2", "O3", "O4", "O5", "length"} == set(report["accuracy"]["observability"])
    extreme = [point["sigma"] for point in report["accuracy"]["extreme_points"]]
    assert len(extreme) == 8
    assert max(extreme) == report["accuracy"]["worst_point"]["sigma"]
    assert {"error", "detectable", "pose_shift", "message"} <= set(report["blind_spots"][0])
    assert {"code", "status", "message", "hint"} == set(report["checks"][0])


def test_a_study_that_would_never_end_is_refused(capsys):
    status, out, err = run(capsys, BAD_DESIGNS / "corner.yaml", "--study", "1" * 25)
    assert (status, out) == (2, "")
    assert "100000 at most" in err


def test_the_study_in_json_and_switched_off(capsys):
    fixture = FIXTURES / "three-planes.yaml"
    _, out, _ = run(capsys, fixture, "--json", "--study", "2", "--seed", "2")
    report = json.loads(out)
    contacts = report["contacts"]
    first = contacts["random_layouts"][0]
    assert (first["contacts"], first["layouts"]) == (6, 2)
    assert contacts["random_layouts"][-1]["ambiguous"] == 0
    assert len(contacts["real_poses"]) == len(contacts["minimal_sets"]) == len(contacts["complex_poses"])
    real_poses = next(entry for entry in contacts["real_poses"] if entry)
    assert set(real_poses) == {"layouts", "fewest_seen", "median", "most_seen"}
    uniqueness = next(check for check in report["checks"] if check["code"] == "uniqueness")
    assert "of 2 random layouts" in uniqueness["message"]
    status, off, _ = run(capsys, fixture, "--json", "--study", "0")
    assert status == 1
    contacts = json.loads(off)["contacts"]
    assert contacts["random_layouts"] == []
    assert set(contacts["real_poses"]) == {None}


@pytest.mark.parametrize(("name", "severity"), [("three-spheres", "ok"), ("cylinder-sphere", "warning")])
def test_designs_without_errors_exit_with_0_reproducibly(capsys, name, severity):
    fixture = FIXTURES / f"{name}.yaml"
    status, out, err = run(capsys, fixture, "--json", "--study", "0")
    assert (status, err) == (0, "")
    assert json.loads(out)["status"] == severity
    if severity == "ok":
        assert run(capsys, fixture, "--json", "--study", "0") == (status, out, err)


@pytest.mark.parametrize("width", [80, 120])
def test_tables_fit_into_a_terminal(width):
    report = quick_report(BAD_DESIGNS / "ball-beside-bar.yaml")
    lines = design_text(report, width).splitlines()
    assert max(map(len, lines)) <= width
    # Words are not broken: the table contains all words of the output without a table.
    flat = " ".join(" ".join(lines).split())
    for finding in report.findings:
        for word in finding.code.split():
            assert word in flat


def test_free_motions_in_json(capsys):
    status, out, _ = run(capsys, BAD_DESIGNS / "ball-on-axis.yaml", "--json")
    (motion,) = json.loads(out)["free_motions"]
    assert status == 1
    assert motion["message"] == "rotates about the axis of bar"
    np.testing.assert_allclose(np.abs(motion["rotation"]), [0, 1, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("name", "lines"),
    [
        (
            "ball-beside-bar",
            ["error", "half-turn", "touch: bar: {y: [", "4 bar + 2 ball", "observability", "tip_radius"],
        ),
        ("loose", ["relations_incomplete", "bar 4, ball 3"]),
    ],
)
def test_table(capsys, name, lines):
    _, out, _ = run(capsys, BAD_DESIGNS / f"{name}.yaml", "--study", "0")
    for words in lines:
        assert words in " ".join(out.split())
    assert max(map(len, out.splitlines())) <= 100
    assert "\x1b" not in out


def test_output_and_junit_files(capsys, tmp_path):
    status, out, _ = run(
        capsys, BAD_DESIGNS / "prism.yaml", "--output", tmp_path / "r.json", "--junit", tmp_path / "r.xml"
    )
    assert status == 1
    assert out == ""
    checks = json.loads((tmp_path / "r.json").read_text())["checks"]
    suite = ElementTree.fromstring((tmp_path / "r.xml").read_text())
    assert int(suite.get("tests")) == len(checks) == len(suite.findall("testcase"))
    assert int(suite.get("failures")) == sum(c["status"] == "error" for c in checks) == len(suite.findall(".//failure"))


def test_explain(capsys):
    status, out, _ = run(capsys, "--explain", "blind_tip_radius")
    assert status == 0
    assert "3 sqrt 3" in out
    status, _, err = run(capsys, "--explain", "blind_tip_radios")
    assert status == 2
    assert "blind_tip_radius" in err


def test_neither_fixture_nor_explain_is_a_usage_error(capsys):
    status, _, err = run(capsys)
    assert status == 2
    assert "fixture" in err


def test_a_plan_from_a_file(capsys, tmp_path):
    plan = tmp_path / "plan.csv"
    head = "# units: mm\n# tip_radius: 1.0\n# sigma: 0.01\nfeature,x,y,z,nx,ny,nz\n"
    rows = [
        ("bar", 9 * np.cos(a), y, 9 * np.sin(a), np.cos(a), 0, np.sin(a))
        for a, y in ((0, 20), (2, 20), (4, 21), (1, 50))
    ]
    rows += [
        ("ball", 60 + 11 * n[0], 11 * n[1], 11 * n[2], *n) for n in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -0.6, -0.8))
    ]
    plan.write_text(head + "\n".join(",".join(map(str, row)) for row in rows) + "\n")
    _, out, _ = run(capsys, BAD_DESIGNS / "ball-beside-bar.yaml", plan, "--json", "--study", "0")
    accuracy = json.loads(out)["accuracy"]
    assert (accuracy["of"], accuracy["contacts"]) == ("plan", 8)
