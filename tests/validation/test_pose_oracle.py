"""The oracle: numbers of poses known from elsewhere, the true pose is found, all poses fit, no path is lost."""

from dataclasses import replace

import numpy as np
import pytest

from tests.validation import pose_oracle
from tests.validation.kinds import CONFIRMED, KINDS, feature_list, kind_of
from tests.validation.monodromy import distinct, load, solve_by_monodromy
from tests.validation.pose_oracle import OracleAnswer, all_real_poses
from tests.validation.pose_problems import TIDY, PoseProblem, oracle_features, problem_number, random_problem, stiffness
from tests.validation.poses_of_package import poses_of_package

QUICK = ["plane3+plane2+plane1", "sphere3+sphere2+sphere1", "sphere2+sphere1+plane3"]


def solved(problem: PoseProblem) -> OracleAnswer:
    return all_real_poses(oracle_features(problem), problem.feature_of_contact, problem.points, problem.rho)


def misfit(problem: PoseProblem, pose: np.ndarray) -> float:
    """Largest distance of a contact from the offset surface of its feature at a pose, computed in base."""
    worst = 0.0
    for x, f, rho in zip(problem.points, problem.feature_of_contact, problem.rho, strict=True):
        feature = problem.features[f]
        arm = x - (pose[:3, :3] @ feature.point + pose[:3, 3])
        axis = pose[:3, :3] @ feature.direction
        distance = {
            "plane": arm @ axis,
            "sphere": np.linalg.norm(arm),
            "cylinder": np.linalg.norm(np.cross(arm, axis)),
        }[feature.type]
        worst = max(worst, abs(distance - rho))
    return worst


def assert_answers(problem: PoseProblem, answer: OracleAnswer) -> None:
    truth = problem.base_from_fixture
    assert min(np.abs(pose[:3, :3] - truth[:3, :3]).max() for pose in answer.poses) < 1e-7
    for pose in answer.poses:
        assert misfit(problem, pose) < 1e-7  # mm
        assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
        assert np.linalg.det(pose[:3, :3]) > 0
    assert answer.finite + answer.singular + answer.diverged + answer.suspicious == answer.paths
    assert answer.suspicious == 0


@pytest.mark.parametrize("kind", KINDS)
def test_stored_roots_are_as_many_as_known_distinct_and_fit_their_problem(kind: str) -> None:
    start = load(kind)
    assert len(start.roots) == KINDS[kind]
    assert start.idle_loops >= 8
    assert len(distinct(start.roots)) == len(start.roots)
    problem = start.problem
    assert tuple(np.bincount(problem.feature_of_contact)) == feature_list(kind)[1]
    for root in start.roots:
        a, b, c, d = root[:4] / np.sqrt(root[:4] @ root[:4])
        rotation = np.array(
            [
                [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
                [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
                [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
            ]
        )
        # vec(2 u q*) = t, written out.
        u = 2 * root[4:] / np.sqrt(root[:4] @ root[:4])
        q0, qv = a, np.array([b, c, d])
        t = -u[0] * qv + q0 * u[1:] - np.cross(u[1:], qv)
        for x, f in zip(problem.contacts, problem.feature_of_contact, strict=True):
            p, s, w = problem.place[f], problem.direction[f], problem.squared_radius[f]
            arm = rotation.T @ (x - t) - p
            terms = {"plane": arm * s, "sphere": [*(arm * arm), -w], "cylinder": [*np.cross(arm, s) ** 2, -w * (s @ s)]}
            values = np.array(terms[problem.types[f]])
            assert abs(values.sum()) < 1e-6 * np.abs(values).max()


@pytest.mark.parametrize("kind", QUICK)
def test_monodromy_counts_again_from_another_problem(kind: str) -> None:
    again = solve_by_monodromy(kind, np.random.default_rng(7), idle=2)
    assert len(again.roots) == CONFIRMED[kind]


@pytest.mark.parametrize(
    "kind",
    [*QUICK, "sphere2+sphere2+sphere2", "cylinder3+sphere3", "cylinder1+sphere3+plane2", "cylinder2+sphere2+plane2"],
)
def test_truth_is_found_and_all_answers_fit(kind: str) -> None:
    problem = random_problem(kind, np.random.default_rng(len(kind)))
    answer = solved(problem)
    assert_answers(problem, answer)
    assert answer.paths == answer.finite == KINDS[kind]
    # Complex poses of a real problem come in conjugate pairs.
    assert len(answer.poses) % 2 == answer.paths % 2
    assert not answer.multiple.any()


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind(kind: str) -> None:
    rng = np.random.default_rng(len(kind))
    for _ in range(5):
        problem = random_problem(kind, rng)
        assert_answers(problem, solved(problem))


@pytest.mark.parametrize("tidy", TIDY)
@pytest.mark.parametrize("kind", ["plane2+plane2+plane2", "sphere3+sphere2+sphere1"])
def test_tidy_layouts(kind: str, tidy: str) -> None:
    problem = random_problem(kind, np.random.default_rng(3), tidy)
    assert_answers(problem, solved(problem))


def test_axis_parallel_cylinder_and_sphere_sends_paths_to_infinity_and_keeps_the_truth() -> None:
    problem = random_problem("cylinder4+sphere2", np.random.default_rng(11), "axis-parallel")
    answer = solved(problem)
    assert_answers(problem, answer)
    assert answer.diverged > 0


def test_three_square_planes_3_2_1_have_four_poses() -> None:
    # By hand: three contacts determine the z plane, two then the y plane and one the x plane; the contacts leave
    # two normals for z (mirrored in the contacts' plane) and two for y.
    planes = [("plane", (0, 0, 0), (0, 0, 1)), ("plane", (0, 0, 0), (0, 1, 0)), ("plane", (0, 0, 0), (1, 0, 0))]
    points = np.array([[10, 20, 0], [80, 20, 0], [40, 90, 0], [15, 0, 5], [70, 0, 8], [0, 35, 6]], dtype=float)
    answer = all_real_poses(planes, [0, 0, 0, 1, 1, 2], points, np.zeros(6))
    rotations = sorted(tuple(np.diag(p[:3, :3]).round(9)) for p in answer.poses)
    assert rotations == [(-1, -1, 1), (-1, 1, -1), (1, -1, -1), (1, 1, 1)]
    assert np.allclose(answer.poses[:, :3, 3], 0, atol=1e-9)


def test_touching_poses_of_two_half_turned_fixtures_come_in_pairs() -> None:
    problem = random_problem("cylinder3+sphere3", np.random.default_rng(5))
    cylinder, sphere = problem.features
    arm = sphere.point - cylinder.point
    across = arm - (arm @ cylinder.direction) * cylinder.direction
    across /= np.linalg.norm(across)
    half_turn = np.eye(4)
    half_turn[:3, :3] = 2 * np.outer(across, across) - np.eye(3)
    half_turn[:3, 3] = sphere.point - half_turn[:3, :3] @ sphere.point
    poses = solved(problem).poses
    for pose in poses:
        assert min(np.abs(pose @ half_turn - other).max() for other in poses) < 1e-5


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_units_and_the_order_of_contacts_change_nothing(factor: float) -> None:
    problem = random_problem("sphere2+sphere2+sphere2", np.random.default_rng(2))
    scaled = [(name, factor * point) for name, point in oracle_features(problem)]
    turn = np.array([5, 2, 0, 4, 1, 3])
    answer = all_real_poses(
        scaled, problem.feature_of_contact[turn], factor * problem.points[turn], factor * problem.rho[turn]
    )
    reference = solved(problem).poses
    assert len(answer.poses) == len(reference)
    for pose in reference:
        expected = np.hstack([pose[:3, :3], factor * pose[:3, 3:]])
        assert min(np.abs(other[:3] - expected).max() / max(1.0, factor) for other in answer.poses) < 1e-6


def test_a_multiple_pose_is_found_and_marked() -> None:
    # Three contacts on a great circle: the two possible centres coincide.
    rng = np.random.default_rng(0)
    rotation = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    centers, radii, index = (
        np.array([[0.0, 0, 0], [60, 0, 0], [20, 70, 10]]),
        np.array([20.0, 15, 12]),
        [0, 0, 0, 1, 1, 2],
    )
    normals = np.array(
        [[1.0, 0, 0], [-0.5, 0.8, 0], [-0.3, -0.9, 0], [0.2, 0.5, 0.8], [0.9, 0.1, 0.3], [-0.2, 0.6, 0.7]]
    )
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = (centers[index] + radii[index][:, None] * normals) @ rotation.T + [100.0, 200.0, -50.0]
    answer = all_real_poses([("sphere", c) for c in centers], index, points, radii[index])
    at_truth = [np.abs(pose[:3, :3] - rotation).max() < 1e-6 for pose in answer.poses]
    assert answer.multiple[at_truth].tolist() == [True]
    assert answer.singular == answer.paths


def test_a_pose_far_from_where_planes_meet_is_not_taken_for_a_multiple_one() -> None:
    problem = problem_number("plane2+plane2+plane2", "loose", 1, 10)
    normals = np.array([f.direction for f in problem.features])
    meeting = np.linalg.solve(normals, np.sum(normals * [f.point for f in problem.features], axis=1))
    assert np.linalg.norm(meeting - problem.features[0].point) > 1000
    answer = solved(problem)
    assert all(stiffness(problem, pose) > 1e-3 for pose in answer.poses)
    assert not answer.multiple.any()


def test_a_root_missing_from_the_start_is_detected(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = pose_oracle.start_of
    monkeypatch.setattr(
        pose_oracle, "start_of", lambda kind, number: replace(whole(kind, number), roots=whole(kind, number).roots[:-1])
    )
    problem = random_problem("sphere2+sphere2+sphere2", np.random.default_rng(2))
    assert solved(problem).suspicious > 0


def test_a_kind_is_named_whatever_the_order() -> None:
    assert (
        kind_of([("plane", 1), ("sphere", 2), ("cylinder", 1), ("cylinder", 2)]) == "cylinder2+cylinder1+sphere2+plane1"
    )
    with pytest.raises(ValueError, match="six contacts"):
        feature_list("sphere2+sphere2")


def test_unanswerable_problems_are_rejected() -> None:
    problem = random_problem("sphere2+sphere2+sphere2", np.random.default_rng(2))
    with pytest.raises(ValueError, match="same for all contacts"):
        all_real_poses(oracle_features(problem), problem.feature_of_contact, problem.points, problem.rho + np.arange(6))
    with pytest.raises(ValueError, match="no solved problem of kind"):
        all_real_poses(oracle_features(problem)[:1], [0] * 6, problem.points, np.full(6, problem.rho[0]))


@pytest.mark.parametrize(
    ("kind", "layout", "number", "count"),
    [
        ("cylinder4+sphere2", "symmetric", 21, 16),
        ("cylinder3+cylinder3", "symmetric", 49, 24),
        ("cylinder3+cylinder3", "loose", 83, 12),
        ("cylinder3+cylinder3", "mixed", 77, 64),
    ],
    ids=str,
)
def test_the_package_finds_poses_with_the_smallest_basins(kind: str, layout: str, number: int, count: int) -> None:
    """Two of these poses each, well conditioned and far from all others, are reached from one start in thousands."""
    problem = problem_number(kind, layout, 1, number)
    oracle = solved(problem)
    found = poses_of_package(problem)
    assert len(oracle.poses) == count
    assert all(np.abs(found - pose).max(axis=(1, 2)).min() < 1e-5 for pose in oracle.poses)
    assert len(found) == count


def test_the_package_keeps_determined_poses_next_to_free_ones() -> None:
    """At the mirror image of these contacts a motion is free; at the true pose and one other pose none is."""
    problem = problem_number("sphere2+plane3+plane1", "symmetric", 1, 662)
    oracle = solved(problem)
    firm = oracle.poses[~oracle.multiple]
    assert len(firm) == 2
    assert min(stiffness(problem, pose) for pose in firm) > 1e-3
    found = poses_of_package(problem)
    assert all(np.abs(found - pose).max(axis=(1, 2)).min() < 1e-5 for pose in firm)
    assert sum(stiffness(problem, pose) < 1e-9 for pose in found) == 8


def test_the_package_takes_the_scatter_around_a_multiple_pose_for_one_pose() -> None:
    """Four multiple poses, around which descents end in dozens of places: no motion is free."""
    problem = problem_number("cylinder4+plane2", "axis-parallel", 1, 128)
    oracle = solved(problem)
    assert (len(oracle.poses), int(oracle.multiple.sum())) == (24, 4)
    found = poses_of_package(problem)
    assert len(found) == 24
    assert all(np.abs(found - pose).max(axis=(1, 2)).min() < 1e-5 for pose in oracle.poses[~oracle.multiple])
    assert all(np.abs(found - pose).max(axis=(1, 2)).min() < 0.1 for pose in oracle.poses[oracle.multiple])
