"""More than six contacts: every pose that path tracking from six of them leads to is found."""

import numpy as np
import pytest

from tests.validation import redundant_poses
from tests.validation.noisy_poses import Judge
from tests.validation.pose_oracle import all_real_poses
from tests.validation.pose_problems import oracle_features
from tests.validation.redundant_poses import Tally, examine
from tests.validation.touched_problems import touched_number

# Two planes or a located ball determine the rotation; another ball or bar may then be at either of two places on a
# line. From one place on that line both descents once led to the same pose.
EITHER_END_OF_A_LINE = (
    ("sphere3+plane2+plane1", 4, "mixed", 77, 0),
    ("sphere1+plane3+plane2", 9, "even", 77, 5),
    ("sphere1+plane3+plane2", 3, "symmetric", 77, 7),
    ("cylinder1+plane3+plane2", 7, "loose", 77, 3),
    ("cylinder1+plane3+plane2", 3, "far", 77, 1),
    ("cylinder2+plane3+plane1", 4, "symmetric", 77, 4),
    ("sphere2+plane3+plane1", 4, "even", 12, 0),
    ("cylinder1+plane3+plane2", 3, "mixed", 12, 11),
)


@pytest.mark.parametrize(("kind", "more", "layout", "seed", "number"), EITHER_END_OF_A_LINE)
def test_both_places_on_a_line_are_found(kind: str, more: int, layout: str, seed: int, number: int) -> None:
    tally = Tally()
    examine("this one", touched_number(kind, more, layout, seed, number), tally)
    assert tally.counts["poses"] >= 2
    assert not tally.remarks


# One known direction leaves a rotation about it, which the starts of the search sample.
BETWEEN_SAMPLES = (
    ("cylinder2+sphere1+plane3", 8, "axis-parallel", 1, 5),
    ("cylinder2+cylinder2+plane2", 4, "symmetric", 1, 1),
    pytest.param("cylinder3+cylinder1+plane2", 5, "symmetric", 1, 22, marks=pytest.mark.slow),
)
# Weakly determined in one direction, in which residuals contribute as much to the Hessian as the Jacobian: three of
# twelve thousand descents passed the true pose slowly until they were abandoned.
BENT_BY_NOISE = (("cylinder2+sphere3+plane1", 6, "even", 1, 23),)


@pytest.mark.parametrize(("kind", "more", "layout", "seed", "number"), BETWEEN_SAMPLES + BENT_BY_NOISE)
def test_poses_that_were_missed_once_are_found(kind: str, more: int, layout: str, seed: int, number: int) -> None:
    tally = Tally()
    examine("this one", touched_number(kind, more, layout, seed, number), tally)
    assert tally.counts["poses"] >= 2
    assert not tally.remarks


@pytest.mark.parametrize("kind", ["plane3+plane2+plane1", "cylinder3+plane3", "sphere3+sphere2+sphere1"])
@pytest.mark.parametrize("layout", ["even", "axis-parallel", "far"])
def test_no_pose_is_missed(kind: str, layout: str) -> None:
    tally = Tally()
    for number in range(2):
        examine(f"{number}", touched_number(kind, 3 + 4 * number, layout, 5, number), tally)
    assert tally.counts["poses"] >= 2
    assert not tally.remarks


def test_a_missing_pose_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    found = redundant_poses.poses_of_package
    monkeypatch.setattr(redundant_poses, "poses_of_package", lambda *problem: np.asarray(found(*problem)[1:]))
    tally = Tally()
    examine("this one", touched_number(*EITHER_END_OF_A_LINE[0]), tally)
    assert tally.counts["missed"] == tally.counts["with miss"] == 1


def test_a_flat_valley_within_noise_gives_its_poses_and_no_others() -> None:
    """Six contacts determine one direction only by a few ten-thousandths: 600 descents once ended all along it."""
    touched = touched_number("cylinder3+plane3", 0, "mixed", 3, 4)
    problem, judge = touched.problem, Judge(touched)
    answer = all_real_poses(oracle_features(problem), problem.feature_of_contact, problem.points, problem.rho)
    found = redundant_poses.poses_of_package(problem, touched.sigma)
    assert len(found) <= answer.paths
    for pose in answer.poses:
        assert min(judge.distance(pose, other) for other in found) < 1
