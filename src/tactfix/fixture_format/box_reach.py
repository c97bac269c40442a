"""Whether a touch box leaves any of an unbounded surface, exactly: nearest and farthest point of the box."""

import numpy as np

from tactfix.fixture import TouchBox
from tactfix.geometry.arrays import EPS, Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface


def leaves_nothing(surface: Surface, box: TouchBox, slack: float) -> bool:
    """Whether no point of the surface lies in the box (one frame), by more than slack (a length)."""
    match surface:
        case Plane():
            low, high = _heights(surface, box)
            return low > slack or high < -slack
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
    """Where the quadratic that holds around s has its least value; s itself where it is constant."""
    point = cylinder.point + s * cylinder.direction
    beyond = np.where(point < box.low, box.low, np.where(point > box.high, box.high, point)) - point
    moving = np.where(beyond != 0, cylinder.direction, 0.0)
    rate = float(moving @ moving)
    return s + float(beyond @ moving) / rate if rate > 0 else s


def _outside(cylinder: Cylinder, box: TouchBox, s: Floats) -> Floats:
    """How far (n,) the points of the axis at s (n,) are from the box."""
    points = cylinder.point + s[:, None] * cylinder.direction
    return np.asarray(np.linalg.norm(np.maximum(np.maximum(box.low - points, points - box.high), 0.0), axis=1))


def _farthest(cylinder: Cylinder, box: TouchBox) -> float:
    """The largest distance of a corner of the box from the axis; infinite where the box is open sideways."""
    open_ = ~(np.isfinite(box.low) & np.isfinite(box.high))
    across = 1 - cylinder.direction**2 > EPS
    if (open_ & across).any():
        return float("inf")
    # What is still open lies along the axis and does not count.
    low, high = np.where(open_, cylinder.point, box.low), np.where(open_, cylinder.point, box.high)
    corners = np.array([[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]] for i, j, k in np.ndindex(2, 2, 2)])
    arms = corners - cylinder.point
    return float(np.linalg.norm(arms - (arms @ cylinder.direction)[:, None] * cylinder.direction, axis=1).max())
