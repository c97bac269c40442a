"""Whether one contact stands out of the others at a pose that fits them all together: Baarda's data snooping.

The sum of squared residuals hides one bad contact among many good ones. A normalised residual is a residual over its
own standard deviation after the fit, sigma_i sqrt(1 - h_i), h_i the leverage: for good contacts a standard normal
number, and of all tests for one wrong contact the most powerful (Baarda 1968, A testing procedure for use in geodetic
networks). Where relations have sigmas of their own the true leverage is larger: the residuals are normalised to less.

1. Residuals over sigma and their derivatives are taken at the pose, one equation each, with what is known beforehand.
2. Each is divided by what the fit leaves of its standard deviation, sqrt(1 - h_i) (`deletion`). The three of a contact
   on a point are a vector r_i of covariance I - H_ii, its size the root of r_i' (I - H_ii)^-1 r_i, whatever the axes.
3. The one stands out that is largest against its limit, if noise exceeds that, over all contacts, with less than the
   probability asked for: of a chi-square with as many degrees of freedom as r_i has directions that the fit leaves.
4. To first order, the pose without that contact says how far it has moved the fixture.
"""

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.deletion import SEEN, Doubts, span_of
from tactfix.fixture import Placement
from tactfix.geometry.arrays import Floats, Ints, cross
from tactfix.noise import normal_limit
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import SMALLEST_RATIO, contact_residuals, sensitivity, with_known
from tactfix.poses.solution import Solution
from tactfix.values import frozen_value


@frozen_value
class NormalizedResiduals:
    """sizes (n,) of the contacts' normalised residuals; directions (n,) in which each may differ from zero."""

    sizes: Floats
    directions: Ints

    def limits(self, probability: float) -> Floats:
        """What noise makes any of them exceed with this probability, (n,)."""
        count = len(self.sizes)
        by_directions = [normal_limit(count, probability, directions) for directions in (1, 1, 2, 3)]
        return np.array(by_directions)[self.directions]


@frozen_value
class StandsOut:
    """A contact (index), the size of its normalised residual, the limit for that, and the directions that it has."""

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
    single = one_equation_each(solution.surfaces, contacts, sigmas)  # step 1
    values, normals = contact_residuals(single.surfaces, single.contacts)
    seen = sensitivity(single.contacts, normals, single.sigmas)
    seen, more = with_known(seen, placement, solution.base_from_fixture)
    doubts = Doubts(np.concatenate([values / single.sigmas, more]), span_of(seen.reduced))
    first = np.flatnonzero(np.diff(single.of, prepend=-1))  # step 2
    sizes, directions = doubts.normalized[first], np.ones(len(first), dtype=np.intp)
    on_point = np.flatnonzero(np.bincount(single.of) == 3)
    equations = first[on_point, None] + np.arange(3)
    sizes[on_point], directions[on_point] = _lengths(doubts.scaled[equations], doubts.span[equations])
    return NormalizedResiduals(sizes, directions)


def _lengths(residuals: Floats, span: Floats) -> tuple[Floats, Ints]:
    """Lengths (k,) of residuals (k, 3) over their covariance I - span span', and directions that this leaves."""
    variances, axes = np.linalg.eigh(np.eye(3) - span @ np.swapaxes(span, 1, 2))
    along = np.einsum("kij,ki->kj", axes, residuals)
    lengths = np.sqrt((along**2 / np.maximum(variances, SEEN)).sum(axis=1))
    return lengths, (variances > SEEN).sum(axis=1)


def contact_that_stands_out(
    contacts: Contacts, sigmas: Floats, solution: Solution, probability: float, placement: Placement | None = None
) -> StandsOut | None:
    """The worst contact, if noise exceeds its normalised residual, over all of them, with less than probability."""
    found = normalized_residuals(contacts, sigmas, solution, placement)
    limits = found.limits(probability)
    worst = int(np.argmax(found.sizes / limits))  # step 3
    size, limit = float(found.sizes[worst]), float(limits[worst])
    return StandsOut(worst, size, limit, int(found.directions[worst])) if size > limit else None


def movement_without(
    contacts: Contacts, sigmas: Floats, solution: Solution, index: int, placement: Placement | None = None
) -> float:
    """How far the fixture moves at most, at any of the contacts, where one of them is left out (to first order)."""
    others = contacts.subset(np.delete(np.arange(len(contacts)), index))
    single = one_equation_each(solution.surfaces, others, np.delete(sigmas, index))
    values, normals = contact_residuals(single.surfaces, single.contacts)
    seen = sensitivity(single.contacts, normals, single.sigmas)
    seen, more = with_known(seen, placement, solution.base_from_fixture)
    scaled = np.concatenate([values / single.sigmas, more])
    motion = -np.linalg.lstsq(seen.reduced, scaled, rcond=SMALLEST_RATIO)[0]  # step 4
    motion = motion if seen.basis is None else seen.basis @ motion
    turn, shift = motion[:3] / seen.scale, motion[3:]
    moves = shift + cross(np.broadcast_to(turn, contacts.points.shape), contacts.points - seen.centre)
    return float(np.linalg.norm(moves, axis=1).max())
