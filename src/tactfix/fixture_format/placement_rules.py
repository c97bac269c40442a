"""Where features carry their place: what else the file says must agree with it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from tactfix.fixture_format.box_reach import leaves_nothing
from tactfix.fixture_format.build import AXES, box_of, recipe_of, surface_of
from tactfix.fixture_format.problems import Finding
from tactfix.fixture_format.relation_rules import SIGMAS
from tactfix.frame import FrameError, frames
from tactfix.geometry.arrays import Floats
from tactfix.geometry.nearest import angle_between, distance_between
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface

if TYPE_CHECKING:
    from tactfix.fixture_format.entries import FixtureEntry

# Directions typed with four digits are parallel within this sine.
_PARALLEL = 1e-4
# Places and directions are typed with some digits: this share of the fixture's size is never a contradiction.
_TYPED = 1e-6
# A frame that is off by more than this share of the fixture's size, or this angle in rad, is another frame.
_FRAME = 1e-4
# "25.4" stands for anything that rounds to it, but not for more than this share of it.
_MOST_ROUNDING = 1e-4


def check_agreement(document: FixtureEntry) -> list[Finding]:
    """Relations, frame and touch boxes that contradict the places, which every feature must have."""
    places = {name: surface_of(feature) for name, feature in document["features"].items()}
    surfaces = {name: surface for name, surface in places.items() if surface is not None}
    return [
        *_check_distances(document, surfaces),
        *_check_angles(document, surfaces),
        *_check_frame(document, surfaces),
        *_check_boxes(document, surfaces),
    ]


def _rounding(value: float) -> float:
    """Half of the last digit that a value is written with, within reason."""
    _, _, decimals = repr(abs(value)).partition(".")
    half = 0.5 * 10.0 ** -len(decimals) if "e" not in decimals else 0.0
    return min(half, _MOST_ROUNDING * abs(value))


def _check_distances(document: FixtureEntry, surfaces: Mapping[str, Surface]) -> Iterator[Finding]:
    size = _size(surfaces)
    for index, distance in enumerate(document.get("distances", [])):
        a, b = (surfaces[name] for name in distance["between"])
        names = " and ".join(distance["between"])
        if not _has_distance(a, b):
            what = f"{names} have a distance only where parallel, and their places are not"
            yield Finding(("distances", index, "between"), what, "leave out the distance, or correct the places")
            continue
        measured = distance_between(a, b)
        if not isinstance(a, Sphere) and not isinstance(b, Sphere):
            measured = abs(measured)  # only a sphere has a side of a plane
        slack = SIGMAS * distance.get("sigma", 0.0) + _rounding(distance["value"]) + _TYPED * size
        if all(abs(meant - distance["value"]) > slack for meant in (measured, *_askew(a, b))):
            what = f"the distance of {names} is {distance['value']:.10g}, but their places make it {measured:.9g}"
            yield Finding(("distances", index, "value"), what, "correct one of them; the distance may be left out")


def _askew(a: Surface, b: Surface) -> tuple[float, ...]:
    """The length of the common perpendicular of two axes, for nearly parallel ones another than their spacing."""
    if not isinstance(a, Cylinder) or not isinstance(b, Cylinder):
        return ()
    square = np.cross(a.direction, b.direction)
    sine = float(np.linalg.norm(square))
    return (abs(float((b.point - a.point) @ square)) / sine,) if sine > _PARALLEL else ()


def _has_distance(a: Surface, b: Surface) -> bool:
    """Whether a distance means something: planes, and a plane and an axis, have one only where parallel."""
    if isinstance(a, Sphere) or isinstance(b, Sphere) or (isinstance(a, Cylinder) and isinstance(b, Cylinder)):
        return True
    angle = angle_between(a, b)
    return (math.cos(angle) if isinstance(a, Cylinder) or isinstance(b, Cylinder) else math.sin(angle)) < _PARALLEL


def _check_angles(document: FixtureEntry, surfaces: Mapping[str, Surface]) -> Iterator[Finding]:
    for index, angle in enumerate(document.get("angles", [])):
        a, b = (surfaces[name] for name in angle["between"])
        if isinstance(a, Sphere) or isinstance(b, Sphere):
            continue  # refused already
        measured = math.degrees(angle_between(a, b))
        slack = SIGMAS * angle.get("sigma", 0.0) + _rounding(angle["value"]) + math.degrees(_PARALLEL)
        if abs(measured - angle["value"]) > slack:
            names = " and ".join(angle["between"])
            what = f"the angle of {names} is {angle['value']:.10g}, but their places make it {measured:.9g}"
            yield Finding(("angles", index, "value"), what, "correct one of them; the angle may be left out")


def _check_boxes(document: FixtureEntry, surfaces: Mapping[str, Surface]) -> Iterator[Finding]:
    for name, model in document.get("touch", {}).items():
        if leaves_nothing(surfaces[name], box_of(model), _TYPED * _size(surfaces)):
            what = f"the touch box of {name} does not meet its surface"
            yield Finding(
                ("touch", name), what, "correct the box or the place; a box is in the fixture frame", at_key=True
            )


def _check_frame(document: FixtureEntry, surfaces: Mapping[str, Surface]) -> Iterator[Finding]:
    frame = document.get("frame")
    if frame is None:
        return
    recipe = recipe_of(frame, document["features"])
    remedy = "leave out the frame: features with places need none"
    try:
        choices = frames(recipe, surfaces)
    except FrameError as error:
        yield Finding(("frame",), str(error).removeprefix("frame: "), remedy, at_key=True)
        return
    # The axes of cylinders have no sign: of the frames that are left open, the one that agrees best.
    built = min(choices, key=lambda matrix: float(np.abs(matrix[:3, :3] - np.eye(3)).sum()))
    if np.linalg.norm(built[:3, 3]) > _FRAME * _size(surfaces):
        what = f"the places of the features put this origin at {_shown(built[:3, 3])}, not at 0"
        yield Finding(("frame", "origin"), what, remedy)
    for axis, _ in (recipe.first, recipe.second):
        k = AXES.index(axis)
        if np.linalg.norm(built[:3, k] - np.eye(3)[k]) > _FRAME:
            what = f"the places of the features turn {axis} to {_shown(built[:3, k])}"
            yield Finding(("frame", axis), what, remedy)


def _shown(vector: Floats) -> str:
    return f"({', '.join(f'{value:.6g}' for value in vector + 0.0)})"


def _size(surfaces: Mapping[str, Surface]) -> float:
    """How large the fixture is: the largest coordinate or radius in it."""
    lengths = [
        max(
            float(np.abs(s.center if isinstance(s, Sphere) else s.point).max()),
            0.0 if isinstance(s, Plane) else s.radius,
        )
        for s in surfaces.values()
    ]
    return max(lengths)
