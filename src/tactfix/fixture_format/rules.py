"""What must make sense together in a fixture file; each rule lives with the section that it is about.

A rule sees the entries that are well formed and takes nothing for granted of what they name: a feature may be missing
or malformed, which is told elsewhere.
"""

from collections.abc import Iterator

from tactfix.fixture_format.build import AXIS_KEYS
from tactfix.fixture_format.entries import Entries
from tactfix.fixture_format.feature_rules import check_features, check_lengths
from tactfix.fixture_format.frame_rules import check_frame
from tactfix.fixture_format.problems import Finding
from tactfix.fixture_format.relation_rules import check_relations
from tactfix.wording import UNPRINTABLE


def check_entries(entries: Entries) -> list[Finding]:
    """Everything that is well formed and makes no sense; places are compared by `geometry_rules`."""
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
    """A name in one line, which cannot leave the comment or message that it stands in."""
    if isinstance(name, str) and (UNPRINTABLE.search(name) or "\n" in name):
        yield Finding(("name",), f"the name {name[:40]!r} holds a control character", "write it in one line of letters")


def _check_probe(entries: Entries) -> Iterator[Finding]:
    """A limit of the tip's offset needs the offset."""
    if entries.probe.get("tip_within") is not None and entries.probe.get("tip_offset") is None:
        what = "probe.tip_within limits how far the tip is from tip_offset, and there is no tip_offset"
        yield Finding(("probe", "tip_within"), what, "give tip_offset: [x, y, z] too", at_key=True)


def _check_touch(entries: Entries) -> Iterator[Finding]:
    """Boxes of features that exist, with a low end below the high one."""
    for name, box in entries.touch.items():
        yield from entries.unknown(name, ("touch", name), at_key=True)
        if entries.type_of(name) == "point":
            what = f"{name} is a point and is touched at one place alone"
            yield Finding(("touch", name), what, "remove its box", at_key=True)
        for axis in AXIS_KEYS:
            low, high = box.get(axis) or (None, None)
            if low is not None and high is not None and low >= high:
                what = f"touch.{name}.{axis} goes from {low:g} to {high:g}"
                remedy = "write [low, high] with low below high, null for an open end, or leave the axis out"
                yield Finding(("touch", name, axis), what, remedy)


def _check_placement(entries: Entries) -> list[Finding]:
    if entries.placement is None:
        return []
    from tactfix.fixture_format.placement import check_placement  # pose formats are not worth their time without one

    return list(check_placement(entries.placement))
