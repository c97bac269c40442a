"""What a probe is good for, from touches of the same places or of a reference ball.

1. Of a ball of known radius the readings are the distances from the best sphere, form of ball and probe included, and
   the radius of the surface on which the tip's centres lie gives that of the tip.
2. Else touches of one feature, and of one target where those are said, are of one place.
3. Their readings are deviations from the mean of their place: along the approach where all contacts say it, else in all
   directions.
4. Sigma is the standard deviation of all readings, pooled over the places; outliers, a drift and a step are looked for
   in their sequence (`sequence`).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import NotQualifiedError, UsageError
from tactfix.feature import Feature
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats, Ints, lengths, unit
from tactfix.geometry.surfaces import Side, Sphere
from tactfix.localizers.sphere import localize_sphere
from tactfix.qualification.result import DirectionMean, QualifyResult
from tactfix.qualification.sequence import drift, interval, is_significant, outliers, step
from tactfix.settings import ONE_FEATURE
from tactfix.units import factor
from tactfix.wording import did_you_mean, listed

FEWEST_ON_BALL = 5
"""Touches of a ball that leave a degree of freedom beyond centre and radius."""
FEWEST_FOR_MAP = 25
"""Touches of a ball from which on means by direction are told."""
_ACROSS = 20.0
"""Times their spread along the approach, which touches of one place do not exceed across it: a machine returns to a
place about as well as its probe triggers there."""
_ONE_APPROACH = 0.2
"""rad between the approaches of touches of one place: a program repeats them, a hand keeps them
within some ten degrees."""
_APART_MM = 5.0
"""mm between touches of one place; the worst machine, and a hand-guided robot, returns closer than this."""
_CUBE = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)], dtype=np.float64)
BALL_DIRECTIONS = unit(_CUBE[np.isin(np.abs(_CUBE).sum(axis=1), (1, 3))])
"""Along the axes and between them (14, 3): where the mean of a ball's touches is told."""


def qualify(
    contacts: Contacts,
    *,
    targets: Sequence[str] | None = None,
    radius: float | None = None,
    side: Side = "outer",
    units: str = "",
) -> QualifyResult:
    """Qualify a probe from repeated touches, or from touches of a reference ball.

    Parameters
    ----------
    contacts : Contacts
        In the order in which they were made. Their sigmas and tip radius are not used.
    targets : sequence of str, optional
        What was touched, for each contact; touches of one feature and one target are of one place.
    radius : float, optional
        Of the reference ball that all contacts touch, in their unit.
    side : {"outer", "inner"}
        "outer" for a ball, "inner" for a socket.
    units : str
        What the contacts' unit is called in the result.

    Returns
    -------
    QualifyResult

    Raises
    ------
    NotQualifiedError
        Where no place is touched twice, or the ball fewer than five times.
    DegenerateContactsError
        Where all touches of the ball lie in one plane.

    Notes
    -----
    sigma^2 is the sum of squared residuals over dof, about each place's mean or the best ball; its 95 per cent interval
    is that of chi-square: dof s^2 / chi2(0.975) <= sigma^2 <= dof s^2 / chi2(0.025).

    References
    ----------
    .. [1] ISO 10360-5: touches of a reference sphere, and their range.

    Examples
    --------
    >>> touches = tactfix.contacts_from_arrays(
    ...     "top", [[0, 0, 0.01], [0, 0, -0.01], [0, 0, 0.02]], [[0, 0, -1]] * 3, sigma=1.0, tip_radius=0.0
    ... )
    >>> round(tactfix.qualify(touches).sigma, 4)
    0.0153
    """
    if radius is not None:
        return _of_ball(contacts, radius, side, units)  # steps 1 and 4
    places = _places(contacts, targets)  # step 2
    readings, warnings = _deviations(contacts, places)  # step 3
    dof = (len(readings) - len(places)) * readings.shape[1]
    if dof < 1:
        raise NotQualifiedError("no place is touched twice; touch one again, or give the radius of the reference ball")
    spans = [_span(readings[place]) for place in places]
    return _result(contacts, readings, places, dof, max(spans), warnings, units)  # step 4


def _result(
    contacts: Contacts,
    readings: Floats,
    places: Sequence[Ints],
    dof: int,
    span: float,
    warnings: list[str],
    units: str,
) -> QualifyResult:
    """What repeated touches and those of a ball tell alike."""
    sigma = float(np.sqrt((readings**2).sum() / dof))
    far = outliers(readings, dof)
    sloped, stepped = drift(readings, places, dof), step(readings, contacts.rows, dof)
    if far:
        kept = np.delete(readings, far, axis=0)
        rest = float(np.sqrt((kept**2).sum() / (dof - len(far) * readings.shape[1])))
        rows = ", ".join(contacts.label(i) for i in far)
        warnings.append(f"outliers: {rows}; without them sigma is about {rest:.3g}: see what happened there")
    if sloped is not None and is_significant(sloped, dof, readings.shape[1]):
        warnings.append(f"the readings drift by {sloped.per_touch:.3g} a touch: wait until the machine is warm")
    if stepped is not None:
        warnings.append(f"from row {stepped.row} on the readings are {stepped.size:.3g} more: did the stylus slip?")
    if dof < 10:
        warnings.append(f"{dof} degrees of freedom leave sigma very uncertain; make ten touches more")
    return QualifyResult(
        units=units,
        touches=len(contacts),
        places=len(places),
        dof=dof,
        sigma=sigma,
        sigma_interval=interval(sigma, dof),
        range=span,
        drift=sloped,
        steps=() if stepped is None else (stepped,),
        outliers=tuple(contacts.rows[i] for i in far),
        warnings=tuple(warnings),
    )


def _places(contacts: Contacts, targets: Sequence[str] | None) -> list[Ints]:
    """The numbers of the touches of each place."""
    said = [""] * len(contacts) if targets is None else list(targets)
    keys = list(zip(contacts.features, said, strict=True))
    return [np.flatnonzero([key == place for key in keys]) for place in dict.fromkeys(keys)]


def _deviations(contacts: Contacts, places: Sequence[Ints]) -> tuple[Floats, list[str]]:
    """How far the touches (n, k) are from the mean of their place, along the approach or in all directions."""
    # From the first of them: far from the origin nothing is lost.
    points = contacts.points - contacts.points[0]
    for place in places:
        points[place] -= points[place].mean(axis=0)
    elsewhere = _of_several_places(contacts, places)
    if not contacts.has_approach.all():
        return points, [
            *elsewhere,
            "not all touches say their approach: sigma is that of any one direction, rms over all three",
        ]
    along = np.zeros((len(points), 1))
    for place in places:
        along[place, 0] = -(points[place] @ _common_approach(contacts, place))
    return along, elsewhere


def _of_several_places(contacts: Contacts, places: Sequence[Ints]) -> list[str]:
    """A warning where touches are taken for those of one place and can hardly be."""
    elsewhere = [contacts.features[place[0]] for place in places if _are_elsewhere(contacts, place)]
    if not elsewhere:
        return []
    return [
        f"the touches of {listed(list(dict.fromkeys(elsewhere)))} are not all of one place, and sigma is then none of "
        "the probe; say with a column target which are, or give the radius if they are of a reference ball"
    ]


def _are_elsewhere(contacts: Contacts, place: Ints) -> bool:
    arms = contacts.points[place] - contacts.points[place[0]]
    arms -= arms.mean(axis=0)
    if contacts.units and lengths(arms).max() > _APART_MM * factor("mm", contacts.units):
        return True
    if not contacts.has_approach[place].all():
        return False
    direction = _common_approach(contacts, place)
    along = arms @ direction
    across = arms - np.outer(along, direction)
    turned = np.arccos(np.clip(contacts.approaches[place] @ direction, -1.0, 1.0)).max() > _ONE_APPROACH
    return bool(turned or np.sqrt((across**2).sum()) > _ACROSS * np.sqrt((along**2).sum()) > 0)


def _common_approach(contacts: Contacts, place: Ints) -> Floats:
    """The mean direction (3,) of the approaches of touches of one place."""
    mean = contacts.approaches[place].mean(axis=0)
    return unit(mean) if mean.any() else contacts.approaches[place[0]]


def _span(readings: Floats) -> float:
    """The largest difference between two of the readings (n, k)."""
    if readings.shape[1] == 1:
        return float(np.ptp(readings))
    return max(float(lengths(readings - one).max()) for one in readings)


def _of_ball(contacts: Contacts, radius: float, side: Side, units: str) -> QualifyResult:
    if len(contacts) < FEWEST_ON_BALL:
        raise NotQualifiedError(f"{len(contacts)} touches of the ball; make {FEWEST_ON_BALL} or more, from all sides")
    ball = localize_sphere(contacts.points, None, None)[0].surface
    assert isinstance(ball, Sphere)
    arms = contacts.points - ball.center
    normals = unit(arms)
    readings = (lengths(arms) - ball.radius)[:, None]
    dof = len(contacts) - 4
    result = _result(contacts, readings, [np.arange(len(contacts))], dof, float(np.ptp(readings)), [], units)
    rows = np.hstack([normals, np.ones((len(contacts), 1))])
    known = float(np.sqrt(np.linalg.inv(rows.T @ rows)[3, 3])) * result.sigma
    tip = ball.radius - radius if side == "outer" else radius - ball.radius
    flanges = contacts.flange_rotations
    outward = normals if side == "outer" else -normals
    seen = outward if flanges is None else np.einsum("nij,ni->nj", flanges, outward)
    warnings = list(result.warnings)
    if tip < 0:
        warnings.append(f"the tip's radius comes out as {tip:.4g}: is the radius of the ball right, and the side?")
    return replace(
        result,
        tip_radius=tip,
        tip_radius_sigma=known,
        directions=_map(readings[:, 0], seen, result.sigma) if len(contacts) >= FEWEST_FOR_MAP else (),
        direction_frame="base" if flanges is None else "flange",
        warnings=tuple(warnings),
    )


def _map(readings: Floats, normals: Floats, sigma: float) -> tuple[DirectionMean, ...]:
    """The mean of the readings (n,) by the direction that their normal is nearest to."""
    nearest = np.argmax(normals @ BALL_DIRECTIONS.T, axis=1)
    return tuple(
        DirectionMean(
            BALL_DIRECTIONS[k], int(count), float(readings[nearest == k].mean()), float(sigma / np.sqrt(count))
        )
        for k, count in enumerate(np.bincount(nearest, minlength=len(BALL_DIRECTIONS)))
        if count
    )


def touches_of_ball(fixture: Fixture, contacts: Contacts, name: str | None = None) -> tuple[Feature, Contacts]:
    """The sphere that contacts touch, and those that touch it; name: which, where they touch several.

    Raises UsageError where it is none, or not the only one.
    """
    balls = [one for one, feature in fixture.features.items() if feature.type == "sphere"]
    if name is not None and name not in balls:
        raise UsageError(f"{fixture.name} has no sphere {name!r}; {did_you_mean(name, balls)}")
    touched = [one for one in balls if one in contacts.by_feature and name in (None, one)]
    if not touched:
        what = f"no contact touches {name or f'a sphere of {fixture.name}'}"
        raise UsageError(f"{what}; touch a ball of known radius from all sides")
    if len(touched) > 1:
        raise UsageError(f"the contacts touch {listed(touched)}, and one is the reference ball; " + ONE_FEATURE)
    return fixture.features[touched[0]], contacts.on(touched[0])
