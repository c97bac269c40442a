"""Touches of a reference ball: which they are, how well they determine its radius, and the best ball through some."""

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.feature import Feature
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats, Ints, lengths, unit
from tactfix.geometry.surfaces import Sphere
from tactfix.settings import ONE_FEATURE
from tactfix.wording import did_you_mean, listed

LEAST_RADIUS_PRECISION = 0.1
"""Least ratio of the radius' standard deviation from as many touches all round to that from these touches. Touches
spread evenly over a cap of 45 degrees half-angle have 0.1, over half the ball 0.5."""
LEAST_BALL = 10.0
"""Least radius of the best ball in sigma. Repeats of one place have a best ball as large as their own scatter; a ball
of 10 mm touched by a hand-guided robot of sigma 0.5 mm has 20 sigma."""
_BALL_STEPS = 10
"""Gauss-Newton steps of the best ball without outliers, from the ball with them; each squares the error."""


def radius_sigma(normals: Floats) -> float:
    """One standard deviation of the radius of the best ball over that of a touch; normals (n, 3) at the touches."""
    rows = np.hstack([normals, np.ones((len(normals), 1))])
    # The last entry of R: the norm of the part of the last column that the others do not span. For touches of one place
    # this is rounding.
    return 1.0 / max(abs(float(np.linalg.qr(rows).R[3, 3])), float(np.finfo(float).eps))


def unless_spread(radius: float, dilution: float, readings: Floats, dof: int) -> list[str]:
    """A warning if touches do not determine the radius of the ball: then it absorbs noise, and sigma is too small.

    dilution: the standard deviation of the radius over that of a touch.
    """
    sigma = float(np.sqrt((readings**2).sum() / dof))
    if LEAST_RADIUS_PRECISION * dilution * np.sqrt(len(readings)) <= 1 and radius >= LEAST_BALL * sigma:
        return []
    return [
        "the touches do not spread over the ball: neither sigma nor the radius of the tip is reliable; touch the "
        "ball from several sides, half of it or more, or give no radius if these are repeats of one place"
    ]


def about_best_ball(points: Floats, start: Sphere, kept: Ints) -> tuple[Floats, Floats]:
    """The distances of the kept touches from their own best ball, and their shares of variance (`AboutRest`)."""
    center, radius = start.center, start.radius
    for _ in range(_BALL_STEPS):
        arms = points[kept] - center
        rows = np.hstack([unit(arms), np.ones((len(kept), 1))])
        change = np.linalg.lstsq(rows, lengths(arms) - radius, rcond=None)[0]
        center, radius = center + change[:3], radius + change[3]
    arms = points[kept] - center
    directions = np.linalg.qr(np.hstack([unit(arms), np.ones((len(kept), 1))])).Q
    return (lengths(arms) - radius)[:, None], 1 - (directions**2).sum(axis=1)


def touches_of_ball(fixture: Fixture, contacts: Contacts, name: str | None = None) -> tuple[Feature, Contacts]:
    """The sphere that contacts touch, and the contacts on it; name: which one, if they touch several.

    Raises UsageError if they touch none, or several and name does not say which.
    """
    balls = [one for one, feature in fixture.features.items() if feature.type == "sphere"]
    if name is not None and name not in balls:
        raise UsageError(f"{fixture.name} has no sphere {name!r}; {did_you_mean(name, balls)}")
    touched = [one for one in balls if one in contacts.by_feature and name in (None, one)]
    if not touched:
        message = f"no contact touches {name or f'a sphere of {fixture.name}'}"
        raise UsageError(f"{message}; touch a ball of known radius from all sides")
    if len(touched) > 1:
        raise UsageError(f"the contacts touch {listed(touched)}, and one is the reference ball; " + ONE_FEATURE)
    return fixture.features[touched[0]], contacts.on(touched[0])
