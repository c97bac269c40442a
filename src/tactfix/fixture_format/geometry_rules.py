"""Rules for placed features: relations, frame and touch boxes must agree with the places."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from tactfix.fixture import Fixture, TouchBox
from tactfix.fixture_format.build import AXIS_KEYS
from tactfix.fixture_format.entries import Entries, Finding
from tactfix.fixture_format.feature_rules import CONTRADICTION_SIGMAS
from tactfix.frame import FrameError, frames
from tactfix.geometry.arrays import EPS, Floats
from tactfix.geometry.nearest import angle_between, distance_between
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, radius_of, reference_point

_PARALLEL_AS_TYPED = 1e-4
"""Directions are parallel if the sine of their angle is below this: twice the rounding (5e-5) of components with four
decimals."""
_TYPED = 1e-6
"""Deviations below this share of the fixture's size are rounding: places and directions have about six digits."""
_FRAME_OFF = 1e-4
"""Tolerance of the frame recipe against the frame of the places, as a share of the fixture's size and in rad, since
directions are written with four decimals."""
_MOST_ROUNDING = 1e-4
"""Largest relative rounding of a written number: "25.4" means any value that rounds to it, but "3" not 2.6."""


def check_geometry(entries: Entries, fixture: Fixture) -> list[Finding]:
    """Relations, frame and touch boxes that contradict the places; fixture: built from entries, all features placed."""
    surfaces = {name: feature.surface for name, feature in fixture.features.items() if feature.surface is not None}
    return [
        *_check_distances(entries, surfaces),
        *_check_angles(entries, surfaces),
        *_check_frame(fixture, surfaces),
        *_check_boxes(fixture, surfaces),
    ]


def _rounding(value: float) -> float:
    """Half a unit of the last decimal of a value, at most _MOST_ROUNDING of it."""
    _, _, decimals = repr(abs(value)).partition(".")
    half = 0.5 * 10.0 ** -len(decimals) if "e" not in decimals else 0.0
    return min(half, _MOST_ROUNDING * abs(value))


def _check_distances(entries: Entries, surfaces: Mapping[str, Surface]) -> Iterator[Finding]:
    size = _size(surfaces)
    for index, distance in entries.distances.items():
        a, b = (surfaces[name] for name in distance["between"])
        names = " and ".join(distance["between"])
        if not _has_distance(a, b):
            message = f"{names} have a distance only if parallel, and their places are not"
            yield Finding(("distances", index, "between"), message, "leave out the distance, or correct the places")
            continue
        measured = distance_between(a, b)
        if not isinstance(a, Sphere | Point) and not isinstance(b, Sphere | Point):
            measured = abs(measured)  # only a sphere has a side of a plane
        slack = CONTRADICTION_SIGMAS * distance.get("sigma", 0.0) + _rounding(distance["value"]) + _TYPED * size
        if all(abs(value - distance["value"]) > slack for value in (measured, *_askew(a, b))):
            message = f"the distance of {names} is {distance['value']:.10g}, but their places give {measured:.9g}"
            yield Finding(("distances", index, "value"), message, "correct one of them; the distance may be left out")


def _askew(a: Surface, b: Surface) -> tuple[float, ...]:
    """The length of the common perpendicular of two axes, which differs from the spacing of nearly parallel ones."""
    if not isinstance(a, Cylinder) or not isinstance(b, Cylinder):
        return ()
    square = np.cross(a.direction, b.direction)
    sine = float(np.linalg.norm(square))
    return (abs(float((b.point - a.point) @ square)) / sine,) if sine > _PARALLEL_AS_TYPED else ()


def _has_distance(a: Surface, b: Surface) -> bool:
    """Whether a distance is defined: for two planes, or a plane and an axis, only if they are parallel."""
    if (
        isinstance(a, Sphere | Point)
        or isinstance(b, Sphere | Point)
        or (isinstance(a, Cylinder) and isinstance(b, Cylinder))
    ):
        return True
    angle = angle_between(a, b)
    return (
        math.cos(angle) if isinstance(a, Cylinder) or isinstance(b, Cylinder) else math.sin(angle)
    ) < _PARALLEL_AS_TYPED


def _check_angles(entries: Entries, surfaces: Mapping[str, Surface]) -> Iterator[Finding]:
    for index, angle in entries.angles.items():
        a, b = (surfaces[name] for name in angle["between"])
        if isinstance(a, Sphere | Point) or isinstance(b, Sphere | Point):
            continue  # reported by feature_rules
        measured = math.degrees(angle_between(a, b))
        slack = (
            CONTRADICTION_SIGMAS * angle.get("sigma", 0.0)
            + _rounding(angle["value"])
            + math.degrees(_PARALLEL_AS_TYPED)
        )
        if abs(measured - angle["value"]) > slack:
            names = " and ".join(angle["between"])
            message = f"the angle of {names} is {angle['value']:.10g}, but their places give {measured:.9g}"
            yield Finding(("angles", index, "value"), message, "correct one of them; the angle may be left out")


def _check_boxes(fixture: Fixture, surfaces: Mapping[str, Surface]) -> Iterator[Finding]:
    for name, box in fixture.touch.items():
        if _leaves_nothing(surfaces[name], box, _TYPED * _size(surfaces)):
            message = f"the touch box of {name} does not meet its surface"
            yield Finding(
                ("touch", name), message, "correct the box or the place; a box is in the fixture frame", at_key=True
            )


def _check_frame(fixture: Fixture, surfaces: Mapping[str, Surface]) -> Iterator[Finding]:
    recipe = fixture.frame
    if recipe is None:
        return
    remedy = "leave out the frame: features with places need none"
    try:
        choices = frames(recipe, surfaces)
    except FrameError as error:
        yield Finding(("frame",), str(error).removeprefix("frame: "), remedy, at_key=True)
        return
    # The axes of cylinders have no sign: take the possible frame closest to the identity.
    built = min(choices, key=lambda matrix: float(np.abs(matrix[:3, :3] - np.eye(3)).sum()))
    if np.linalg.norm(built[:3, 3]) > _FRAME_OFF * _size(surfaces):
        message = f"the places of the features put this origin at {_shown(built[:3, 3])}, not at 0"
        yield Finding(("frame", "origin"), message, remedy)
    for axis, _ in (recipe.first, recipe.second):
        k = AXIS_KEYS.index(axis)
        if np.linalg.norm(built[:3, k] - np.eye(3)[k]) > _FRAME_OFF:
            message = f"the places of the features give {axis} the direction {_shown(built[:3, k])}"
            yield Finding(("frame", axis), message, remedy)


def _shown(vector: Floats) -> str:
    return f"({', '.join(f'{value:.6g}' for value in vector + 0.0)})"


def _size(surfaces: Mapping[str, Surface]) -> float:
    """Size of the fixture (a length): its largest coordinate or radius."""
    lengths = [
        max(
            float(np.abs(reference_point(s)).max()),
            radius_of(s),
        )
        for s in surfaces.values()
    ]
    return max(lengths)


def _leaves_nothing(surface: Surface, box: TouchBox, slack: float) -> bool:
    """Whether no point of the surface lies in the box (one frame), by more than slack (a length)."""
    match surface:
        case Plane():
            low, high = _heights(surface, box)
            return low > slack or high < -slack
        case Point():
            return bool((np.maximum(box.low - surface.point, surface.point - box.high) > slack).any())
        case Sphere():
            outside = np.maximum(np.maximum(box.low - surface.center, surface.center - box.high), 0.0)
            farthest = np.maximum(np.abs(box.low - surface.center), np.abs(box.high - surface.center))
            nearest_is_beyond = float(np.linalg.norm(outside)) > surface.radius + slack
            return nearest_is_beyond or float(np.linalg.norm(farthest)) < surface.radius - slack
        case Cylinder():
            return _nearest(surface, box) > surface.radius + slack or _farthest(surface, box) < surface.radius - slack


def _heights(plane: Plane, box: TouchBox) -> tuple[float, float]:
    """The lowest and highest signed distance of points of the box from the plane."""
    along = np.abs(plane.normal) > EPS
    ends = np.array([box.low - plane.point, box.high - plane.point])[:, along] * plane.normal[along]
    return float(ends.min(axis=0).sum()), float(ends.max(axis=0).sum())


def _nearest(cylinder: Cylinder, box: TouchBox) -> float:
    """The least distance of the axis from the box.

    The squared distance of a point of the axis from the box is convex and piecewise quadratic in s; it bends where the
    axis crosses a face of the box, so its least value is at a bend or at the vertex of a piece.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = np.concatenate([(end - cylinder.point) / cylinder.direction for end in (box.low, box.high)])
    bends = np.unique(crossings[np.isfinite(crossings)])
    if not len(bends):
        return float(_outside(cylinder, box, np.zeros(1))[0])
    reach = 1.0 + bends[-1] - bends[0]
    middles = np.concatenate([[bends[0] - reach], (bends[1:] + bends[:-1]) / 2, [bends[-1] + reach]])
    vertices = np.array([_vertex(cylinder, box, s) for s in middles])
    return float(_outside(cylinder, box, np.concatenate([bends, vertices])).min())


def _vertex(cylinder: Cylinder, box: TouchBox, s: float) -> float:
    """Minimizer of the quadratic piece around s; s itself if it is constant."""
    point = cylinder.point + s * cylinder.direction
    beyond = np.where(point < box.low, box.low, np.where(point > box.high, box.high, point)) - point
    moving = np.where(beyond != 0, cylinder.direction, 0.0)
    rate = float(moving @ moving)
    return s + float(beyond @ moving) / rate if rate > 0 else s


def _outside(cylinder: Cylinder, box: TouchBox, s: Floats) -> Floats:
    """Distances (n,) from the box to the points of the axis at s (n,)."""
    points = cylinder.point + s[:, None] * cylinder.direction
    return np.asarray(np.linalg.norm(np.maximum(np.maximum(box.low - points, points - box.high), 0.0), axis=1))


def _farthest(cylinder: Cylinder, box: TouchBox) -> float:
    """The largest distance of a corner of the box from the axis; infinite if the box is open across the axis."""
    open_ = ~(np.isfinite(box.low) & np.isfinite(box.high))
    across = 1 - cylinder.direction**2 > EPS
    if (open_ & across).any():
        return float("inf")
    # The sides still open are along the axis, which does not change the distance.
    low, high = np.where(open_, cylinder.point, box.low), np.where(open_, cylinder.point, box.high)
    corners = np.array([[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]] for i, j, k in np.ndindex(2, 2, 2)])
    arms = corners - cylinder.point
    return float(np.linalg.norm(arms - (arms @ cylinder.direction)[:, None] * cylinder.direction, axis=1).max())
