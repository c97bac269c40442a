"""The place of a seat, cone, nest or mark, which fixes the tip's centre: the mean of the contacts on it."""

import numpy as np

from tactfix.errors import DegenerateContactsError
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Point
from tactfix.values import frozen_value


@frozen_value
class PointCandidate:
    """The one place that contacts on a point allow; fields as of a `candidate.SurfaceCandidate`."""

    surface: Point
    chi2: float
    rms: float
    condition: float
    poorly_determined: bool = False


def localize_point(points: Floats, sigmas: Floats) -> tuple[PointCandidate, ...]:
    """The weighted mean p of tip centres points (n, 3): the least of the sum of |x_i - p|^2 / sigma_i^2.

    sigmas (n,), along each axis, in the same unit. The one candidate; its condition is 1, as no layout is degenerate.
    Raises DegenerateContactsError without any contact.
    """
    if not len(points):
        raise DegenerateContactsError("point", "no contact on it", 0.0, 1.0, "touch it once or more")
    weights = 1 / sigmas**2
    place = weights @ points / weights.sum()
    squares = ((points - place) ** 2).sum(axis=1)
    return (PointCandidate(Point(place), float(weights @ squares), float(np.sqrt(squares.mean())), 1.0),)
