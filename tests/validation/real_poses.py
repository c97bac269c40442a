"""Real poses from complex roots: frames, refinement on the real distances, comparison of poses."""

from dataclasses import dataclass

import numpy as np

from tests.validation.study_forms import CYLINDER, PLANE, Problem, conjugate, quaternion_product


@dataclass(frozen=True)
class Gauge:
    """Frames near those of the start: x' = B (x - x0) / unit in base, y' = G (y - y0) / unit in the fixture."""

    base_turn: np.ndarray
    base_center: np.ndarray
    fixture_turn: np.ndarray
    fixture_center: np.ndarray
    unit: float

    def pose(self, turned: np.ndarray) -> np.ndarray:
        """base_from_fixture (4, 4) from the pose x' = R' y' + t'."""
        pose = np.eye(4)
        pose[:3, :3] = self.base_turn.T @ turned[:3, :3] @ self.fixture_turn
        moved = self.base_center + self.unit * self.base_turn.T @ turned[:3, 3]
        pose[:3, 3] = moved - pose[:3, :3] @ self.fixture_center
        return pose


def pose_of_root(root: np.ndarray) -> tuple[np.ndarray, float]:
    """The real part (4, 4) of the pose of a root z (8,), and the relative size of its imaginary part."""
    scaled = root / np.sqrt(root[:4] @ root[:4])
    q, u = scaled[:4], scaled[4:]
    t = 2 * quaternion_product(u, conjugate(q))[1:]
    imaginary = max(np.abs(q.imag).max(), np.abs(t.imag).max() / (1 + np.abs(t).max()))
    pose = np.eye(4)
    unit = q.real / np.linalg.norm(q.real)
    vectors = np.hstack([np.zeros((3, 1)), np.eye(3)])
    pose[:3, :3] = quaternion_product(quaternion_product(unit, vectors), conjugate(unit))[:, 1:].T
    pose[:3, 3] = t.real
    return pose, float(imaginary)


def distances_off(problem: Problem, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The distance (6,) of each contact from its feature at a pose, and its gradient (6, 3) in the fixture frame."""
    body = (problem.contacts - pose[:3, 3]) @ pose[:3, :3]
    off, gradients = np.zeros(6), np.zeros((6, 3))
    for i, (y, f) in enumerate(zip(body, problem.feature_of_contact, strict=True)):
        arm, s = y - problem.place[f], problem.direction[f]
        if problem.types[f] == PLANE:
            off[i], gradients[i] = arm @ s, s
            continue
        if problem.types[f] == CYLINDER:
            arm = arm - (arm @ s) * s
        length = np.linalg.norm(arm)
        off[i], gradients[i] = length - np.sqrt(problem.squared_radius[f]), arm / max(length, 1e-300)
    return off, gradients


def polished(problem: Problem, pose: np.ndarray, steps: int = 60) -> tuple[np.ndarray, float]:
    """The pose after damped Gauss-Newton steps on the six distances, and the largest remaining distance."""
    damping, off = 1e-6, distances_off(problem, pose)[0]
    for _ in range(steps):
        off, jacobian = _distances_and_jacobian(problem, pose)
        step = np.linalg.solve(jacobian.T @ jacobian + damping * np.eye(6), -jacobian.T @ off)
        trial = pose @ _exponential(step)
        if np.linalg.norm(distances_off(problem, trial)[0]) < np.linalg.norm(off):
            pose, damping = trial, max(0.1 * damping, 1e-15)
        else:
            damping *= 10
        if damping > 1e3 or np.linalg.norm(step) < 1e-15:
            break
    return pose, float(np.abs(distances_off(problem, pose)[0]).max())


def _distances_and_jacobian(problem: Problem, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The distances (6,) of the contacts at a pose, and their derivatives (6, 6) by R -> R exp([w]), t -> t + R v."""
    off, gradients = distances_off(problem, pose)
    body = (problem.contacts - pose[:3, 3]) @ pose[:3, :3]
    # y = R^T (x - t): dy = y cross w - v.
    return off, np.hstack([np.cross(gradients, body), -gradients])


def is_multiple(problem: Problem, pose: np.ndarray) -> bool:
    """Whether the Jacobian of the six distances is singular to the accuracy of an end of a path.

    Rotations are about the contacts' mean, because the fixture's origin, where planes meet, may be very far away.
    """
    gradients = distances_off(problem, pose)[1]
    body = (problem.contacts - pose[:3, 3]) @ pose[:3, :3]
    values = np.linalg.svd(np.hstack([np.cross(gradients, body - body.mean(axis=0)), gradients]), compute_uv=False)
    return bool(values[-1] < 1e-6 * values[0])


def _exponential(step: np.ndarray) -> np.ndarray:
    """The motion (4, 4) with the rotation vector step[:3] and the translation step[3:]."""
    q = np.concatenate([[1.0], 0.5 * step[:3]])
    q /= np.linalg.norm(q)
    motion = np.eye(4)
    vectors = np.hstack([np.zeros((3, 1)), np.eye(3)])
    motion[:3, :3] = quaternion_product(quaternion_product(q, vectors), conjugate(q))[:, 1:].T
    motion[:3, 3] = step[3:]
    return motion


def pose_gap(a: np.ndarray, b: np.ndarray) -> float:
    """The difference of two poses (4, 4): its largest entry, in the unit of the gauge."""
    return float(np.abs(a - b).max())
