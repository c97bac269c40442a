"""The touchable part of each surface: its box, the extent of the fixture, and well spread points on it.

Everything is in the frame of the boxes (the fixture frame). Boxes may be open. If a finite piece is needed, an open box
is closed around the middle of the fixture, because a fixture file does not say where an unbounded surface ends. Points
are spread as follows (`sample_touches`):

1. The box is closed.
2. A low-discrepancy sequence in the unit square (Roberts' R2) is mapped to the surface, preserving areas.
3. Points in the box are kept, batch by batch, until there are enough or _TRIALS_PER_POINT are used up.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from tactfix.fixture import TouchBox
from tactfix.geometry.arrays import Bools, Floats, circle_axes, unit
from tactfix.geometry.nearest import foot
from tactfix.geometry.scale import middle_of
from tactfix.geometry.surfaces import (
    Cylinder,
    Plane,
    Point,
    SidedSurface,
    Sphere,
    Surface,
    outward_normals,
    radius_of,
    reference_point,
)

_EDGE = 1e-9
"""Tolerance of a box, as a share of its size or as a sine: a plane at z = 0 in a box z: [0, 0] must not be lost to
rounding."""
_COORDINATE_ROUNDING = 1e-9
"""Share of the coordinates, or of the least size, below which the size of the fixture is rounding."""
_PLASTIC = 1.32471795724474602596
"""The plastic number, the real root of x^3 = x + 1 (Roberts' R2 sequence)."""
_SEQUENCE_STEP = np.array([1 / _PLASTIC, 1 / _PLASTIC**2])
"""Steps of the additive recurrence whose points are evenly spread over the unit square."""
_TRIALS_PER_POINT = 256
"""Trials for each point wanted, after which fewer points are returned: a box that contains a hundredth of a surface
still gives all of them."""


def within_box(box: TouchBox | None, points: Floats, margin: float | Floats = 0.0) -> Bools:
    """Which points (..., 3) lie in the box, with a margin (scalar or (...,)) outside its faces; all if box is None."""
    if box is None:
        return np.ones(points.shape[:-1], dtype=bool)
    slack = np.asarray(margin, dtype=np.float64)[..., None]
    return np.asarray(((points >= box.low - slack) & (points <= box.high + slack)).all(axis=-1))


def axial_interval(cylinder: Cylinder, box: TouchBox | None) -> tuple[float, float]:
    """The interval of s in point + s direction with some of the surface in the box; infinite at an open end."""
    return _interval(cylinder, box, _rim(cylinder), _EDGE)


def solid_interval(cylinder: Cylinder, box: TouchBox | None) -> tuple[float, float]:
    """The interval of s in point + s direction with the whole circumference in the box; infinite at an open end.

    Only faces that the axis meets at more than 30 degrees end a bar: a box that cuts off one side of it does not.
    """
    return _interval(cylinder, box, -_rim(cylinder), 0.5)


def _rim(cylinder: Cylinder) -> Floats:
    """The half extent (3,) of a circle of the cylinder along each coordinate."""
    return np.asarray(cylinder.radius * np.sqrt(np.clip(1 - cylinder.direction**2, 0.0, 1.0)))


def _interval(cylinder: Cylinder, box: TouchBox | None, margin: Floats, least: float) -> tuple[float, float]:
    """The interval of s in the box grown by margin (3,), by the faces that the axis meets at a sine above least."""
    low, high = -np.inf, np.inf
    if box is None:
        return low, high
    for k in np.flatnonzero(np.abs(cylinder.direction) > least):
        ends = np.array([box.low[k] - margin[k], box.high[k] + margin[k]]) - cylinder.point[k]
        first, last = np.sort(ends / cylinder.direction[k])
        low, high = max(low, float(first)), min(high, float(last))
    return low, high


def face(plane: Plane, box: TouchBox) -> Floats:
    """Corners (k, 3), in order, of the part of the plane in a bounded box; (0, 3) if they do not meet."""
    middle, size = (box.low + box.high) / 2, float(np.linalg.norm(box.high - box.low))
    u, v = circle_axes(plane.normal)
    corners = foot(plane, middle) + size * np.array([u + v, v - u, -u - v, u - v])
    for k in range(3):
        for sign, limit in ((1.0, box.high[k]), (-1.0, -box.low[k])):
            corners = _clipped(corners, sign * corners[:, k] - limit - _EDGE * size)
    return corners


def _clipped(corners: Floats, excess: Floats) -> Floats:
    """The polygon (k, 3) without the part where excess (k,), linear over it, is positive."""
    kept: list[Floats] = []
    for i in range(len(corners)):
        j = (i + 1) % len(corners)
        if excess[i] <= 0:
            kept.append(corners[i])
        if (excess[i] <= 0) != (excess[j] <= 0):
            share = excess[i] / (excess[i] - excess[j])
            kept.append(corners[i] + share * (corners[j] - corners[i]))
    return np.array(kept).reshape(-1, 3)


def closed_box(surface: Surface, box: TouchBox | None, centre: Floats, radius: float) -> TouchBox:
    """The box with its open sides closed: at radius from the point of the plane or axis nearest to centre (3,)."""
    anchor, extent = foot(surface, centre), radius_of(surface)
    if isinstance(surface, Cylinder | Plane):
        extent += radius
    low = np.full(3, -np.inf) if box is None else box.low
    high = np.full(3, np.inf) if box is None else box.high
    # A box with one given side beyond the anchor keeps a piece of that size next to this side.
    ends_low = np.where(np.isfinite(low), low, np.minimum(anchor - extent, high - 2 * extent))
    ends_high = np.where(np.isfinite(high), high, np.maximum(anchor + extent, ends_low + 2 * extent))
    return TouchBox(ends_low, ends_high)


def piece_bounds(surface: Surface, box: TouchBox) -> tuple[Floats, Floats] | None:
    """Corners low (3,) and high (3,) of a box around the part of a surface in its touch box; None if unbounded."""
    return _bounds(surface, box) if is_bounded(surface, box) else None


def bounds_of(
    surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox], least: float = 1.0
) -> tuple[Floats, Floats]:
    """Corners low (3,) and high (3,) of the axis-parallel box around all touchable parts.

    Open parts end at the radius of the bounded features around their middle. If nothing is bounded, they end around the
    point nearest to all surfaces, at the size given by radii and distances, or at least if there are none.
    """
    everywhere = TouchBox(np.full(3, -np.inf), np.full(3, np.inf))
    boxed = [(surface, boxes.get(name, everywhere)) for name, surface in surfaces.items()]
    bounded = [piece for piece in (piece_bounds(surface, box) for surface, box in boxed) if piece is not None]
    low, high = _hull(bounded or [(point, point) for point in _middle_points(surfaces.values())])
    centre = (low + high) / 2
    radius = float(np.linalg.norm(high - low)) / 2
    if not bounded:
        radius = max([radius, *(radius_of(s) for s in surfaces.values())])
    # Planes that meet in one point, within rounding, have no size.
    rounding = _COORDINATE_ROUNDING * max(float(np.abs([low, high]).max()), least)
    radius = radius if radius > rounding else least
    return _hull([_bounds(surface, closed_box(surface, box, centre, radius)) for surface, box in boxed])


def extreme_points(surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox], least: float = 1.0) -> Floats:
    """The eight corners (8, 3) of `bounds_of`.

    The variance of a point along any direction is a convex function of the point, so a corner has the largest.
    """
    low, high = bounds_of(surfaces, boxes, least)
    return np.array([[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]] for i, j, k in np.ndindex(2, 2, 2)])


def extent_of(
    surfaces: Mapping[str, Surface], boxes: Mapping[str, TouchBox], least: float = 1.0
) -> tuple[Floats, float]:
    """Centre (3,) and radius of a ball around all touchable parts of the fixture (`bounds_of`)."""
    low, high = bounds_of(surfaces, boxes, least)
    return (low + high) / 2, float(np.linalg.norm(high - low)) / 2


def is_bounded(surface: Surface, box: TouchBox) -> bool:
    """Whether the part of the surface in the box is bounded."""
    if isinstance(surface, Sphere | Point):
        return True
    if isinstance(surface, Cylinder):
        return bool(np.isfinite(axial_interval(surface, box)).all())
    # A plane is bounded when no open direction of the box, projected on it, leads to infinity.
    open_sides = ~(np.isfinite(box.low) & np.isfinite(box.high))
    return not (open_sides & (np.abs(surface.normal) < 1 - _EDGE)).any()


def _bounds(surface: Surface, box: TouchBox) -> tuple[Floats, Floats]:
    """Corners of a box around the part of the surface in a box that bounds it."""
    match surface:
        case Sphere() | Point():
            low, high = reference_point(surface) - radius_of(surface), reference_point(surface) + radius_of(surface)
        case Cylinder():
            rim = _rim(surface)
            ends = surface.point + np.outer(axial_interval(surface, box), surface.direction)
            low, high = ends.min(axis=0) - rim, ends.max(axis=0) + rim
        case Plane():
            # An infinite side is perpendicular to the plane here: any finite value in its place cuts nothing off.
            corners = face(surface, closed_box(surface, box, surface.point, 1.0))
            low, high = (corners.min(axis=0), corners.max(axis=0)) if len(corners) else (surface.point, surface.point)
    return np.maximum(low, np.minimum(box.low, high)), np.minimum(high, np.maximum(box.high, low))


def _hull(bounds: Iterable[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    lows, highs = zip(*bounds, strict=True)
    return np.min(lows, axis=0), np.max(highs, axis=0)


def _middle_points(surfaces: Iterable[Surface]) -> Floats:
    """Feet (n, 3), on the planes and axes, of the point nearest to all of them in the least-squares sense."""
    unbounded = [surface for surface in surfaces if isinstance(surface, Plane | Cylinder)]
    middle = middle_of(unbounded, cutoff=1e-9)
    return np.array([foot(surface, middle) for surface in unbounded])


def sample_touches(
    surface: Surface,
    box: TouchBox | None,
    count: int,
    centre: Floats,
    radius: float,
    start: tuple[float, float] = (0.5, 0.5),
) -> tuple[Floats, Floats]:
    """Well spread points on the touchable part of a surface: points (m, 3) and outward normals (m, 3), m <= count.

    centre (3,) and radius, as of `extent_of`: for `closed_box`. start in [0, 1)^2 shifts the sequence: random starts
    give random point sets. Fewer than count only if the box contains less than a hundredth of the surface.
    """
    if isinstance(surface, Point):
        # The direction in which a tip enters is unknown: away from the middle of the fixture is assumed.
        way = surface.point - centre
        away = unit(way) if way.any() else np.eye(3)[2]
        return np.tile(surface.point, (min(count, 1), 1)), np.tile(away, (min(count, 1), 1))
    closed = closed_box(surface, box, centre, radius)  # step 1
    found: list[Floats] = []
    have = 0
    for batch in range(_TRIALS_PER_POINT // 4):
        index = np.arange(4 * count * batch, 4 * count * (batch + 1))[:, None]
        points = _placed(  # step 2
            surface, closed, np.asarray((np.asarray(start) + _SEQUENCE_STEP * index) % 1.0, dtype=np.float64)
        )
        size = float(np.linalg.norm(closed.high - closed.low))
        found.append(points[within_box(closed, points, _EDGE * size)])  # step 3
        have += len(found[-1])
        if have >= count:
            break
    points = np.concatenate(found)[:count]
    return points, np.array(outward_normals(surface, points))


def _placed(surface: SidedSurface, closed: TouchBox, square: Floats) -> Floats:
    """Points (n, 3) of the surface at parameters (n, 2) in the unit square; the map preserves areas."""
    if isinstance(surface, Plane):
        corners = face(surface, closed)
        if not len(corners):
            return np.zeros((0, 3))
        edges = np.roll(corners, -1, axis=0) - corners
        if np.abs(edges).max() <= 10 * _EDGE * np.linalg.norm(closed.high - closed.low):
            # Within rounding the box contains a single point.
            return np.zeros((0, 3))
        u = unit(edges[np.argmax(np.linalg.norm(edges, axis=1))])
        axes = np.array([u, np.cross(surface.normal, u)])
        flat = (corners - corners[0]) @ axes.T
        low, high = flat.min(axis=0), flat.max(axis=0)
        return np.asarray(corners[0] + (low + square * (high - low)) @ axes)
    angle = 2 * np.pi * square[:, 1]
    if isinstance(surface, Sphere):
        height = 2 * square[:, 0] - 1
        ring = np.sqrt(1 - height**2)
        return np.asarray(
            surface.center + surface.radius * np.stack([ring * np.cos(angle), ring * np.sin(angle), height], axis=1)
        )
    low, high = axial_interval(surface, closed)
    if not low <= high:
        return np.zeros((0, 3))
    u, v = circle_axes(surface.direction)
    along = (low + square[:, 0] * (high - low))[:, None] * surface.direction
    around = np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * v
    return np.asarray(surface.point + along + surface.radius * around)
