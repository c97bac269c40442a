"""The plain values of a fixture file in, a fixture out, or everything that is wrong with them at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

from tactfix.fixture import Fixture
from tactfix.fixture_format.build import build_fixture
from tactfix.fixture_format.declared import Declared
from tactfix.fixture_format.json_schema import is_well_formed
from tactfix.fixture_format.problems import Finding
from tactfix.fixture_format.sense import check_sense

if TYPE_CHECKING:
    from tactfix.fixture_format.entries import FixtureEntry


def parse_fixture(value: Any, name: str) -> Fixture | list[Finding]:
    """The fixture that value says; name: its name if the file gives none."""
    if not isinstance(value, dict):
        remedy = "begin with tactfix: 1, then units: and features:"
        what = "the file is empty" if value is None else "the file is not a mapping of keys to values"
        return [Finding((), what, remedy)]
    refused = [] if is_well_formed(value) else _refused(value)
    if refused:
        return refused
    document = cast("FixtureEntry", value)
    findings = check_sense(document, Declared(tuple(document["features"]), document["features"]))
    return findings or build_fixture(document, name)


def _refused(value: dict[str, Any]) -> list[Finding]:
    """What pydantic finds wrong, and what makes no sense in the rest; only now is it worth the time to import it."""
    from tactfix.fixture_format.pydantic_errors import refusals_of
    from tactfix.fixture_format.remainder import sense_of_the_rest

    refusals = refusals_of(value)
    return [refusal.finding for refusal in refusals] + (sense_of_the_rest(value, refusals) if refusals else [])
