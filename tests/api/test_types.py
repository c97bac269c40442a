"""Types of results as mypy infers them; and batch, reports and machine files used from Python."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import tactfix

ROOT = Path(__file__).parents[2]
FIXTURE = ROOT / "fixtures" / "robot-cell-plate.yaml"
CONTACTS = ROOT / "samples" / "robot-cell-plate" / "contacts.csv"

EXAMPLE = """
import numpy as np
import tactfix

fixture = tactfix.load_fixture("a.yaml")
result = tactfix.locate(fixture, tactfix.load_contacts("a.csv", fixture))
if result.status == "located":
    origin = result.base_from_fixture[:3, 3]
    sigmas = np.sqrt(np.diag(result.covariance))
    reveal_type(result)
else:
    reveal_type(result)
anyhow: tactfix.LocateResult = result
back = tactfix.LocateResult.from_json(result.to_json())
if back.status != "located":
    print(back.free_motions)
else:
    print(back.base_from_fixture @ np.eye(4))
"""


WRONG = """
import tactfix
fixture = tactfix.load_fixture("a.yaml")
result = tactfix.locate(fixture, tactfix.load_contacts("a.csv", fixture))
reveal_type(result)
tactfix.plan(fixture, contacts="many")
"""
PROGRAMS = {
    "wrong": WRONG,
    "asking": EXAMPLE,
    "not_asking": EXAMPLE.replace('if result.status == "located":', "if fixture.name:"),
}


@pytest.fixture(scope="module")
def mypy_output(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The output of mypy --strict for each program."""
    folder = tmp_path_factory.mktemp("users")
    for name, text in PROGRAMS.items():
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    # Libraries take most of the time; with the project's (strict) settings their cache is shared.
    settings = ["--config-file", str(ROOT / "pyproject.toml"), "--cache-dir", str(ROOT / ".mypy_cache")]
    command = [sys.executable, "-m", "mypy", "--strict", *settings, *(f"{name}.py" for name in PROGRAMS)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    lines = done.stdout.splitlines(keepends=True)
    return {name: "".join(line for line in lines if line.startswith(f"{name}.py:")) for name in PROGRAMS}


def test_users_see_the_types(mypy_output: dict[str, str]) -> None:
    assert (
        'Revealed type is "tactfix.locate_result.LocatedResult | tactfix.locate_result.NotLocatedResult"'
        in mypy_output["wrong"]
    )
    assert 'Argument "contacts" to "plan" has incompatible type "str"' in mypy_output["wrong"]
    assert mypy_output["wrong"].count(": error: ") == 1


def test_a_status_check_narrows_the_type_to_a_located_result(mypy_output: dict[str, str]) -> None:
    assert re.findall(r'Revealed type is "([\w.]+)"', mypy_output["asking"]) == [
        "tactfix.locate_result.LocatedResult",
        "tactfix.locate_result.NotLocatedResult",
    ]
    assert ": error: " not in mypy_output["asking"]


def test_without_a_status_check_the_pose_may_be_none(mypy_output: dict[str, str]) -> None:
    assert "not indexable" in mypy_output["not_asking"]


@pytest.mark.parametrize(("features", "kind"), [(None, "LocatedResult"), ("plate", "NotLocatedResult")])
def test_the_class_is_that_of_the_status(features: str | None, kind: str) -> None:
    fixture = tactfix.load_fixture(FIXTURE)
    contacts = tactfix.load_contacts(CONTACTS, fixture)
    result = tactfix.locate(fixture, contacts if features is None else contacts.on(features))
    assert type(result).__name__ == type(tactfix.LocateResult.from_json(result.to_json())).__name__ == kind
    assert isinstance(result, tactfix.LocateResult)
    with pytest.raises(AttributeError):
        result.dof = 3  # type: ignore[misc]


def test_contacts_know_their_unit() -> None:
    fixture = tactfix.load_fixture(FIXTURE)
    contacts = tactfix.load_contacts(CONTACTS, fixture)
    assert contacts.units == contacts[:3].units == (contacts[:3] + contacts[3:]).units == "mm"
    metres = tactfix.load_contacts(CONTACTS)
    assert metres.units == "m"
    assert np.allclose(1000 * metres.points, contacts.points)
    with pytest.raises(tactfix.UsageError, match="contacts in m, and robot-cell-plate in mm"):
        tactfix.locate(fixture, metres)
    with pytest.raises(tactfix.UsageError, match="cannot be joined"):
        _ = metres + contacts
    with pytest.raises(tactfix.UsageError, match="units"):
        tactfix.contacts_from_arrays("a", [[0, 0, 0]], sigma=0.1, tip_radius=0.0, units="feet")


def test_machine_files_are_read_by_their_format(tmp_path: Path) -> None:
    fixture = tactfix.load_fixture(FIXTURE)
    log = tmp_path / "touches.xyz"
    log.write_text("10 0 1.5\n0 10 1.5\n10 10 1.5\n", encoding="utf-8")
    options = tactfix.ContactOptions("mm", 3.0, 0.1)
    read = tactfix.load_contacts(log, fixture, options, format="xyz", features="plate:3", approach="0,0,-1")
    assert read.features == ("plate",) * 3
    assert read.approaches.tolist() == [[0, 0, -1]] * 3
    with pytest.raises(tactfix.UsageError, match="name theirs with format="):
        tactfix.load_contacts(CONTACTS, fixture, features="plate:3")


def test_messages_to_python_speak_of_arguments(tmp_path: Path) -> None:
    bare = tmp_path / "bare.csv"
    bare.write_text("feature,x,y,z\nplate,0,0,0\n", encoding="utf-8")
    with pytest.raises(tactfix.FileError, match="or give tip_radius=") as caught:
        tactfix.load_contacts(bare)
    assert "--" not in str(caught.value)
    assert "--tip-radius" in caught.value.on_command_line


def test_texts_of_results_in_python_name_no_options() -> None:
    """Notes on logs, exceeded limits and design hints are not errors, so one wording serves command line and Python."""
    fixture = tactfix.load_fixture(FIXTURE)
    log = {"format": "ur", "features": "plate:4,pin:6,ball:5"}
    options = tactfix.ContactOptions(tip_radius=0.003, sigma=8e-5)
    day = sorted((ROOT / "samples" / "calibration-day").glob("*.txt"))
    (row,) = tactfix.batch(fixture, day[:1], options, **log, max_sigma=1e-6, at=(300.0, 180.0, 60.0))
    assert "tip offset" in " ".join(row.warnings)
    assert "(300, 180, 60) is" in row.message
    bare = tactfix.Fixture.from_features("bare", "mm", dict(fixture.features), touch={})
    reports = [
        tactfix.design_check(bare),
        tactfix.design_check(fixture, None, tactfix.Wishes(max_sigma=1e-6, layouts=0)),
    ]
    findings = [finding for report in reports for finding in report.findings]
    assert {"sigma_missing", "accuracy"} <= {finding.code for finding in findings}
    texts = [row.message, *row.warnings, *(f"{finding.message} {finding.hint}" for finding in findings)]
    assert [text for text in texts if re.search(r"(^|\s)--[a-z]", text)] == []


def test_a_batch_has_a_row_for_each_set(tmp_path: Path) -> None:
    fixture = tactfix.load_fixture(FIXTURE)
    torn = tmp_path / "torn.csv"
    torn.write_text("feature,x\n", encoding="utf-8")
    rows = tactfix.batch(fixture, [CONTACTS, torn], max_sigma=1.0)
    assert [(row.status, row.acceptable) for row in rows] == [("located", True), ("error", False)]
    one = tactfix.locate(fixture, tactfix.load_contacts(CONTACTS, fixture))
    assert np.array(rows[0].transform).reshape(4, 4).tolist() == one.to_dict()["transform"]


def test_the_report_is_a_page() -> None:
    pytest.importorskip("jinja2")
    pytest.importorskip("plotly")
    fixture = tactfix.load_fixture(FIXTURE)
    contacts = tactfix.load_contacts(CONTACTS, fixture)
    result = tactfix.locate(fixture, contacts)
    page = tactfix.html_report(fixture, contacts, result, inputs={"contacts": CONTACTS}, notes={"operator": "Ada"})
    assert page.startswith("<!DOCTYPE html>") or page.startswith("<!doctype html>")
    assert "Ada" in page
    assert json.dumps(result.units)[1:-1] in page


def test_batch_reads_machine_logs_as_load_contacts_does() -> None:
    """Also with a tip offset: if one is given, the poses are those of the flange, and no note asks for it."""
    logs = sorted((ROOT / "samples" / "calibration-day").glob("*.txt"))[:1]
    fixture = tactfix.load_fixture(FIXTURE)
    log = {"format": "ur", "features": "plate:4,pin:6,ball:5"}
    for offset in ((0.0, 0.0, 0.0), (0.0, 0.0, 0.1)):
        options = tactfix.ContactOptions(tip_radius=0.003, sigma=8e-5, tip_offset=offset)
        (row,) = tactfix.batch(fixture, logs, options, **log)
        alone = tactfix.locate(fixture, tactfix.load_contacts(logs[0], fixture, options, **log))
        assert row.transform == pytest.approx(alone.pose.base_from_fixture.ravel(), abs=1e-9)
        assert row.warnings == alone.warnings
