"""The accuracy of the pose from a set of contacts: covariance, extreme points, observability, influence of each.

All quantities are in the fixture frame; the true pose is the identity.

1. Rows [n, (x - c) x n] over sigma, for each contact at x with normal n, and those of a measured pose make up J.
2. The covariance of the pose is (J^T J)^-1, carried to the fixture's origin.
3. The sigma of each extreme point is the root of the largest eigenvalue of the covariance there.
4. The same without each contact in turn, by Woodbury's identity.
5. The singular vector with the smallest singular value is the motion that is determined worst.
6. The singular values of the contacts alone, all sigmas alike, give the observability indices (`Observability`).
"""

from dataclasses import replace

import numpy as np

from tactfix.acceptance import point_covariance
from tactfix.contacts import Contacts
from tactfix.design.nominal_contacts import Source, Touched
from tactfix.geometry.arrays import Floats, Frozen, Ints
from tactfix.geometry.scale import Tolerance
from tactfix.localization.free_motions import tidied
from tactfix.localization.motion_words import motion_in_words
from tactfix.placement import Placement
from tactfix.poses.placement_terms import terms_in_fixture
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import Sensitivity, contact_residuals, sensitivity
from tactfix.results import FreeMotion
from tactfix.values import frozen_value

_HERE = np.eye(4)
"""base_from_fixture of a design: base is the fixture frame."""


@frozen_value
class PointSigma:
    """A point (3,) of the fixture, and its largest standard deviation (units), along direction (3,)."""

    point: Frozen
    sigma: float
    direction: Frozen


@frozen_value
class Observability:
    """The observability indices of robot calibration, from the singular values (6,) of rows [n, (x - c) x n / length].

    If the placement constrains directions, the singular values are those of the other directions.

    length: rms distance of the contacts from their centroid c (units); it makes rotations and translations comparable.
    O1 = (product s)^(1/6) / sqrt(n), O2 = smin / smax, O3 = smin, O4 = smin^2 / smax, O5 = 1 / sum(1 / s).
    Sources: Menq and Borm (O1), Driels (O2), Nahvi (O3, O4), Sun and Hollerbach 2008 (O5 and the names).
    """

    singular_values: Frozen
    length: float
    contacts: int

    @property
    def indices(self) -> dict[str, float]:
        """O1 to O5; all 0 if a motion is free."""
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

    sigma_without is None if a motion is free without the contact.
    """

    label: str
    feature: str
    point: tuple[float, float, float]
    sigma_without: float | None


@frozen_value
class Certainty:
    """The accuracy of the pose. covariance (6, 6): d_rot (rad), d_t (units) about the fixture's origin.

    extreme: the extreme points of the fixture; worst: the one with the largest sigma; at: the points asked for;
    weakest: the motion with the largest sigma, one standard deviation of it; most and least: the contacts without which
    the worst sigma is largest and smallest.
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
        """The largest standard deviation of a rotation about any axis (rad)."""
        return float(np.sqrt(np.linalg.eigvalsh(self.covariance[:3, :3])[-1]))


def free_of(touched: Touched, tolerance: Tolerance) -> tuple[FreeMotion, ...]:
    """The motions that contacts and placement leave free, in words; empty if they determine the pose."""
    free = _sensitivity(touched, touched.placement).free_motions(np.zeros(3))
    motions = tidied(free) if len(free) else free
    return tuple(motion_in_words(motion, touched.surfaces, tolerance) for motion in motions)


def certainty(touched: Touched, at: Floats, tolerance: Tolerance, source: Source) -> Certainty:
    """The accuracy of the pose from contacts and placement that leave no motion free (`free_of`).

    at (m, 3): further points of the fixture whose sigma is computed.
    """
    contacts, placement, corners = touched.contacts, touched.placement, touched.corners
    seen = _sensitivity(touched, placement)  # step 1
    covariance = seen.covariance(np.zeros(3))  # step 2
    found = tuple(_sigma_at(covariance, corner) for corner in corners)  # step 3
    of = one_equation_each(touched.surfaces, contacts, touched.sigmas).of
    influences = _influences(contacts, seen, of, covariance, corners)  # step 4
    values, motions = seen.svd()  # step 5
    weakest = seen.twists(motions[-1:] / values[-1], np.zeros(3))[0]
    return Certainty(
        source=source,
        contacts=len(contacts),
        covariance=covariance,
        observability=_observability(touched),  # step 6
        worst=max(found, key=lambda point: point.sigma),
        extreme=found,
        at=tuple(_sigma_at(covariance, point) for point in at),
        weakest=motion_in_words(weakest, touched.surfaces, tolerance),
        most=max(influences, key=lambda i: np.inf if i.sigma_without is None else i.sigma_without),
        least=min(influences, key=lambda i: np.inf if i.sigma_without is None else i.sigma_without),
    )


def _sensitivity(touched: Touched, placement: Placement | None) -> Sensitivity:
    """The sensitivity of the contacts, and of a measured pose, to the motions that placement leaves free."""
    single = one_equation_each(touched.surfaces, touched.contacts, touched.sigmas)
    _, normals = contact_residuals(single.surfaces, single.contacts)
    seen = sensitivity(single.contacts, normals, single.sigmas)
    if placement is None:
        return seen
    basis, rows = terms_in_fixture(placement, placement.near, seen.centre, seen.scale)
    return Sensitivity(np.vstack([seen.jacobian, rows]), seen.centre, seen.scale, basis)


def _observability(touched: Touched) -> Observability:
    """The indices of the contacts alone, over the motions that placement does not constrain."""
    count = len(touched.contacts)
    constrained = None if touched.placement is None else replace(touched.placement, sigma=None, within=None)
    seen = _sensitivity(replace(touched, sigmas=np.ones(count)), constrained)
    return Observability(seen.svd()[0], seen.scale, count)


def _sigma_at(covariance: Floats, point: Floats) -> PointSigma:
    values, vectors = np.linalg.eigh(point_covariance(_HERE, covariance, point))
    return PointSigma(point, float(np.sqrt(max(values[-1], 0.0))), vectors[:, -1])


_NO_REDUNDANCY = 1e-9
"""1 - leverage (no unit) below which some motion is determined by the contact alone. In 2,000 random sets rounding
leaves 1e-15 at most with six contacts; with a seventh it is 2e-9 or more, 2e-3 in the median."""


def _influences(
    contacts: Contacts, seen: Sensitivity, of: Ints, covariance: Floats, corners: Floats
) -> list[Influence]:
    """The worst sigma of a corner without each contact in turn.

    Without the rows J of a contact the covariance C increases by C J^T (I - J C J^T)^-1 J C (Woodbury). J C J^T is the
    contact's leverage; it has an eigenvalue of 1 if the contact alone determines a motion. of: as in `Equations`.
    """
    # Rows about the fixture's origin, as the covariance; those of a measured pose come last and are left out.
    jacobian = seen.jacobian[: len(of)]
    rows = np.hstack([jacobian[:, :3] * seen.scale, np.zeros((len(jacobian), 3))])
    rows += np.hstack([np.cross(seen.centre, jacobian[:, 3:]), jacobian[:, 3:]])
    blocks = _by_contact(rows, of, len(contacts))
    gain = blocks @ covariance
    rest = np.eye(blocks.shape[1]) - gain @ np.swapaxes(blocks, 1, 2)
    lost = np.linalg.eigvalsh(rest)[:, 0] <= _NO_REDUNDANCY
    rest[lost] = np.eye(blocks.shape[1])
    without = covariance + np.swapaxes(gain, 1, 2) @ np.linalg.solve(rest, gain)
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
    """The rows (m, 6) by contact (count, k, 6), filled up with zeros."""
    place = np.arange(len(of)) - np.searchsorted(of, of)
    blocks = np.zeros((count, int(place.max(initial=0)) + 1, 6))
    blocks[of, place] = rows
    return blocks
