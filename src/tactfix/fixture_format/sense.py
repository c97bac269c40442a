"""Whether the entries of a fixture file make sense together; each rule lives with the section that it is about."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tactfix.fixture_format.declared import Declared
from tactfix.fixture_format.feature_rules import check_features, is_placed
from tactfix.fixture_format.frame_rules import check_frame
from tactfix.fixture_format.length_sense import check_lengths
from tactfix.fixture_format.problems import Finding
from tactfix.fixture_format.relation_rules import check_relations
from tactfix.fixture_format.rules import check_touch

if TYPE_CHECKING:
    from tactfix.fixture_format.entries import FixtureEntry


def check_sense(document: FixtureEntry, declared: Declared) -> list[Finding]:
    """Everything that is well formed and makes no sense; the geometry is only judged where all else is in order."""
    findings = [
        *check_features(document, declared),
        *check_lengths(document),
        *check_relations(document, declared),
        *check_frame(document, declared),
        *check_touch(document, declared),
    ]
    if findings or not is_placed(document):
        return findings
    from tactfix.fixture_format.placement_rules import (
        check_agreement,  # not worth its time where no feature has a place
    )

    return check_agreement(document)
