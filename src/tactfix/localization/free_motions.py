"""Free motions of a solution, or the most weakly determined one, and whether a solution is underdetermined.

1. A solution is underdetermined if a motion is free, its covariance is not trusted, or a sigma exceeds its limit.
2. Free motions get a basis: pure translations first, then rotations without a part along these (`tidied`).
3. If none is free, the weakest motion is the longest axis of the covariance, rotations and translations compared by how
   far they move the contacts.
4. Each motion is named by features (`motion_words`).
"""

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import TINY, Floats
from tactfix.poses.solution import Solution, at_base_origin
from tactfix.results import FreeMotion

UNDERDETERMINED_ANGLE = 0.1
"""Largest sigma of rotation in rad of a pose that is reported. Beyond it the linear statistics fail: SURE times it
is 0.5 rad, at which the sine differs from the angle by 4 per cent."""
SPECIAL_MOTION = 1e-6
"""Ratio below which a motion is named as a special one, a pure translation or rotation: as
`geometry.scale.SPECIAL_POSITION`."""
UNDERDETERMINED_SHIFT = 0.25
"""Largest sigma of the place of the contacts' centre, as a share of their spread, of a pose that is reported: with four
sigma or more a contact could be anywhere on the fixture."""
UNBOUNDED_SHIFT = 10.0
"""Sigma, in spreads of the contacts, beyond which no number is given for a weak motion (half a turn for a rotation):
noise alone constrains it, and the linear sigma is meaningless."""


def is_underdetermined(solution: Solution, contacts: Contacts) -> bool:
    """Whether a motion is free, or determined worse than the limits, or without a covariance that can be trusted."""
    # Step 1.
    return bool(len(solution.free_twists)) or not solution.trusted or _exceeds_limits(solution, contacts)


def _exceeds_limits(solution: Solution, contacts: Contacts) -> bool:
    turn, shift = solution.sigmas_at(contacts.centre)
    return turn > UNDERDETERMINED_ANGLE or shift > UNDERDETERMINED_SHIFT * contacts.spread


def free_motions(fixture: Fixture, contacts: Contacts, solution: Solution) -> tuple[FreeMotion, ...]:
    """The free motions at a solution, in base and in words; the weakest one if none is free."""
    if len(solution.free_twists):  # steps 2 and 4
        return tuple(in_words(fixture, solution, twist, "", contacts.spread) for twist in tidied(solution.free_twists))
    worst, shift = solution.sigmas_at(contacts.centre)
    note = f", known only to {np.degrees(worst):.2g} deg and {shift:.2g} {fixture.units} (1 sigma)"
    if not _exceeds_limits(solution, contacts):
        # Near a fold the small sigma of the linear model does not say why there is no pose.
        note += " in the linear model; within the noise it is not valid, and the true pose may be farther off"
    if worst > np.pi or shift > UNBOUNDED_SHIFT * contacts.spread:
        note = ", which these contacts hardly constrain"
    return (in_words(fixture, solution, _weakest(contacts, solution), note, contacts.spread),)  # steps 3 and 4


def _weakest(contacts: Contacts, solution: Solution) -> Floats:
    """The most weakly determined motion (6,) of the point at base's origin (step 3)."""
    origin = solution.base_from_fixture[:3, 3]
    arm = float(np.abs(contacts.points - origin).max())
    units = np.array([1, 1, 1, arm, arm, arm])
    axes = np.linalg.eigh(solution.covariance / np.outer(units, units))[1]
    return np.asarray(at_base_origin((axes[:, -1] * units)[None], origin)[0])


def in_words(fixture: Fixture, solution: Solution, twist: Floats, note: str, size_touched: float) -> FreeMotion:
    """The motion twist (6,) at base's origin, of unit size, named by the features; note follows its name.

    size_touched: of the touched part, a length: planes that all meet in one point have no size.
    """
    from tactfix.geometry.scale import Tolerance, tolerance_for  # located fixtures have no motion to name
    from tactfix.localization.motion_words import twist_in_words

    rotation, translation = twist[:3], twist[3:]
    turn = np.linalg.norm(rotation)
    size = turn if turn > 0 else np.linalg.norm(translation)
    own = tolerance_for(solution.surfaces, SPECIAL_MOTION)
    tolerance = Tolerance(own.angle, max(own.length, SPECIAL_MOTION * size_touched))
    words = twist_in_words(rotation / size, translation / size, solution.surfaces, tolerance)
    return FreeMotion(rotation / size, translation / size, f"the fixture {words}{note}")


def tidied(twists: Floats) -> Floats:
    """A basis (k, 6) of the same motions, pure translations first with rotation exactly 0, then one per rotation."""
    rotations = twists[:, :3]
    u, values, _ = np.linalg.svd(rotations, full_matrices=True)
    rank = int((values > 1e-7 * max(float(np.abs(twists).max()), TINY)).sum())
    mixed = u.T @ twists
    translations, turning = mixed[rank:], mixed[:rank]
    translations[:, :3] = 0.0
    for direction in _orthonormal(translations[:, 3:]):
        # A rotation loses its part along a free translation: a cylinder rotates instead of screwing.
        turning[:, 3:] -= np.outer(turning[:, 3:] @ direction, direction)
    return np.vstack([translations, turning])


def _orthonormal(vectors: Floats) -> Floats:
    return np.linalg.qr(vectors.T)[0].T if len(vectors) else vectors
