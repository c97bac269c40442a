"""A pose that fits, with everything that telling candidates apart and reporting need to know of it."""

from collections.abc import Mapping, Sequence

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats, cross
from tactfix.geometry.surfaces import Surface
from tactfix.poses.contact_certainty import contact_certainty
from tactfix.poses.pose_fit import covariance_at
from tactfix.poses.sigma_points import Spread
from tactfix.results import Candidate
from tactfix.values import frozen_value


@frozen_value
class Solution:
    """One pose of least chi-square, and how sure it is.

    surfaces: the features in base. residuals (n,): along the outward normals. normals (n, 3): there. covariance (6,
    6): of (d_rot, d_t) in base axes about the fixture's origin, infinite where a motion is free. place_sigmas (n,):
    of each contact's place on its surface (length); normal_sigmas (n,): of the direction of the normal there (rad).
    free_twists (k, 6): motions at base's origin that nothing resists. trusted: whether the covariance is true
    (`spread`).
    """

    base_from_fixture: Floats
    surfaces: Mapping[str, Surface]
    residuals: Floats
    normals: Floats
    chi2: float
    rms: float
    covariance: Floats
    place_sigmas: Floats
    normal_sigmas: Floats
    free_twists: Floats
    trusted: bool

    def sigmas_at(self, point: Floats) -> tuple[float, float]:
        """Worst standard deviations of rotation (rad) and of the place of a point (3,) of the fixture, in base."""
        covariance = covariance_at(self.covariance, point - self.base_from_fixture[:3, 3])
        return largest_sigma(covariance[:3, :3]), largest_sigma(covariance[3:, 3:])


@frozen_value
class Solutions:
    """All of them, best first. limit: the chi-square, with dof degrees of freedom, up to which a pose explains them.

    complete: whether the search is sure to have found all. continuum: so many that they are samples of a free motion.
    fallen: what fitted the contacts of each feature and broke a relation. aside: where the pose was measured and the
    contacts fix it by themselves, what they alone would leave beside those found; else None.
    """

    found: tuple[Solution, ...]
    dof: int
    limit: float
    complete: bool
    continuum: bool
    fallen: tuple[Candidate, ...] = ()
    aside: tuple[Solution, ...] | None = None


_EQUAL_CHI2 = 1e-6
"""Chi-squares closer than this, or than this share of them, do not say which pose is the better one."""


def in_order(found: Sequence[Solution]) -> tuple[Solution, ...]:
    """Best first; those that fit equally well but for rounding by their entries, so that the order is no accident.

    Contacts of a dry run hold mirror-symmetric poses exactly: the last digit would choose which of them leads.
    """
    ordered = sorted(found, key=lambda solution: solution.chi2)
    ranks: list[int] = []
    for number, solution in enumerate(ordered):
        tied = number and solution.chi2 - ordered[ranks[-1]].chi2 <= _EQUAL_CHI2 * max(1.0, solution.chi2)
        ranks.append(ranks[-1] if tied else number)
    entries = [tuple(np.round(solution.base_from_fixture[:3].T.ravel(), 6)) for solution in ordered]
    return tuple(ordered[i] for i in sorted(range(len(ordered)), key=lambda i: (ranks[i], entries[i])))


def largest_sigma(covariance: Floats) -> float:
    """Standard deviation in the worst direction of a covariance (3, 3); infinite where an entry is."""
    if not np.isfinite(covariance).all():
        return float("inf")
    return float(np.sqrt(max(np.linalg.eigvalsh(covariance)[-1], 0.0)))


def solution_from(
    base_from_fixture: Floats,
    surfaces: Mapping[str, Surface],
    contacts: Contacts,
    residuals: Floats,
    normals: Floats,
    chi2: float,
    spread: Spread,
) -> Solution:
    """A solution from the spread of its pose.

    With a free motion the covariance is infinite, and the sigmas of every contact that it moves.
    """
    factor, free = spread.factor, spread.free
    origin = base_from_fixture[:3, 3]
    moving = free[:, np.abs(free).max(axis=0) > 1e-9 * max(float(np.abs(free).max(initial=0.0)), 1e-300)]
    covariance = np.full((6, 6), np.inf) if moving.shape[1] else factor @ factor.T
    place, normal = contact_certainty(surfaces, contacts, normals, origin, factor, moving)
    return Solution(
        base_from_fixture=base_from_fixture,
        surfaces=surfaces,
        residuals=residuals,
        normals=normals,
        chi2=chi2,
        rms=float(np.sqrt(residuals @ residuals / len(residuals))),
        covariance=covariance,
        place_sigmas=place,
        normal_sigmas=normal,
        free_twists=at_base_origin(moving.T, origin),
        trusted=spread.trusted,
    )


def at_base_origin(twists: Floats, origin: Floats) -> Floats:
    """Twists (k, 6) of the point origin (3,) as twists of the point at base's origin."""
    return np.hstack([twists[:, :3], twists[:, 3:] - cross(twists[:, :3], origin)])
