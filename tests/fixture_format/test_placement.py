"""placement and the probe's tip in fixture files: values are read, impossible ones rejected."""

import json
import pickle
import re
from pathlib import Path

import numpy as np
import pytest

from tactfix.errors import FileError
from tactfix.files.fixture_file import load_fixture
from tactfix.fixture import Probe
from tactfix.placement import Placement
from tests.support.file_texts import PLACED, written

KUKA = '{kuka: "{X 1200,Y -350,Z 400,A -90,B 0,C 0}"}'
# A turn of -90 degrees about z: x_base = y_fixture, y_base = -x_fixture.
NEAR = [[0, 1, 0, 1200], [-1, 0, 0, -350], [0, 0, 1, 400], [0, 0, 0, 1]]


def placement(folder: Path, text: str, units: str = "mm") -> Placement:
    fixture = load_fixture(written(folder, PLACED.replace("units: mm", f"units: {units}") + f"placement: {text}\n"))
    assert fixture.placement is not None
    return fixture.placement


def refusal(folder: Path, text: str) -> str:
    with pytest.raises(FileError) as caught:
        placement(folder, text)
    (problem,) = caught.value.problems
    assert problem.line == 7
    return problem.what


def test_no_placement_without_the_block(tmp_path: Path) -> None:
    assert load_fixture(written(tmp_path, PLACED)).placement is None


@pytest.mark.parametrize(
    "near", [KUKA, f"{{matrix: {NEAR}}}", "{matrix: '0 1 0 1200\n\n-1 0 0 -350\n\n0 0 1 400\n\n0 0 0 1'}"]
)
def test_near_in_several_formats(tmp_path: Path, near: str) -> None:
    known = placement(tmp_path, f"{{near: {near}}}")
    np.testing.assert_allclose(known.near, NEAR, atol=1e-12)
    assert (known.within, known.sigma, known.free) == (None, None, None)


def test_a_format_in_millimetres_in_a_fixture_in_metres(tmp_path: Path) -> None:
    found = placement(tmp_path, f"{{near: {KUKA}}}", units="m").near
    np.testing.assert_allclose(found[:3, 3], [1.2, -0.35, 0.4])


def test_limits_in_rad_and_free_directions(tmp_path: Path) -> None:
    known = placement(tmp_path, f"{{near: {KUKA}, within: {{translation: 20, rotation: 180}}, free: [rz, x]}}")
    assert known.within == (20.0, pytest.approx(np.pi))
    assert known.free == {"x", "rz"}


def test_a_sigma_for_each_component(tmp_path: Path) -> None:
    known = placement(tmp_path, f"{{near: {KUKA}, sigma: {{translation: 0.5, rotation: 1.8}}}}")
    rotation = np.pi / 100
    np.testing.assert_allclose(known.covariance, np.diag([rotation**2] * 3 + [0.25] * 3))


def test_pose_and_covariance_from_a_file_next_to_the_fixture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir("/")
    covariance = np.diag([1e-6, 2e-6, 3e-6, 1e-8, 2e-8, 3e-8])
    covariance[0, 3] = covariance[3, 0] = 5e-8
    pose = {"schema": "tactfix/locate/1", "status": "located", "units": "m", "transform": np.eye(4).tolist()}
    (tmp_path / "old.json").write_text(json.dumps(pose | {"covariance": covariance.tolist()}))
    known = placement(tmp_path, "{near: {file: old.json}, sigma: {file: old.json}}")
    scale = np.array([1, 1, 1, 1e3, 1e3, 1e3])
    np.testing.assert_allclose(known.covariance, covariance * scale * scale[:, None])
    held = covariance * (np.arange(6) != 4) * (np.arange(6) != 4)[:, None]
    (tmp_path / "old.json").write_text(json.dumps(pose | {"covariance": held.tolist()}))
    assert "above zero in every direction" in refusal(tmp_path, "{near: {file: old.json}, sigma: {file: old.json}}")
    (tmp_path / "old.json").write_text(json.dumps(pose))
    assert "no covariance" in refusal(tmp_path, "{near: {file: old.json}, sigma: {file: old.json}}")


def test_a_placement_can_be_pickled(tmp_path: Path) -> None:
    fixture = load_fixture(written(tmp_path, PLACED + f"placement: {{near: {KUKA}, free: [x]}}\n"))
    known = pickle.loads(pickle.dumps(fixture)).placement
    np.testing.assert_allclose(known.near, NEAR, atol=1e-12)
    assert known.free == {"x"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{within: {translation: 1, rotation: 1}}", "no near"),
        ("{free: [x]}", "no near"),
        (f"{{near: {KUKA}, within: {{translation: 1}}}}", "no rotation"),
        (f"{{near: {KUKA}, within: {{translation: 0, rotation: 1}}}}", "translation is 0"),
        (f"{{near: {KUKA}, within: {{translation: 1, rotation: 181}}}}", "rotation is 181"),
        (f"{{near: {KUKA}, within: {{translation: 1e31, rotation: 1}}}}", "beyond 1e+30"),
        (f"{{near: {KUKA}, within: {{translation: 1, rotation: 1}}, sigma: {{file: a.json}}}}", "within and sigma"),
        (f"{{near: {KUKA}, sigma: 0.5}}", "placement.sigma is 0.5"),
        (f"{{near: {KUKA}, sigma: {{file: nowhere.json}}}}", "no such file"),
        (f"{{near: {KUKA}, free: [x, yaw]}}", "'yaw'"),
        (f"{{near: {KUKA}, free: [x, x]}}", "twice"),
        (f"{{near: {KUKA}, free: []}}", "a list of 0"),
        ("{near: {kuka: 3}}", "placement.near.kuka is 3"),
        ("{near: {kuka: [[1, 0, 0, 0]]}}", "a list of 1"),
        (f"{{near: {{kuka: {NEAR}}}}}", "placement.near.kuka is a list"),
        ('{near: {kuka: "X 1"}}', "no pose of this form"),
        ('{near: {cuka: "X 1"}}', "no pose format 'cuka'"),
        ("{near: {file: ../no.json}}", "no such file"),
        ("{near: {npy: abc}}", "not a numpy array"),
        ("{near: {matrix: [[1, 0, 0, 1e300], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}}", "beyond 1e+30"),
        ("{near: {matrix: [[1e300, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}}", "beyond 1e+30"),
        ("{near: {matrix: [[2, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}}", "does not rotate"),
    ],
)
def test_invalid_input(tmp_path: Path, text: str, expected: str) -> None:
    assert expected in refusal(tmp_path, text)


def test_the_tip_of_the_probe(tmp_path: Path) -> None:
    text = PLACED + "probe: {tip_offset: [0, 0, 120], tip_within: 5}\n"
    assert load_fixture(written(tmp_path, text)).probe == Probe(tip_offset=(0.0, 0.0, 120.0), tip_within=5.0)


@pytest.mark.parametrize(
    ("probe", "expected"),
    [
        ("{tip_within: 5}", "there is no tip_offset"),
        ("{tip_offset: [0, 0]}", "a list of 2"),
        ("{tip_offset: [0, 0, 1e31]}", "beyond 1e+30"),
        ("{tip_offset: [0, 0, 1], tip_within: 0}", "tip_within is 0"),
    ],
)
def test_invalid_tips(tmp_path: Path, probe: str, expected: str) -> None:
    with pytest.raises(FileError, match=re.escape(expected)):
        load_fixture(written(tmp_path, PLACED + f"probe: {probe}\n"))
