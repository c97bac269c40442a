"""Qualification of a probe from touches of the same places or of a reference ball.

1. On a ball of known radius the readings are the distances from the best sphere, form errors of ball and probe
   included, and the radius of this sphere of tip centres gives the tip radius.
2. Else touches with the same feature and target are of one place.
3. Their readings are deviations from the mean of their place: along the approach if all contacts have one, else in all
   directions.
4. Sigma is the standard deviation of all readings, pooled over the places; their sequence is tested for outliers, a
   drift and a step (`sequence`). Sigma without outliers is about the means, or the ball, of the other touches.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import NotQualifiedError
from tactfix.geometry.arrays import Floats, Ints, lengths, unit
from tactfix.geometry.surfaces import Side, Sphere
from tactfix.localizers.sphere import localize_sphere
from tactfix.qualification.ball import about_best_ball, radius_sigma, unless_spread
from tactfix.qualification.result import DirectionMean, QualifyResult
from tactfix.qualification.sequence import AboutRest, drift, interval, is_significant, outliers, step
from tactfix.units import factor
from tactfix.wording import listed

FEWEST_ON_BALL = 5
"""Touches of a ball that leave a degree of freedom beyond centre and radius."""
FEWEST_FOR_MAP = 25
"""Fewest touches of a ball for means by direction."""
IN_ALL_DIRECTIONS = "not all touches have an approach: sigma is that of one direction, rms over all three"
"""The warning if deviations are taken in all directions."""
_ACROSS = 20.0
"""Largest ratio of the spread of touches of one place across the approach to that along it: a machine returns to a
place about as well as its probe triggers there."""
_ONE_APPROACH = 0.2
"""Largest angle (rad) of an approach to the mean of its place: programs repeat approaches, hands keep them within some
ten degrees."""
_APART_MM = 5.0
"""Largest distance (mm) of a touch from the mean of its place: the worst machine and a hand-guided robot return closer
than this."""
_CUBE = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)], dtype=np.float64)
BALL_DIRECTIONS = unit(_CUBE[np.isin(np.abs(_CUBE).sum(axis=1), (1, 3))])
"""Unit vectors (14, 3) along the axes and along the diagonals of the octants, for means by direction."""


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
        One for each contact; touches with the same feature and target are of one place.
    radius : float, optional
        Of the reference ball that all contacts touch, in their unit.
    side : {"outer", "inner"}
        "outer" for a ball, "inner" for a socket.
    units : str
        Name of the contacts' unit in the result.

    Returns
    -------
    QualifyResult

    Raises
    ------
    NotQualifiedError
        No place is touched twice, or the ball fewer than five times.
    DegenerateContactsError
        All touches of the ball lie in one plane.

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
    readings = _deviations(contacts, places)  # step 3
    dof = (len(readings) - len(places)) * readings.shape[1]
    if dof < 1:
        raise NotQualifiedError("no place is touched twice; touch one again, or give the radius of the reference ball")
    spans = [_span(readings[place]) for place in places]
    about_rest = partial(_about_means, readings, places)
    foreign = _of_several_places(contacts, places)
    result = _result(contacts, readings, about_rest, places, dof, max(spans), foreign, units)  # step 4
    return result if readings.shape[1] == 1 else replace(result, warnings=(*result.warnings, IN_ALL_DIRECTIONS))


def _about_means(readings: Floats, places: Sequence[Ints], kept: Ints) -> tuple[Floats, Floats]:
    """The readings of the kept touches about their own means, and their shares of variance (`AboutRest`)."""
    left = np.zeros(len(readings), dtype=bool)
    left[kept] = True
    centred, shares = readings.copy(), np.zeros(len(readings))
    for place in places:
        rest = place[left[place]]
        if len(rest):
            centred[rest] -= centred[rest].mean(axis=0)
            shares[rest] = 1 - 1 / len(rest)
    return centred[kept], shares[kept]


def _result(
    contacts: Contacts,
    readings: Floats,
    about_rest: AboutRest,
    places: Sequence[Ints],
    dof: int,
    span: float,
    foreign: list[str],
    units: str,
) -> QualifyResult:
    """The result of readings, of repeated touches or of a ball; foreign: warnings that they are no such touches."""
    sigma = float(np.sqrt((readings**2).sum() / dof))
    far = _with_partners(outliers(about_rest, len(readings), dof), places)
    # Of touches that are spread over a feature, the sequence is that of where they were made.
    sloped = None if foreign else drift(readings, places, dof)
    stepped = None if foreign else step(readings, contacts.rows, dof)
    warnings = list(foreign)
    if far:
        rest = _length(_sigma_without(far, about_rest, places, dof, len(readings)), units)
        rows = ", ".join(contacts.label(i) for i in far)
        warnings.append(f"outliers: {rows}; without them sigma is about {rest}: check these touches")
    if sloped is not None and is_significant(sloped, dof, readings.shape[1]):
        slope = _length(sloped.per_touch, units)
        warnings.append(f"the readings drift by {slope} a touch: wait until the machine is warm")
    if stepped is not None:
        size = _length(stepped.size, units)
        warnings.append(f"from row {stepped.row} on the readings are {size} more: did the stylus slip?")
    if dof < 10:
        warnings.append(f"{dof} degrees of freedom leave sigma very uncertain; make ten more touches")
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


def _length(value: float, units: str) -> str:
    return f"{value:.3g} {units}".rstrip()


def _with_partners(far: Sequence[int], places: Sequence[Ints]) -> list[int]:
    """The outliers, and with one of two touches of a place also the other: which one is off is not known."""
    pairs = [place.tolist() for place in places if len(place) == 2 and np.isin(place, far).any()]
    return sorted({*far, *(i for pair in pairs for i in pair)})


def _sigma_without(far: Sequence[int], about_rest: AboutRest, places: Sequence[Ints], dof: int, touches: int) -> float:
    """Sigma of the touches without the outliers, about their own means or their own ball."""
    rest, _ = about_rest(np.delete(np.arange(touches), far))
    emptied = sum(bool(np.isin(place, far).all()) for place in places)
    return float(np.sqrt((rest**2).sum() / (dof - (len(far) - emptied) * rest.shape[1])))


def _places(contacts: Contacts, targets: Sequence[str] | None) -> list[Ints]:
    """The indices of the touches of each place."""
    keys = list(zip(contacts.features, [""] * len(contacts) if targets is None else targets, strict=True))
    return [np.flatnonzero([key == place for key in keys]) for place in dict.fromkeys(keys)]


def _deviations(contacts: Contacts, places: Sequence[Ints]) -> Floats:
    """The deviations (n, k) of the touches from the mean of their place, along the approach or in all directions."""
    # Relative to the first touch, so that no digits are lost far from the origin.
    points = contacts.points - contacts.points[0]
    for place in places:
        points[place] -= points[place].mean(axis=0)
    if not contacts.has_approach.all():
        return np.asarray(points)
    along = np.zeros((len(points), 1))
    for place in places:
        along[place, 0] = -(points[place] @ _common_approach(contacts, place))
    return along


def _of_several_places(contacts: Contacts, places: Sequence[Ints]) -> list[str]:
    """A warning if touches with the same feature and target cannot plausibly be of one place."""
    elsewhere = [contacts.features[place[0]] for place in places if _are_elsewhere(contacts, place)]
    if not elsewhere:
        return []
    return [
        f"the touches of {listed(list(dict.fromkeys(elsewhere)))} are not all of one place, so sigma is not that of "
        "the probe; name the place of each in a column target, or give the radius if they are of a reference ball"
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
    known = radius_sigma(normals)
    foreign = unless_spread(ball.radius, known, readings, dof)
    about_rest = partial(about_best_ball, contacts.points, ball)
    span = float(np.ptp(readings))
    result = _result(contacts, readings, about_rest, [np.arange(len(contacts))], dof, span, foreign, units)
    tip = ball.radius - radius if side == "outer" else radius - ball.radius
    flanges = contacts.flange_rotations
    outward = normals if side == "outer" else -normals
    seen = outward if flanges is None else np.einsum("nij,ni->nj", flanges, outward)
    warnings = list(result.warnings)
    if tip < 0 and not foreign:
        warnings.append(f"the tip's radius would be {tip:.4g}: is the radius of the ball right, and the side?")
    return replace(
        result,
        tip_radius=tip,
        tip_radius_sigma=known * result.sigma,
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
