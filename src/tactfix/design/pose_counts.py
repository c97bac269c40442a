"""The number of poses of a minimal set of contacts over the complex numbers, for almost all fixtures.

The count of a kind (the types of the features, and the contacts on each) is the same for almost every fixture and
contact set of that kind; a special position has as many or fewer isolated poses. The counts are in pose_counts.json,
each with its source.
"""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Final, Literal, TypeAlias

from tactfix.geometry.surfaces import FeatureType
from tactfix.values import frozen_value

Source: TypeAlias = Literal["reference", "reasoned", "tracked"]

_KINDS: Final[tuple[FeatureType, ...]] = ("plane", "sphere", "cylinder", "point")


@frozen_value(eq=True)
class PoseCount:
    """The poses of six contacts of one kind, copies by symmetry included.

    complex_poses: in general position; no set of this kind has more isolated ones. source: "reference" (figures made
    elsewhere by another method, and path tracking here), "reasoned" (derived feature by feature, and path tracking), or
    "tracked" (path tracking alone, twice).
    """

    kind: str
    complex_poses: int
    source: Source


def pose_count(types: Mapping[str, FeatureType], counts: Mapping[str, int]) -> PoseCount | None:
    """The count for this distribution over features of these types.

    None if the contacts are not six, or so distributed do not locate a fixture.
    """
    if sum(counts.values()) != 6:
        return None
    kind = kind_of_set(types, counts)
    known = _table().get(kind)
    return None if known is None else PoseCount(kind, *known)


def kind_of_set(types: Mapping[str, FeatureType], counts: Mapping[str, int]) -> str:
    """The name of the kind of a set: contacts by feature, over features of these types."""
    return kind_of([(types[name], count) for name, count in counts.items() if count])


def kind_of(touched: Sequence[tuple[FeatureType, int]]) -> str:
    """The name of a kind from type and contacts of each feature: in the order of _KINDS, by rising count."""
    ordered = sorted((_KINDS.index(name), count) for name, count in touched)
    return ", ".join(f"{_KINDS[index]} {count}" for index, count in ordered)


@cache
def _table() -> Mapping[str, tuple[int, Source]]:
    """Complex poses and source by kind."""
    text = resources.files("tactfix.design").joinpath("pose_counts.json").read_text(encoding="utf-8")
    return {row["kind"]: (row["complex_poses"], row["source"]) for row in json.loads(text)["rows"]}
