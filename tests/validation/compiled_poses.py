"""real_poses.polished and is_multiple as compiled loops; together with compiled_paths the compiled method."""

import numpy as np

from tests.validation import compiled_paths
from tests.validation.compiled import compiled
from tests.validation.compiled_paths import TYPE_NUMBER
from tests.validation.pose_oracle import Method
from tests.validation.study_forms import Problem


def polished(problem: Problem, pose: np.ndarray) -> tuple[np.ndarray, float]:
    """The pose after damped Gauss-Newton steps on the six distances, and the largest remaining distance."""
    pose = np.array(pose, order="C")
    return pose, _polish(_numbers(problem), pose, 60)


def is_multiple(problem: Problem, pose: np.ndarray) -> bool:
    """Whether the Jacobian of the six distances is singular to the accuracy of an end of a path."""
    jacobian = np.zeros((6, 6))
    _distances(_numbers(problem), np.ascontiguousarray(pose), np.zeros(6), jacobian)
    middle = (problem.contacts.mean(axis=0) - pose[:3, 3]) @ pose[:3, :3]
    jacobian[:, :3] -= np.cross(-jacobian[:, 3:], middle)
    values = np.linalg.svd(jacobian, compute_uv=False)
    return bool(values[-1] < 1e-6 * values[0])


def _numbers(problem: Problem) -> tuple[np.ndarray, ...]:
    feature = np.array(problem.feature_of_contact)
    types = np.array([TYPE_NUMBER[t] for t in problem.types])[feature]
    radius = np.sqrt(problem.squared_radius)
    rows = (problem.place[feature], problem.direction[feature], radius[feature], problem.contacts)
    return types, *(np.ascontiguousarray(row, dtype=float) for row in rows)


@compiled
def _distances(numbers, pose, off, jacobian):
    """Distances (6,) of the contacts, and their derivatives (6, 6) by R -> R exp([w]), t -> t + R v, in place."""
    types, place, direction, radius, contacts = numbers
    y, arm, g = np.zeros(3), np.zeros(3), np.zeros(3)
    for i in range(6):
        for k in range(3):
            y[k] = 0.0
            for m in range(3):
                y[k] += pose[m, k] * (contacts[i, m] - pose[m, 3])
        s = direction[i]
        along = 0.0
        for k in range(3):
            arm[k] = y[k] - place[i, k]
            along += arm[k] * s[k]
        if types[i] == 0:
            off[i] = along
            g[:] = s
        else:
            if types[i] == 2:
                arm -= along * s
            length = np.sqrt(arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2])
            off[i] = length - radius[i]
            g[:] = arm / max(length, 1e-300)
        jacobian[i, 0] = g[1] * y[2] - g[2] * y[1]
        jacobian[i, 1] = g[2] * y[0] - g[0] * y[2]
        jacobian[i, 2] = g[0] * y[1] - g[1] * y[0]
        for k in range(3):
            jacobian[i, 3 + k] = -g[k]


@compiled
def _polish(numbers, pose, steps):
    """real_poses.polished, the pose in place."""
    off, trial_off = np.zeros(6), np.zeros(6)
    jacobian, trial_jacobian = np.zeros((6, 6)), np.zeros((6, 6))
    trial = pose.copy()
    damping = 1e-6
    _distances(numbers, pose, off, jacobian)
    for _ in range(steps):
        normal = jacobian.T @ jacobian
        for k in range(6):
            normal[k, k] += damping
        step = np.linalg.solve(normal, -(jacobian.T @ off))
        _move(pose, step, trial)
        _distances(numbers, trial, trial_off, trial_jacobian)
        if np.sqrt((trial_off**2).sum()) < np.sqrt((off**2).sum()):
            pose[:] = trial
            off[:] = trial_off
            jacobian[:] = trial_jacobian
            damping = max(0.1 * damping, 1e-15)
        else:
            damping *= 10
        if damping > 1e3 or np.sqrt((step**2).sum()) < 1e-15:
            break
    return np.abs(off).max()


@compiled
def _move(pose, step, moved):
    """moved (4, 4): the pose, then the rotation by quaternion (1, w / 2) and the shift, in its own frame."""
    a, b, c, d = 1.0, 0.5 * step[0], 0.5 * step[1], 0.5 * step[2]
    n = a * a + b * b + c * c + d * d
    turn = np.zeros((3, 3))
    turn[0, 0], turn[0, 1], turn[0, 2] = a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)
    turn[1, 0], turn[1, 1], turn[1, 2] = 2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)
    turn[2, 0], turn[2, 1], turn[2, 2] = 2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d
    for i in range(3):
        for k in range(3):
            moved[i, k] = (pose[i, 0] * turn[0, k] + pose[i, 1] * turn[1, k] + pose[i, 2] * turn[2, k]) / n
        moved[i, 3] = pose[i, 3] + pose[i, 0] * step[3] + pose[i, 1] * step[4] + pose[i, 2] * step[5]
    for k in range(4):
        moved[3, k] = pose[3, k]


COMPILED = Method(compiled_paths.track, compiled_paths.gradients, polished, is_multiple)
