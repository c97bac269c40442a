"""Descents: steps against normal equations solved by numpy, and ends against the conditions for an end."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tactfix.poses.descent import FEW_SYSTEMS, damped_step, descend, solve_positive, turned
from tactfix.poses.equations import curvature, evaluate, pose_equations
from tactfix.poses.starts import covering
from tactfix.poses.zeros import Zeros
from tests.support.problems import BALLS, touch_all


@pytest.mark.parametrize("count", [1, FEW_SYSTEMS - 1, FEW_SYSTEMS, 3 * FEW_SYSTEMS])
def test_positive_systems(count):
    rng = np.random.default_rng(count)
    halves = rng.normal(size=(count, 6, 6))
    matrices, rhs = halves @ halves.swapaxes(1, 2) + 0.1 * np.eye(6), rng.normal(size=(count, 6))
    found = solve_positive(np.moveaxis(matrices, 0, -1).copy(), rhs.T.copy())
    assert np.allclose(found.T, np.linalg.solve(matrices, rhs[..., None])[..., 0], rtol=1e-9, atol=1e-9)


def test_a_singular_system_among_few_does_not_raise():
    matrices = np.repeat(np.eye(6)[:, :, None], 3, axis=2)
    matrices[..., 1] = 0.0
    with np.errstate(over="ignore", invalid="ignore"):
        found = solve_positive(matrices, np.ones((6, 3)))
    assert np.allclose(found[:, [0, 2]], 1.0)


@pytest.mark.parametrize("count", [4, 2 * FEW_SYSTEMS])
def test_a_step_is_damped_and_no_longer_than_one_radian(count):
    rng = np.random.default_rng(count)
    residual, jacobian = rng.normal(size=(7, count)), rng.normal(size=(6, 7, count))
    damping = rng.uniform(0.01, 1.0, count)
    steps = damped_step(residual, jacobian, damping)
    for k in range(count):
        j = jacobian[:, :, k].T
        normal = j.T @ j
        wanted = -np.linalg.solve(normal + damping[k] * np.diag(np.diag(normal)), j.T @ residual[:, k])
        wanted /= max(1.0, np.linalg.norm(wanted[:3]))
        assert steps[:, k] == pytest.approx(wanted, rel=1e-6, abs=1e-9)


def test_cayley_turns():
    vectors = np.array([[0.2, -0.5, 0.1], [0.0, 0.0, 0.0], [30.0, 0.0, 0.0]]).T
    angles = 2 * np.arctan(np.linalg.norm(vectors, axis=0) / 2)
    axes = vectors / np.maximum(np.linalg.norm(vectors, axis=0), 1e-300)
    wanted = Rotation.from_rotvec((axes * angles).T).as_matrix()
    still = np.repeat(np.eye(3)[:, :, None], 3, axis=2)
    assert np.allclose(np.moveaxis(turned(vectors, still), -1, 0), wanted, atol=1e-14)


def ball_equations(seed):
    """Nine contacts on three balls, in units of 100 mm, in the fixture's own frame."""
    rng = np.random.default_rng(seed)
    truth = touch_all(BALLS, dict.fromkeys(BALLS, 3), rng, pose=np.eye(4), scale=0.01)
    surfaces = [patch.surface(0.01) for patch in BALLS.values()]
    index = [list(BALLS).index(name) for name in truth.names]
    return pose_equations(surfaces, index, truth.contacts().points, np.ones(9), 0.0)


def test_ends_are_zeros_and_what_is_left_above_the_limit_is_not_among_them():
    equations = ball_equations(5)
    rng = np.random.default_rng(6)
    rotations = np.moveaxis(Rotation.random(60, random_state=7).as_matrix(), 0, -1)
    offsets = rng.normal(size=(3, 60))
    before = rotations.copy(), offsets.copy()
    ends = descend(equations, rotations, offsets, 1e-12)
    assert 0 < len(ends) < 60
    assert np.allclose(ends.entries, np.concatenate([np.eye(3).ravel(), np.zeros(3)]), atol=1e-6)
    assert (ends.costs < 1e-12).all()
    assert (ends.counts == 1).all()
    assert np.array_equal(before[0], rotations)
    assert np.array_equal(before[1], offsets)
    assert len(descend(equations, rotations, offsets, np.inf)) == 60


@pytest.mark.parametrize("geometric", [False, True])
def test_curvature_completes_the_gauss_newton_hessian(geometric):
    """Against differences of the gradient of half the sum of squares, at random poses, for all types of features."""
    rng = np.random.default_rng(7)
    surfaces = [
        Plane(rng.normal(size=3), rng.normal(size=3)),
        Sphere(rng.normal(size=3), 0.7),
        Cylinder(rng.normal(size=3), rng.normal(size=3), 0.4),
    ]
    equations = pose_equations(surfaces, [0, 0, 1, 1, 2, 2, 2], rng.normal(size=(7, 3)), rng.uniform(1, 2, 7), 0.05)
    rotations = np.moveaxis(Rotation.random(4, random_state=1).as_matrix(), 0, -1)
    offsets = rng.normal(size=(3, 4))

    def gradient(step):
        vectors = np.repeat(step[:3, None], 4, axis=1)
        residual, jacobian = evaluate(equations, turned(vectors, rotations), offsets + step[3:, None], geometric)
        # The columns of the rotation are derivatives at the displaced pose; relative to the start, the map from
        # vectors to rotations contributes half a cross product to first order.
        slope = np.einsum("inN,nN->iN", jacobian, residual)
        slope[:3] += np.cross(slope[:3].T, step[:3]).T / 2
        return slope

    residual, jacobian = evaluate(equations, rotations, offsets, geometric)
    hessian = np.einsum("inN,jnN->ijN", jacobian, jacobian)
    hessian += curvature(equations, rotations, offsets, residual, geometric)
    for k in range(6):
        step = 1e-5 * np.eye(6)[k]
        change = (gradient(step) - gradient(-step)) / 2e-5
        assert np.allclose(change, hessian[:, k], rtol=1e-6, atol=1e-6)


ALONG_THE_AXES = np.array(
    [
        [-643.3481770648135, 650.0, 768.4787047133052],
        [-645.6698729810778, 637.3047157533383, 752.5],
        [-654.3301270189222, 662.7449836986957, 747.5],
        [-656.6436391841576, 650.0, 731.5071206141163],
        [-530.0309596445497, 800.0, 800.0],
        [-520.0, 799.9689909809194, 880.0],
    ]
)
"""Contacts with noise of 0.017 mm, four on a bar, one on a ball and one on a plane, with several nearly equal poses."""


def test_descents_along_curved_valleys_end():
    """Straight steps leave a curved valley after a thousandth of its length: 165 of 407 descents had not converged."""
    bar = Cylinder([0.5, 0.5, 1.0], [0.5, 0.0, np.sqrt(0.75)], 0.127)
    surfaces = [bar, Sphere([0.0, -1.0, 0.0], 0.2), Plane([-1.0, -1.0, -0.5], [0.0, 1.0, 0.0])]
    points = (ALONG_THE_AXES - ALONG_THE_AXES.mean(axis=0)) / 100
    equations = pose_equations(surfaces, [0, 0, 0, 0, 1, 2], points, np.ones(6), 0.0)
    limit = 50 * (0.017 / 100) ** 2
    ends = descend(equations, *covering(equations, 600, 0), limit, most_steps=100)
    kept = Zeros.none().joined(ends)
    assert len(ends) > 300
    assert len(kept) < 10
    assert np.sum(kept.costs < 1e-20) == 6


OPPOSITE = [[0.2435, -1.0234, 0.6755], [-0.2457, 1.0198, -0.683], [0.2512, -1.0226, 0.6759], [-0.249, 1.0262, -0.6684]]
"""Two opposite places on a ball of radius 1.25, each touched twice with a noise of 0.005."""


def test_descents_end_where_noise_makes_the_sum_of_squares_a_saddle():
    """Without noise the ball could turn about the line through both places; a third of Gauss-Newton descents ended."""
    equations = pose_equations([Sphere([-7.5, -10.0, 2.5], 1.25)], [0, 0, 0, 0], np.array(OPPOSITE), np.ones(4), 0.0)
    ends = descend(equations, *covering(equations, 300, 0), 0.001, most_steps=80)
    residual, jacobian = evaluate(equations, ends.rotations, ends.offsets, geometric=False)
    gradient = np.abs(np.einsum("inN,nN->iN", jacobian, residual)).max(axis=0)
    assert len(ends) > 290
    assert np.mean(gradient < 1e-8) > 0.95
