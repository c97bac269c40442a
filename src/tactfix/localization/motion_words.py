"""Motions in words that name the fixture's features: "rotates about the line through ball_1 and ball_2"."""

from collections.abc import Mapping, Sequence

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.geometry.motions import (
    Cylindrical,
    Fixed,
    Line,
    Motions,
    Planar,
    Prismatic,
    Revolute,
    Spherical,
    are_parallel,
    common_motions,
    is_on,
    twists,
)
from tactfix.geometry.scale import Tolerance, middle_of
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, reference_point
from tactfix.results import FreeMotion
from tactfix.wording import listed

Surfaces = Mapping[str, Surface]
ROUNDING_OF_WORDS = 1e-9
"""Share of the largest coordinate (or of 0.001, if all are smaller) below which a coordinate is rounding and printed as
zero; messages have four digits."""
_WHOLE_NUMBERS = 1e4
"""Coordinates of this size or more are printed as whole numbers: four digits would take a power of ten."""


def free_motions(surfaces: Surfaces, tolerance: Tolerance) -> tuple[FreeMotion, ...]:
    """A basis of the motions common to all surfaces, in their frame, each in words; translations first.

    Rotations are unit twists (rad), translations are unit vectors; a pure translation has rotation [0, 0, 0].
    """
    motions = common_motions(surfaces.values(), tolerance)
    messages = _messages(motions, surfaces, tolerance)
    return tuple(
        FreeMotion(twist[:3], twist[3:], message) for twist, message in zip(twists(motions), messages, strict=True)
    )


def _messages(motions: Motions, surfaces: Surfaces, tolerance: Tolerance) -> list[str]:
    """One sentence for each row of twists(motions), in that order."""
    match motions:
        case Fixed():
            return []
        case Prismatic():
            return [f"slides along {direction_in_words(motions.direction, surfaces, tolerance)}"]
        case Revolute():
            return [f"rotates about {line_in_words(motions.line, surfaces, tolerance)}"]
        case Cylindrical():
            words = line_in_words(motions.line, surfaces, tolerance)
            return [f"slides along {words}", f"rotates about {words}"]
        case Spherical():
            balls = listed([n for n, s in surfaces.items() if isinstance(s, Sphere | Point)])
            return [f"rotates about the line through the centre of {balls} parallel to {axis}" for axis in "xyz"]
        case Planar():
            planes = listed(list(surfaces))
            slides = [f"slides along {planes} in the direction {vector(t[3:])}" for t in twists(motions)[:2]]
            return [*slides, f"rotates about the normal of {planes}"]


def motion_in_words(twist: Floats, surfaces: Surfaces, tolerance: Tolerance) -> FreeMotion:
    """A twist (6,) at the origin of the surfaces' frame, rotation (rad) first, with its words."""
    return FreeMotion(twist[:3], twist[3:], twist_in_words(twist[:3], twist[3:], surfaces, tolerance))


def twist_in_words(rotation: Floats, translation: Floats, surfaces: Surfaces, tolerance: Tolerance) -> str:
    """Any motion in words: rotation (3,) rad and translation (3,) of the point at the origin of the surfaces' frame.

    A screw has its axis at the point (rotation x translation) / |rotation|^2 and the pitch
    2 pi rotation . translation / |rotation|^2 per turn (Chasles).
    """
    turn = float(np.linalg.norm(rotation))
    travel = float(np.linalg.norm(translation))
    here = float(np.linalg.norm(translation + np.cross(rotation, middle_of(surfaces.values()))))
    # No feature moves by the rotation as much as it does by the translation, to within the tolerance.
    if turn * tolerance.length <= tolerance.angle**2 * here:
        return f"slides along {direction_in_words(translation / travel, surfaces, tolerance)}"
    line = Line(np.cross(rotation, translation) / turn**2, rotation / turn)
    words = line_in_words(line, surfaces, tolerance)
    pitch = 2 * np.pi * float(rotation @ translation) / turn**2
    if abs(pitch) <= 2 * np.pi * tolerance.length:
        return f"rotates about {words}"
    return f"screws about {words}, {pitch:.4g} forward with each turn"


def line_in_words(line: Line, surfaces: Surfaces, tolerance: Tolerance) -> str:
    """A line named by the features that it belongs to, by numbers if there are none."""
    coaxial = [n for n, s in surfaces.items() if isinstance(s, Cylinder) and _is_axis(s, line, tolerance)]
    if coaxial:
        return f"the axis of {listed(coaxial)}"
    balls = [
        n for n, s in surfaces.items() if isinstance(s, Sphere | Point) and is_on(reference_point(s), line, tolerance)
    ]
    if _span(balls, surfaces) > tolerance.length:
        return f"the line through {listed(balls)}"
    for name, s in surfaces.items():
        if isinstance(s, Plane) and balls and are_parallel(s.normal, line.direction, tolerance):
            return f"the normal of {name} through the centre of {listed(balls)}"
    through = f"the centre of {listed(balls)}" if balls else vector(line.point)
    met = [n for n, s in surfaces.items() if isinstance(s, Cylinder) and _meets_square(s, line, tolerance)]
    if met:
        return f"the line through {through}, perpendicular to the axis of {listed(met)} and intersecting it"
    planes = [
        n for n, s in surfaces.items() if isinstance(s, Plane) and abs(s.normal @ line.direction) <= tolerance.angle
    ]
    along = f", parallel to {listed(planes)}" if len(planes) > 1 else ""
    return f"the line through {through} along {vector(line.direction)}{along}"


def direction_in_words(direction: Floats, surfaces: Surfaces, tolerance: Tolerance) -> str:
    """A direction named by the axes or planes that it lies along, by numbers if there are none."""
    axes = [
        name
        for name, s in surfaces.items()
        if isinstance(s, Cylinder) and are_parallel(s.direction, direction, tolerance)
    ]
    if axes:
        return f"the axis of {listed(axes)}"
    planes = [
        name for name, s in surfaces.items() if isinstance(s, Plane) and abs(s.normal @ direction) <= tolerance.angle
    ]
    if len(planes) > 1:
        return f"the common direction {vector(direction)} of {listed(planes)}"
    return f"the direction {vector(direction)}" + (f" of {planes[0]}" if planes else "")


def vector(values: Floats) -> str:
    """(1, 0, -0.5): four digits, whole numbers if large, no negative zero, and zero for rounding."""
    least = ROUNDING_OF_WORDS * max(1e-3, float(np.abs(values).max(initial=0.0)))
    shown = [0.0 if abs(value) < least else float(value) for value in values]
    return "(" + ", ".join(f"{value:.4g}" if abs(value) < _WHOLE_NUMBERS else f"{value:.0f}" for value in shown) + ")"


def _is_axis(cylinder: Cylinder, line: Line, tolerance: Tolerance) -> bool:
    """Whether the line is the cylinder's axis."""
    widened = _widened(tolerance, cylinder.point - line.point)
    return are_parallel(cylinder.direction, line.direction, tolerance) and is_on(cylinder.point, line, widened)


def _widened(tolerance: Tolerance, arm: Floats) -> Tolerance:
    """A length tolerance that allows for the angle over the distance at which two lines are compared."""
    return Tolerance(tolerance.angle, tolerance.length + tolerance.angle * float(np.linalg.norm(arm)))


def _span(balls: Sequence[str], surfaces: Surfaces) -> float:
    """The largest distance between the centres of the named spheres, 0 for fewer than two."""
    centers = [reference_point(surfaces[name]) for name in balls]
    return max((float(np.linalg.norm(a - b)) for a in centers for b in centers), default=0.0)


def _meets_square(cylinder: Cylinder, line: Line, tolerance: Tolerance) -> bool:
    """Whether the line meets the cylinder's axis at a right angle."""
    if abs(cylinder.direction @ line.direction) > tolerance.angle:
        return False
    square = np.cross(cylinder.direction, line.direction)
    return bool(abs((cylinder.point - line.point) @ square) <= tolerance.length)
