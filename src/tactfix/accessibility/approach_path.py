"""Whether the straight approach to a contact is free, or which other feature blocks it.

Only features that the fixture file describes can block, and only the tip's centre is tested. So a real obstacle may be
missed, but a pose is never rejected because of one that does not exist.

1. A ball blocks an approach that passes its centre nearer than its radius.
2. A bar blocks one that passes its axis nearer than its radius, between the ends that its touch box gives.
3. A bounded face blocks one that comes out of its material, except through the opening of an inner surface.
4. The first blocking feature of each contact is returned.
"""

from collections.abc import Mapping

import numpy as np

from tactfix.accessibility.touchable import is_bounded, solid_interval
from tactfix.fixture import TouchBox
from tactfix.geometry.arrays import EPS, Bools, Floats, lengths
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface, residuals


def path_blocked(
    surfaces: Mapping[str, Surface],
    boxes: Mapping[str, TouchBox],
    feature: str,
    points: Floats,
    approaches: Floats,
    approach_distance: float | None = None,
    margin: float | Floats = 0.0,
    strict: bool = False,
) -> list[str | None]:
    """For each contact on feature, the other feature that its straight approach runs through, or None.

    The approach is the segment from point - L approach to point, L = approach_distance; infinite if None. Everything is
    in the frame of the boxes: points (n, 3) are tip centres (or points of the surface), approaches (n, 3) unit vectors;
    a row of nan is never blocked. An approach is blocked if it enters an obstacle deeper than margin, scalar or (n,); a
    negative margin is a clearance.

    Obstacles: outer spheres; outer cylinders as solid bars between the ends that their touch box gives, else infinite
    (a bar with an open end never covers the contact itself); planes that their touch box bounds, for an approach that
    comes out of their material, except through the opening of an inner feature. Inner surfaces never block. The feature
    itself is subject to the approach test (eq. 11).

    strict is for planning a path instead of testing one: possible obstacles count too. A bar with an open end blocks
    contacts in it, and a bounded face blocks balls and bars behind it.
    """
    margins = np.broadcast_to(np.asarray(margin, dtype=np.float64), len(points))
    length = np.inf if approach_distance is None else approach_distance
    names: list[str | None] = [None] * len(points)
    own = surfaces[feature]
    for name, surface in surfaces.items():
        if name == feature:
            continue
        match surface:
            case Sphere(side="outer"):
                blocked = _through_ball(surface, points, approaches, length, margins)  # step 1
            case Cylinder(side="outer"):
                # Step 2.
                blocked = _through_bar(surface, boxes.get(name), points, approaches, length, margins, strict)
            case Plane() if name in boxes:  # step 3
                sides = (surface, Plane(surface.point, -surface.normal))
                both = strict and isinstance(own, Sphere | Cylinder) and own.side == "outer"
                blocked = np.zeros(len(points), dtype=bool)
                for side in sides[: 1 + both]:
                    crossed = _through_face(side, boxes[name], points, approaches, length, margins)
                    blocked |= crossed & ~_in_opening(surfaces, side, points, approaches)
            case _:
                continue
        for i in np.flatnonzero(blocked):  # step 4
            names[i] = names[i] or name
    return names


def _least_distance(arms: Floats, steps: Floats, first: Floats, last: Floats) -> Floats:
    """min over u in [first, last] of |arm - u step| (n,), for arms and steps (n, 3); inf for an empty range."""
    square = (steps**2).sum(axis=1)
    moving = square > EPS
    nearest = np.where(moving, (arms * steps).sum(axis=1) / np.where(moving, square, 1.0), first)
    nearest = np.clip(nearest, first, np.maximum(first, last))
    distance = lengths(arms - nearest[:, None] * steps)
    return np.asarray(np.where(first <= last, distance, np.inf))


def _through_ball(ball: Sphere, points: Floats, approaches: Floats, length: float, margins: Floats) -> Bools:
    """Which approaches pass the centre nearer than radius - margin."""
    first, last = np.zeros(len(points)), np.full(len(points), length)
    distance = _least_distance(points - ball.center, approaches, first, last)
    return np.asarray(distance < ball.radius - margins)


def _through_bar(
    bar: Cylinder,
    box: TouchBox | None,
    points: Floats,
    approaches: Floats,
    length: float,
    margins: Floats,
    strict: bool,
) -> Bools:
    """Which approaches pass the axis nearer than radius - margin, between the ends of the bar."""
    low, high = solid_interval(bar, box)
    arms = points - bar.point
    along, rate = arms @ bar.direction, approaches @ bar.direction
    first, last = _between(along, rate, low + margins, high - margins, length)
    radial_arms = arms - along[:, None] * bar.direction
    radial_steps = approaches - rate[:, None] * bar.direction
    blocked = _least_distance(radial_arms, radial_steps, first, last) < bar.radius - margins
    if not strict and np.isinf([low, high]).any():
        blocked &= lengths(radial_arms) >= bar.radius - np.maximum(margins, 0.0)
    return np.asarray(blocked)


def _between(along: Floats, rate: Floats, low: Floats, high: Floats, length: float) -> tuple[Floats, Floats]:
    """The range first <= u <= last of [0, length] with low <= along - u rate <= high; empty if first > last."""
    level = np.abs(rate) <= EPS
    step = np.where(level, 1.0, rate)
    ends = np.sort(np.stack([(along - low) / step, (along - high) / step]), axis=0)
    outside = level & ((along < low) | (along > high))
    first = np.where(level, np.where(outside, np.inf, 0.0), np.maximum(ends[0], 0.0))
    last = np.where(level, length, np.minimum(ends[1], length))
    # An empty range gets finite ends, so that no invalid arithmetic follows.
    empty = np.isinf(first)
    return np.where(empty, 0.0, first), np.where(empty, -1.0, last)


def _crossing(plane: Plane, points: Floats, approaches: Floats) -> tuple[Floats, Floats]:
    """u (n,) and point (n, 3) at which the approach comes out of the plane's material; nan if it does not."""
    rate = approaches @ plane.normal
    rises = rate > EPS
    u = np.where(rises, residuals(plane, points, 0.0) / np.where(rises, rate, 1.0), np.nan)
    return u, np.asarray(points - u[:, None] * approaches)


def _through_face(
    plane: Plane, box: TouchBox, points: Floats, approaches: Floats, length: float, margins: Floats
) -> Bools:
    """Which approaches start behind a bounded face, by more than margin, and come out through it."""
    if not is_bounded(plane, box):
        return np.zeros(len(points), dtype=bool)
    u, crossing = _crossing(plane, points, approaches)
    behind = (length - u) * (approaches @ plane.normal) > np.maximum(margins, 0.0)
    before = residuals(plane, points, 0.0) > np.maximum(margins, 0.0)
    # Along the normal there is nothing to compare: the face lies in the plane.
    across = np.abs(plane.normal) > 1 - 1e-9
    slack = np.where(across, np.inf, -margins[:, None])
    inside = ((crossing >= box.low - slack) & (crossing <= box.high + slack)).all(axis=1)
    return np.asarray(behind & before & inside)


def _in_opening(surfaces: Mapping[str, Surface], plane: Plane, points: Floats, approaches: Floats) -> Bools:
    """Which approaches come out of the plane within the opening of an inner surface."""
    crossing = _crossing(plane, points, approaches)[1]
    opening = np.zeros(len(points), dtype=bool)
    for surface in surfaces.values():
        if isinstance(surface, Sphere | Cylinder) and surface.side == "inner":
            opening |= residuals(surface, crossing, 0.0) > 0
    return opening
