"""Converts a fixture to the plain values of a fixture file, the inverse of `read`."""

import math
from typing import Any, TypeAlias

import numpy as np

from tactfix.feature import Feature
from tactfix.fixture import AxisRule, Fixture, FrameRecipe, Relation, TouchBox
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere
from tactfix.placement import DIRECTIONS, Placement

Document: TypeAlias = dict[str, Any]


def fixture_document(fixture: Fixture) -> Document:
    """The mapping of a fixture file of format 1; lengths in the fixture's units, angles in degrees."""
    parts = {
        "tactfix": 1,
        "name": fixture.name,
        "units": fixture.units,
        "probe": _probe(fixture),
        "features": {name: feature_entry(feature) for name, feature in fixture.features.items()},
        "distances": [_relation(relation) for relation in fixture.relations if relation.kind == "distance"],
        "angles": [_relation(relation) for relation in fixture.relations if relation.kind == "angle"],
        "frame": None if fixture.frame is None else _frame(fixture.frame),
        "touch": {name: _box(box) for name, box in fixture.touch.items()},
        "placement": None if fixture.placement is None else _placement(fixture.placement),
    }
    return {key: value for key, value in parts.items() if value not in (None, {}, [])}


def feature_entry(feature: Feature) -> Document:
    """The entry of one feature."""
    entry: Document = {"type": feature.type}
    if feature.radius is not None:
        entry["radius"] = feature.radius
    if feature.side != "outer":
        entry["side"] = feature.side
    match feature.surface:
        case Plane(point, normal):
            entry |= {"point": _list(point), "normal": _list(normal)}
        case Sphere(center):
            entry |= {"center": _list(center)}
        case Cylinder(point, direction):
            entry |= {"point": _list(point), "direction": _list(direction)}
        case Point():
            entry |= {"point": _list(feature.surface.point)}
        case None:
            pass
    return entry | ({"sigma": feature.sigma} if feature.sigma else {})


def _probe(fixture: Fixture) -> Document:
    probe = fixture.probe
    values = {
        "tip_radius": probe.tip_radius,
        "sigma": probe.sigma,
        "approach_distance": probe.approach_distance,
        "tip_offset": None if probe.tip_offset is None else list(probe.tip_offset),
        "tip_within": probe.tip_within,
    }
    return {key: value for key, value in values.items() if value is not None}


def _relation(relation: Relation) -> Document:
    unit = 1.0 if relation.kind == "distance" else 180 / math.pi
    entry = {"between": list(relation.between), "value": _plain(unit * relation.value, relation.kind)}
    return entry | ({"sigma": _plain(unit * relation.sigma, relation.kind)} if relation.sigma else {})


def _plain(value: float, kind: str) -> float:
    """An angle to 15 digits; the sixteenth is rounding of the conversion from rad to degrees."""
    return value if kind == "distance" else float(f"{value:.15g}")


def _frame(recipe: FrameRecipe) -> Document:
    names = recipe.origin.features
    origin: Document = {recipe.origin.kind: list(names)}
    if recipe.origin.kind == "center_of":
        origin = {"center_of": names[0]}
    elif recipe.origin.kind == "foot_of":
        origin = {"foot_of": names[0], "on": names[1]}
    return {"origin": origin, recipe.first[0]: _axis(recipe.first[1]), recipe.second[0]: _axis(recipe.second[1])}


def _axis(rule: AxisRule) -> Document:
    names = rule.features
    direction = {"along": names[0]} if rule.kind == "along" else {"from": names[0], "to": names[1]}
    return {"opposite": direction} if rule.opposite else direction


def _box(box: TouchBox) -> Document:
    ends = {axis: [_end(box.low[k]), _end(box.high[k])] for k, axis in enumerate("xyz")}
    return {axis: interval for axis, interval in ends.items() if interval != [None, None]}


def _end(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _placement(placement: Placement) -> Document:
    entry: Document = {"near": {"matrix": [_list(row) for row in placement.near]}}
    for key, limits in (("within", placement.within), ("sigma", placement.sigma)):
        if isinstance(limits, tuple):
            entry[key] = {"translation": limits[0], "rotation": _plain(math.degrees(limits[1]), "angle")}
    if placement.free is not None:
        entry["free"] = [direction for direction in DIRECTIONS if direction in placement.free]
    return entry


def _list(values: Floats) -> list[float]:
    return [float(value) for value in np.asarray(values) + 0.0]
