"""The result of a localizer: surfaces through the contacts, their chi-square, and how well determined they are.

How well a state of a least-squares problem is determined (`determination`):

1. The singular vectors of the Jacobian give the weakest direction of the parameters.
2. The second difference of the residuals along it gives their curvature.
3. The condition is the inverse of the smallest singular value.
4. The state is poorly determined if noise of a few sigma can reach the double root that this curvature implies.
"""

from collections.abc import Callable, Iterable

import numpy as np

from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.geometry.surfaces import SidedSurface
from tactfix.noise import chi_square_limit
from tactfix.values import frozen_value


@frozen_value
class SurfaceCandidate:
    """One surface that explains the contacts; its radius is the given or found offset radius.

    chi2: sum of squared residuals over sigma, or over the rounding of the coordinates if there are no sigmas. rms: of
    the residuals, in the contacts' unit. condition: displacement of the least determined parameter over that of the
    contacts and known distances, lengths in units of the contacts' extent, angles in rad; infinite at a double root.
    poorly_determined: the surface is a double root, or so close to one that noise can merge it with its neighbour or
    make both complex.
    """

    surface: SidedSurface
    chi2: float
    rms: float
    condition: float
    poorly_determined: bool


ONE_ROOT = 1e-6
"""Distance of two states, in units of the contacts' extent and in rad, up to which they are one root reached twice: far
above the few 1e-9 that the last step of `least_squares` leaves, far below what noise distinguishes."""

PROBE = 1e-3
"""Step of the second difference, in problems of unit size: its rounding is 1e-16 / 1e-6 = 1e-10, its error of fourth
order 1e-6 of the curvature."""

_DOUBLE_ROOT_SIGMAS = 4.0
"""A state is poorly determined if noise of this many sigma merges it with a second root: good contacts exceed 4
sigma once in 16,000 cases."""


def determination(
    evaluate: Callable[[Floats, Ints], tuple[Floats, Floats]],
    step: Callable[[Floats, Floats], Floats],
    states: Floats,
    sigma: float,
) -> tuple[Floats, Bools]:
    """Condition (B,) and poorly determined (B,) of the states (B, q) of problems of unit size.

    Along the weakest direction v of the Jacobian, with singular value s and left vector u, the residuals run like
    s d + c d^2 / 2: a second root lies at d = -2 s / c, and noise of size s^2 / (2 c) along u merges both.
    """
    index: Ints = np.arange(len(states))
    residuals, jacobians = evaluate(states, index)
    u, singular, vh = np.linalg.svd(jacobians, full_matrices=False)  # step 1
    weakest, smallest = vh[:, -1], singular[:, -1]
    ahead, _ = evaluate(step(states, PROBE * weakest), index)  # step 2
    behind, _ = evaluate(step(states, -PROBE * weakest), index)
    curvature = np.einsum("bn,bn->b", u[:, :, -1], ahead + behind - 2 * residuals) / PROBE**2
    with np.errstate(divide="ignore"):
        condition = 1.0 / np.abs(smallest)  # step 3
    # Step 4.
    return condition, np.asarray(smallest**2 <= 2.0 * _DOUBLE_ROOT_SIGMAS * sigma * np.abs(curvature))


def candidates_of(
    surfaces: Iterable[SidedSurface], chi2: Floats, distances: Floats, condition: Floats, poor: Bools
) -> tuple[SurfaceCandidate, ...]:
    """The candidates of k surfaces with chi2, condition and poor (k,), residuals distances (k, n) (length)."""
    rms = np.sqrt(np.mean(distances**2, axis=1))
    columns = zip(surfaces, chi2.tolist(), rms.tolist(), condition.tolist(), poor.tolist(), strict=True)
    return tuple(SurfaceCandidate(*column) for column in columns)


def distinct_explanations(states: Floats, chi2: Floats, dof: int) -> list[int]:
    """Indices of the states (B, k) that noise can explain, best first, each root once.

    chi2 (B,): of their residuals, with dof degrees of freedom; of a redundant set the best state is always included.
    """
    kept: list[int] = []
    for i in np.argsort(chi2, kind="stable").tolist():
        explains = chi2[i] <= chi_square_limit(dof) or (dof > 0 and not kept)
        if explains and all(np.linalg.norm(states[i] - states[k]) > ONE_ROOT for k in kept):
            kept.append(i)
    return kept
