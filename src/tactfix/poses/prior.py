"""Poses compared with prior knowledge of the fixture's pose: limits, a measured pose, constrained directions.

1. d = (log R R_near^T, t - t_near) in base axes; C is the covariance of the pose.
2. Limits reject a pose if its angle or translation exceeds them by more than SURE of its own sigmas.
3. A measured pose with covariance C_near, and constrained directions, reject it if noise does not explain d:

    d' (C + C_near)^-1 d > the limit of chi-square,   C_near = 0 in constrained directions.
"""

import math
from typing import Protocol

import numpy as np

from tactfix.geometry.arrays import Floats, Ints
from tactfix.geometry.rigid import rotation_vectors
from tactfix.noise import SURE, chi_square_limit
from tactfix.placement import Placement
from tactfix.values import frozen_value


@frozen_value(eq=True)
class Contradiction:
    """Why a pose contradicts a placement, in words, and the ratio of its deviation to the allowed one."""

    message: str
    ratio: float


class LocatedPose(Protocol):
    """A pose (4, 4), its covariance (6, 6), and the free motions (k, 6)."""

    @property
    def base_from_fixture(self) -> Floats:
        """The pose (4, 4)."""

    @property
    def covariance(self) -> Floats:
        """Its covariance (6, 6): rotation (rad), translation, base axes, about the fixture's origin."""

    @property
    def free_twists(self) -> Floats:
        """Twists (k, 6) of its free motions."""


def deviation(placement: Placement, base_from_fixture: Floats) -> Floats:
    """The deviation (6,) of a pose from near: rotation vector (rad) and translation of the origin, base axes."""
    turn = base_from_fixture[:3, :3] @ placement.near[:3, :3].T
    return np.concatenate([rotation_vectors(turn[None])[0], base_from_fixture[:3, 3] - placement.near[:3, 3]])


def contradiction(placement: Placement, solution: LocatedPose, units: str, fitted: bool) -> Contradiction | None:
    """The contradiction of a pose, if any; fitted: the fit contained the measured pose and constraints."""
    off = deviation(placement, solution.base_from_fixture)  # step 1
    # Step 2.
    if placement.within is not None and (beyond := _beyond_limits(placement.within, off, solution.covariance, units)):
        return beyond
    known = _known_covariance(placement)  # step 3
    if known is None:
        return None
    if not fitted:
        # Contacts that leave a motion free cannot contradict a measured pose.
        return _beyond_chance(off, known + solution.covariance, units) if len(solution.free_twists) == 0 else None
    measured = np.flatnonzero(np.diag(known))
    return _beyond_chance(off, known, units, measured) if len(measured) else None


def _beyond_limits(within: tuple[float, float], off: Floats, covariance: Floats, units: str) -> Contradiction | None:
    """The contradiction by the worse of rotation and translation, if it is beyond its limit."""
    beyond = None
    for first, limit in ((3, within[0]), (0, within[1])):
        which = slice(first, first + 3)
        part = off[which].tolist()
        size = math.hypot(*part)
        ratio = _beyond_limit(size, limit, off[which], covariance[which, which]) if size > limit else 0.0
        if ratio > (1.0 if beyond is None else beyond.ratio):
            worst = int(np.argmax(np.abs(part)))
            words = f"it would be {amount(first, size, units)} from near, limit {amount(first, limit, units)}"
            beyond = Contradiction(f"{words}: {component(first + worst, part[worst], units)}", ratio)
    return beyond


def _beyond_limit(size: float, limit: float, part: Floats, covariance: Floats) -> float:
    """The ratio of the size of a rotation or translation (3,) of covariance (3, 3) to what a limit allows.

    Zero where a motion is free.
    """
    if not np.isfinite(covariance).all():
        return 0.0
    return size / (limit + SURE * math.sqrt(max(float(part @ covariance @ part), 0.0)) / size)


def _known_covariance(placement: Placement) -> Floats | None:
    """The covariance (6, 6) of near, zero in constrained directions; None if all are free and nothing was measured."""
    free = np.concatenate([placement.turns, placement.shifts])
    if placement.covariance is None:
        # A free direction without a measurement has an infinite variance.
        return None if free.all() else np.diag(np.where(free, np.inf, 0.0))
    return placement.covariance * np.outer(free, free)


def _beyond_chance(off: Floats, covariance: Floats, units: str, index: Ints | None = None) -> Contradiction | None:
    """The contradiction if components with a finite variance deviate more than noise explains."""
    asked = np.flatnonzero(np.isfinite(np.diag(covariance))) if index is None else index
    part, block = off[asked], covariance[np.ix_(asked, asked)]
    chi2, limit = float(part @ np.linalg.solve(block, part)), chi_square_limit(len(asked))
    if chi2 <= limit:
        return None
    sigmas = np.sqrt(np.diag(block))
    worst = int(np.argmax(np.abs(part) / sigmas))
    many = f"{abs(part[worst]) / sigmas[worst]:.3g} sigma"
    return Contradiction(
        f"it would be {component(int(asked[worst]), part[worst], units)} from near, {many}", chi2 / limit
    )


def component(number: int, value: float, units: str) -> str:
    """One of the six components of a motion in words: off by 3.02 mm along z."""
    return f"off by {amount(number, value, units)} {'about' if number < 3 else 'along'} {'xyz'[number % 3]}"


def amount(number: int, value: float, units: str) -> str:
    """The value of one of the six components of a motion with its unit, angles in degrees."""
    return f"{math.degrees(value):.4g} deg" if number < 3 else f"{value:.4g} {units}"
