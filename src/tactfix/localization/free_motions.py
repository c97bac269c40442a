"""Motions that the contacts leave free, or see so weakly that the answer is worthless."""

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import TINY, Floats
from tactfix.poses.solution import Solution, at_base_origin
from tactfix.results import FreeMotion

WORTHLESS_ANGLE = 0.1
"""Rad: a pose whose direction is not known to this (1 sigma) tells nothing, and linear statistics no longer hold."""
TOLD = 1e-6
"""Ratio below which a motion is told as a special one: a slide, or a rotation without advance."""
WORTHLESS_SHIFT = 0.25
"""The same for the place of a contact on its surface, as a share of the spread of the contacts."""
UNKNOWN_SHIFT = 10.0
"""Times the contacts' spread beyond which a sigma says no more than that noise alone holds the fixture; half a turn is
as much of a rotation."""


def is_worthless(solution: Solution, contacts: Contacts) -> bool:
    """Whether a motion is free, or known so badly that it might as well be, or too badly to say how badly."""
    if len(solution.free_twists) or not solution.trusted:
        return True
    turn, shift = solution.sigmas_at(contacts.centre)
    return turn > WORTHLESS_ANGLE or shift > WORTHLESS_SHIFT * contacts.spread


def free_motions(fixture: Fixture, contacts: Contacts, solution: Solution) -> tuple[FreeMotion, ...]:
    """The free motions at a solution, in base and in words; the weakest one where none is quite free."""
    if len(solution.free_twists):
        return tuple(in_words(fixture, solution, twist, "", contacts.spread) for twist in tidied(solution.free_twists))
    worst, shift = solution.sigmas_at(contacts.centre)
    note = f", known only to {np.degrees(worst):.2g} deg and {shift:.2g} {fixture.units} (1 sigma)"
    if worst > np.pi or shift > UNKNOWN_SHIFT * contacts.spread:
        note = ", which these contacts hardly resist"
    return (in_words(fixture, solution, _weakest(contacts, solution), note, contacts.spread),)


def _weakest(contacts: Contacts, solution: Solution) -> Floats:
    """The least known motion (6,) of the point at base's origin: the longest axis of the covariance.

    Rotations and translations are compared by how far they move the contacts.
    """
    origin = solution.base_from_fixture[:3, 3]
    arm = float(np.abs(contacts.points - origin).max())
    units = np.array([1, 1, 1, arm, arm, arm])
    axes = np.linalg.eigh(solution.covariance / np.outer(units, units))[1]
    return np.asarray(at_base_origin((axes[:, -1] * units)[None], origin)[0])


def in_words(fixture: Fixture, solution: Solution, twist: Floats, note: str, size_touched: float) -> FreeMotion:
    """The motion twist (6,) at base's origin, of unit size, named by the features; note follows its name.

    size_touched: of the touched part, a length: planes that all meet in one point have none of their own.
    """
    from tactfix.geometry.scale import Tolerance, tolerance_for  # located fixtures have no motion to name
    from tactfix.localization.motion_words import twist_in_words

    rotation, translation = twist[:3], twist[3:]
    turn = np.linalg.norm(rotation)
    size = turn if turn > 0 else np.linalg.norm(translation)
    own = tolerance_for(solution.surfaces, TOLD)
    tolerance = Tolerance(own.angle, max(own.length, TOLD * size_touched))
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
        # Without its slide along a free translation a cylinder turns instead of screwing.
        turning[:, 3:] -= np.outer(turning[:, 3:] @ direction, direction)
    return np.vstack([translations, turning])


def _orthonormal(vectors: Floats) -> Floats:
    return np.linalg.qr(vectors.T)[0].T if len(vectors) else vectors
