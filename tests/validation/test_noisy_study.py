"""The counts of noisy_poses for results that are right or wrong on purpose."""

import numpy as np
import pytest

from tactfix.locate_result import LocateResult
from tactfix.results import Candidate, Reason
from tests.validation import noisy_poses
from tests.validation.noisy_poses import Judge, Tally, examine
from tests.validation.pose_oracle import all_real_poses
from tests.validation.pose_problems import distances, oracle_features
from tests.validation.touched_problems import Touched, touched_number


@pytest.fixture(scope="module")
def touched() -> Touched:
    return touched_number("sphere3+sphere2+sphere1", 0, "loose", 1, 0)


@pytest.fixture(scope="module")
def poses(touched: Touched) -> tuple[np.ndarray, np.ndarray]:
    """The least-squares pose near the true one, and another pose that fits as well."""
    problem, judge = touched.problem, Judge(touched)
    answer = all_real_poses(oracle_features(problem), problem.feature_of_contact, problem.points, problem.rho)
    return judge.settled, next(pose for pose in answer.poses if not judge.is_planted(pose))


def covariance_of(touched: Touched, pose: np.ndarray) -> np.ndarray:
    normals = distances(touched.problem, pose)[1] @ pose[:3, :3].T
    jacobian = np.hstack([np.cross(touched.problem.points - pose[:3, 3], normals), normals])
    return touched.sigma**2 * np.linalg.inv(jacobian.T @ jacobian)


def counts(touched: Touched, monkeypatch: pytest.MonkeyPatch, status: str, *candidates, covariance=None) -> dict:
    """The counts for a result with these candidates (pose, reasons), located at the first without reasons."""
    listed = tuple(
        Candidate(pose, {}, 1.0, 0.0, (Reason("approach", None, None, reasons),) if reasons else ())
        for pose, reasons in candidates
    )
    pose = next((pose for pose, reasons in candidates if not reasons), None) if status == "located" else None
    answer = LocateResult("noisy", "mm", status, pose, covariance, 0, None, None, None, listed, {}, ())
    monkeypatch.setattr(noisy_poses, "located", lambda _: answer)
    tally = Tally()
    examine("this one", touched, tally)
    assert len(tally.remarks) == sum(tally.counts[category] for category in ("false", "beyond", "lost", "fell"))
    return {name: count for name, count in tally.counts.items() if count}


def test_the_planted_pose_located_is_fine(touched, poses, monkeypatch) -> None:
    here, other = poses
    covariance = covariance_of(touched, here)
    found = counts(touched, monkeypatch, "located", (here, ""), (other, "approach"), covariance=covariance)
    assert found == {"located": 1}


def test_another_pose_located_is_false_and_the_planted_one_fell_or_is_lost(touched, poses, monkeypatch) -> None:
    here, other = poses
    covariance = covariance_of(touched, other)
    fell = counts(touched, monkeypatch, "located", (here, "approach"), (other, ""), covariance=covariance)
    assert fell == {"located": 1, "false": 1, "fell": 1}
    lost = counts(touched, monkeypatch, "located", (other, ""), covariance=covariance)
    assert lost == {"located": 1, "false": 1, "lost": 1}


def test_the_planted_pose_with_too_small_a_covariance_is_beyond_it(touched, poses, monkeypatch) -> None:
    found = counts(touched, monkeypatch, "located", (poses[0], ""), covariance=1e-6 * covariance_of(touched, poses[0]))
    assert found == {"located": 1, "beyond": 1}


def test_no_pose_at_all_is_lost_unless_a_motion_is_free(touched, poses, monkeypatch) -> None:
    assert counts(touched, monkeypatch, "inconsistent", (poses[1], "fit")) == {"inconsist": 1, "lost": 1}
    assert counts(touched, monkeypatch, "ambiguous", (poses[0], ""), (poses[1], "")) == {"ambig": 1}
    assert counts(touched, monkeypatch, "underdetermined") == {"underdet": 1}
