"""The commands fit and init."""

import json
import os
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tactfix.cli import main
from tactfix.contacts import Contacts
from tactfix.errors import DegenerateContactsError
from tactfix.files.fixture_file import load_fixture
from tactfix.fitting.fit import FitResult
from tactfix.formats import TEMPLATES
from tactfix.geometry.surfaces import Plane
from tests.support.file_texts import HEAD, written
from tests.support.project import FIXTURES

PLANE = HEAD + "x,y,z,ax,ay,az\n0,0,1,0,0,-1\n1,0,1,0,0,-1\n0,1,1,0,0,-1\n"


@pytest.fixture
def fit_calls(monkeypatch: pytest.MonkeyPatch) -> list[tuple[object, ...]]:
    """The arguments of each call of fit, which is replaced by a stub that returns a plane."""
    calls: list[tuple[object, ...]] = []

    def fit(kind: str, contacts: Contacts, radius: float | None, side: str) -> FitResult:
        calls.append((kind, len(contacts), radius, side))
        plane = Plane(np.zeros(3), np.array([0.0, 0.0, 1.0]))
        return FitResult("plane", "located", 0, plane, chi2=0.0, chi2_limit=3.8, rms=0.0, warnings=("mind the step",))

    monkeypatch.setattr(import_module("tactfix.fitting.fit"), "fit", fit)
    return calls


def test_arguments_arrive_and_results_leave(
    fit_calls: list[tuple[object, ...]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(written(tmp_path, PLANE, "c.csv"))
    assert main(["fit", "sphere", path, "--radius", "2.5", "--side", "inner"]) == 0
    assert fit_calls == [("sphere", 3, 2.5, "inner")]
    out, err = capsys.readouterr()
    assert out == "point 0.0 0.0 0.0\nnormal 0.0 0.0 1.0\n"
    assert "mind the step" in err
    assert main(["fit", "plane", path, "--json", "--quiet"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["surface"]["normal"] == [0, 0, 1]
    assert err == ""
    assert main(["fit", "plane", path, "--output", str(tmp_path / "out.json")]) == 0
    assert json.loads((tmp_path / "out.json").read_text())["schema"] == "tactfix/fit/1"


def test_contacts_that_leave_the_surface_free(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fit(*_: object) -> FitResult:
        raise DegenerateContactsError("plane", "collinear", 1e-12, 1e-6, "spread them")

    monkeypatch.setattr(import_module("tactfix.fitting.fit"), "fit", fit)
    path = str(written(tmp_path, PLANE, "c.csv"))
    assert main(["fit", "plane", path]) == 4
    out, err = capsys.readouterr()
    assert out == ""
    assert "collinear" in err
    assert main(["fit", "plane", path, "--json"]) == 4
    report = json.loads(capsys.readouterr().out)
    assert (report["status"], report["surface"]) == ("underdetermined", None)


@pytest.mark.parametrize("options", [["--radius", "0"], ["--radius", "nan"], ["--side", "left"], ["--feature", "x"]])
def test_usage(fit_calls: list[tuple[object, ...]], tmp_path: Path, options: list[str]) -> None:
    path = str(written(tmp_path, PLANE, "c.csv"))
    assert main(["fit", "sphere", path, *options]) == 2
    assert main(["fit", "plane", path, "--radius", "1"]) == 2
    assert main(["fit", "plane", path, "--side", "inner"]) == 2
    assert main(["fit", "cone", path]) == 2
    assert fit_calls == []


def test_one_feature_of_several(
    fit_calls: list[tuple[object, ...]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = str(written(tmp_path, HEAD + "feature,x,y,z\na,0,0,1\nb,1,0,1\na,0,1,1\n", "c.csv"))
    assert main(["fit", "plane", path]) == 2
    assert "a, b" in capsys.readouterr().err
    assert main(["fit", "plane", path, "--feature", "a"]) == 0
    assert fit_calls == [("plane", 2, None, "outer")]


@pytest.mark.parametrize("name", TEMPLATES)
def test_a_template_is_the_fixture_that_ships(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["init", "--like", name]) == 0
    out = capsys.readouterr().out
    path = written(tmp_path, out)
    assert load_fixture(path).name == name
    assert out.count("#") >= 3
    shipped = FIXTURES / f"{name}.yaml"
    assert out == shipped.read_text(encoding="utf-8")
    # On a narrow terminal lines break between words.
    assert max(map(len, out.splitlines())) <= 60


def test_every_fixture_that_ships_is_a_template() -> None:
    folder = FIXTURES
    assert sorted(path.stem for path in folder.glob("*.yaml")) == sorted(TEMPLATES)


def test_init_does_not_overwrite(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, "mine")
    assert main(["init", str(path)]) == 2
    assert path.read_text() == "mine"
    assert "--force" in capsys.readouterr().err
    assert main(["init", str(path), "--force"]) == 0
    assert load_fixture(path).name == "robot-cell-plate"
    assert main(["init", "--like", "tree-spheres"]) == 2
    assert "three-spheres" in capsys.readouterr().err


def test_init_reports_folders_without_permission(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    stat = os.stat

    def guarded(path: Any, *rest: Any, **options: Any) -> os.stat_result:
        if "closed" in str(path):
            raise PermissionError(13, "Permission denied")
        return stat(path, *rest, **options)

    monkeypatch.setattr(os, "stat", guarded)
    assert main(["init", str(tmp_path / "closed" / "fixture.yaml")]) == 3
    assert "cannot be written: Permission denied" in capsys.readouterr().err


@pytest.mark.parametrize("marks", [("a\u0308", "\u00e4"), ("\u00e4", "a\u0308")])
def test_a_name_is_the_same_however_its_accents_are_coded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], marks: tuple[str, str]
) -> None:
    written_as, asked_for = (f"Fl{mark}che" for mark in marks)
    rows = PLANE.replace("x,y,z", "feature,x,y,z", 1)
    for start in "01":
        rows = rows.replace(f"\n{start},", f"\n{written_as},{start},")
    path = written(tmp_path, rows, "contacts.csv")
    assert main(["fit", "plane", str(path), "--feature", asked_for]) == 0, capsys.readouterr().err
