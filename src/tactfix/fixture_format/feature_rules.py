"""Features: names, places given in full, all features placed or none."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from tactfix.fixture_format.declared import Declared
from tactfix.fixture_format.problems import Finding

if TYPE_CHECKING:
    from tactfix.fixture_format.entries import FeatureEntry, FixtureEntry

PLACE: Final[dict[str, tuple[str, ...]]] = {
    "plane": ("point", "normal"),
    "sphere": ("center",),
    "cylinder": ("point", "direction"),
}
"""What places a feature of each type in the fixture frame."""
# What would fall apart in a contact file or on the command line (--features bar:5,ball:3).
_FORBIDDEN: Final = re.compile(r"^\s|\s$|[,;:#\"'\x00-\x1f]")


def given_places(feature: FeatureEntry) -> list[str]:
    """Which of the keys that place a feature it has."""
    return [key for key in PLACE[feature["type"]] if feature.get(key) is not None]


def check_features(document: FixtureEntry, declared: Declared) -> Iterator[Finding]:
    """Findings about names and places."""
    for name in declared.names:
        if _FORBIDDEN.search(name):
            remedy = "write a name without commas, semicolons, colons, quotes, # and outer blanks"
            yield Finding(("features", name), f"{name!r} is no name for a feature", remedy, at_key=True)
    for name, feature in document["features"].items():
        yield from _check_place(name, feature)
    placed = [name for name, feature in document["features"].items() if given_places(feature)]
    unplaced = [name for name in document["features"] if name not in placed]
    if placed and unplaced:
        for name in unplaced:
            keys = " and ".join(PLACE[document["features"][name]["type"]])
            what = f"{name} has no place in the fixture frame, {placed[0]} has one"
            remedy = f"give {keys} of {name} too, or no place to any feature"
            yield Finding(("features", name), what, remedy, at_key=True)


def _check_place(name: str, feature: FeatureEntry) -> Iterator[Finding]:
    given = given_places(feature)
    missing = [key for key in PLACE[feature["type"]] if key not in given]
    if given and missing:
        what = f"{name} has {given[0]} and no {missing[0]}"
        yield Finding(("features", name, given[0]), what, f"give {missing[0]} too, or leave out both", at_key=True)
    for key in ("normal", "direction"):
        vector = feature.get(key)
        if key in given and isinstance(vector, list) and not any(vector):
            yield Finding(("features", name, key), f"{name}: the {key} is zero", "write a vector of any other length")


def is_placed(document: FixtureEntry) -> bool:
    """Whether every feature carries its place."""
    return all(len(given_places(feature)) == len(PLACE[feature["type"]]) for feature in document["features"].values())
