"""Poses held against what is known of the fixture's place beforehand: limits, a measured pose, directions held.

With d = (log R R_near^T, t - t_near) in base axes and C the covariance of the pose, limits speak against it where the
angle or the translation is beyond them by SURE of its own sigmas; a measured pose of covariance C_near, and directions
that are held, where d is more than chance explains:

    d' (C + C_near)^-1 d > the limit of chi-square,   C_near = 0 in the directions that are held.
"""

from typing import Protocol

import numpy as np

from tactfix.fixture import Placement
from tactfix.geometry.arrays import TINY, Floats, Ints
from tactfix.noise import SURE, chi_square_limit
from tactfix.poses.pose_domain import turn_vectors
from tactfix.values import frozen_value


@frozen_value(eq=True)
class Contradiction:
    """A pose that what is known beforehand speaks against: in words, and by how many times what would be allowed."""

    message: str
    ratio: float


class LocatedPose(Protocol):
    """A pose (4, 4), its covariance (6, 6), and the motions (k, 6) that its contacts leave free."""

    @property
    def base_from_fixture(self) -> Floats:
        """The pose (4, 4)."""

    @property
    def covariance(self) -> Floats:
        """Of it (6, 6), in the order of a pose's."""

    @property
    def free_twists(self) -> Floats:
        """Motions (k, 6)."""


def deviation(placement: Placement, base_from_fixture: Floats) -> Floats:
    """How far (6,) a pose is from near: rotation vector (rad) and translation of the origin, base axes."""
    turn = base_from_fixture[:3, :3] @ placement.near[:3, :3].T
    return np.concatenate([turn_vectors(turn[None])[0], base_from_fixture[:3, 3] - placement.near[:3, 3]])


def contradiction(placement: Placement, solution: LocatedPose, units: str, fitted: bool) -> Contradiction | None:
    """What speaks against a pose; fitted: a measured pose and directions held were part of its fit."""
    off = deviation(placement, solution.base_from_fixture)
    if placement.within is not None and (beyond := _beyond_limits(placement.within, off, solution.covariance, units)):
        return beyond
    known = _known_covariance(placement)
    if known is None:
        return None
    if not fitted:
        # What the contacts leave free they do not contradict.
        return _beyond_chance(off, known + solution.covariance, units) if len(solution.free_twists) == 0 else None
    measured = np.flatnonzero(np.diag(known))
    return _beyond_chance(off, known, units, measured) if len(measured) else None


def _beyond_limits(within: tuple[float, float], off: Floats, covariance: Floats, units: str) -> Contradiction | None:
    """The worse of rotation and translation where it is beyond its limit."""
    shift_limit, turn_limit = within
    turn = _beyond_limit(off[:3], covariance[:3, :3], turn_limit)
    shift = _beyond_limit(off[3:], covariance[3:, 3:], shift_limit)
    if max(turn, shift) <= 1:
        return None
    first, part, limit = (0, off[:3], turn_limit) if turn > shift else (3, off[3:], shift_limit)
    worst = int(np.argmax(np.abs(part)))
    size = amount(first, float(np.linalg.norm(part)), units)
    words = f"it would be {size} from near, limit {amount(first, limit, units)}"
    return Contradiction(f"{words}: {component(first + worst, part[worst], units)}", max(turn, shift))


def _beyond_limit(part: Floats, covariance: Floats, limit: float) -> float:
    """By how many times a rotation or translation (3,) of covariance (3, 3) is beyond what a limit allows."""
    return float(np.linalg.norm(part)) / max(limit + SURE * _sigma_along(covariance, part), TINY)


def _sigma_along(covariance: Floats, vector: Floats) -> float:
    """The standard deviation of covariance (3, 3) along a vector (3,); infinite where an entry is."""
    if not np.isfinite(covariance).all():
        return float("inf")
    return float(np.sqrt(max(float(vector @ covariance @ vector), 0.0) / max(float(vector @ vector), TINY)))


def _known_covariance(placement: Placement) -> Floats | None:
    """The covariance (6, 6) of near, zero in the directions held; None where all are free and nothing was measured."""
    free = np.concatenate([placement.turns, placement.shifts])
    if placement.covariance is None:
        # Free directions that nobody measured may be anywhere.
        return None if free.all() else np.diag(np.where(free, np.inf, 0.0))
    return placement.covariance * np.outer(free, free)


def _beyond_chance(off: Floats, covariance: Floats, units: str, index: Ints | None = None) -> Contradiction | None:
    """Whether components with a finite variance are off by more than chance explains, and the one that is most."""
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
    return f"{np.degrees(value):.4g} deg" if number < 3 else f"{value:.4g} {units}"
