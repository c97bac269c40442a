"""A pose that fits, with its uncertainty at each contact."""

from collections.abc import Mapping, Sequence
from typing import Generic, TypeAlias, TypeVar

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats, cross
from tactfix.geometry.rigid import skew
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Surface, offset_radius
from tactfix.poses.pose_fit import covariance_at
from tactfix.poses.sigma_points import Spread
from tactfix.results import Candidate
from tactfix.values import frozen_value

STILL = 1e-6
"""A free motion is taken to leave a contact in place if it displaces it by less than this share of the largest
displacement of any contact: far above rounding, and far below a displacement that a contact could show."""


@frozen_value
class Solution:
    """One pose of least chi-square, and its uncertainty.

    surfaces: the features in base. residuals (n,): along the outward normals. normals (n, 3): there. covariance (6,
    6): of (d_rot, d_t) in base axes about the fixture's origin, infinite where a motion is free. place_sigmas (n,):
    of each contact's place on its surface (length); normal_sigmas (n,): of the direction of the normal there (rad).
    free_twists (k, 6): free motions at base's origin. trusted: whether the covariance describes the pose
    (`sigma_points`).
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


Pose = TypeVar("Pose")


@frozen_value
class Found(Generic[Pose]):
    """The result of a search for poses, best chi-square first: fits, or solutions with their uncertainty.

    limit: the chi-square, with dof degrees of freedom, up to which a pose explains the contacts; if none does, the
    nearest misses are kept. complete: whether the search met its criteria of completeness. continuum: they are samples
    of a free motion. partial: some of many isolated poses, so that rejecting all of them proves nothing. fallen:
    combinations that explain the contacts of each feature and violate a relation. aside: for a measured pose, the
    further poses of the contacts alone, if these determine the pose; None if another search is needed for them.
    """

    found: tuple[Pose, ...]
    dof: int
    limit: float
    complete: bool
    continuum: bool
    partial: bool = False
    fallen: tuple[Candidate, ...] = ()
    aside: tuple[Pose, ...] | None = None


Solutions: TypeAlias = Found[Solution]
"""The poses that explain contacts, each with its uncertainty."""


_EQUAL_CHI2 = 1e-6
"""Difference of chi-squares, absolute or relative, up to which they are equal: least squares leave 1e-9 and less, and a
millionth of a sigma squared decides nothing."""


def in_order(found: Sequence[Solution]) -> tuple[Solution, ...]:
    """The solutions, best first; those of equal chi-square in the order of their entries.

    Exact simulated contacts fit mirror-symmetric poses equally: otherwise rounding would decide their order.
    """
    ordered = sorted(found, key=lambda solution: solution.chi2)
    ranks: list[int] = []
    for number, solution in enumerate(ordered):
        tied = number and solution.chi2 - ordered[ranks[-1]].chi2 <= _EQUAL_CHI2 * max(1.0, solution.chi2)
        ranks.append(ranks[-1] if tied else number)
    entries = [tuple(np.round(solution.base_from_fixture[:3].T.ravel(), 6)) for solution in ordered]
    return tuple(ordered[i] for i in sorted(range(len(ordered)), key=lambda i: (ranks[i], entries[i])))


def largest_sigma(covariance: Floats) -> float:
    """Largest standard deviation along a direction, of a covariance (3, 3); infinite if an entry is."""
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
    place, normal = place_and_normal_sigmas(surfaces, contacts, normals, origin, factor, moving)
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


def place_and_normal_sigmas(
    surfaces: Mapping[str, Surface], contacts: Contacts, normals: Floats, origin: Floats, factor: Floats, free: Floats
) -> tuple[Floats, Floats]:
    """Standard deviations of each contact's place on the fixture (n,), a length, and of its normal (n,), rad.

    A small motion of the fixture, rotation w and translation v about a point o, moves a point x of it by
    u = v + w x (x - o). The outward normal n below a tip that stays where it is turns by

        plane      w x n
        sphere     w x n - sign (I - n n^T) u / rho
        cylinder   w x n - sign e e^T u / rho,   e = axis x n,

    with rho the tip's distance from the centre or axis and sign -1 on an inner surface.

    factor (6, m): of the covariance factor factor^T of rotation and translation about origin (3,); free (6, k): free
    motions there. Infinite for a contact whose place or normal a free motion changes. Surfaces and outward normals
    (n, 3) in base.
    """
    places = np.concatenate(
        [-skew(contacts.points - origin), np.broadcast_to(np.eye(3), (len(contacts), 3, 3))], axis=2
    )
    turns = np.concatenate([-skew(normals), np.zeros((len(contacts), 3, 3))], axis=2)
    turns -= _curvatures(surfaces, contacts, normals) @ places
    place, normal = _spread(places @ factor), _spread(turns @ factor)
    if free.shape[1]:
        moves = _spread(places @ free)
        size = float(np.abs(contacts.points - contacts.centre).max()) or 1.0
        place = np.where(moves > STILL * moves.max(), np.inf, place)
        normal = np.where(_spread(turns @ free) > STILL * moves.max() / size, np.inf, normal)
    return place, normal


def _spread(motions: Floats) -> Floats:
    """Root sum of squares (n,) of all entries of motions (n, 3, m)."""
    return np.asarray(np.sqrt((motions**2).sum(axis=(1, 2))))


def _curvatures(surfaces: Mapping[str, Surface], contacts: Contacts, normals: Floats) -> Floats:
    """The matrices (n, 3, 3) from the translation of the surface at a contact to the change of its normal."""
    curvatures = np.zeros((len(contacts), 3, 3))
    for name, index in contacts.by_feature.items():
        surface = surfaces[name]
        if isinstance(surface, Plane | Point):
            continue
        own = normals[index]
        rho = offset_radius(name, surface.radius, surface.side, contacts.tip_radius)
        if isinstance(surface, Cylinder):
            around = cross(surface.direction, own)
            across = around[:, :, None] * around[:, None, :]
        else:
            across = np.eye(3) - own[:, :, None] * own[:, None, :]
        curvatures[index] = across * ((1.0 if surface.side == "outer" else -1.0) / rho)
    return curvatures
