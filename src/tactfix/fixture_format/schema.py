"""Format 1 of fixture files: these models are its one description, the JSON Schema made of them its one other form."""

import json
from collections.abc import Iterable
from typing import Annotated, Any, Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag

from tactfix.units import Unit

DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"


def generated_schema() -> str:
    """The JSON Schema of these models: what fixtures/tactfix.schema.json must hold, with a newline at its end."""
    schema = FixtureDocument.model_json_schema(by_alias=True)
    head = {"$schema": DIALECT, "title": "tactfix fixture"}
    return json.dumps({**head, **{key: value for key, value in schema.items() if key != "title"}}, indent=2) + "\n"


class Strict(BaseModel):
    """What all models share: unknown keys, nan, infinity and wrong types are errors, and nothing is converted."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)


Name: TypeAlias = Annotated[str, Field(min_length=1)]
"""The name of a feature of this file."""
Vector: TypeAlias = Annotated[list[float], Field(min_length=3, max_length=3)]
"""Three numbers x, y, z in the fixture frame."""
Length: TypeAlias = Annotated[float, Field(gt=0)]
"""A length above zero, in the file's units."""
Sigma: TypeAlias = Annotated[float, Field(ge=0)]
"""One standard deviation, zero for something exactly known."""

_SIGMA: Any = Field(
    default=0.0, description="Form and calibration error of this feature along its normal, added to the probe's."
)
_SIDE: Any = Field(default="outer", description="outer: a boss or ball, touched from outside; inner: a bore or socket.")


class PlaneModel(Strict):
    """A flat face."""

    type: Literal["plane"] = Field(description="A flat face; its normal points out of the material.")
    point: Vector | None = Field(default=None, description="Any point of the face, in the fixture frame.")
    normal: Vector | None = Field(
        default=None, description="Outward normal, any length but zero, in the fixture frame."
    )
    sigma: Sigma = _SIGMA


class SphereModel(Strict):
    """A ball or a spherical socket."""

    type: Literal["sphere"] = Field(description="A ball, or a spherical socket (side: inner).")
    radius: Length = Field(description="Radius of the sphere.")
    side: Literal["outer", "inner"] = _SIDE
    center: Vector | None = Field(default=None, description="Centre, in the fixture frame.")
    sigma: Sigma = _SIGMA


class CylinderModel(Strict):
    """A pin, bar or boss, or a bore."""

    type: Literal["cylinder"] = Field(description="A pin, bar or boss, or a bore (side: inner).")
    radius: Length = Field(description="Radius of the cylinder.")
    side: Literal["outer", "inner"] = _SIDE
    point: Vector | None = Field(default=None, description="Any point of the axis, in the fixture frame.")
    direction: Vector | None = Field(
        default=None, description="Direction of the axis, of either sign, any length but zero, in the fixture frame."
    )
    sigma: Sigma = _SIGMA


FeatureModel: TypeAlias = Annotated[PlaneModel | SphereModel | CylinderModel, Field(discriminator="type")]


class CenterOf(Strict):
    """The centre of a sphere."""

    center_of: Name = Field(description="A sphere: the origin is its centre.")


class FootOf(Strict):
    """The point of one feature that is nearest to another."""

    foot_of: Name = Field(description="The feature above: a sphere, or a cylinder where 'on' is a cylinder too.")
    on: Name = Field(description="The cylinder or plane on whose axis or face the origin lies, nearest to 'foot_of'.")


class MeetOf(Strict):
    """The point where features meet."""

    meet_of: Annotated[list[Name], Field(min_length=2, max_length=3)] = Field(
        description="Three planes, or a cylinder and a plane: the origin is where they (or the axis) meet."
    )


class Along(Strict):
    """The direction of an axis or an outward normal."""

    along: Name = Field(description="A cylinder (its axis, of open sign) or a plane (its outward normal).")


class FromTo(Strict):
    """The direction from one feature to another."""

    from_: Name = Field(alias="from", description="Where the axis comes from.")
    to: Name = Field(description="Where the axis points to.")


class Opposite(Strict):
    """The reverse of a direction."""

    opposite: "Direction" = Field(description="The direction that this one is the reverse of: along, or from and to.")


def _first_known(keys: Iterable[str]) -> Any:
    """A discriminator: which of keys a mapping has."""

    def tag(value: Any) -> str | None:
        names = value if isinstance(value, dict) else getattr(type(value), "model_fields", ())
        return next((key for key in keys if key in names or f"{key}_" in names), None)

    return Discriminator(tag)


Origin: TypeAlias = Annotated[
    Annotated[CenterOf, Tag("center_of")] | Annotated[FootOf, Tag("foot_of")] | Annotated[MeetOf, Tag("meet_of")],
    _first_known(("center_of", "foot_of", "meet_of")),
]
Direction: TypeAlias = Annotated[
    Annotated[Along, Tag("along")] | Annotated[FromTo, Tag("from")], _first_known(("along", "from"))
]
AxisModel: TypeAlias = Annotated[
    Annotated[Along, Tag("along")] | Annotated[FromTo, Tag("from")] | Annotated[Opposite, Tag("opposite")],
    _first_known(("along", "from", "opposite")),
]


class FrameModel(Strict):
    """An origin and two of x, y, z: the first one written holds exactly, the second is made square to it."""

    origin: Origin = Field(description="Where the origin is: center_of, foot_of and on, or meet_of.")
    x: AxisModel | None = Field(default=None, description="Direction of x: along, from and to, or opposite of one.")
    y: AxisModel | None = Field(default=None, description="Direction of y: along, from and to, or opposite of one.")
    z: AxisModel | None = Field(default=None, description="Direction of z: along, from and to, or opposite of one.")


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
