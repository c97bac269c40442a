"""The plain values of a fixture file in, a fixture out, or everything that is wrong with them at once.

1. Form: the whole file is held to the JSON Schema; where it does not keep to it, pydantic says where and how.
2. Rules: the entries that are well formed are held to what makes sense among them (`rules`).
3. Geometry: a file that passed both is built, and its relations, frame and boxes are held to the places it gives.
"""

from typing import TYPE_CHECKING, Any

from tactfix.fixture import Fixture
from tactfix.fixture_format.build import build_fixture
from tactfix.fixture_format.entries import Entries, entries_of
from tactfix.fixture_format.json_schema import is_well_formed
from tactfix.fixture_format.problems import Finding
from tactfix.fixture_format.rules import check_entries
from tactfix.placement import Placement

if TYPE_CHECKING:
    from tactfix.fixture_format.placement import PoseFiles


def read_fixture(value: Any, name: str, pose_files: "PoseFiles") -> Fixture | list[Finding]:
    """The fixture that value says; name: its name if the file gives none; pose_files: reads poses that it names."""
    if not isinstance(value, dict):
        remedy = "begin with tactfix: 1, then units: and features:"
        what = "the file is empty" if value is None else "the file is not a mapping of keys to values"
        return [Finding((), what, remedy)]
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
    from tactfix.fixture_format.geometry_rules import check_geometry  # not worth its time where there are no places

    return check_geometry(entries, fixture) or fixture


def _placement(entries: Entries, pose_files: "PoseFiles") -> Placement | list[Finding] | None:
    if entries.placement is None:
        return None
    from tactfix.fixture_format.placement import read_placement  # pose formats are not worth their time without one

    return read_placement(entries.placement, entries.written["units"], pose_files)


def _malformations(value: Any) -> list[Finding]:
    if is_well_formed(value):
        return []
    from tactfix.fixture_format.pydantic_errors import malformations  # not worth its time for a good file

    return malformations(value)
