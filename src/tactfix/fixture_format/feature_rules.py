"""Rules of features: valid names, complete places, all or none placed. Rules of lengths: plausible in some unit.

Rules of distances and angles: valid pairs of features, valid values, and no contradiction among them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations
from typing import Final

from tactfix.fixture_format.entries import Entries, Entry, Finding, Path
from tactfix.geometry.nearest import ALMOST_PARALLEL
from tactfix.units import LEAST_LENGTH, MOST_LENGTH
from tactfix.wording import UNPRINTABLE

PLACE: Final[dict[str, tuple[str, ...]]] = {
    "plane": ("point", "normal"),
    "sphere": ("center",),
    "point": ("point",),
    "cylinder": ("point", "direction"),
}
"""Keys that place a feature of each type in the fixture frame."""
PLACE_KEYS: Final = frozenset(key for keys in PLACE.values() for key in keys)
# Characters that separate names in a contact file or on the command line (--features bar:5,ball:3).
_FORBIDDEN: Final = re.compile(rf"^\s|\s$|[,;:#\"'\t\n]|{UNPRINTABLE.pattern}")

_SIZES: Final = ("radius", "sigma", "tip_radius", "approach_distance", "tip_within", "translation")
_PLACES: Final = ("point", "center", "tip_offset", "x", "y", "z")
_NUMBER_REMEDY: Final = "check the number and the units of the file"


def given_places(feature: Entry) -> list[str]:
    """The keys of PLACE that the feature has."""
    return [key for key in PLACE[feature["type"]] if feature.get(key) is not None]


def check_features(entries: Entries) -> Iterator[Finding]:
    """Findings about names and places."""
    for name in entries.named:
        if _FORBIDDEN.search(name):
            remedy = "write a name without commas, semicolons, colons, quotes, # and outer blanks"
            yield Finding(("features", name), f"{name!r} is not a valid name of a feature", remedy, at_key=True)
    for name, feature in entries.features.items():
        yield from _check_place(name, feature)
    placed = [name for name, feature in entries.features.items() if given_places(feature)]
    unplaced = [name for name in entries.features if name not in placed]
    if placed and unplaced:
        for name in unplaced:
            keys = " and ".join(PLACE[entries.features[name]["type"]])
            message = f"{name} has no place in the fixture frame, {placed[0]} has one"
            remedy = f"give {keys} of {name} too, or no place to any feature"
            yield Finding(("features", name), message, remedy, at_key=True)


def _check_place(name: str, feature: Entry) -> Iterator[Finding]:
    given = given_places(feature)
    missing = [key for key in PLACE[feature["type"]] if key not in given]
    if given and missing:
        message = f"{name} has {given[0]} and no {missing[0]}"
        yield Finding(("features", name, given[0]), message, f"give {missing[0]} too, or leave out both", at_key=True)
    for key in ("normal", "direction"):
        vector = feature.get(key)
        if key in given and isinstance(vector, list) and not any(vector):
            yield Finding(("features", name, key), f"{name}: the {key} is zero", "write a vector of any other length")


def check_lengths(entries: Entries) -> Iterator[Finding]:
    """Findings about lengths too large, or too small and not 0; a normal or direction may have any non-zero length."""
    yield from _check_sizes(("probe",), entries.probe)
    for name, feature in entries.features.items():
        yield from _check_sizes(("features", name), feature)
    for index, distance in entries.distances.items():
        yield from _check_sizes(("distances", index), distance)
        yield from _beyond(("distances", index, "value"), distance["value"])
    for name, box in entries.touch.items():
        yield from _check_sizes(("touch", name), box)
    for key in ("within", "sigma"):
        yield from _check_sizes(("placement", key), (entries.placement or {}).get(key) or {})


def _check_sizes(path: Path, entry: Entry) -> Iterator[Finding]:
    for key in _SIZES:
        size = entry.get(key)
        if size is not None:
            yield from _beyond((*path, key), size)
            if 0 < size < LEAST_LENGTH:
                yield Finding(
                    (*path, key), f"{key} is {size:g}, below {LEAST_LENGTH:g}: no length in any unit", _NUMBER_REMEDY
                )
    for key in _PLACES:
        places: Iterable[float | None] = entry.get(key) or ()
        for index, place in enumerate(places):
            if place is not None:
                yield from _beyond((*path, key, index), place)


def _beyond(path: Path, length: float) -> Iterator[Finding]:
    if abs(length) > MOST_LENGTH:
        message = f"{length:g} is beyond {MOST_LENGTH:g}: no length in any unit"
        yield Finding(path, message, _NUMBER_REMEDY)


CONTRADICTION_SIGMAS: Final = 4.0
"""Known values contradict each other if they differ by more than this many sigmas, which a normal error does once in
16,000 times."""
_DISTANCE_ROUNDING: Final = 1e-6
"""Relative tolerance of distances, for their rounding."""


def check_relations(entries: Entries) -> Iterator[Finding]:
    """Findings about distances and angles."""
    yield from _check_pairs("distances", entries.distances, entries)
    yield from _check_pairs("angles", entries.angles, entries)
    for index, distance in entries.distances.items():
        yield from _check_distance(("distances", index), distance, entries)
    for index, angle in entries.angles.items():
        yield from _check_angle(("angles", index), angle, entries)
    yield from _check_triangles(entries)


def _check_pairs(section: str, relations: Mapping[int, Entry], entries: Entries) -> Iterator[Finding]:
    """Relations must be between two different existing features, each pair once."""
    first: dict[frozenset[str], int] = {}
    for index, relation in relations.items():
        for place, name in enumerate(relation["between"]):
            yield from entries.unknown(name, (section, index, "between", place))
        pair = frozenset(relation["between"])
        if len(pair) == 1:
            message = f"both features are {relation['between'][0]}"
            yield Finding((section, index, "between"), message, "name two features")
        elif pair in first:
            message = f"{section[:-1]} between {' and '.join(relation['between'])} is given twice"
            yield Finding((section, index, "between"), message, f"remove one (the other is number {first[pair] + 1})")
        first.setdefault(pair, index)


def _kinds(between: list[str], entries: Entries) -> tuple[str, ...]:
    """The kinds of both features, sorted; empty if one of them is unknown."""
    kinds = [entries.kind_of(name) for name in between]
    return tuple(sorted(kind for kind in kinds if kind)) if all(kinds) else ()


def _check_distance(path: Path, distance: Entry, entries: Entries) -> Iterator[Finding]:
    kinds = _kinds(distance["between"], entries)
    if not kinds:
        return
    if distance["value"] < 0 and kinds != ("center", "plane"):
        types = sorted(str(entries.type_of(name)) for name in distance["between"])
        message = f"a distance between {types[0]} and {types[1]} has no sign, this is {distance['value']:g}"
        yield Finding((*path, "value"), message, "write it without the sign")
    placed = any(given_places(entries.features[name]) for name in distance["between"])
    if placed:
        return
    names = " and ".join(distance["between"])
    angle = next((a["value"] for a in entries.angles.values() if set(a["between"]) == set(distance["between"])), None)
    if kinds == ("cylinder", "cylinder") and angle and math.sin(math.radians(angle)) < ALMOST_PARALLEL:
        message = f"{names} have a distance only if clearly skew or parallel; their angle is {angle:g}"
        remedy = f"give the angle 0 between {names} if they are parallel, or leave out the distance"
        yield Finding((*path, "between"), message, remedy)
    if kinds in (("plane", "plane"), ("cylinder", "plane")):
        wanted = (0.0, 180.0) if kinds == ("plane", "plane") else (90.0,)
        if angle not in wanted:
            known = "their angle is not given" if angle is None else f"their angle is {angle:g}"
            angles = " or ".join(f"{value:g}" for value in wanted)
            remedy = f"give the angle {angles} between {names} too, or leave out the distance"
            yield Finding((*path, "between"), f"{names} have a distance only if parallel; {known}", remedy)


def _check_angle(path: Path, angle: Entry, entries: Entries) -> Iterator[Finding]:
    for place, name in enumerate(angle["between"]):
        if entries.kind_of(name) == "center":
            message = f"{name} is a {entries.type_of(name)} and has no direction"
            yield Finding((*path, "between", place), message, "give angles between planes and cylinders")
    if "cylinder" in _kinds(angle["between"], entries) and angle["value"] > 90:
        message = f"an angle with the axis of a cylinder is at most 90, this is {angle['value']:g}"
        yield Finding((*path, "value"), message, f"an axis has no sign: write {180 - angle['value']:g}")


def _check_triangles(entries: Entries) -> Iterator[Finding]:
    """Triangle inequality for the distances of three centres."""
    index_of: dict[frozenset[str], int] = {}
    for index, distance in entries.distances.items():
        if _kinds(distance["between"], entries) == ("center", "center"):
            index_of.setdefault(frozenset(distance["between"]), index)
    names = sorted({name for pair in index_of for name in pair})
    for three in combinations(names, 3):
        pairs = [frozenset(pair) for pair in combinations(three, 2)]
        if not all(pair in index_of for pair in pairs):
            continue
        longest, *others = sorted(
            (entries.distances[index_of[pair]] for pair in pairs), key=lambda distance: -distance["value"]
        )
        excess = longest["value"] - sum(other["value"] for other in others)
        slack = (
            CONTRADICTION_SIGMAS * math.hypot(longest.get("sigma", 0.0), *(other.get("sigma", 0.0) for other in others))
            + _DISTANCE_ROUNDING * longest["value"]
        )
        if excess > slack:
            path = ("distances", index_of[frozenset(longest["between"])], "value")
            apart = " and ".join(longest["between"])
            message = f"{apart} are farther apart than their distances from {_third(three, longest)} allow"
            yield Finding(path, message, "check the three distances between these")


def _third(three: tuple[str, ...], side: Entry) -> str:
    return next(name for name in three if name not in side["between"])
