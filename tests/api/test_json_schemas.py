"""The JSON output of the commands conforms to the schemas that `tactfix schema` prints, for every status."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from tactfix.cli.application import COMMANDS
from tactfix.fixture_format.json_schema import conforms
from tactfix.report.json_schema import JSON_COMMANDS
from tests.support.command_line import tactfix

ROOT = Path(__file__).parents[2]
PLATE = "fixtures/robot-cell-plate.yaml"
TOUCHED = f"{PLATE} samples/robot-cell-plate/contacts.csv"
BAR = "fit cylinder samples/cylinder-sphere/contacts.csv --feature bar"
CALLS = [
    ("locate", f"locate {TOUCHED}", "located"),
    ("locate", f"locate {TOUCHED} --at 300,180,60 --near pose.json --within 20,5", "located"),
    ("locate", "locate fixtures/cylinder-sphere.yaml samples/cylinder-sphere/contacts-normal.csv", "ambiguous"),
    ("locate", f"locate {PLATE} plate.csv", "underdetermined"),
    ("locate", f"locate {PLATE} reversed.csv", "inconsistent"),
    ("locate", f"locate {TOUCHED} --unknown tip-radius", "located"),
    ("fit", f"{BAR} --radius 1", "located"),
    ("fit", f"{BAR} --radius 2", "inconsistent"),
    ("fit", "fit sphere three.csv", "underdetermined"),
    ("check", f"check {TOUCHED} --reference pose.json --history history.jsonl", "not_moved"),
    ("check", f"check {TOUCHED} --reference elsewhere.json", "moved"),
    ("check", f"check {PLATE} plate.csv --reference pose.json", "underdetermined"),
    ("compare", "compare pose.json elsewhere.json --limit-translation 1", "exceeded"),
    ("compare", "compare pose.txt pose.txt", "ok"),
    ("design-check", "design-check fixtures/three-planes.yaml --study 2", "error"),
    ("design-check", "design-check fixtures/cylinder-sphere.yaml --study 0", "warning"),
    ("design-check", f"design-check {PLATE} plate.csv --study 0", "error"),
    ("plan", f"plan {PLATE} --contacts 7 --starts 1", None),
    ("plan", f"plan {TOUCHED} --add 1 --starts 1", None),
    ("simulate", f"simulate {PLATE} --seed 1 --fault outlier:3", None),
    ("qualify", "qualify reversed.csv", None),
    ("qualify", "qualify ball.csv --radius 12.7", None),
    ("batch", f"batch {PLATE} samples/robot-cell-plate/contacts.csv --jobs 1 --output rows.jsonl", None),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the project's fixtures and samples, and the other files that the calls read."""
    place = tmp_path_factory.mktemp("schemas")
    for name in ("fixtures", "samples"):
        shutil.copytree(ROOT / name, place / name)
    contacts = place / "samples" / "robot-cell-plate" / "contacts.csv"
    lines = contacts.read_text(encoding="utf-8").splitlines(keepends=True)
    for name, kept in (("plate.csv", ("#", "feature", "plate")), ("three.csv", ("#", "feature", "plate"))):
        rows = [line for line in lines if line.startswith(kept)]
        (place / name).write_text("".join(rows if name == "plate.csv" else rows[:-1]), encoding="utf-8")
    tactfix(
        "simulate", place / PLATE, "--seed", 4, "--fault", "reversed-approach:3", "--output", place / "reversed.csv"
    )
    tactfix("locate", place / PLATE, contacts, "--output", place / "pose.json")
    tactfix("locate", place / PLATE, contacts, "--output", place / "pose.txt")
    moved = json.loads((place / "pose.json").read_text(encoding="utf-8"))
    moved["transform"][0][3] += 5.0
    (place / "elsewhere.json").write_text(json.dumps(moved), encoding="utf-8")
    write_ball(place / "ball.csv")
    return place


def write_ball(path: Path) -> None:
    """Write touches of a ball of radius 12.7 mm from thirty directions, with a tip of radius 2 mm."""
    rows = []
    for k in range(30):
        z = 1.0 - (2 * k + 1) / 45.0
        x, y = (1 - z * z) ** 0.5 * (1 if k % 2 else -1), 0.0
        if k % 3 == 0:
            x, y = y, x
        r = 14.7 + 0.01 * ((7 * k) % 5 - 2)
        rows.append(f"ball,{r * x},{r * y},{r * z},{-x},{-y},{-z}\n")
    path.write_text("# units: mm\nfeature,x,y,z,ax,ay,az\n" + "".join(rows), encoding="utf-8")


def schema_of(command: str) -> dict[str, Any]:
    printed = tactfix("schema", "--of", command)
    assert printed.returncode == 0
    schema: dict[str, Any] = json.loads(printed.stdout)
    return schema


def conforms_to(value: Any, schema: dict[str, Any]) -> bool:
    return conforms(value, schema, schema["$defs"])


@pytest.mark.parametrize(("command", "line", "status"), CALLS, ids=[line for _, line, _ in CALLS])
def test_the_json_conforms_to_its_schema(
    command: str, line: str, status: str | None, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    ran = tactfix(*line.split(), "--json")
    assert ran.stdout, ran.stderr
    printed = json.loads(ran.stdout)
    assert printed.get("status") == status
    schema = schema_of(command)
    assert conforms_to(printed, schema)
    assert not conforms_to({**printed, "another": 1}, schema)
    assert not conforms_to({**printed, "schema": "tactfix/other/1"}, schema)
    for key in set(printed) - {"at", "unknowns", "joint_covariance", "tip"}:
        assert not conforms_to({name: value for name, value in printed.items() if name != key}, schema), key


def test_each_line_of_guide_conforms_to_its_schema(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    printed = tactfix("guide", PLATE, "plate.csv", "--json").stdout.splitlines()
    schema = schema_of("guide")
    assert len(printed) == 4
    assert all(conforms_to(json.loads(line), schema) for line in printed)


@pytest.mark.slow
def test_the_json_of_calibrate_conforms_to_its_schema() -> None:
    cell = ROOT / "samples" / "robot-calibration"
    printed = json.loads(tactfix("calibrate", cell / "cell.yaml", cell / "touches.csv", "--json").stdout)
    assert printed["status"] == "calibrated"
    assert conforms_to(printed, schema_of("calibrate"))


def test_every_command_with_json_has_a_schema() -> None:
    with_json = {name for name in COMMANDS if "  --json  " in tactfix(name, "--help").stdout}
    assert set(JSON_COMMANDS) == with_json


def test_a_command_without_json_is_refused() -> None:
    ran = tactfix("schema", "--of", "lokate")
    assert ran.returncode == 2
    assert "did you mean 'locate'?" in ran.stderr
