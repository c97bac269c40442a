"""The well-formed entries of a fixture file, and findings about them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, TypeAlias

from tactfix.fixture_format.json_schema import is_entry, is_section
from tactfix.values import frozen_value
from tactfix.wording import did_you_mean

Path: TypeAlias = tuple[str | int, ...]
"""Keys and indices from the root of the file to a value."""


@frozen_value(eq=True)
class Finding:
    """What is wrong and how to correct it; at_key: the key is wrong, not its value."""

    path: Path
    message: str
    remedy: str
    at_key: bool = False


def unknown_key(path: Path, known: Iterable[str]) -> Finding:
    """An unknown key, or the digits behind a decimal comma: {sigma: 0,1}; known: the valid keys."""
    key = str(path[-1])
    if key.isdecimal():
        return Finding(path, f"{key} follows a comma", "write a decimal point: 10.5, not 10,5", at_key=True)
    return Finding(path, f"unknown key {path[-1]!r}", did_you_mean(key, known), at_key=True)


Entry: TypeAlias = Mapping[str, Any]
"""A feature, relation, box, probe, frame or placement, valid against its model in `tactfix.fixture_format.schema`."""


@frozen_value(eq=True)
class Entries:
    """The well-formed entries of a file; malformed ones are left out, and reported by pydantic_errors.

    written: the unchecked values of the file. distances and angles: by their index in the file.
    """

    written: Mapping[str, Any]
    features: Mapping[str, Entry]
    distances: Mapping[int, Entry]
    angles: Mapping[int, Entry]
    touch: Mapping[str, Entry]
    probe: Entry
    frame: Entry | None
    placement: Entry | None

    @property
    def named(self) -> Mapping[str, Any]:
        """Every feature of the file by name, well-formed or not; empty if there is no such section."""
        features = self.written.get("features")
        return features if isinstance(features, dict) else {}

    def unknown(self, name: str, path: Path, *, at_key: bool = False) -> list[Finding]:
        """A finding if the file has no feature of this name, well-formed or not."""
        if name in self.named or not self.named:
            return []
        return [Finding(path, f"there is no feature {name!r}", did_you_mean(name, self.named), at_key)]

    def type_of(self, name: str) -> str | None:
        """plane, sphere, cylinder or point; None if no well-formed feature has this name."""
        return self.features[name]["type"] if name in self.features else None

    def kind_of(self, name: str) -> str | None:
        """The type as relations and frame use it: "center" for sphere and point."""
        type_ = self.type_of(name)
        return "center" if type_ in ("sphere", "point") else type_


def entries_of(value: Mapping[str, Any]) -> Entries:
    """The well-formed entries among the unchecked values of a file."""
    return Entries(
        written=value,
        features=_named_entries("features", value),
        distances=_listed_entries("distances", value),
        angles=_listed_entries("angles", value),
        touch=_named_entries("touch", value),
        probe=_section("probe", value) or {},
        frame=_section("frame", value),
        placement=_section("placement", value),
    )


def _named_entries(section: str, value: Mapping[str, Any]) -> dict[str, Entry]:
    entries = value.get(section)
    if not isinstance(entries, dict):
        return {}
    return {name: entry for name, entry in entries.items() if is_entry(section, entry)}


def _listed_entries(section: str, value: Mapping[str, Any]) -> dict[int, Entry]:
    entries = value.get(section)
    if not isinstance(entries, list):
        return {}
    return {index: entry for index, entry in enumerate(entries) if is_entry(section, entry)}


def _section(section: str, value: Mapping[str, Any]) -> Entry | None:
    entry = value.get(section)
    return entry if is_section(section, entry) else None
