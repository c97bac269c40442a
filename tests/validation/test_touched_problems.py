"""The noisy problems: contacts on their surfaces, touched from the stated side, and files that agree with them."""

from pathlib import Path

import numpy as np
import pytest

import tactfix
from tests.validation.noisy_poses import Judge
from tests.validation.pose_oracle import all_real_poses
from tests.validation.pose_problems import LAYOUTS, distances, oracle_features, problem_number
from tests.validation.touched_problems import MOST_TILT, Touched, touched_number

KINDS_TOUCHED = ("plane3+plane2+plane1", "sphere3+sphere2+sphere1", "cylinder3+sphere2+plane1", "cylinder4+cylinder2")


def outward(touched: Touched) -> np.ndarray:
    """Normals out of the material, by small steps from each contact: the direction in which the distance increases."""
    problem = touched.problem
    pose = problem.base_from_fixture
    normals = []
    for x, f in zip(problem.points, problem.feature_of_contact, strict=True):
        feature = problem.features[f]
        axis = pose[:3, :3] @ feature.direction
        arm = x - (pose[:3, :3] @ feature.point + pose[:3, 3])
        if feature.type == "plane":
            normals.append(axis)
            continue
        if feature.type == "cylinder":
            arm = np.cross(np.cross(axis, arm), axis)
        normals.append(arm / np.linalg.norm(arm) * (1 if feature.side == "outer" else -1))
    return np.array(normals)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("kind", KINDS_TOUCHED)
def test_contacts_are_off_by_noise_alone_and_touched_from_outside_of_the_material(kind: str, layout: str) -> None:
    off, tilts = [], []
    for number in range(10):
        touched = touched_number(kind, number % 4, layout, 1, number)
        assert len(touched.problem.points) == 6 + number % 4
        off += list(distances(touched.problem, touched.problem.base_from_fixture)[0] / touched.sigma)
        tilts += list(np.arccos(-np.sum(touched.approaches * outward(touched), axis=1)))
    assert np.abs(off).max() < 5
    assert 0.7 < np.std(off) < 1.3
    assert 0.5 * MOST_TILT < max(tilts) <= MOST_TILT + 1e-6


@pytest.mark.parametrize("kind", KINDS_TOUCHED)
def test_files_agree_with_the_problem(kind: str, tmp_path: Path) -> None:
    touched = touched_number(kind, 2, "far", 1, 4)
    (tmp_path / "fixture.yaml").write_text(touched.fixture_yaml())
    (tmp_path / "contacts.csv").write_text(touched.contacts_csv())
    fixture = tactfix.load_fixture(tmp_path / "fixture.yaml")
    contacts = tactfix.load_contacts(tmp_path / "contacts.csv", fixture)
    assert np.array_equal(contacts.points, touched.problem.points)
    assert np.allclose(contacts.approaches, touched.approaches, atol=1e-15)
    assert (contacts.sigmas == touched.sigma).all()
    assert contacts.tip_radius == touched.problem.tip_radius
    for read, true in zip(fixture.features.values(), touched.problem.features, strict=True):
        assert (read.type, read.side) == (true.type, true.side)
        assert true.type == "plane" or read.radius == true.radius


def test_a_judge_distinguishes_the_true_pose_from_others() -> None:
    touched = touched_number("sphere3+sphere2+sphere1", 0, "loose", 1, 0)
    judge, planted = Judge(touched), touched.problem.base_from_fixture
    problem = touched.problem
    answer = all_real_poses(oracle_features(problem), problem.feature_of_contact, problem.points, problem.rho)
    verdicts = [judge.is_planted(pose) for pose in answer.poses]
    assert sum(verdicts) == 1
    assert len(verdicts) > 1
    found = answer.poses[verdicts.index(True)]
    assert np.abs(found - judge.settled).max() < 1e-6
    far = planted.copy()
    far[:3, 3] += 100 * touched.sigma
    assert not judge.is_planted(far)


def test_the_distance_by_covariance_is_that_of_the_contacts_own_information() -> None:
    touched = touched_number("plane3+plane2+plane1", 3, "far", 1, 5)
    problem, judge = touched.problem, Judge(touched)
    pose = judge.settled
    # Covariance about the fixture's origin, from the contacts: x - t is the lever arm of each.
    normals = distances(problem, pose)[1] @ pose[:3, :3].T
    jacobian = np.hstack([np.cross(problem.points - pose[:3, 3], normals), normals])
    scale = np.array([1e4, 1e4, 1e4, 1, 1, 1])
    covariance = touched.sigma**2 * np.linalg.inv((jacobian / scale).T @ (jacobian / scale)) / np.outer(scale, scale)
    by_covariance = judge.by_covariance(pose, covariance)
    assert by_covariance == pytest.approx(judge.seen(pose, problem.base_from_fixture, pose), rel=1e-6)


def test_numbered_problems_are_the_same_each_time_and_differ_from_each_other() -> None:
    one, again, other = (problem_number("cylinder3+plane3", "even", 1, number) for number in (3, 3, 4))
    assert np.array_equal(one.points, again.points)
    assert not np.allclose(one.points, other.points)


def test_a_layout_far_away_is_far_in_base_and_in_the_fixture() -> None:
    problem = problem_number("cylinder3+plane3", "far", 1, 0)
    assert np.abs(problem.points).min() > 5e3
    assert min(np.abs(f.point).min() for f in problem.features) > 5e3
    assert np.abs(distances(problem, problem.base_from_fixture)[0]).max() < 1e-10
