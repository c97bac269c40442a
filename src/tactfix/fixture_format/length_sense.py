"""Lengths: none beyond what is a length in any unit, as in contact files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Final

from tactfix.fixture_format.problems import Finding, Path
from tactfix.units import LEAST_LENGTH, MOST_LENGTH

if TYPE_CHECKING:
    from tactfix.fixture_format.entries import FixtureEntry

_SIZES: Final = ("radius", "sigma", "tip_radius", "approach_distance")
_PLACES: Final = ("point", "center", "x", "y", "z")
_REMEDY: Final = "check the number and the units of the file"


def check_lengths(document: FixtureEntry) -> Iterator[Finding]:
    """Findings about lengths too large, or too small and not 0; a normal or direction may have any length but 0."""
    yield from _check(("probe",), document.get("probe", {}))
    for name, feature in document["features"].items():
        yield from _check(("features", name), feature)
    for index, distance in enumerate(document.get("distances", [])):
        yield from _check(("distances", index), distance)
        yield from _beyond(("distances", index, "value"), distance["value"])
    for name, box in document.get("touch", {}).items():
        yield from _check(("touch", name), box)


def _check(path: Path, entry: Any) -> Iterator[Finding]:
    for key in _SIZES:
        size = entry.get(key)
        if size is not None:
            yield from _beyond((*path, key), size)
            if 0 < size < LEAST_LENGTH:
                yield Finding(
                    (*path, key), f"{key} is {size:g}, below {LEAST_LENGTH:g}: no length in any unit", _REMEDY
                )
    for key in _PLACES:
        places: Iterable[float | None] = entry.get(key) or ()
        for index, place in enumerate(places):
            if place is not None:
                yield from _beyond((*path, key, index), place)


def _beyond(path: Path, length: float) -> Iterator[Finding]:
    if abs(length) > MOST_LENGTH:
        what = f"{length:g} is beyond {MOST_LENGTH:g}: no length in any unit"
        yield Finding(path, what, _REMEDY)
