"""Whether one contact stands out of the others at a pose that fits them all together: Baarda's data snooping.

The sum of squared residuals hides one bad contact among many good ones. A normalised residual is a residual over its
own standard deviation after the fit, sigma_i sqrt(1 - h_i), h_i the leverage: for good contacts a standard normal
number, and of all tests for one wrong contact the most powerful (Baarda 1968, A testing procedure for use in geodetic
networks). Where relations have sigmas of their own the true leverage is larger: the residuals are normalised to less.

1. Residuals over sigma and their derivatives are taken at the pose, one equation each, with what is known beforehand.
2. Each is divided by what the fit leaves of its standard deviation, sqrt(1 - h_i) (`deletion`).
3. The largest stands out if noise exceeds it, among all of them, with less than the probability asked for.
4. To first order, the pose without that contact says how far it has moved the fixture.
"""

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.deletion import Doubts, span_of
from tactfix.fixture import Placement
from tactfix.geometry.arrays import Floats, Ints, cross
from tactfix.noise import normal_limit
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import SMALLEST_RATIO, contact_residuals, sensitivity, with_known
from tactfix.poses.solution import Solution


def normalized_residuals(
    contacts: Contacts, sigmas: Floats, solution: Solution, placement: Placement | None = None
) -> tuple[Floats, Ints]:
    """Sizes (m,) of the normalised residuals, and which contact (m,) each is of: three are of a contact on a point.

    sigmas (n,) of the residuals; placement: what is known of the pose beforehand.
    """
    single = one_equation_each(solution.surfaces, contacts, sigmas)  # step 1
    values, normals = contact_residuals(single.surfaces, single.contacts)
    seen = sensitivity(single.contacts, normals, single.sigmas)
    seen, more = with_known(seen, placement, solution.base_from_fixture)
    doubts = Doubts(np.concatenate([values / single.sigmas, more]), span_of(seen.reduced))
    return doubts.normalized[: len(single.of)], single.of  # step 2


def contact_that_stands_out(
    contacts: Contacts, sigmas: Floats, solution: Solution, probability: float, placement: Placement | None = None
) -> tuple[int, float] | None:
    """The index and the normalised residual of the worst contact, if noise exceeds that with less than probability."""
    sizes, of = normalized_residuals(contacts, sigmas, solution, placement)
    worst = int(np.argmax(sizes))  # step 3
    return (int(of[worst]), float(sizes[worst])) if sizes[worst] > normal_limit(len(sizes), probability) else None


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
