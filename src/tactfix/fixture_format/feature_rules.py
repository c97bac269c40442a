"""Features: names, places given in full, all features placed or none. And no length that is none in any unit."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Final

from tactfix.fixture_format.entries import Entries, Entry
from tactfix.fixture_format.problems import Finding, Path
from tactfix.units import LEAST_LENGTH, MOST_LENGTH
from tactfix.wording import UNPRINTABLE

PLACE: Final[dict[str, tuple[str, ...]]] = {
    "plane": ("point", "normal"),
    "sphere": ("center",),
    "point": ("point",),
    "cylinder": ("point", "direction"),
}
"""What places a feature of each type in the fixture frame."""
PLACE_KEYS: Final = frozenset(key for keys in PLACE.values() for key in keys)
# What would fall apart in a contact file or on the command line (--features bar:5,ball:3).
_FORBIDDEN: Final = re.compile(rf"^\s|\s$|[,;:#\"'\t\n]|{UNPRINTABLE.pattern}")

_SIZES: Final = ("radius", "sigma", "tip_radius", "approach_distance", "tip_within", "translation")
_PLACES: Final = ("point", "center", "tip_offset", "x", "y", "z")
_NUMBER_REMEDY: Final = "check the number and the units of the file"


def given_places(feature: Entry) -> list[str]:
    """Which of the keys that place a feature it has."""
    return [key for key in PLACE[feature["type"]] if feature.get(key) is not None]


def check_features(entries: Entries) -> Iterator[Finding]:
    """Findings about names and places."""
    for name in entries.named:
        if _FORBIDDEN.search(name):
            remedy = "write a name without commas, semicolons, colons, quotes, # and outer blanks"
            yield Finding(("features", name), f"{name!r} is no name for a feature", remedy, at_key=True)
    for name, feature in entries.features.items():
        yield from _check_place(name, feature)
    placed = [name for name, feature in entries.features.items() if given_places(feature)]
    unplaced = [name for name in entries.features if name not in placed]
    if placed and unplaced:
        for name in unplaced:
            keys = " and ".join(PLACE[entries.features[name]["type"]])
            what = f"{name} has no place in the fixture frame, {placed[0]} has one"
            remedy = f"give {keys} of {name} too, or no place to any feature"
            yield Finding(("features", name), what, remedy, at_key=True)


def _check_place(name: str, feature: Entry) -> Iterator[Finding]:
    given = given_places(feature)
    missing = [key for key in PLACE[feature["type"]] if key not in given]
    if given and missing:
        what = f"{name} has {given[0]} and no {missing[0]}"
        yield Finding(("features", name, given[0]), what, f"give {missing[0]} too, or leave out both", at_key=True)
    for key in ("normal", "direction"):
        vector = feature.get(key)
        if key in given and isinstance(vector, list) and not any(vector):
            yield Finding(("features", name, key), f"{name}: the {key} is zero", "write a vector of any other length")


def check_lengths(entries: Entries) -> Iterator[Finding]:
    """Findings about lengths too large, or too small and not 0; a normal or direction may have any length but 0."""
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
        what = f"{length:g} is beyond {MOST_LENGTH:g}: no length in any unit"
        yield Finding(path, what, _NUMBER_REMEDY)
