"""Degenerate contacts, through which infinitely many surfaces pass, recognized by dimensionless ratios.

All functions take contacts of unit size (`scaling`), so that the result is the same in m, mm and um.
"""

import numpy as np

from tactfix.errors import DegenerateContactsError
from tactfix.geometry.arrays import Floats
from tactfix.localizers.scaling import UnitContacts

RATIO = 1e-7
"""Share of the contacts' extent within which a layout counts as degenerate, however small sigma is: the root of the
rounding of doubles. Nearer, no digit of the result is left."""

_SIGMAS, _PLAIN = 3.0, 0.02
"""A layout is degenerate if its ratio is below _SIGMAS sigma (in units of the extent), since noise of good contacts
rarely exceeds three sigma; but never if the ratio exceeds _PLAIN, however large sigma is: it is then seen to be no
such layout."""


def limit(contacts: UnitContacts) -> float:
    """The ratio below which a layout counts as degenerate."""
    return max(RATIO, min(_SIGMAS * contacts.sigma, _PLAIN))


def refuse_coincident(kind: str, contacts: UnitContacts, needed: int) -> None:
    """Raise unless at least needed contacts lie at different places."""
    bound, points = limit(contacts), contacts.points
    places: list[Floats] = []
    nearest = np.inf
    for point in points:
        distance = min((float(np.linalg.norm(point - place)) for place in places), default=np.inf)
        if distance > bound:
            places.append(point)
        nearest = min(nearest, distance)
        if len(places) >= needed:
            return
    reason = f"{len(points)} contacts, but only {len(places)} different places, and {needed} are needed"
    raise DegenerateContactsError(kind, reason, nearest, bound, "touch somewhere else")


def refuse_collinear(kind: str, contacts: UnitContacts) -> None:
    """Raise when all contacts lie on one straight line."""
    spread = np.linalg.svd(contacts.points - contacts.points.mean(axis=0), compute_uv=False)
    ratio, bound = float(spread[1] / spread[0]), limit(contacts)
    if ratio <= bound:
        raise DegenerateContactsError(kind, "all contacts lie on one straight line", ratio, bound, "touch beside it")


def refuse_coplanar(kind: str, contacts: UnitContacts) -> None:
    """Raise when all contacts lie in one plane."""
    spread = np.linalg.svd(contacts.points - contacts.points.mean(axis=0), compute_uv=False)
    ratio, bound = float(spread[2] / spread[0]), limit(contacts)
    if ratio <= bound:
        raise DegenerateContactsError(kind, "all contacts lie in one plane", ratio, bound, "touch outside that plane")


def refuse_two_parallel_lines(kind: str, contacts: UnitContacts) -> None:
    """Raise when all contacts lie on two parallel lines, one of which may have a single contact.

    Of any three contacts two share a line, so one of the three directions between three well spread contacts is the
    direction of the lines.
    """
    points, bound = contacts.points, limit(contacts)
    ratio = min(_spread_about_two_points(points, d) for d in _directions_of_three(points))
    if ratio <= bound:
        reason = "all contacts lie on two parallel lines, and a cylinder of any radius passes through those"
        raise DegenerateContactsError(kind, reason, ratio, bound, "touch beside the lines, or give the radius")


def _directions_of_three(points: Floats) -> list[Floats]:
    """The three directions between three contacts that lie far apart."""
    first = points[np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1))]
    second = points[np.argmax(np.linalg.norm(points - first, axis=1))]
    nearer = np.minimum(np.linalg.norm(points - first, axis=1), np.linalg.norm(points - second, axis=1))
    third = points[np.argmax(nearer)]
    arms = [second - first, third - first, third - second]
    return [arm / length for arm in arms if (length := np.linalg.norm(arm)) > 0]


def _spread_about_two_points(points: Floats, direction: Floats) -> float:
    """The largest distance of the contacts, projected along a direction, from the nearer of two of them."""
    flat = points - (points @ direction)[:, None] * direction
    first = flat[np.argmax(np.linalg.norm(flat - flat.mean(axis=0), axis=1))]
    second = flat[np.argmax(np.linalg.norm(flat - first, axis=1))]
    return float(np.max(np.minimum(np.linalg.norm(flat - first, axis=1), np.linalg.norm(flat - second, axis=1))))
