"""The frame recipe: features that exist, of types that the rules can use, and two axes that are not the same."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from tactfix.fixture_format.build import axes_of
from tactfix.fixture_format.declared import Declared
from tactfix.fixture_format.feature_rules import given_places, is_placed
from tactfix.fixture_format.problems import Finding, Path

if TYPE_CHECKING:
    from tactfix.fixture_format.entries import AxisEntry, DirectionEntry, FixtureEntry, OriginEntry

_FEET: Final = {("sphere", "cylinder"), ("sphere", "plane"), ("cylinder", "cylinder")}
_MEETINGS: Final = {("plane", "plane", "plane"), ("cylinder", "plane")}


def check_frame(document: FixtureEntry, declared: Declared) -> Iterator[Finding]:
    """Findings about the frame, and that it is missing where it is needed."""
    frame = document.get("frame")
    if frame is None:
        if not declared.frame_refused and not is_placed(document) and not _is_any_placed(document):
            remedy = "add frame: {origin: ..., and two of x, y, z}, or give every feature its place"
            yield Finding((), "there is no frame, and the features do not carry their place", remedy)
        return
    yield from _check_origin(frame["origin"], declared)
    axes = axes_of(frame)
    if len(axes) != 2:
        what = f"frame has {len(axes)} of the axes x, y, z"
        yield Finding(("frame",), what, "give two of them; the third follows", at_key=True)
    for axis, entry in axes:
        yield from _check_axis(("frame", axis), entry, declared)
        yield from _check_length(("frame", axis), entry, document)
    if len(axes) == 2 and _names(axes[0][1]) == _names(axes[1][1]):
        what = f"{axes[0][0]} and {axes[1][0]} follow the same line"
        yield Finding(("frame", axes[1][0]), what, "take another feature for one of them")


def _is_any_placed(document: FixtureEntry) -> bool:
    """Whether places have been begun: then what misses is told there."""
    return any(given_places(feature) for feature in document["features"].values())


def _check_origin(origin: OriginEntry, declared: Declared) -> Iterator[Finding]:
    if "center_of" in origin:
        yield from _check_center(origin["center_of"], declared)
    elif "foot_of" in origin:
        yield from _check_foot(origin["foot_of"], origin["on"], declared)
    else:
        yield from _check_meeting(origin["meet_of"], declared)


def _check_center(name: str, declared: Declared) -> Iterator[Finding]:
    path = ("frame", "origin", "center_of")
    yield from declared.unknown(name, path)
    if declared.type_of(name) not in (None, "sphere"):
        what = f"{name} is a {declared.type_of(name)} and has no centre"
        yield Finding(path, what, "name a sphere, or use foot_of or meet_of")


def _check_foot(above: str, below: str, declared: Declared) -> Iterator[Finding]:
    yield from declared.unknown(above, ("frame", "origin", "foot_of"))
    yield from declared.unknown(below, ("frame", "origin", "on"))
    types = (declared.type_of(above), declared.type_of(below))
    if above == below:
        what = f"{above} has no foot on itself"
        yield Finding(("frame", "origin", "on"), what, "name the cylinder or plane that the foot is on")
    elif None not in types and types not in _FEET:
        what = f"{above}, a {types[0]}, has no foot on {below}, a {types[1]}"
        remedy = "take a sphere above a cylinder or plane, or two cylinders"
        yield Finding(("frame", "origin"), what, remedy)


def _check_meeting(names: list[str], declared: Declared) -> Iterator[Finding]:
    for index, name in enumerate(names):
        yield from declared.unknown(name, ("frame", "origin", "meet_of", index))
    types = [declared.type_of(name) for name in names]
    if len(set(names)) < len(names):
        yield Finding(("frame", "origin", "meet_of"), "a feature stands here twice", "name different features")
    elif None not in types and tuple(sorted(str(type_) for type_ in types)) not in _MEETINGS:
        what = f"a {' and a '.join(map(str, types))} do not meet in one point"
        yield Finding(("frame", "origin", "meet_of"), what, "name three planes, or a cylinder and a plane")


def _check_axis(path: Path, entry: AxisEntry, declared: Declared) -> Iterator[Finding]:
    direction: AxisEntry | DirectionEntry = entry
    if "opposite" in entry:
        path, direction = (*path, "opposite"), entry["opposite"]
    if "along" not in direction:
        yield from _check_from_to(path, direction["from"], direction["to"], declared)
        return
    yield from declared.unknown(direction["along"], (*path, "along"))
    if declared.type_of(direction["along"]) == "sphere":
        what = f"{direction['along']} is a sphere and has no direction"
        yield Finding((*path, "along"), what, "name a cylinder or plane, or use from and to")


def _check_from_to(path: Path, start: str, end: str, declared: Declared) -> Iterator[Finding]:
    yield from declared.unknown(start, (*path, "from"))
    yield from declared.unknown(end, (*path, "to"))
    types = {declared.type_of(start), declared.type_of(end)}
    if start == end:
        yield Finding((*path, "to"), f"{end} is where the axis comes from", "name another feature")
    elif None not in types and "plane" in types and "sphere" not in types:
        what = f"there is no one direction from {start} to {end}"
        yield Finding(path, what, "use along for the normal of a plane; from and to take spheres and cylinders")


def _check_length(path: Path, entry: AxisEntry, document: FixtureEntry) -> Iterator[Finding]:
    """A direction from one feature to another needs a distance between them."""
    direction = entry.get("opposite", entry)
    if "from" not in direction:
        return
    ends = {direction["from"], direction["to"]}
    if any(set(distance["between"]) == ends and distance["value"] == 0 for distance in document.get("distances", [])):
        what = f"there is no direction from {direction['from']} to {direction['to']}: their distance is 0"
        yield Finding(path, what, "take another feature for this axis")


def _names(entry: AxisEntry) -> frozenset[str]:
    """The features that an axis follows, whichever way it points."""
    direction = entry.get("opposite", entry)
    if "along" in direction:
        return frozenset((direction["along"],))
    return frozenset((direction["from"], direction["to"]))
