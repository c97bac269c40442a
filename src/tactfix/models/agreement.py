"""Where features carry their place: what else the file says must agree with it."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from tactfix.fixture import AxisRule, FrameRecipe, OriginRule
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface, feet, radial, residuals
from tactfix.models.box_reach import leaves_nothing
from tactfix.models.build import box_of, recipe_of, surface_of
from tactfix.models.entries import FixtureEntry
from tactfix.models.feature_sense import is_placed
from tactfix.models.findings import Finding
from tactfix.models.measures import (
    PARALLEL,
    angle_between,
    are_parallel,
    common_perpendicular,
    direction_of,
    distance_between,
)
from tactfix.models.relation_sense import SIGMAS

# Places and directions are typed with some digits: this share of the fixture's size is never a contradiction.
_TYPED = 1e-6
# A frame that is off by more than this share of the fixture's size, or this angle in rad, is another frame.
_FRAME = 1e-4
# "25.4" stands for anything that rounds to it, but not for more than this share of it.
_MOST_ROUNDING = 1e-4


def check_agreement(document: FixtureEntry) -> list[Finding]:
    """Relations, frame and touch boxes that contradict the places of the features; none where these have no place."""
    if not is_placed(document):
        return []
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
        if isinstance(a, Plane | Cylinder) and isinstance(b, Plane | Cylinder) and not _has_distance(a, b):
            angle = math.degrees(angle_between(a, b))
            what = f"{names} have a distance only where parallel; their places make an angle of {angle:.6g}"
            yield Finding(("distances", index, "between"), what, "leave out the distance, or correct the places")
            continue
        measured = distance_between(a, b)
        if (
            abs(measured - distance["value"])
            > SIGMAS * distance.get("sigma", 0.0) + _rounding(distance["value"]) + _TYPED * size
        ):
            what = f"the distance of {names} is {distance['value']:g}, but their places make it {measured:.9g}"
            yield Finding(("distances", index, "value"), what, "correct one of them; the distance may be left out")


def _has_distance(a: Surface, b: Surface) -> bool:
    return (isinstance(a, Cylinder) and isinstance(b, Cylinder)) or are_parallel(a, b)


def _check_angles(document: FixtureEntry, surfaces: Mapping[str, Surface]) -> Iterator[Finding]:
    for index, angle in enumerate(document.get("angles", [])):
        a, b = (surfaces[name] for name in angle["between"])
        measured = math.degrees(angle_between(a, b))
        slack = SIGMAS * angle.get("sigma", 0.0) + _rounding(angle["value"]) + math.degrees(PARALLEL)
        if abs(measured - angle["value"]) > slack:
            names = " and ".join(angle["between"])
            what = f"the angle of {names} is {angle['value']:g}, but their places make it {measured:.9g}"
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
    origin = _origin(recipe.origin, surfaces)
    if origin is None:
        what = f"{recipe.origin.kind} {', '.join(recipe.origin.features)} is no point: the places make it parallel"
        yield Finding(("frame", "origin"), what, remedy)
    elif np.linalg.norm(origin) > _FRAME * _size(surfaces):
        at = ", ".join(f"{value:.6g}" for value in origin)
        yield Finding(("frame", "origin"), f"the places of the features put this origin at ({at}), not at 0", remedy)
    yield from _check_axes(recipe, surfaces, remedy)


def _check_axes(recipe: FrameRecipe, surfaces: Mapping[str, Surface], remedy: str) -> Iterator[Finding]:
    first = np.zeros(3)
    for axis, rule in (recipe.first, recipe.second):
        direction = _direction(rule, surfaces)
        direction = direction - (direction @ first) * first
        length = float(np.linalg.norm(direction))
        wanted = np.eye(3)["xyz".index(axis)]
        if length < _FRAME:
            yield Finding(("frame", axis), f"the places of the features leave {axis} without a direction", remedy)
            return
        direction = direction / length
        if rule.kind == "along" and isinstance(surfaces[rule.features[0]], Cylinder):
            direction = direction * np.copysign(1.0, direction @ wanted)
        if np.linalg.norm(direction - wanted) > _FRAME:
            along = ", ".join(f"{value:.6g}" for value in direction + 0.0)
            yield Finding(("frame", axis), f"the places of the features turn {axis} to ({along})", remedy)
        first = wanted


def _direction(rule: AxisRule, surfaces: Mapping[str, Surface]) -> Floats:
    """The direction (3,) that a rule means; of length one unless it has none."""
    sign = -1.0 if rule.opposite else 1.0
    if rule.kind == "along":
        return sign * direction_of(surfaces[rule.features[0]])
    vector = _between(*(surfaces[name] for name in rule.features))
    length = float(np.linalg.norm(vector))
    return sign * vector / length if length > _TYPED * _size(surfaces) else np.zeros(3)


def _between(start: Surface, end: Surface) -> Floats:
    """The shortest vector (3,) from the centre, axis or face of start to that of end."""
    match start, end:
        case Sphere(), Sphere():
            return np.asarray(end.center - start.center)
        case Cylinder(), Cylinder():
            return common_perpendicular(start, end)
        case Cylinder(), Sphere():
            return radial(start, end.center)
        case Plane(), Sphere():
            return np.asarray(residuals(start, end.center, 0.0) * start.normal)
        case _:
            return -_between(end, start)


def _origin(rule: OriginRule, surfaces: Mapping[str, Surface]) -> Floats | None:
    """The point (3,) that a rule means; None where parallel features make it none."""
    match [surfaces[name] for name in rule.features]:
        case [Sphere() as sphere]:
            return sphere.center
        case [Sphere() as above, Plane() as plane]:
            return feet(plane, above.center)
        case [Sphere() as above, Cylinder() as below]:
            return np.asarray(above.center - radial(below, above.center))
        case [Cylinder() as above, Cylinder() as below]:
            return _crossing(above, below)
        case [Cylinder() as bar, Plane() as plane]:
            rate = float(bar.direction @ plane.normal)
            height = residuals(plane, bar.point, 0.0)
            return None if abs(rate) < PARALLEL else np.asarray(bar.point - height / rate * bar.direction)
        case planes:
            normals = np.array([direction_of(plane) for plane in planes])
            offsets = np.array([direction_of(p) @ p.point for p in planes if isinstance(p, Plane)])
            return None if abs(np.linalg.det(normals)) < PARALLEL else np.linalg.solve(normals, offsets)


def _crossing(above: Cylinder, below: Cylinder) -> Floats | None:
    """The point (3,) of the axis of below that is nearest to the axis of above."""
    if are_parallel(above, below):
        return None
    # Seen along the axis of above, the foot is where the axis of below comes nearest to its point.
    sideways = below.direction - (below.direction @ above.direction) * above.direction
    rate = float(sideways @ sideways)
    return np.asarray(below.point + ((above.point - below.point) @ sideways) / rate * below.direction)


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
