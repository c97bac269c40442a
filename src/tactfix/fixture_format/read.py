"""Converts the plain values of a fixture file to a fixture, or reports everything that is wrong with them at once.

1. Schema: the whole file is checked against the JSON Schema; pydantic explains violations.
2. Rules: the well-formed entries are checked for consistency, by rules grouped by section. A rule must work if a
   feature that an entry names is missing or malformed, which is reported elsewhere.
3. Geometry: a file that passes both is built, and its relations, frame and boxes are compared with the places.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from tactfix.fixture import Fixture
from tactfix.fixture_format.build import AXIS_KEYS, build_fixture
from tactfix.fixture_format.entries import Entries, Finding, entries_of
from tactfix.fixture_format.feature_rules import check_features, check_lengths, check_relations
from tactfix.fixture_format.frame_rules import check_frame
from tactfix.fixture_format.json_schema import is_well_formed
from tactfix.placement import Placement
from tactfix.wording import UNPRINTABLE

if TYPE_CHECKING:
    from tactfix.fixture_format.placement import PoseFiles


def read_fixture(value: Any, name: str, pose_files: "PoseFiles") -> Fixture | list[Finding]:
    """The fixture of the plain values, or findings; name: default name; pose_files: reads the pose files it names."""
    if not isinstance(value, dict):
        remedy = "begin with tactfix: 1, then units: and features:"
        message = "the file is empty" if value is None else "the file is not a mapping of keys to values"
        return [Finding((), message, remedy)]
    entries = entries_of(value)
    findings = [*_malformations(value), *check_entries(entries)]
    if findings:
        return findings
    placement = _placement(entries, pose_files)
    if isinstance(placement, list):
        return placement
    fixture = build_fixture(entries, name, placement)
    if not fixture.is_placed:
        return fixture
    from tactfix.fixture_format.geometry_rules import check_geometry  # not needed without places

    return check_geometry(entries, fixture) or fixture


def _placement(entries: Entries, pose_files: "PoseFiles") -> Placement | list[Finding] | None:
    if entries.placement is None:
        return None
    from tactfix.fixture_format.placement import read_placement  # slow, and needed only with a placement

    return read_placement(entries.placement, entries.written["units"], pose_files)


def _malformations(value: Any) -> list[Finding]:
    if is_well_formed(value):
        return []
    from tactfix.fixture_format.pydantic_errors import malformations  # slow, and not needed for a valid file

    return malformations(value)


def check_entries(entries: Entries) -> list[Finding]:
    """Findings about well-formed entries; `geometry_rules` compares them with the places."""
    return [
        *_check_name(entries.written.get("name")),
        *check_features(entries),
        *check_lengths(entries),
        *check_relations(entries),
        *check_frame(entries),
        *_check_probe(entries),
        *_check_touch(entries),
        *_check_placement(entries),
    ]


def _check_name(name: object) -> Iterator[Finding]:
    """The name must be one printable line, so that it is safe in comments and messages."""
    if isinstance(name, str) and (UNPRINTABLE.search(name) or "\n" in name):
        yield Finding(
            ("name",),
            f"the name {name[:40]!r} contains a control character",
            "write it in one line of printable characters",
        )


def _check_probe(entries: Entries) -> Iterator[Finding]:
    """tip_within needs tip_offset."""
    if entries.probe.get("tip_within") is not None and entries.probe.get("tip_offset") is None:
        message = "probe.tip_within limits how far the tip is from tip_offset, and there is no tip_offset"
        yield Finding(("probe", "tip_within"), message, "give tip_offset: [x, y, z] too", at_key=True)


def _check_touch(entries: Entries) -> Iterator[Finding]:
    """Boxes must be of existing features, low end below high end."""
    for name, box in entries.touch.items():
        yield from entries.unknown(name, ("touch", name), at_key=True)
        if entries.type_of(name) == "point":
            message = f"{name} is a point, which is touched at one place only"
            yield Finding(("touch", name), message, "remove its box", at_key=True)
        for axis in AXIS_KEYS:
            low, high = box.get(axis) or (None, None)
            if low is not None and high is not None and low >= high:
                message = f"touch.{name}.{axis} goes from {low:g} to {high:g}"
                remedy = "write [low, high] with low below high, null for no limit, or leave the axis out"
                yield Finding(("touch", name, axis), message, remedy)


def _check_placement(entries: Entries) -> list[Finding]:
    if entries.placement is None:
        return []
    from tactfix.fixture_format.placement import check_placement  # slow, and needed only with a placement

    return list(check_placement(entries.placement))
