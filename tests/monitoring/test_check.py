"""The daily check: verdict and bound on simulated days, errors, the history, and the power of the drift test."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from tactfix import Limits, Pose, check, compare, load_contacts, load_fixture, locate, simulate
from tactfix.errors import FileError, OtherFixtureError
from tactfix.files.check_history import append_history, read_history
from tactfix.geometry.surfaces import outward_normals
from tactfix.monitoring.drift import CheckRecord, drift_of
from tests.support.project import ROOT

FIXTURE = load_fixture(ROOT / "fixtures" / "robot-cell-plate.yaml")
NOMINAL = load_contacts(ROOT / "samples" / "robot-cell-plate" / "contacts.csv", FIXTURE)
LOCATED = locate(FIXTURE, NOMINAL)
POSE = LOCATED.pose
OUTWARD = np.array(
    [outward_normals(LOCATED.surfaces[f], p) for f, p in zip(NOMINAL.features, NOMINAL.points, strict=True)]
)
EXACT = NOMINAL.points - np.array([c.residual for c in LOCATED.contacts])[:, None] * OUTWARD


def day(rng: np.random.Generator, shift=(0.0, 0.0, 0.0), turn_deg=(0.0, 0.0, 0.0)):
    """Contacts of a day on which the fixture has moved, about its origin; noise along the approach."""
    turn = Rotation.from_rotvec(turn_deg, degrees=True).as_matrix()
    origin = POSE.translation
    points = origin + (EXACT - origin) @ turn.T + shift
    noise = NOMINAL.sigmas * rng.standard_normal(len(points))
    return replace(NOMINAL, points=points + noise[:, None] * NOMINAL.approaches, approaches=NOMINAL.approaches @ turn.T)


def test_a_fixture_has_moved_only_if_it_was_moved() -> None:
    rng = np.random.default_rng(1)
    still = check(FIXTURE, day(rng), POSE)
    assert still.has_moved is False
    moved = check(FIXTURE, day(rng, shift=(0.0, 0.0, 0.8)), POSE)
    assert moved.has_moved is True
    assert moved.movement is not None
    assert moved.movement.distance == pytest.approx(0.8, abs=4 * moved.movement.distance_sigma)


def test_limits_decide_where_they_are_given() -> None:
    contacts = day(np.random.default_rng(2), shift=(0.0, 0.0, 0.8))
    assert check(FIXTURE, contacts, POSE, limits=Limits(translation=2.0)).has_moved is False
    assert check(FIXTURE, contacts, POSE, limits=Limits(translation=0.3)).has_moved is True
    turned = day(np.random.default_rng(3), turn_deg=(0.0, 0.0, 1.0))
    assert check(FIXTURE, turned, POSE, limits=Limits(rotation=np.deg2rad(0.5))).has_moved is True


def test_the_worst_point_is_the_corner_that_moves_farthest() -> None:
    found = check(FIXTURE, day(np.random.default_rng(4), turn_deg=(0.0, 0.0, 1.0)), POSE)
    assert found.worst is not None
    assert found.movement is not None
    after = locate(FIXTURE, day(np.random.default_rng(4), turn_deg=(0.0, 0.0, 1.0))).base_from_fixture
    before = POSE.base_from_fixture
    corner = np.append(found.worst.point, 1.0)
    assert np.linalg.norm((after - before) @ corner) == pytest.approx(found.worst.displacement)
    inside = np.append(found.worst.point * 0.5, 1.0)
    assert np.linalg.norm((after - before) @ inside) < found.worst.displacement


@pytest.mark.parametrize("turn", [0.0, 0.05])
def test_the_bound_holds_on_19_days_of_20(turn: float) -> None:
    """Simulated days: the bound is compared with the true displacement at many points of the fixture."""
    rng = np.random.default_rng(5)
    # Both poses are measured: the reference has noise about the true pose as well.
    reference = locate(FIXTURE, day(rng)).pose
    some = check(FIXTURE, day(rng), reference)
    assert some.worst is not None
    size = np.abs(some.worst.point)
    places = rng.uniform(-size, size, (200, 3))
    true_turn = Rotation.from_rotvec([0.0, 0.0, turn], degrees=True).as_matrix() - np.eye(3)
    farthest = np.linalg.norm(places @ POSE.rotation.T @ true_turn.T, axis=1).max()
    held, days = 0, 40
    for _ in range(days):
        reference = locate(FIXTURE, day(rng)).pose
        found = check(FIXTURE, day(rng, turn_deg=(0.0, 0.0, turn)), reference)
        held += bool(found.bound >= farthest)
    assert held >= 33  # of 40 days with 95 per cent each; fewer occur once in 3,000


def test_check_and_compare_reject_a_reference_of_another_fixture() -> None:
    other = replace(POSE, fixture="three-planes")
    with pytest.raises(OtherFixtureError, match="three-planes"):
        check(FIXTURE, NOMINAL, other)
    with pytest.raises(OtherFixtureError):
        compare(POSE, other)
    assert compare(POSE, replace(POSE, fixture="")).distance == 0.0


def test_a_reference_without_covariance_counts_as_exact_with_a_note() -> None:
    found = check(FIXTURE, NOMINAL, Pose(POSE.base_from_fixture, None))
    assert any("exact" in warning for warning in found.warnings)
    assert found.movement is not None
    np.testing.assert_allclose(found.movement.covariance, POSE.covariance, rtol=1e-9)


def test_a_reference_in_metres_is_the_same() -> None:
    contacts = day(np.random.default_rng(6), shift=(0.3, 0.0, 0.0))
    one, other = check(FIXTURE, contacts, POSE), check(FIXTURE, contacts, POSE.in_units("m"))
    assert other.bound == pytest.approx(one.bound)
    assert other.movement.distance == pytest.approx(one.movement.distance)


def test_contacts_that_do_not_locate_are_reported() -> None:
    found = check(FIXTURE, NOMINAL.subset([0, 1, 2]), POSE)
    assert found.has_moved is None
    assert found.result.status == "underdetermined"
    assert found.record is None


def test_appended_checks_are_read_back(tmp_path: Path) -> None:
    path = tmp_path / "history.jsonl"
    assert read_history(path) == ()
    for seed in (1, 2):
        append_history(path, check(FIXTURE, day(np.random.default_rng(seed)), POSE).record)
    first, second = read_history(path)
    assert first.fixture == FIXTURE.name
    assert not np.array_equal(first.motion, second.motion)
    np.testing.assert_array_equal(second.reference, POSE.base_from_fixture)
    assert len(path.read_text().splitlines()) == 2


@pytest.mark.parametrize("bad", ['{"schema": "tactfix/check-history/1"}', "no json", '{"schema": "x"}', "[1]", "null"])
def test_an_invalid_line_of_a_history_is_named(tmp_path: Path, bad: str) -> None:
    path = tmp_path / "history.jsonl"
    append_history(path, check(FIXTURE, NOMINAL, POSE).record)
    with path.open("a") as file:
        file.write(bad + "\n")
    with pytest.raises(FileError, match="line 2: this is no check"):
        read_history(path)
    path.write_text(path.read_text()[:-1])
    with pytest.raises(FileError, match="cut off"):
        read_history(path)


def test_nan_in_a_history_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "history.jsonl"
    append_history(path, check(FIXTURE, NOMINAL, POSE).record)
    record = json.loads(path.read_text())
    record["motion"][0] = float("nan")
    path.write_text(json.dumps(record) + "\n")
    with pytest.raises(FileError):
        read_history(path)


def test_a_history_that_cannot_be_written_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be appended"):
        append_history(tmp_path / "nowhere" / "history.jsonl", check(FIXTURE, NOMINAL, POSE).record)


def records(motions: np.ndarray, alone: np.ndarray, reference: np.ndarray) -> list[CheckRecord]:
    return [CheckRecord("", "cell", "mm", np.eye(4), motion, alone, reference) for motion in motions]


SIGMAS = np.array([1e-4, 1e-4, 2e-4, 0.02, 0.03, 0.02])


def runs(rng: np.random.Generator, days: int, count: int, slope: np.ndarray) -> list[list[CheckRecord]]:
    """Histories in which the fixture moves by slope a day; all days of one share the error of the reference."""
    alone, reference = np.diag(SIGMAS**2), np.diag((0.7 * SIGMAS) ** 2)
    found = []
    for _ in range(count):
        common = 0.7 * SIGMAS * rng.standard_normal(6)
        noise = SIGMAS * rng.standard_normal((days, 6))
        found.append(records(np.arange(1, days + 1)[:, None] * slope + common + noise, alone, reference))
    return found


@pytest.mark.parametrize("days", [3, 20])
def test_the_rate_of_false_drifts_is_the_stated_one(days: int) -> None:
    chances = [drift_of(run).chance for run in runs(np.random.default_rng(7), days, 2000, np.zeros(6))]
    for level in (0.5, 0.1, 0.01):
        expected = 2000 * level
        assert abs(sum(c < level for c in chances) - expected) < 4 * np.sqrt(expected)


def test_a_drift_that_no_single_day_shows_is_detected() -> None:
    """A fifth of a sigma a day in one coordinate for twenty days: a significant slope, but few significant days."""
    slope = np.array([0.0, 0.0, 0.0, 0.0, 0.2 * SIGMAS[4], 0.0])
    drifting = runs(np.random.default_rng(8), 20, 300, slope)
    share_detected = np.mean([drift_of(run).detected for run in drifting])
    variances = SIGMAS**2 * (1 + 0.7**2)
    days = np.array([[record.motion for record in run] for run in drifting])
    single = np.mean((chi2.sf((days**2 / variances).sum(axis=2), 6) < 1e-3).any(axis=1))
    assert share_detected > 0.75
    assert single < 0.55
    found = np.array([drift_of(run).per_check for run in drifting])
    np.testing.assert_allclose(found.mean(axis=0), slope, atol=4 * (SIGMAS / 26 / np.sqrt(300)).max())


def test_an_old_rest_does_not_dilute_a_drift() -> None:
    rng = np.random.default_rng(9)
    rest = runs(rng, 100, 1, np.zeros(6))[0]
    drifting = runs(rng, 30, 1, np.array([0.0, 0.0, 0.0, 0.0, 0.3 * SIGMAS[4], 0.0]))[0]
    assert drift_of([*rest, *drifting]).checks == 30
    assert drift_of([*rest, *drifting]).detected


def test_checks_against_another_reference_do_not_count() -> None:
    earlier = [check(FIXTURE, day(np.random.default_rng(k)), POSE).record for k in range(4)]
    assert check(FIXTURE, NOMINAL, POSE, history=earlier).drift.checks == 5
    assert check(FIXTURE, NOMINAL, replace(POSE, base_from_fixture=np.eye(4)), history=earlier).drift is None
    with pytest.raises(OtherFixtureError):
        check(FIXTURE, NOMINAL, POSE, history=[replace(earlier[0], fixture="other")])


def test_simulated_contacts_at_the_reference_have_not_moved() -> None:
    contacts = simulate(FIXTURE, base_from_fixture=POSE.base_from_fixture, seed=3).contacts
    assert check(FIXTURE, contacts, POSE).has_moved is False
