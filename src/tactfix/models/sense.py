"""Whether the entries of a fixture file make sense together; each rule lives with the section that it is about."""

from tactfix.models.agreement import check_agreement
from tactfix.models.declared import Declared
from tactfix.models.entries import FixtureEntry
from tactfix.models.feature_sense import check_features
from tactfix.models.findings import Finding
from tactfix.models.frame_sense import check_frame
from tactfix.models.relation_sense import check_relations
from tactfix.models.touch_sense import check_touch


def check_sense(document: FixtureEntry, declared: Declared) -> list[Finding]:
    """Everything that is well formed and makes no sense; the geometry is only judged where all else is in order."""
    findings = [
        *check_features(document, declared),
        *check_relations(document, declared),
        *check_frame(document, declared),
        *check_touch(document, declared),
    ]
    return findings or check_agreement(document)
