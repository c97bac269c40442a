"""Rules of the frame recipe: existing features of suitable types, and two different axes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from tactfix.fixture_format.build import axes_of
from tactfix.fixture_format.entries import Entries, Entry, Finding, Path
from tactfix.fixture_format.feature_rules import PLACE_KEYS

_FEET: Final = {("center", "cylinder"), ("center", "plane"), ("cylinder", "cylinder")}
_MEETINGS: Final = {("plane", "plane", "plane"), ("cylinder", "plane")}


def check_frame(entries: Entries) -> Iterator[Finding]:
    """Findings about the frame, or that it is missing."""
    frame = entries.frame
    if frame is None:
        yield from _check_absence(entries)
        return
    yield from _check_origin(frame["origin"], entries)
    axes = axes_of(frame)
    if len(axes) != 2:
        message = f"frame has {len(axes)} of the axes x, y, z"
        yield Finding(("frame",), message, "give two of them; the third follows", at_key=True)
    for axis, entry in axes:
        yield from _check_axis(("frame", axis), entry, entries)
        yield from _check_length(("frame", axis), entry, entries)
    if len(axes) == 2 and _names(axes[0][1]) == _names(axes[1][1]):
        message = f"{axes[0][0]} and {axes[1][0]} are defined by the same features"
        yield Finding(("frame", axes[1][0]), message, "take another feature for one of them")


def _check_absence(entries: Entries) -> Iterator[Finding]:
    """A frame is needed unless features are placed; if only some are, feature_rules reports the others."""
    named = [entry for entry in entries.named.values() if isinstance(entry, dict)]
    is_any_placed = any(entry.get(key) is not None for entry in named for key in PLACE_KEYS)
    if entries.written.get("frame") is None and entries.features and not is_any_placed:
        remedy = "add frame: {origin: ..., and two of x, y, z}, or give every feature its place"
        yield Finding((), "there is no frame, and the features have no places", remedy)


def _check_origin(origin: Entry, entries: Entries) -> Iterator[Finding]:
    if "center_of" in origin:
        yield from _check_center(origin["center_of"], entries)
    elif "foot_of" in origin:
        yield from _check_foot(origin["foot_of"], origin["on"], entries)
    else:
        yield from _check_meeting(origin["meet_of"], entries)


def _check_center(name: str, entries: Entries) -> Iterator[Finding]:
    path = ("frame", "origin", "center_of")
    yield from entries.unknown(name, path)
    if entries.kind_of(name) not in (None, "center"):
        message = f"{name} is a {entries.type_of(name)} and has no centre"
        yield Finding(path, message, "name a sphere or point, or use foot_of or meet_of")


def _check_foot(above: str, below: str, entries: Entries) -> Iterator[Finding]:
    yield from entries.unknown(above, ("frame", "origin", "foot_of"))
    yield from entries.unknown(below, ("frame", "origin", "on"))
    types = (entries.type_of(above), entries.type_of(below))
    if above == below:
        message = f"{above} has no foot on itself"
        yield Finding(("frame", "origin", "on"), message, "name the cylinder or plane that the foot is on")
    elif None not in types and (entries.kind_of(above), entries.kind_of(below)) not in _FEET:
        message = f"{above}, a {types[0]}, has no foot on {below}, a {types[1]}"
        remedy = "take a sphere or point above a cylinder or plane, or two cylinders"
        yield Finding(("frame", "origin"), message, remedy)


def _check_meeting(names: list[str], entries: Entries) -> Iterator[Finding]:
    for index, name in enumerate(names):
        yield from entries.unknown(name, ("frame", "origin", "meet_of", index))
    types = [entries.type_of(name) for name in names]
    if len(set(names)) < len(names):
        yield Finding(("frame", "origin", "meet_of"), "a feature is given twice", "name different features")
    elif None not in types and tuple(sorted(str(type_) for type_ in types)) not in _MEETINGS:
        message = f"a {' and a '.join(map(str, types))} do not meet in one point"
        yield Finding(("frame", "origin", "meet_of"), message, "name three planes, or a cylinder and a plane")


def _check_axis(path: Path, entry: Entry, entries: Entries) -> Iterator[Finding]:
    direction = entry
    if "opposite" in entry:
        path, direction = (*path, "opposite"), entry["opposite"]
    if "along" not in direction:
        yield from _check_from_to(path, direction["from"], direction["to"], entries)
        return
    yield from entries.unknown(direction["along"], (*path, "along"))
    if entries.kind_of(direction["along"]) == "center":
        message = f"{direction['along']} is a {entries.type_of(direction['along'])} and has no direction"
        yield Finding((*path, "along"), message, "name a cylinder or plane, or use from and to")


def _check_from_to(path: Path, start: str, end: str, entries: Entries) -> Iterator[Finding]:
    yield from entries.unknown(start, (*path, "from"))
    yield from entries.unknown(end, (*path, "to"))
    kinds = {entries.kind_of(start), entries.kind_of(end)}
    if start == end:
        yield Finding((*path, "to"), f"from and to are both {end}", "name another feature")
    elif None not in kinds and "plane" in kinds and "center" not in kinds:
        message = f"the direction from {start} to {end} is not defined"
        yield Finding(
            path, message, "use along for the normal of a plane; from and to take spheres, points and cylinders"
        )


def _check_length(path: Path, entry: Entry, entries: Entries) -> Iterator[Finding]:
    """A direction from one feature to another needs a non-zero distance."""
    direction = entry.get("opposite", entry)
    if "from" not in direction:
        return
    ends = {direction["from"], direction["to"]}
    if any(set(distance["between"]) == ends and distance["value"] == 0 for distance in entries.distances.values()):
        message = f"there is no direction from {direction['from']} to {direction['to']}: their distance is 0"
        yield Finding(path, message, "take another feature for this axis")


def _names(entry: Entry) -> frozenset[str]:
    """The features that define an axis, regardless of its sign."""
    direction = entry.get("opposite", entry)
    if "along" in direction:
        return frozenset((direction["along"],))
    return frozenset((direction["from"], direction["to"]))
