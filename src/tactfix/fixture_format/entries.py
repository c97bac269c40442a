"""The shape of a fixture file that keeps to its schema, for those that read it after that is settled."""

from typing import NotRequired, TypeAlias, TypedDict

from tactfix.geometry.surfaces import FeatureType, Side

Vector: TypeAlias = list[float]
Interval: TypeAlias = list[float | None]


class FeatureEntry(TypedDict):
    """A feature; radius and side not on planes."""

    type: FeatureType
    radius: NotRequired[float]
    side: NotRequired[Side]
    point: NotRequired[Vector | None]
    normal: NotRequired[Vector | None]
    center: NotRequired[Vector | None]
    direction: NotRequired[Vector | None]
    sigma: NotRequired[float]


class RelationEntry(TypedDict):
    """A distance, or an angle in degrees."""

    between: list[str]
    value: float
    sigma: NotRequired[float]


class OriginEntry(TypedDict, total=False):
    """center_of, or foot_of and on, or meet_of."""

    center_of: str
    foot_of: str
    on: str
    meet_of: list[str]


# "from" is a keyword, so these two cannot be written as classes.
DirectionEntry = TypedDict("DirectionEntry", {"along": str, "from": str, "to": str}, total=False)
AxisEntry = TypedDict("AxisEntry", {"along": str, "from": str, "to": str, "opposite": DirectionEntry}, total=False)


class FrameEntry(TypedDict):
    """Origin and axes; the order in which x, y and z are written counts."""

    origin: OriginEntry
    x: NotRequired[AxisEntry | None]
    y: NotRequired[AxisEntry | None]
    z: NotRequired[AxisEntry | None]


class ProbeEntry(TypedDict, total=False):
    """Defaults for a contact file."""

    tip_radius: float | None
    sigma: float | None
    approach_distance: float | None


class TouchEntry(TypedDict, total=False):
    """A box; null is open."""

    x: Interval | None
    y: Interval | None
    z: Interval | None


class FixtureEntry(TypedDict):
    """The whole file."""

    tactfix: int
    name: NotRequired[str | None]
    units: str
    probe: NotRequired[ProbeEntry]
    features: dict[str, FeatureEntry]
    distances: NotRequired[list[RelationEntry]]
    angles: NotRequired[list[RelationEntry]]
    frame: NotRequired[FrameEntry | None]
    touch: NotRequired[dict[str, TouchEntry]]
