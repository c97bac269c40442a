"""Contacts at unit size about their mean, and the refusal of degenerate ones, by dimensionless ratios.

So tolerances apply in m, mm and um, near and far from the origin. Through degenerate contacts pass infinitely many
surfaces.
"""

import numpy as np

from tactfix.errors import DegenerateContactsError
from tactfix.geometry.arrays import EPS, TINY, Floats, Frozen, farthest_first
from tactfix.values import frozen_value

ROUNDING = 4 * EPS
"""Relative rounding of a coordinate after up to eight operations, of at most EPS / 2 each."""


def effective_sigmas(points: Floats, sigmas: Floats | float | None) -> Floats:
    """One standard deviation (n,) of each contact (n, 3), rounding of its coordinates included.

    sigmas: (n,), one number for all, or None for exact contacts.
    """
    rounding = ROUNDING * float(np.max(np.abs(points)))
    given = np.broadcast_to(0.0 if sigmas is None else np.asarray(sigmas, dtype=float), (len(points),))
    return np.asarray(np.hypot(given, max(rounding, TINY)))


@frozen_value
class UnitContacts:
    """points (n, 3) = (contacts - origin) / scale, with rms distance 1 from their mean.

    weights (n,): inverse to sigma, with mean square 1. sigma: one standard deviation of a weighted residual; rounding:
    of a residual, by that of the coordinates; both in units of scale.
    """

    points: Frozen
    weights: Frozen
    sigma: float
    origin: Frozen
    scale: float
    rounding: float


def unit_contacts(points: Floats, sigmas: Floats | float | None) -> UnitContacts:
    """The contacts (n, 3) with sigmas (n,), one number or None, at unit size."""
    deviations = effective_sigmas(points, sigmas)
    origin = points.mean(axis=0)
    centred = points - origin
    scale = float(np.sqrt(np.mean(np.sum(centred**2, axis=1)))) or 1.0
    # The equal sigma of all contacts that would give the same total information.
    common = float(1.0 / np.sqrt(np.mean(deviations**-2)))
    rounding = 16 * ROUNDING * float(np.max(np.abs(points))) / scale
    return UnitContacts(centred / scale, common / deviations, common / scale, origin, scale, rounding)


RATIO = 1e-7
"""Share of the contacts' extent within which a layout counts as degenerate, however small sigma is: the root of the
rounding of doubles. Below it, no digit of the result is left."""

_SIGMAS, _PLAIN = 3.0, 0.02
"""A layout is degenerate if its ratio is below _SIGMAS sigma (in units of the extent), which noise rarely exceeds; but
never if the ratio exceeds _PLAIN, however large sigma is."""


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
    """Raise if all contacts lie on one straight line."""
    _refuse_flat(kind, contacts, 1, "all contacts lie on one straight line", "touch off that line")


def refuse_coplanar(kind: str, contacts: UnitContacts) -> None:
    """Raise if all contacts lie in one plane."""
    _refuse_flat(kind, contacts, 2, "all contacts lie in one plane", "touch outside that plane")


def _refuse_flat(kind: str, contacts: UnitContacts, dimension: int, reason: str, remedy: str) -> None:
    """Raise if all contacts lie in a linear space of that dimension: the next singular value is below the limit."""
    spread = np.linalg.svd(contacts.points - contacts.points.mean(axis=0), compute_uv=False)
    ratio, bound = float(spread[dimension] / spread[0]), limit(contacts)
    if ratio <= bound:
        raise DegenerateContactsError(kind, reason, ratio, bound, remedy)


def refuse_two_parallel_lines(kind: str, contacts: UnitContacts) -> None:
    """Raise if all contacts lie on two parallel lines, one of which may have a single contact.

    Of any three contacts two share a line, so one of the three directions between three well spread contacts is the
    direction of the lines.
    """
    points, bound = contacts.points, limit(contacts)
    ratio = min(_spread_about_two_points(points, d) for d in _directions_of_three(points))
    if ratio <= bound:
        reason = "all contacts lie on two parallel lines, and a cylinder of any radius passes through those"
        raise DegenerateContactsError(kind, reason, ratio, bound, "touch off these lines, or give the radius")


def _directions_of_three(points: Floats) -> list[Floats]:
    """The three directions between three contacts that lie far apart."""
    first, second, third = points[farthest_first(points, 3)]
    arms = [second - first, third - first, third - second]
    return [arm / length for arm in arms if (length := np.linalg.norm(arm)) > 0]


def _spread_about_two_points(points: Floats, direction: Floats) -> float:
    """The largest distance of the contacts, projected along a direction, from the nearer of two of them."""
    flat = points - (points @ direction)[:, None] * direction
    first, second = flat[farthest_first(flat, 2)]
    return float(np.max(np.minimum(np.linalg.norm(flat - first, axis=1), np.linalg.norm(flat - second, axis=1))))
