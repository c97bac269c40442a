"""From what the file says to what a fixture is: plain values, angles in rad."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

import numpy as np

from tactfix.fixture import Axis, AxisRule, Feature, Fixture, FrameRecipe, OriginRule, Probe, Relation, TouchBox
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface

if TYPE_CHECKING:
    from tactfix.fixture_format.entries import (
        AxisEntry,
        FeatureEntry,
        FixtureEntry,
        FrameEntry,
        Interval,
        OriginEntry,
        TouchEntry,
    )

AXES: Final[tuple[Axis, ...]] = ("x", "y", "z")


def build_fixture(document: FixtureEntry, name: str) -> Fixture:
    """The fixture of a file in which the rules found nothing wrong; name: if it gives none itself."""
    probe, frame = document.get("probe", {}), document.get("frame")
    return Fixture(
        name=document.get("name") or name,
        units=document["units"],
        probe=Probe(probe.get("tip_radius"), probe.get("sigma"), probe.get("approach_distance")),
        features={name: build_feature(name, entry) for name, entry in document["features"].items()},
        relations=relations_of(document),
        frame=None if frame is None else recipe_of(frame, document["features"]),
        touch={name: box_of(entry) for name, entry in document.get("touch", {}).items()},
    )


def build_feature(name: str, entry: FeatureEntry) -> Feature:
    """One feature."""
    radius = None if entry["type"] == "plane" else float(entry["radius"])
    return Feature(
        name, entry["type"], radius, entry.get("side", "outer"), float(entry.get("sigma", 0.0)), surface_of(entry)
    )


def surface_of(entry: FeatureEntry) -> Surface | None:
    """Where a feature is in the fixture frame, None where the file does not say."""
    side = entry.get("side", "outer")
    match entry:
        case {"type": "plane", "point": list(point), "normal": list(normal)}:
            return Plane(_vector(point), _direction(normal))
        case {"type": "sphere", "center": list(center), "radius": radius}:
            return Sphere(_vector(center), float(radius), side)
        case {"type": "cylinder", "point": list(point), "direction": list(direction), "radius": radius}:
            return Cylinder(_vector(point), _direction(direction), float(radius), side)
        case _:
            return None


def relations_of(document: FixtureEntry) -> tuple[Relation, ...]:
    """The distances, then the angles, angles in rad."""
    distances = [
        Relation("distance", (d["between"][0], d["between"][1]), float(d["value"]), float(d.get("sigma", 0.0)))
        for d in document.get("distances", [])
    ]
    angles = [
        Relation("angle", (a["between"][0], a["between"][1]), math.radians(a["value"]), math.radians(a.get("sigma", 0)))
        for a in document.get("angles", [])
    ]
    return (*distances, *angles)


def recipe_of(frame: FrameEntry, features: Mapping[str, FeatureEntry]) -> FrameRecipe:
    """The frame recipe; [plane, cylinder] is turned into [cylinder, plane]."""
    (first, first_rule), (second, second_rule) = axes_of(frame)
    return FrameRecipe(
        _origin_rule(frame["origin"], features), (first, _axis_rule(first_rule)), (second, _axis_rule(second_rule))
    )


def axes_of(frame: FrameEntry) -> list[tuple[Axis, AxisEntry]]:
    """The axes that are given, in the order in which they are written."""
    given = [(axis, frame.get(axis)) for axis in frame if axis in AXES]
    return [(axis, entry) for axis, entry in given if isinstance(entry, dict)]


def _origin_rule(entry: OriginEntry, features: Mapping[str, FeatureEntry]) -> OriginRule:
    if "center_of" in entry:
        return OriginRule("center_of", (entry["center_of"],))
    if "foot_of" in entry:
        return OriginRule("foot_of", (entry["foot_of"], entry["on"]))
    return OriginRule("meet_of", tuple(sorted(entry["meet_of"], key=lambda name: features[name]["type"] == "plane")))


def _axis_rule(entry: AxisEntry) -> AxisRule:
    direction = entry.get("opposite", entry)
    if "along" in direction:
        return AxisRule("along", (direction["along"],), "opposite" in entry)
    return AxisRule("from_to", (direction["from"], direction["to"]), "opposite" in entry)


def box_of(entry: TouchEntry) -> TouchBox:
    """The touch box, infinite where the file leaves it open."""
    low, high = zip(_ends(entry.get("x")), _ends(entry.get("y")), _ends(entry.get("z")), strict=True)
    return TouchBox(np.array(low), np.array(high))


def _ends(interval: Interval | None) -> tuple[float, float]:
    low, high = interval or (None, None)
    return -math.inf if low is None else low, math.inf if high is None else high


def _vector(values: list[float]) -> Floats:
    return np.array(values, dtype=np.float64)


def _direction(values: list[float]) -> Floats:
    """Scaled to a largest component of one, so that no square under- or overflows."""
    vector = _vector(values)
    return np.asarray(vector / np.abs(vector).max())
