"""Whether the entries of a fixture file make sense together; each rule lives with the section that it is about."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tactfix.models.declared import Declared
from tactfix.models.feature_sense import check_features, is_placed
from tactfix.models.findings import Finding
from tactfix.models.frame_sense import check_frame
from tactfix.models.length_sense import check_lengths
from tactfix.models.relation_sense import check_relations
from tactfix.models.touch_sense import check_touch

if TYPE_CHECKING:
    from tactfix.models.entries import FixtureEntry


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
    from tactfix.models.agreement import check_agreement  # not worth its time where no feature has a place

    return check_agreement(document)
