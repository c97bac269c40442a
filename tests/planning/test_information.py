"""The criteria against plain linear algebra, and against their definitions by points of the fixture."""

import numpy as np
import pytest

from tactfix.acceptance import point_covariance, worst_sigma
from tactfix.geometry.arrays import unit
from tactfix.planning.information import CRITERIA, Objective, rows_of, smallest_eigenvalues

CENTRE, RADIUS = np.array([40.0, -20.0, 7.0]), 90.0


def random_rows(count, seed):
    rng = np.random.default_rng(seed)
    points = CENTRE + RADIUS * rng.uniform(-1, 1, (count, 3))
    normals = unit(rng.standard_normal((count, 3)))
    return points, normals, rows_of(points, normals, np.full(count, 0.02), CENTRE, RADIUS)


def corners():
    return np.random.default_rng(5).uniform(-1, 1, (8, 3))


def plainly(criterion, information):
    if criterion == "d":
        return -np.log(np.linalg.det(information))
    if criterion == "e":
        return -np.linalg.eigvalsh(information)[0]
    covariance = np.linalg.inv(information)
    worst = 0.0
    for x, y, z in corners():
        jacobian = np.array([[0, z, -y, 1, 0, 0], [-z, 0, x, 0, 1, 0], [y, -x, 0, 0, 0, 1]])
        worst = max(worst, np.linalg.eigvalsh(jacobian @ covariance @ jacobian.T)[-1])
    return worst


@pytest.mark.parametrize("criterion", CRITERIA)
def test_scores_are_those_of_the_whole_sum(criterion):
    _, _, rows = random_rows(40, 1)
    information = rows[:9].T @ rows[:9]
    objective = Objective(criterion, corners(), 0.02)
    scores = objective.scores(information, rows)
    for row, score in zip(rows, scores, strict=True):
        assert np.isclose(score, plainly(criterion, information + np.outer(row, row)), rtol=1e-5)
    assert np.isclose(objective.score(information), plainly(criterion, information), rtol=1e-5)


@pytest.mark.parametrize("criterion", CRITERIA)
def test_five_contacts_and_one_are_scored_through_the_singular_sum(criterion):
    _, _, rows = random_rows(30, 2)
    information = rows[:5].T @ rows[:5]
    scores = Objective(criterion, corners(), 0.02).scores(information, rows[5:])
    expected = [plainly(criterion, information + np.outer(row, row)) for row in rows[5:]]
    assert np.allclose(scores, expected, rtol=1e-2)
    assert np.argmin(scores) == np.argmin(expected)


def test_the_smallest_eigenvalue_of_an_update_also_where_it_does_not_move():
    information = np.diag([1.0, 1.0, 2.0, 3.0, 4.0, 5.0])
    rows = np.array([[0, 0, 1.0, 0, 0, 0], [1, 0, 0, 0, 0, 0], [0.3, 0.4, 0.1, 0.5, 2, 1], [0, 0, 0, 0, 0, 0]])
    expected = [np.linalg.eigvalsh(information + np.outer(row, row))[0] for row in rows]
    assert np.allclose(smallest_eigenvalues(information, rows), expected, atol=1e-6)
    information = np.diag([1.0, 1.5, 2.0, 3.0, 4.0, 5.0])
    expected = [np.linalg.eigvalsh(information + np.outer(row, row))[0] for row in rows]
    assert np.allclose(smallest_eigenvalues(information, rows), expected, atol=1e-6)


def test_the_worst_score_is_the_variance_by_the_covariance_of_the_pose():
    """Scaled rows about the middle of the fixture, against the pose covariance about its origin."""
    points, normals, rows = random_rows(10, 3)
    plain = np.hstack([np.cross(points, normals), normals]) / 0.02
    covariance = np.linalg.inv(plain.T @ plain)
    expected = worst_sigma(point_covariance(np.eye(4), covariance, CENTRE + RADIUS * corners())).max()
    assert np.isclose(np.sqrt(Objective("worst", corners(), 0.02).score(rows.T @ rows)), expected, rtol=1e-6)


def test_no_point_of_the_box_is_known_worse_than_its_worst_corner():
    _, _, rows = random_rows(7, 4)
    box = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    inside = np.random.default_rng(6).uniform(-1, 1, (500, 3))
    of_box, of_inside = (Objective("worst", points, 0.02).score(rows.T @ rows) for points in (box, inside))
    assert of_inside <= of_box


def test_rows_are_the_change_of_the_residuals():
    """Finite differences of the signed distance under motions of the fixture."""
    points, normals, _ = random_rows(5, 7)
    rows = rows_of(points, normals, np.ones(5), np.zeros(3), 1.0)
    step = 1e-6
    for k in range(6):
        turn, shift = np.zeros(3), np.zeros(3)
        (turn if k < 3 else shift)[k % 3] = step
        moved = points + np.cross(turn, points) + shift
        change = np.einsum("ni,ni->n", moved - points, normals) / step
        assert np.allclose(rows[:, k], change, atol=1e-5)


@pytest.mark.parametrize("criterion", CRITERIA)
def test_ten_times_the_sigma_scores_as_ten_times_the_sigma(criterion):
    rng = np.random.default_rng(3)
    points, normals = rng.standard_normal((2, 9, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    sigmas = []
    for sigma in (0.01, 0.1):
        objective = Objective(criterion, np.eye(3), sigma)
        rows = rows_of(points, normals, np.full(9, sigma), np.zeros(3), 1.0)
        sigmas.append(objective.sigma_of(objective.score(rows.T @ rows)))
    assert sigmas[1] == pytest.approx(10 * sigmas[0], rel=1e-6)
