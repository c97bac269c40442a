"""What a fixture is, once its file has been read: plain frozen values in the fixture's units, angles in rad.

`tactfix.fixture_format` makes these from the YAML file; nothing else knows how the file looks.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, TypeAlias

from tactfix.geometry.arrays import Floats, frozen
from tactfix.geometry.surfaces import FeatureType, Side, Surface

Axis: TypeAlias = Literal["x", "y", "z"]


@dataclass(frozen=True, slots=True, eq=False)
class Feature:
    """One thing to touch. radius is None for a plane; surface is its place in the fixture frame, or None.

    sigma is the feature's own form and calibration error along the normal, added to the probe's in quadrature.
    """

    name: str
    type: FeatureType
    radius: float | None
    side: Side
    sigma: float
    surface: Surface | None


@dataclass(frozen=True, slots=True)
class Relation:
    """A known distance (length, fixture units) or angle (rad) between two features, with one standard deviation."""

    kind: Literal["distance", "angle"]
    between: tuple[str, str]
    value: float
    sigma: float


@dataclass(frozen=True, slots=True)
class OriginRule:
    """Where the fixture's origin is.

    center_of: (sphere,); foot_of: (A, B), the point of axis or plane B nearest to A; meet_of: three planes, or
    (cylinder, plane).
    """

    kind: Literal["center_of", "foot_of", "meet_of"]
    features: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class AxisRule:
    """A direction: along: (cylinder or plane,); from_to: (A, B). opposite turns it round."""

    kind: Literal["along", "from_to"]
    features: tuple[str, ...]
    opposite: bool = False


@dataclass(frozen=True, slots=True)
class FrameRecipe:
    """How the fixture frame is built: the first axis holds exactly, the second is made square to it."""

    origin: OriginRule
    first: tuple[Axis, AxisRule]
    second: tuple[Axis, AxisRule]


@dataclass(frozen=True, slots=True, eq=False)
class TouchBox:
    """Where a surface may be touched: low (3,) <= x_fixture <= high (3,), infinite where open."""

    low: Floats
    high: Floats

    def __post_init__(self) -> None:
        object.__setattr__(self, "low", frozen(self.low))
        object.__setattr__(self, "high", frozen(self.high))


@dataclass(frozen=True, slots=True)
class Probe:
    """What the fixture file says of the probe, None where it says nothing.

    approach_distance: how far the probe comes in a straight line before it touches; None: from far away.
    """

    tip_radius: float | None = None
    sigma: float | None = None
    approach_distance: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Fixture:
    """A fixture: features by name in file order, what is known between them, its frame, and where it may be touched."""

    name: str
    units: str
    probe: Probe
    features: Mapping[str, Feature]
    relations: tuple[Relation, ...]
    frame: FrameRecipe | None
    touch: Mapping[str, TouchBox]

    def __post_init__(self) -> None:
        object.__setattr__(self, "features", MappingProxyType(dict(self.features)))
        object.__setattr__(self, "touch", MappingProxyType(dict(self.touch)))

    def __reduce__(self) -> tuple[object, ...]:
        """Read-only views do not travel to other processes: there the fixture is built again."""
        rest = (self.relations, self.frame, dict(self.touch))
        return Fixture, (self.name, self.units, self.probe, dict(self.features), *rest)

    @property
    def is_placed(self) -> bool:
        """Whether each feature carries its place in the fixture frame (by geometry, not by relations)."""
        return all(feature.surface is not None for feature in self.features.values())
