"""Suspicious residuals at a pose that fits: one contact (Baarda's data snooping), or the tip's place in the flange.

Chi-square of many good contacts can hide one bad contact. A normalised residual is a residual over its own standard
deviation after the fit, sigma_i sqrt(1 - h_i), where h_i is the leverage. For a good contact it is a standard normal
number. Of all tests for one wrong contact this is the most powerful (Baarda 1968, A testing procedure for use in
geodetic networks). For relations with a sigma of their own the true leverage is larger than the one used here, so the
normalised residuals are too small and the test is conservative.

1. Residuals over sigma and their derivatives are taken at the pose, one equation each, with what is known beforehand.
2. Each is divided by sqrt(1 - h_i), its standard deviation after the fit (`deletion`). The three residuals of a contact
   on a point are a vector r_i of covariance I - H_ii. Its size, the root of r_i' (I - H_ii)^-1 r_i, is independent of
   the axes.
3. The contact whose size is largest relative to its limit is an outlier if noise exceeds that limit, over all contacts,
   with less than the given probability. The size squared is a chi-square with as many degrees of freedom as r_i has
   directions with a redundancy number above LEAST_REDUNDANCY.
4. The pose without that contact is computed to first order; the difference is how far the contact moved the fixture.

A tip that is displaced by q in the flange frame moves contact i by R_i q, where R_i is the rotation of the flange, and
changes its residual by n_i . R_i q. If the flange had different orientations, no motion of the fixture has the same
effect, and the least squares get three more columns:

5. Residuals and the columns n_i . R_i are projected onto the complement of the columns of the Jacobian of step 1.
6. If the projected columns are dependent, q is not determined; otherwise least squares give q.
7. q is compared with one wrong contact by the Bayesian information criterion (Schwarz 1978).
"""

import math

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.deletion import LEAST_REDUNDANCY, CaseDeletion, span_of
from tactfix.geometry.arrays import Floats, Ints, cross
from tactfix.noise import normal_limit
from tactfix.placement import Placement
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import SMALLEST_RATIO, Sensitivity, contact_residuals, sensitivity, with_known
from tactfix.poses.solution import Solution
from tactfix.values import frozen_value


@frozen_value
class _Linearized:
    """Equations of contacts and of a measured pose, to first order at a pose.

    residuals (m + k,): over sigma, those of the measured pose last; normals (m, 3); of (m,): the contact of each.
    """

    residuals: Floats
    sensitivity: Sensitivity
    normals: Floats
    sigmas: Floats
    of: Ints

    @property
    def deletion(self) -> CaseDeletion:
        return CaseDeletion(self.residuals, span_of(self.sensitivity.reduced))


def _linearized(contacts: Contacts, sigmas: Floats, solution: Solution, placement: Placement | None) -> _Linearized:
    single = one_equation_each(solution.surfaces, contacts, sigmas)  # step 1
    values, normals = contact_residuals(single.surfaces, single.contacts)
    seen, more = with_known(sensitivity(single.contacts, normals, single.sigmas), placement, solution.base_from_fixture)
    return _Linearized(np.concatenate([values / single.sigmas, more]), seen, normals, single.sigmas, single.of)


@frozen_value
class NormalizedResiduals:
    """sizes (n,) of the contacts' normalised residuals; directions (n,) in which each may differ from zero."""

    sizes: Floats
    directions: Ints

    def limits(self, probability: float) -> Floats:
        """The limits (n,) that noise alone makes any of them exceed with this probability."""
        count = len(self.sizes)
        by_directions = [normal_limit(count, probability, directions) for directions in (1, 1, 2, 3)]
        return np.array(by_directions)[self.directions]


@frozen_value
class StandsOut:
    """An outlier: index of the contact, size and limit of its normalised residual, number of its directions."""

    index: int
    size: float
    limit: float
    directions: int


def normalized_residuals(
    contacts: Contacts, sigmas: Floats, solution: Solution, placement: Placement | None = None
) -> NormalizedResiduals:
    """The normalised residuals at a pose.

    sigmas (n,) of the residuals; placement: what is known of the pose beforehand.
    """
    at_pose = _linearized(contacts, sigmas, solution, placement)
    deletion = at_pose.deletion
    first = np.flatnonzero(np.diff(at_pose.of, prepend=-1))  # step 2
    sizes, directions = deletion.normalized[first], np.ones(len(first), dtype=np.intp)
    on_point = np.flatnonzero(np.bincount(at_pose.of) == 3)
    equations = first[on_point, None] + np.arange(3)
    sizes[on_point], directions[on_point] = _lengths(deletion.scaled[equations], deletion.span[equations])
    return NormalizedResiduals(sizes, directions)


def _lengths(residuals: Floats, span: Floats) -> tuple[Floats, Ints]:
    """Lengths (k,) of residuals (k, 3) in the metric of their covariance I - span span', and its rank (k,)."""
    variances, axes = np.linalg.eigh(np.eye(3) - span @ np.swapaxes(span, 1, 2))
    along = np.einsum("kij,ki->kj", axes, residuals)
    lengths = np.sqrt((along**2 / np.maximum(variances, LEAST_REDUNDANCY)).sum(axis=1))
    return lengths, (variances > LEAST_REDUNDANCY).sum(axis=1)


def contact_that_stands_out(
    contacts: Contacts, sigmas: Floats, solution: Solution, probability: float, placement: Placement | None = None
) -> StandsOut | None:
    """The contact that is worst relative to its limit; None if it is within the limit for this probability."""
    found = normalized_residuals(contacts, sigmas, solution, placement)
    limits = found.limits(probability)
    worst = int(np.argmax(found.sizes / limits))  # step 3
    size, limit = float(found.sizes[worst]), float(limits[worst])
    return StandsOut(worst, size, limit, int(found.directions[worst])) if size > limit else None


def movement_without(
    contacts: Contacts, sigmas: Floats, solution: Solution, index: int, placement: Placement | None = None
) -> float:
    """The largest displacement of the fixture at any contact when one contact is deleted (to first order)."""
    others = contacts.subset(np.delete(np.arange(len(contacts)), index))
    at_pose = _linearized(others, np.delete(sigmas, index), solution, placement)
    seen = at_pose.sensitivity
    motion = -np.linalg.lstsq(seen.reduced, at_pose.residuals, rcond=SMALLEST_RATIO)[0]  # step 4
    motion = motion if seen.basis is None else seen.basis @ motion
    turn, shift = motion[:3] / seen.scale, motion[3:]
    moves = shift + cross(np.broadcast_to(turn, contacts.points.shape), contacts.points - seen.centre)
    return float(np.linalg.norm(moves, axis=1).max())


@frozen_value
class TipChange:
    """change (3,): of the tip, in the flange frame and fixture units; chi2: after the change.

    is_plausible: whether it explains the residuals no worse than deleting the worst contact does, by the Bayesian
    information criterion: log n for each free number, and twice log n for the choice of one contact.
    """

    change: Floats
    chi2: float
    is_plausible: bool


def tip_change(
    contacts: Contacts, sigmas: Floats, solution: Solution, placement: Placement | None = None
) -> TipChange | None:
    """The change of the tip that fits best; None if the contacts do not determine it. sigmas (n,) of the residuals."""
    assert contacts.flange_rotations is not None
    at_pose = _linearized(contacts, sigmas, solution, placement)
    deletion, count = at_pose.deletion, len(at_pose.of)
    rotations = contacts.flange_rotations[at_pose.of]
    columns = np.zeros((len(deletion.scaled), 3))
    columns[:count] = np.einsum("ni,nij->nj", at_pose.normals, rotations) / at_pose.sigmas[:, None]
    # Step 5.
    own: Floats = columns - deletion.span @ (deletion.span.T @ columns)
    left = deletion.scaled - deletion.span @ (deletion.span.T @ deletion.scaled)
    sizes = np.linalg.svd(own, compute_uv=False)  # step 6
    if sizes[-1] <= SMALLEST_RATIO * np.linalg.norm(columns):
        return None
    change = -np.linalg.lstsq(own, left, rcond=None)[0]
    rest = left + own @ change
    worst = float(deletion.normalized[:count].max())
    chi2, before = float(rest @ rest), float(left @ left)
    as_one = before - worst**2 + 3 * math.log(count)  # step 7
    return TipChange(np.asarray(change, dtype=np.float64), chi2, chi2 + 3 * math.log(count) <= as_one)
