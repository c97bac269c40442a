"""Path tracking: the roots of homogeneous equations along a path of problems, by a batched predictor-corrector in P7.

There are seven equations and eight unknowns: a step from z0 is taken in the affine patch z0^H (z - z0) = 0, and z is
then normalized to |z| = 1, so a root that goes to infinity needs no special treatment. A fourth-order Runge-Kutta step
predicts, two Newton steps correct; the first of them measures the error of the prediction and determines the next step
size. Each path has its own step size; all paths of a batch share every numpy call.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np


class Equations(Protocol):
    """An object that evaluates the equations, such as study_forms.ContactSystem."""

    def equations(self, z: np.ndarray, tau: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]: ...


@dataclass(frozen=True)
class Steps:
    """Step control: largest error of a prediction, largest ratio of the Newton steps; limits of size and number."""

    prediction: float = 3e-4
    contraction: float = 0.1
    smallest: float = 1e-7
    most: int = 300
    first: float = 0.05


def track(
    system: Equations, z: np.ndarray, begin: complex, end: complex, steps: Steps
) -> tuple[np.ndarray, np.ndarray]:
    """Follow roots (k, 8) from tau = begin to tau = end: their ends and the part of the path completed."""
    z = z / np.linalg.norm(z, axis=1, keepdims=True)
    part, step = np.zeros(len(z)), np.full(len(z), steps.first)
    active = np.arange(len(z))
    for _ in range(steps.most):
        if len(active) == 0:
            break
        h = np.minimum(step[active], 1.0 - part[active])
        moved, first, second = _step(system, z[active], begin, end - begin, part[active], h)
        fine = (first <= steps.prediction) & (second <= np.maximum(steps.contraction * first, 3e-7))
        with np.errstate(divide="ignore"):
            factor = 0.8 * (steps.prediction / np.maximum(first, 1e-300)) ** 0.2
        good = active[fine]
        z[good] = moved[fine] / np.linalg.norm(moved[fine], axis=1, keepdims=True)
        part[good] = np.where(h[fine] >= 1.0 - part[good], 1.0, part[good] + h[fine])
        step[active] = h * np.where(fine, np.clip(factor, 0.5, 4.0), np.clip(factor, 0.1, 0.5))
        active = active[(part[active] < 1.0) & (step[active] > steps.smallest)]
    arrived = part >= 1.0
    z[arrived] = _settled(system, z[arrived], end)
    return z, part


def _settled(system: Equations, z: np.ndarray, tau: complex) -> np.ndarray:
    """Roots (k, 8) after Newton steps to the accuracy of rounding; a step that is not small is rejected."""
    for _ in range(3):
        correction = newton_step(system, z, np.full(len(z), tau), z.conj())
        small = np.linalg.norm(correction, axis=1) < 1e-3
        z = np.where(small[:, None], z + correction, z)
        z = z / np.linalg.norm(z, axis=1, keepdims=True)
    return z


def _step(
    system: Equations, z0: np.ndarray, begin: complex, span: complex, part: np.ndarray, h: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One Runge-Kutta step of size h (k,) and two Newton steps: new z (k, 8) and the sizes of the Newton steps."""
    patch = z0.conj()
    tau0, tau1, tau2 = (begin + span * (part + c * h) for c in (0.0, 0.5, 1.0))
    dh = (span * h)[:, None]
    k1 = dh * _velocity(system, z0, tau0, patch)
    k2 = dh * _velocity(system, z0 + 0.5 * k1, tau1, patch)
    k3 = dh * _velocity(system, z0 + 0.5 * k2, tau1, patch)
    k4 = dh * _velocity(system, z0 + k3, tau2, patch)
    z = z0 + (k1 + 2 * (k2 + k3) + k4) / 6
    sizes = []
    for _ in range(2):
        correction = newton_step(system, z, tau2, patch)
        z = z + correction
        sizes.append(np.linalg.norm(correction, axis=1))
    return z, sizes[0], sizes[1]


def _velocity(system: Equations, z: np.ndarray, tau: np.ndarray, patch: np.ndarray) -> np.ndarray:
    """dz/dtau (k, 8) within the patch."""
    _, f_z, f_tau = system.equations(z, tau)
    return _solve(f_z, -f_tau, patch)


def newton_step(system: Equations, z: np.ndarray, tau: np.ndarray, patch: np.ndarray) -> np.ndarray:
    """The Newton step (k, 8) at fixed tau (k,) within the patch."""
    f, f_z, _ = system.equations(z, tau)
    return _solve(f_z, -f, patch)


def _solve(f_z: np.ndarray, right: np.ndarray, patch: np.ndarray) -> np.ndarray:
    """v (k, 8) with f_z v = right and patch . v = 0; nan if exactly singular, so that the step is rejected."""
    matrix = np.concatenate([f_z, patch[:, None, :]], axis=1)
    right = np.concatenate([right, np.zeros((len(right), 1))], axis=1)[..., None]
    try:
        return np.linalg.solve(matrix, right)[..., 0]
    except np.linalg.LinAlgError:
        return np.array([_solve_one(m, r) for m, r in zip(matrix, right, strict=True)])


def _solve_one(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    try:
        return np.linalg.solve(matrix, right)[:, 0]
    except np.linalg.LinAlgError:
        return np.full(8, np.nan + 0j)
