"""Distances and angles: between which features, of which size, and no contradiction among themselves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Final

from tactfix.fixture_format.entries import Entries, Entry
from tactfix.fixture_format.feature_rules import given_places
from tactfix.fixture_format.problems import Finding, Path
from tactfix.geometry.nearest import ALMOST_PARALLEL

# Known values may contradict each other by what their sigmas explain: four of them, one in 16,000.
CONTRADICTION_SIGMAS: Final = 4.0
_DISTANCE_ROUNDING: Final = 1e-6
"""Share of a distance that rounding to six decimals may make of it."""


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
    """Two different features that exist, and each pair once."""
    first: dict[frozenset[str], int] = {}
    for index, relation in relations.items():
        for place, name in enumerate(relation["between"]):
            yield from entries.unknown(name, (section, index, "between", place))
        pair = frozenset(relation["between"])
        if len(pair) == 1:
            what = f"{relation['between'][0]} stands on both sides"
            yield Finding((section, index, "between"), what, "name two features")
        elif pair in first:
            what = f"{section[:-1]} between {' and '.join(relation['between'])} is given twice"
            yield Finding((section, index, "between"), what, f"remove one (the other is number {first[pair] + 1})")
        first.setdefault(pair, index)


def _kinds(between: list[str], entries: Entries) -> tuple[str, ...]:
    """The kinds of both features, sorted; empty where one of them is not known."""
    kinds = [entries.kind_of(name) for name in between]
    return tuple(sorted(kind for kind in kinds if kind)) if all(kinds) else ()


def _check_distance(path: Path, distance: Entry, entries: Entries) -> Iterator[Finding]:
    kinds = _kinds(distance["between"], entries)
    if not kinds:
        return
    if distance["value"] < 0 and kinds != ("center", "plane"):
        types = sorted(str(entries.type_of(name)) for name in distance["between"])
        what = f"a distance between {types[0]} and {types[1]} has no sign, this is {distance['value']:g}"
        yield Finding((*path, "value"), what, "write it without the sign")
    placed = any(given_places(entries.features[name]) for name in distance["between"])
    if placed:
        return
    names = " and ".join(distance["between"])
    angle = next((a["value"] for a in entries.angles.values() if set(a["between"]) == set(distance["between"])), None)
    if kinds == ("cylinder", "cylinder") and angle and math.sin(math.radians(angle)) < ALMOST_PARALLEL:
        what = f"{names} have a distance only where clearly askew or parallel; their angle is {angle:g}"
        remedy = f"give the angle 0 between {names} if they are parallel, or leave out the distance"
        yield Finding((*path, "between"), what, remedy)
    if kinds in (("plane", "plane"), ("cylinder", "plane")):
        wanted = (0.0, 180.0) if kinds == ("plane", "plane") else (90.0,)
        if angle not in wanted:
            known = "their angle is not given" if angle is None else f"their angle is {angle:g}"
            angles = " or ".join(f"{value:g}" for value in wanted)
            remedy = f"give the angle {angles} between {names} too, or leave out the distance"
            yield Finding((*path, "between"), f"{names} have a distance only where parallel; {known}", remedy)


def _check_angle(path: Path, angle: Entry, entries: Entries) -> Iterator[Finding]:
    for place, name in enumerate(angle["between"]):
        if entries.kind_of(name) == "center":
            what = f"{name} is a {entries.type_of(name)} and has no direction"
            yield Finding((*path, "between", place), what, "give angles between planes and cylinders")
    if "cylinder" in _kinds(angle["between"], entries) and angle["value"] > 90:
        what = f"an angle with the axis of a cylinder is at most 90, this is {angle['value']:g}"
        yield Finding((*path, "value"), what, f"an axis has no sign: write {180 - angle['value']:g}")


def _check_triangles(entries: Entries) -> Iterator[Finding]:
    """No side of three centres is longer than the other two together."""
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
            what = (
                f"{' and '.join(longest['between'])} are further apart than the way round over {_third(three, longest)}"
            )
            yield Finding(path, what, "check the three distances between these")


def _third(three: tuple[str, ...], side: Entry) -> str:
    return next(name for name in three if name not in side["between"])
