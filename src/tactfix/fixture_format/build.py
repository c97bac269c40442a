"""Converts the plain values of a checked fixture file to a Fixture; angles to rad."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from tactfix.feature import Feature
from tactfix.fixture import Axis, AxisRule, Fixture, FrameRecipe, OriginRule, Probe, Relation, TouchBox
from tactfix.fixture_format.entries import Entries, Entry
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface
from tactfix.placement import Placement

AXIS_KEYS: Final[tuple[Axis, ...]] = ("x", "y", "z")


ROUNDED = 1e-9
"""Distances below this share of the fixture's largest length are zero: it is above rounding in doubles (1e-15) and
below any distance on a real part. Only features that coincide have no direction from one to the other."""


def build_fixture(entries: Entries, name: str, placement: Placement | None) -> Fixture:
    """The fixture of a file that has passed schema and rules; name: default for a file without one."""
    return Fixture(
        name=entries.written.get("name") or name,
        units=entries.written["units"],
        probe=_probe(entries.probe),
        features={name: _feature(name, entry) for name, entry in entries.features.items()},
        relations=_relations(entries),
        frame=None if entries.frame is None else _recipe(entries.frame, entries),
        touch={name: _box(entry) for name, entry in entries.touch.items()},
        placement=placement,
    )


def _probe(entry: Entry) -> Probe:
    offset = entry.get("tip_offset")
    return Probe(
        tip_radius=_number(entry.get("tip_radius")),
        sigma=_number(entry.get("sigma")),
        approach_distance=_number(entry.get("approach_distance")),
        tip_offset=None if offset is None else (float(offset[0]), float(offset[1]), float(offset[2])),
        tip_within=_number(entry.get("tip_within")),
    )


def _number(value: float | None) -> float | None:
    """As float: the file may hold an integer."""
    return None if value is None else float(value)


def _feature(name: str, entry: Entry) -> Feature:
    radius = _number(entry.get("radius"))
    return Feature(
        name, entry["type"], radius, entry.get("side", "outer"), float(entry.get("sigma", 0.0)), _surface(entry)
    )


def _surface(entry: Entry) -> Surface | None:
    """The surface of a feature in the fixture frame, None if the file does not place it."""
    side = entry.get("side", "outer")
    match entry:
        case {"type": "plane", "point": list(point), "normal": list(normal)}:
            return Plane(_vector(point), _direction(normal))
        case {"type": "point", "point": list(point)}:
            return Point(_vector(point))
        case {"type": "sphere", "center": list(center), "radius": radius}:
            return Sphere(_vector(center), float(radius), side)
        case {"type": "cylinder", "point": list(point), "direction": list(direction), "radius": radius}:
            return Cylinder(_vector(point), _direction(direction), float(radius), side)
        case _:
            return None


def _relations(entries: Entries) -> tuple[Relation, ...]:
    """The distances, then the angles, angles in rad."""
    given = entries.distances.values()
    radii = (entry.get("radius") or 0.0 for entry in entries.named.values())
    smallest = ROUNDED * max([*(abs(d["value"]) for d in given), *radii], default=0.0)
    distances = [
        Relation(
            "distance",
            (d["between"][0], d["between"][1]),
            float(d["value"]) if abs(d["value"]) > smallest else 0.0,
            float(d.get("sigma", 0.0)),
        )
        for d in given
    ]
    angles = [
        Relation("angle", (a["between"][0], a["between"][1]), math.radians(a["value"]), math.radians(a.get("sigma", 0)))
        for a in entries.angles.values()
    ]
    return (*distances, *angles)


def _recipe(frame: Entry, entries: Entries) -> FrameRecipe:
    """The frame recipe; [plane, cylinder] is turned into [cylinder, plane]."""
    (first, first_rule), (second, second_rule) = axes_of(frame)
    return FrameRecipe(
        _origin_rule(frame["origin"], entries), (first, _axis_rule(first_rule)), (second, _axis_rule(second_rule))
    )


def axes_of(frame: Entry) -> list[tuple[Axis, Entry]]:
    """The axes that are given, in the order in which they are written."""
    given = [(axis, frame.get(axis)) for axis in frame if axis in AXIS_KEYS]
    return [(axis, entry) for axis, entry in given if isinstance(entry, dict)]


def _origin_rule(entry: Entry, entries: Entries) -> OriginRule:
    if "center_of" in entry:
        return OriginRule("center_of", (entry["center_of"],))
    if "foot_of" in entry:
        return OriginRule("foot_of", (entry["foot_of"], entry["on"]))
    return OriginRule("meet_of", tuple(sorted(entry["meet_of"], key=lambda name: entries.type_of(name) == "plane")))


def _axis_rule(entry: Entry) -> AxisRule:
    direction = entry.get("opposite", entry)
    if "along" in direction:
        return AxisRule("along", (direction["along"],), "opposite" in entry)
    return AxisRule("from_to", (direction["from"], direction["to"]), "opposite" in entry)


def _box(entry: Entry) -> TouchBox:
    """The touch box, infinite on open sides."""
    low, high = zip(_ends(entry.get("x")), _ends(entry.get("y")), _ends(entry.get("z")), strict=True)
    return TouchBox(np.array(low), np.array(high))


def _ends(interval: list[float | None] | None) -> tuple[float, float]:
    low, high = interval or (None, None)
    return -math.inf if low is None else float(low), math.inf if high is None else float(high)


def _vector(values: list[float]) -> Floats:
    return np.array(values, dtype=np.float64)


def _direction(values: list[float]) -> Floats:
    """Divided by the largest component, so that no square under- or overflows."""
    vector = _vector(values)
    return np.asarray(vector / np.abs(vector).max())
