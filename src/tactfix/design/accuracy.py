"""The accuracy of the pose from a set of contacts: covariance, extreme points, observability, influence of each.

Everything is in the fixture frame with the fixture standing at its origin, the true pose being the identity.

1. Rows [n, (x - c) x n] over sigma, for each contact at x with normal n, and those of a measured pose make up J.
2. The covariance of the pose is (J^T J)^-1, carried to the fixture's origin.
3. The sigma of each extreme point is the root of the largest eigenvalue of the covariance there.
4. The same without each contact in turn, by Woodbury's identity.
5. The singular vector with the smallest singular value is the motion that is determined worst.
6. The singular values of the contacts alone, all sigmas alike, give the observability indices (`Observability`).
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tactfix.acceptance import point_covariance
from tactfix.contacts import Contacts
from tactfix.design.nominal_contacts import Source
from tactfix.geometry.arrays import Floats, Frozen, Ints
from tactfix.geometry.scale import Tolerance
from tactfix.geometry.surfaces import Surface
from tactfix.localization.free_motions import tidied
from tactfix.localization.motion_words import twist_in_words
from tactfix.placement import Placement
from tactfix.poses.placement_terms import terms_in_fixture
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import Sensitivity, contact_residuals, sensitivity
from tactfix.results import FreeMotion
from tactfix.values import frozen_value

_HERE = np.eye(4)
"""base_from_fixture of a design: the fixture stands where its frame is base, and sigmas are in its own axes."""


@frozen_value
class PointSigma:
    """A point (3,) of the fixture: one standard deviation (units) along the direction (3,) that is known worst."""

    point: Frozen
    sigma: float
    direction: Frozen


@frozen_value
class Observability:
    """The indices of robot calibration, from the singular values (6,) of the rows [n, (x - c) x n / length], one each.

    Where directions are held there are fewer values, of the others.

    length: rms distance of the contacts from their centroid c (units); it makes rotations and translations comparable.
    O1 = (product s)^(1/6) / sqrt(n), O2 = smin / smax, O3 = smin, O4 = smin^2 / smax, O5 = 1 / sum(1 / s).
    Sources: Menq and Borm (O1), Driels (O2), Nahvi (O3, O4), Sun and Hollerbach 2008 (O5 and the names).
    """

    singular_values: Frozen
    length: float
    contacts: int

    @property
    def indices(self) -> dict[str, float]:
        """O1 to O5; all 0 where a motion is free."""
        s = self.singular_values
        if s[-1] <= 0:
            return dict.fromkeys(("O1", "O2", "O3", "O4", "O5"), 0.0)
        return {
            "O1": float(np.exp(np.log(s).mean()) / np.sqrt(self.contacts)),
            "O2": float(s[-1] / s[0]),
            "O3": float(s[-1]),
            "O4": float(s[-1] ** 2 / s[0]),
            "O5": float(1 / (1 / s).sum()),
        }


@frozen_value(eq=True)
class Influence:
    """A contact at point (3,) of the fixture frame, and the worst sigma of an extreme point without it.

    None where a motion is then free.
    """

    label: str
    feature: str
    point: tuple[float, float, float]
    sigma_without: float | None


@frozen_value
class Certainty:
    """What the contacts promise. covariance (6, 6): d_rot (rad), d_t (units) about the fixture's origin.

    extreme: the extreme points of the fixture, worst: the one that is known worst; at: the points asked for; weakest:
    the motion known worst, one standard deviation of it; most and least: the contacts whose loss costs most and least.
    """

    source: Source
    contacts: int
    covariance: Frozen
    observability: Observability
    worst: PointSigma
    extreme: tuple[PointSigma, ...]
    at: tuple[PointSigma, ...]
    weakest: FreeMotion
    most: Influence
    least: Influence

    @property
    def turn_sigma(self) -> float:
        """One standard deviation of the rotation known worst (rad)."""
        return float(np.sqrt(np.linalg.eigvalsh(self.covariance[:3, :3])[-1]))


def free_of(
    contacts: Contacts,
    surfaces: Mapping[str, Surface],
    sigmas: Floats,
    tolerance: Tolerance,
    placement: Placement | None = None,
) -> tuple[FreeMotion, ...]:
    """The motions that these contacts leave free beside placement, in words; none where they fix the pose.

    sigmas (n,) of the residuals.
    """
    free = _sensitivity(contacts, surfaces, sigmas, placement).free_motions(np.zeros(3))
    motions = tidied(free) if len(free) else free
    return tuple(_in_words(motion, surfaces, tolerance) for motion in motions)


def certainty(
    contacts: Contacts,
    surfaces: Mapping[str, Surface],
    sigmas: Floats,
    corners: Floats,
    at: Floats,
    tolerance: Tolerance,
    source: Source,
    placement: Placement | None = None,
) -> Certainty:
    """What contacts in the fixture frame promise beside placement, with sigmas (n,) of their residuals.

    corners (k, 3): the fixture's extreme points; at (m, 3): further points to tell. The contacts must leave no motion
    free (free_of).
    """
    seen = _sensitivity(contacts, surfaces, sigmas, placement)  # step 1
    covariance = seen.covariance(np.zeros(3))  # step 2
    found = tuple(_sigma_at(covariance, corner) for corner in corners)  # step 3
    of = one_equation_each(surfaces, contacts, sigmas).of
    influences = _influences(contacts, seen, of, covariance, corners)  # step 4
    values, motions = seen.svd()  # step 5
    weakest = seen.twists(motions[-1:] / values[-1], np.zeros(3))[0]
    return Certainty(
        source=source,
        contacts=len(contacts),
        covariance=covariance,
        observability=_observability(contacts, surfaces, placement),  # step 6
        worst=max(found, key=lambda point: point.sigma),
        extreme=found,
        at=tuple(_sigma_at(covariance, point) for point in at),
        weakest=_in_words(weakest, surfaces, tolerance),
        most=max(influences, key=lambda i: np.inf if i.sigma_without is None else i.sigma_without),
        least=min(influences, key=lambda i: np.inf if i.sigma_without is None else i.sigma_without),
    )


def _sensitivity(
    contacts: Contacts, surfaces: Mapping[str, Surface], sigmas: Floats, placement: Placement | None
) -> Sensitivity:
    """What the contacts see, and beside them a pose that was measured, of the motions that are not held."""
    single = one_equation_each(surfaces, contacts, sigmas)
    _, normals = contact_residuals(single.surfaces, single.contacts)
    seen = sensitivity(single.contacts, normals, single.sigmas)
    if placement is None:
        return seen
    basis, rows = terms_in_fixture(placement, placement.near, seen.centre, seen.scale)
    return Sensitivity(np.vstack([seen.jacobian, rows]), seen.centre, seen.scale, basis)


def _observability(contacts: Contacts, surfaces: Mapping[str, Surface], placement: Placement | None) -> Observability:
    """The indices of the contacts alone, over what is not held."""
    held = None if placement is None else replace(placement, sigma=None, within=None)
    seen = _sensitivity(contacts, surfaces, np.ones(len(contacts)), held)
    return Observability(seen.svd()[0], seen.scale, len(contacts))


def _sigma_at(covariance: Floats, point: Floats) -> PointSigma:
    values, vectors = np.linalg.eigh(point_covariance(_HERE, covariance, point))
    return PointSigma(point, float(np.sqrt(max(values[-1], 0.0))), vectors[:, -1])


_NO_REDUNDANCY = 1e-9
"""1 - leverage (no unit) below which the contact alone holds some motion. Of 2,000 random sets rounding leaves 1e-15
at most where six contacts are all there are; with a seventh it is 2e-9 or more, 2e-3 in the median."""


def _influences(
    contacts: Contacts, seen: Sensitivity, of: Ints, covariance: Floats, corners: Floats
) -> list[Influence]:
    """The worst sigma of a corner without each contact in turn.

    Taking the rows J away from the information adds C J^T (I - J C J^T)^-1 J C to the covariance C (Woodbury); J C J^T
    is the contact's leverage, with an eigenvalue of 1 where no other contact sees what it sees. of: as in `Equations`.
    """
    # Rows about the fixture's origin: the twist there is what the covariance is of.
    # Those of a measured pose come last and are no contact's.
    jacobian = seen.jacobian[: len(of)]
    rows = np.hstack([jacobian[:, :3] * seen.scale, np.zeros((len(jacobian), 3))])
    rows += np.hstack([np.cross(seen.centre, jacobian[:, 3:]), jacobian[:, 3:]])
    blocks = _by_contact(rows, of, len(contacts))
    told = blocks @ covariance
    rest = np.eye(blocks.shape[1]) - told @ np.swapaxes(blocks, 1, 2)
    lost = np.linalg.eigvalsh(rest)[:, 0] <= _NO_REDUNDANCY
    rest[lost] = np.eye(blocks.shape[1])
    without = covariance + np.swapaxes(told, 1, 2) @ np.linalg.solve(rest, told)
    worst = np.zeros(len(contacts))
    for corner in corners:
        variances = np.linalg.eigvalsh(point_covariance(_HERE, without, corner))[:, -1]
        worst = np.maximum(worst, variances)
    sigmas = np.sqrt(worst)
    return [
        Influence(contacts.label(i), feature, (x, y, z), None if lost[i] else float(sigmas[i]))
        for i, (feature, (x, y, z)) in enumerate(zip(contacts.features, contacts.points.tolist(), strict=True))
    ]


def _by_contact(rows: Floats, of: Ints, count: int) -> Floats:
    """The rows (m, 6) of each contact (count, k, 6), zeros behind where others have more."""
    place = np.arange(len(of)) - np.searchsorted(of, of)
    blocks = np.zeros((count, int(place.max(initial=0)) + 1, 6))
    blocks[of, place] = rows
    return blocks


def _in_words(twist: Floats, surfaces: Mapping[str, Surface], tolerance: Tolerance) -> FreeMotion:
    return FreeMotion(twist[:3], twist[3:], twist_in_words(twist[:3], twist[3:], surfaces, tolerance))
