"""The whole of a fixture file, format 1."""

from typing import Annotated, TypeAlias

from pydantic import Field

from tactfix.fixture_format.features import FeatureModel
from tactfix.fixture_format.frame import FrameModel
from tactfix.fixture_format.strict import Length, Name, Sigma, Strict
from tactfix.units import Unit

Pair: TypeAlias = Annotated[list[Name], Field(min_length=2, max_length=2)]
Interval: TypeAlias = Annotated[list[float | None], Field(min_length=2, max_length=2)]


class ProbeModel(Strict):
    """What holds for a contact file that does not say."""

    tip_radius: Annotated[float, Field(ge=0)] | None = Field(
        default=None,
        description="0: contacts are points of the surface; above 0: contacts are centres of a tip of this radius.",
    )
    sigma: Length | None = Field(
        default=None, description="One standard deviation of a contact along the surface normal."
    )
    approach_distance: Length | None = Field(
        default=None,
        description="How far the probe comes in a straight line before it touches; without it: from far away.",
    )


class DistanceModel(Strict):
    """A known distance."""

    between: Pair = Field(description="The two features.")
    value: float = Field(
        description="Between centres, axes and planes; sphere to plane is signed, positive on the outward side."
    )
    sigma: Sigma = Field(default=0.0, description="One standard deviation of value.")


class AngleModel(Strict):
    """A known angle."""

    between: Pair = Field(description="The two features: planes and cylinders.")
    value: Annotated[float, Field(ge=0, le=180)] = Field(
        description="Degrees: 0 to 180 between outward normals, 0 to 90 where an axis takes part, which has no sign."
    )
    sigma: Sigma = Field(default=0.0, description="One standard deviation of value, in degrees.")


class TouchModel(Strict):
    """A box in the fixture frame; null is open."""

    x: Interval | None = Field(default=None, description="[low, high] of x, null where it is open.")
    y: Interval | None = Field(default=None, description="[low, high] of y, null where it is open.")
    z: Interval | None = Field(default=None, description="[low, high] of z, null where it is open.")


class FixtureDocument(Strict):
    """A tactfix fixture file: the features that a probe touches, and where they are."""

    # Not Literal[1]: true and 1.0 equal 1.
    tactfix: int = Field(ge=1, le=1, description="Version of this file format.", json_schema_extra={"const": 1})
    name: str | None = Field(
        default=None, min_length=1, description="Name of the fixture; without it, the file's name."
    )
    units: Unit = Field(description="The unit of every length in this file. Angles are degrees.")
    probe: ProbeModel = Field(default=ProbeModel(), description="Defaults for a contact file that does not say.")
    features: dict[Name, FeatureModel] = Field(min_length=1, description="What the probe touches, by name.")
    distances: list[DistanceModel] = Field(default=[], description="Known distances between features.")
    angles: list[AngleModel] = Field(default=[], description="Known angles between features.")
    frame: FrameModel | None = Field(
        default=None, description="How the frame is built from the features; not needed where they carry their place."
    )
    touch: dict[Name, TouchModel] = Field(
        default={}, description="Where each surface may be touched: a box in the fixture frame."
    )
