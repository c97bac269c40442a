"""The command calibrate: the sample, its outputs, and every rejected input with its position in the file."""

import json
from pathlib import Path

import numpy as np
import pytest

from tactfix.cli.app import run
from tests.support.project import ROOT

SAMPLE = ROOT / "samples" / "robot-calibration"


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    """A copy of the sample's folder; its cell file."""
    for file in SAMPLE.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    return tmp_path / "cell.yaml"


def run_calibrate(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, str, str]:
    status = run(["calibrate", *map(str, words)])
    out, err = capsys.readouterr()
    return status, out, err


def offsets_only(cell: Path) -> None:
    cell.write_text(cell.read_text().replace("unknown: all", "unknown: [joint_offsets, tip]"))


def test_the_sample_is_calibrated_and_its_rows_are_read_again(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    touches = cell.parent / "touches.csv"
    robot = cell.parent / "robot.yaml"
    status, out, _ = run_calibrate(capsys, cell, touches, "--json", "--output", robot)
    assert status == 0
    report = json.loads(out)
    assert report["schema"] == "tactfix/calibrate/1"
    assert report["status"] == "calibrated"
    assert set(report["places"]) == {"front", "left", "high"}
    assert {"O1", "O2", "O3", "O4", "O5"} == set(report["observability"])
    assert report["prediction"]["after"] < 0.1 * report["prediction"]["before"]
    # The rows written, used as nominal robot, leave almost nothing to calibrate.
    rows = robot.read_text().split("rows:")[1].split("tip_offset:")
    head, tail = cell.read_text().split("    rows:")[0], "probe:" + cell.read_text().split("probe:")[1]
    body = "\n".join("    " + line for line in rows[0].splitlines()[1:])
    tail = tail.replace("[30.0, 0.0, 150.0]", rows[1].strip())
    # The nominal robot's tip is always fitted.
    cell.write_text(f"{head}    rows:\n{body}\n{tail}".replace("unknown: all", "unknown: [tip]"))
    _, again, _ = run_calibrate(capsys, cell, touches, "--json")
    for name, place in json.loads(again)["places"].items():
        # Not exactly equal, because the nominal robot's tip is fitted again.
        assert place["rms_before"] == pytest.approx(report["places"][name]["rms_after"], rel=0.05)


def test_touches_at_one_place_write_no_robot(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    offsets_only(cell)
    lines = (cell.parent / "touches.csv").read_text().splitlines()
    alone = cell.parent / "front.csv"
    alone.write_text("\n".join(line for line in lines if line.startswith(("#", "place", "front"))))
    robot = cell.parent / "robot.yaml"
    status, out, err = run_calibrate(capsys, cell, alone, "--output", robot)
    assert (status, out) == (4, "")
    assert not robot.exists()
    assert "another place" in err
    status, _, err = run_calibrate(capsys, cell, alone, "--unchecked", "--output", robot)
    assert status == 0
    assert err.count("another place") == 1
    assert robot.exists()


def test_report_and_tip_agree_with_the_json(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    offsets_only(cell)
    cell.write_text(cell.read_text().replace("front: plate", '"<b>": plate').replace(", high: plate", ""))
    lines = (cell.parent / "touches.csv").read_text().splitlines()
    kept = [line.replace("front", "<b>") for line in lines if not line.startswith("high")]
    touches = cell.parent / "touches.csv"
    touches.write_text("\n".join(kept))
    page, json_file = cell.parent / "robot.html", cell.parent / "robot.json"
    status, out, _ = run_calibrate(capsys, cell, touches, "--output", page, "--tip-format", "kuka")
    assert status == 0
    assert run_calibrate(capsys, cell, touches, "--output", json_file)[:2] == (0, "")
    report = json.loads(json_file.read_text())
    tip = report["tip"]["transform"]
    numbers = [float(word.split(" ")[1]) for word in out.strip("{}\n").split(",")]
    assert numbers[:3] == pytest.approx([row[3] for row in tip[:3]], abs=1e-5)
    offset = {item["name"]: item["value"] for item in report["parameters"]}
    assert numbers[:3] == pytest.approx([30 + offset["tip.x"], offset["tip.y"], 150 + offset["tip.z"]], abs=1e-5)
    assert len(report["tip"]["covariance"]) == 3
    text = page.read_text()
    assert "<b>" not in text
    assert "&lt;b&gt;" in text
    for place in report["places"].values():
        assert f"{place['rms_before']:.4g}" in text
        assert f"{place['rms_after']:.4g}" in text
    for touch in report["touches"]:
        assert f"{touch['after']:+.4g}" in text
    best = min(report["factors"], key=lambda item: item["rms"])
    assert best["factor"] > 0
    assert report["shrinkage"] == best["factor"]
    assert 0 < report["undetermined"] < 0.5


def test_touches_to_add_are_a_touch_file(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from tests.api.test_json_schemas import conforms_to, schema_of

    few = cell.parent / "few.csv"
    few.write_text("\n".join((cell.parent / "touches.csv").read_text().splitlines()[:12]))
    added = cell.parent / "added.csv"
    status, out, err = run_calibrate(capsys, cell, few, "--plan", 3, "--output", added)
    assert (status, out) == (0, "")
    assert "none is added at left and high: write placement" in err
    assert len(added.read_text().splitlines()) == 3 + 3
    status, out, err = run_calibrate(capsys, cell, added, "--plan", 0, "--json")
    assert status == 0
    report = json.loads(out)
    assert report["planned"] == 3
    assert report["added"] == []
    assert report["prediction"]["planned"] == report["prediction"]["with_added"] < report["prediction"]["prior"]
    left = report["undetermined"]
    assert 0.5 < left["planned"] == left["with_added"] < 1
    assert f"the touches planned leave {100 * left['planned']:.0f} per cent of the robot's errors undetermined" in err
    assert "reduce the unknown parameters" in err
    assert conforms_to(report, schema_of("calibrate-plan"))
    for words, message in (
        ((cell, "--plan", 3), "the pose of front, left and high is not known; give planned touches, or placement"),
        ((cell,), "no TOUCHES are given"),
        ((cell, few, "--plan", 3, "--hold-out", "front"), "--plan cannot be combined with --hold-out"),
        ((cell, few, "--plan", 3, "--output", "x.urdf"), "x.urdf: touches to add are written as .csv or .json"),
    ):
        status, out, err = run_calibrate(capsys, *words)
        assert (status, out) == (2, "")
        assert message in err


def test_unwritable_outputs_are_rejected_before_computing(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    touches = cell.parent / "touches.csv"
    for words, message in (
        (("--output", "robot.urdf"), "robot.urdf: this robot is written as .yaml; or name a .json or .html file"),
        (("--json", "--tip-format", "kuka"), "--json and --tip-format cannot be combined"),
        (("--tip-format", "kukka"), "there is no pose format 'kukka'; did you mean 'kuka'?"),
    ):
        status, out, err = run_calibrate(capsys, cell, touches, *words)
        assert (status, out) == (2, "")
        assert message in err


BAD_TOUCHES = {
    "degrees said to be rad": (("# joints: deg", "# joints: rad"), r"row 1, line 3: q2 is 37.2\d+ rad, outside"),
    "rad said to be degrees": (None, "row 1, line 3: no joint is ever 6.3 degrees from zero: these are rad"),
    "nothing said": (("# joints: deg\n", ""), "the unit of the joints, degrees or rad, is not given"),
    "a column too few": ((",q6", ""), "line 2: the robot has 6 joints, the file has q1, q2, q3, q4 and q5"),
    "an unknown place": (("\nfront,a", "\nfronk,a"), "row 1, line 3: there is no place 'fronk'; did you mean 'front'"),
    "an unknown feature": (("\nfront,a", "\nfront,d"), "row 1, line 3: seats at 'front' has no feature 'd'"),
    "a setting twice": (("# joints: deg", "# joints: deg\n# joints: rad"), "line 2: joints is given twice"),
    "a setting without its colon": (("# joints: deg", "# joints: deg\n## sigma 0.2"), "line 2: .*write '# sigma: 0.2'"),
    "a setting of the cell": (
        ("# joints: deg", "# joints: deg\n# tip_radius: 3"),
        "line 2: tip_radius belongs in the cell",
    ),
    "a setting misspelt": (
        ("# joints: deg", "# joints: deg\n# sigm: 1"),
        "line 2: unknown setting 'sigm'; write '# sigma",
    ),
    "an unknown unit": (("# joints: deg", "# joints: deg\n# units: ft"), "units is 'ft'; use one of: mm, m, um, in"),
    "no number": (("\nfront,a,", "\nfront,a,x"), "row 1, line 3: q1 is 'x"),
}


@pytest.mark.parametrize(("change", "message"), BAD_TOUCHES.values(), ids=BAD_TOUCHES.keys())
def test_bad_touches_are_refused_with_their_place(
    cell: Path, capsys: pytest.CaptureFixture[str], change: tuple[str, str] | None, message: str
) -> None:
    import re

    touches = cell.parent / "touches.csv"
    text = touches.read_text()
    if change is None:
        head, *rows = [line.split(",") for line in text.splitlines()[1:]]
        rows = [[*row[:2], *(repr(float(np.deg2rad(float(q)))) for q in row[2:])] for row in rows]
        text = "# joints: deg\n" + "\n".join(",".join(row) for row in [head, *rows])
    else:
        text = text.replace(*change, 1)
    touches.write_text(text)
    status, out, err = run_calibrate(capsys, cell, touches)
    assert (status, out) == (3, "")
    assert re.search(message, err), err


def test_relations_that_fix_the_shape_will_do(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    distances = {"a, b": 60.0, "a, c": 82.46211251235322, "b, c": 101.9803902718557}
    text = "tactfix: 1\nname: seats\nunits: mm\n"
    text += "features: {a: {type: point}, b: {type: point}, c: {type: point}}\ndistances:\n"
    text += "".join(f"  - {{between: [{pair}], value: {value}}}\n" for pair, value in distances.items())
    text += "frame: {origin: {center_of: a}, x: {from: a, to: b}, y: {from: a, to: c}}\n"
    (cell.parent / "seats.yaml").write_text(text)
    touches = cell.parent / "touches.csv"
    plan = run_calibrate(capsys, cell, touches, "--plan", 0, "--json")
    (cell.parent / "seats.yaml").write_text((SAMPLE / "seats.yaml").read_text())
    other = run_calibrate(capsys, cell, touches, "--plan", 0, "--json")
    assert plan[0] == other[0] == 0
    one, two = (json.loads(out)["prediction"]["planned"] for _, out, _ in (plan, other))
    assert one == pytest.approx(two, rel=1e-4)
    (cell.parent / "seats.yaml").write_text(text.replace("value: 60.0", "value: 60.0, sigma: 0.1"))
    status, _, err = run_calibrate(capsys, cell, touches)
    assert status == 3
    assert "line 17, column 19: fixture 'plate' has relations between its features that have a sigma" in err


def test_a_joint_beyond_its_limits_is_reported(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arm = '<robot name="r"><link name="a"/><link name="b"/><link name="t"/><joint name="A1" type="revolute">'
    arm += '<parent link="a"/><child link="b"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/></joint>'
    arm += '<joint name="t" type="fixed"><parent link="b"/><child link="t"/></joint></robot>'
    (cell.parent / "r.urdf").write_text(arm)
    text = cell.read_text()
    dh = text[text.index("robot:") : text.index("probe:")]
    cell.write_text(text.replace(dh, "robot: {urdf: r.urdf, tip_link: t}\n"))
    touches = cell.parent / "t.csv"
    touches.write_text("# joints: deg\nplace,feature,q1\nfront,a,20\nfront,a,70\n")
    status, _, err = run_calibrate(capsys, cell, touches)
    assert status == 3
    assert "row 2, line 4: q1 is 70 deg, outside -57.3 to 57.3 of A1" in err
    cell.write_text(cell.read_text().replace("tip_link: t", "tip_link: tip"))
    status, _, err = run_calibrate(capsys, cell, touches)
    assert status == 3
    assert "r.urdf: there is no link 'tip'" in err


def test_an_approach_that_is_given_in_part_is_refused(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    touches = cell.parent / "touches.csv"
    settings, head, first, *rows = touches.read_text().splitlines()
    lines = [settings, f"{head},ax,ay,az", f"{first},0,,-1", *(f"{row},,," for row in rows)]
    touches.write_text("\n".join(lines))
    status, out, err = run_calibrate(capsys, cell, touches)
    assert (status, out) == (3, "")
    assert "row 1, line 3: ay is empty; give all three of the approach or none" in err


BAD_CELLS = {
    "a decimal comma": (("sigma: 0.05", "sigma: 0,05"), "line 14.*05 follows a comma; write a decimal"),
    "a decimal comma on a line of its own": (
        ("probe: {tip_radius: 5.0, sigma: 0.05,", "probe:\n  {tip_radius: 5.0,\n  sigma:\n    '0,05',"),
        "probe.sigma is the text '0,05'; write a decimal point: 0.05\n",
    ),
    "four coordinates": (("[30.0, 0.0, 150.0]", "[30,5, 0.0, 150.0]"), "tip_offset is a list of 4; write three"),
    "an unknown key": (("unknown: all", "unknwon: all"), "line 15, column 1: unknown key 'unknwon'; did you mean"),
    "an unknown parameter": (("unknown: all", "unknown: [joint_9.offset]"), "line 15, column 11: there is no para"),
    "no prior": (("joint_offset: 0.3, ", ""), "line 16, column 8: prior has no joint_offset, which joint_1"),
    "a prior of zero": (("length: 0.5", "length: 0"), "line 16, column 36: prior.length is 0; write a number above 0"),
    "an unknown fixture": (("front: plate", "front: plait"), "line 18.*'plait', which is not among fixtures; did"),
    "two robots": (("  dh:", "  urdf: r.urdf\n  dh:"), "line 5, column 3: robot has both urdf and dh"),
    "no robot file": (("robot:\n  dh:", "robot: {urdf: r.urdf, tip_link: t}\nx:\n  dh:"), "unknown key 'x'"),
    "a loop of places": (
        ("front: plate", "front: {fixture: plate, place: {of: front, xyzabc: x}}"), "joined to itself, directly"
    ),
    "unknown as a word": (("unknown: all", "unknown: tip"), "unknown is the text 'tip'; write all, or a list"),
    "a version to come": (
        ("tactfix_cell: 1", "tactfix_cell: 2"),
        "tactfix_cell is 2; this tactfix reads format 1: write tactfix_cell: 1, or install a newer tactfix",
    ),
    "fixtures without names": (
        ("{plate: seats.yaml}", "seats.yaml"), "the text 'seats.yaml'; write a name for each file: {plate: plate.yaml}"
    ),
    "a version that equals 1": (("tactfix_cell: 1", "tactfix_cell: true"), "tactfix_cell is true"),
    "a range from high to low": (
        ("robot:", "robot:\n  joint_ranges: [[0, 1], [2, 1], [0, 1], [0, 1], [0, 1], [0, 1]]"),
        "range 2 of joint_ranges goes from 2 to 1",
    ),
    "joined to no place": (
        ("left: plate", "left: {fixture: plate, place: {of: frond, kuka: x}}"),
        "'left' is joined to 'frond', which is not among places; did you mean 'front'",
    ),
    "joined by no pose": (
        ("left: plate", "left: {fixture: plate, place: {of: front, kuka: x}}"), "place: contains no pose of this form"
    ),
    "a limit below zero": (
        ("left: plate", "left: {fixture: plate, placement: {near: {kuka: x}, within: {translation: -1, rotation: 1}}}"),
        "^[^\n]*places.left.placement.within.translation is -1[^\n]*\n$",
    ),
    "joined and placed": (
        ("left: plate", "left: {fixture: plate, placement: {near: {kuka: x}}, place: {of: front, kuka: x}}"),
        "'left' is joined to 'front' and has a placement of its own",
    ),
    "no fixture file": (("seats.yaml", "seat.yaml"), "seat.yaml: there is no such file"),
}  # fmt: skip


@pytest.mark.parametrize(("change", "message"), BAD_CELLS.values(), ids=BAD_CELLS.keys())
def test_bad_cells_are_refused_with_their_place(
    cell: Path, capsys: pytest.CaptureFixture[str], change: tuple[str, str], message: str
) -> None:
    import re

    text = cell.read_text()
    assert change[0] in text
    cell.write_text(text.replace(*change, 1))
    status, out, err = run_calibrate(capsys, cell, cell.parent / "touches.csv")
    assert (status, out) == (3, "")
    assert re.search(message, err), err
