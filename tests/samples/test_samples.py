"""Every contact file of samples/ by the command line, compared with the results that its generator expects."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.samples.generate import SAMPLES, SIGMAS_ALLOWED, all_files
from tests.samples.generate_day import day_files
from tests.support.command_line import Ran, tactfix

FILES = all_files()
DAY = day_files()
CASES = [path for path in FILES if path.suffix == ".csv"]


def located(path: Path, *options: str) -> tuple[Ran, dict]:
    expected = json.loads(FILES[path.with_name(path.stem.replace("contacts", "expected") + ".json")])
    return tactfix("locate", SAMPLES.parent / expected["fixture"], SAMPLES / path, *options), expected


def turn_and_shift(one: np.ndarray, other: np.ndarray) -> tuple[float, float]:
    """Angle (rad) and distance of the origins between two poses."""
    chord = np.linalg.norm(one[:3, :3] - other[:3, :3]) / np.sqrt(8)
    return float(2 * np.arcsin(min(chord, 1.0))), float(np.linalg.norm(one[:3, 3] - other[:3, 3]))


def is_near(found: np.ndarray, true: np.ndarray, tolerance: dict[str, float]) -> bool:
    turn, shift = turn_and_shift(found, true)
    return turn <= tolerance["rotation"] and shift <= tolerance["translation"]


@pytest.mark.parametrize("path", CASES, ids=str)
def test_the_contacts_are_what_the_generator_makes(path: Path) -> None:
    assert (SAMPLES / path).read_text(encoding="utf-8") == FILES[path]


@pytest.mark.parametrize("path", DAY, ids=str)
def test_the_day_is_what_its_generator_makes(path: Path) -> None:
    assert (SAMPLES / path).read_text(encoding="utf-8") == DAY[path]


NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
ROUNDING = 1e-6
"""In sigmas of the pose: far above the rounding differences of processors and libraries, far below any effect."""


@pytest.mark.parametrize("path", [path for path in FILES if path.suffix == ".json"], ids=str)
def test_the_expected_results_are_what_the_generator_makes(path: Path) -> None:
    """The same text, and the same numbers except for rounding: the last digits of a sine depend on the machine."""
    stored, generated = (SAMPLES / path).read_text(encoding="utf-8"), FILES[path]
    assert NUMBER.sub("#", stored) == NUMBER.sub("#", generated)
    ours, theirs = json.loads(generated), json.loads(stored)
    for name, tolerance in ours["tolerance"].items():
        assert theirs["tolerance"][name] == pytest.approx(tolerance, rel=ROUNDING)
    for one, other in zip(poses_of(ours), poses_of(theirs), strict=True):
        off = np.abs(one - other)
        assert off[:3, :3].max() <= ROUNDING * ours["tolerance"]["rotation"] / SIGMAS_ALLOWED
        assert off[:3, 3].max() <= ROUNDING * ours["tolerance"]["translation"] / SIGMAS_ALLOWED
        assert not off[3].any()
    assert without_poses(ours) == without_poses(theirs)


def poses_of(expected: dict) -> list[np.ndarray]:
    return [np.array(p) for p in expected.get("poses", [expected["transform"]])]


def without_poses(expected: dict) -> dict:
    kept = {name: value for name, value in expected.items() if name not in ("poses", "tolerance")}
    return kept | {"transform": expected["transform"] is None}


@pytest.mark.parametrize("path", CASES, ids=str)
def test_exit_status_and_matrix(path: Path) -> None:
    done, expected = located(path)
    assert done.returncode == expected["exit"], done.stderr
    if expected["transform"] is None:
        assert not done.stdout
        return
    found = np.loadtxt(done.stdout.splitlines())
    assert found.shape == (4, 4)
    assert is_near(found, np.array(expected["transform"]), expected["tolerance"])


@pytest.mark.parametrize("path", CASES, ids=str)
def test_json(path: Path) -> None:
    done, expected = located(path, "--json")
    document = json.loads(done.stdout)
    assert (document["status"], document["units"]) == (expected["status"], expected["units"])
    left = [np.array(c["transform"]) for c in document["candidates"] if c["accepted"]]
    wanted = poses_of(expected)
    assert len(left) == len(wanted)
    assert all(any(is_near(found, true, expected["tolerance"]) for found in left) for true in wanted)
    assert (document["transform"] is None) == (expected["transform"] is None)


@pytest.mark.parametrize("path", [p for p in CASES if p.parent.name != "cylinder-sphere"], ids=str)
def test_sigma_is_that_of_the_generators_own_jacobian(path: Path) -> None:
    """Within a few per cent, because the generator uses one sigma for all features."""
    done, expected = located(path, "--json")
    covariance = np.array(json.loads(done.stdout)["covariance"])
    for part, name in ((covariance[:3, :3], "rotation"), (covariance[3:, 3:], "translation")):
        sigma = np.sqrt(np.linalg.eigvalsh(part)[-1])
        assert sigma == pytest.approx(expected["tolerance"][name] / SIGMAS_ALLOWED, rel=0.1)


def test_the_samples_differ_by_more_than_their_tolerance() -> None:
    """A wrong pose must fail: the second pose of the paper's ambiguous case is far outside the tolerance."""
    expected = json.loads(FILES[Path("cylinder-sphere/expected-normal.json")])
    one, other = (np.array(p) for p in expected["poses"])
    assert not is_near(one, other, {name: 1000 * value for name, value in expected["tolerance"].items()})
