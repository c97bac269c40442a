"""The models of the entries of a fixture file: probe, features, relations, touch boxes; and what all models share."""

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field


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


class PointModel(Strict):
    """A seat, cone, nest or mark that holds the centre of the tip at one place, whatever its radius."""

    type: Literal["point"] = Field(description="A seat, cone, nest or mark that holds the tip's centre at one place.")
    point: Vector | None = Field(default=None, description="That place, in the fixture frame.")
    sigma: Sigma = Field(default=0.0, description="How well the place is known, in each direction.")


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


FeatureModel: TypeAlias = Annotated[PlaneModel | PointModel | SphereModel | CylinderModel, Field(discriminator="type")]


Pair: TypeAlias = Annotated[list[Name], Field(min_length=2, max_length=2)]
Interval: TypeAlias = Annotated[list[float | None], Field(min_length=2, max_length=2)]


class ProbeModel(Strict):
    """Properties of the probe, used if the contact file does not give them."""

    tip_radius: Annotated[float, Field(ge=0)] | None = Field(
        default=None,
        description="0: contacts are points of the surface; above 0: contacts are centres of a tip of this radius.",
    )
    sigma: Length | None = Field(
        default=None, description="One standard deviation of a contact along the surface normal."
    )
    approach_distance: Length | None = Field(
        default=None,
        description="Length of the straight path of the probe before it touches; by default unlimited.",
    )
    tip_offset: Vector | None = Field(
        default=None, description="Centre of the tip in the flange frame, for contacts that are flange poses."
    )
    tip_within: Length | None = Field(
        default=None, description="Largest distance of the tip from tip_offset, if the tip is determined with the pose."
    )


class DistanceModel(Strict):
    """A known distance."""

    between: Pair = Field(description="The two features.")
    value: float = Field(
        description="Between centres, axes and planes; centre to plane is signed, positive on the outward side."
    )
    sigma: Sigma = Field(default=0.0, description="One standard deviation of value.")


class AngleModel(Strict):
    """A known angle."""

    between: Pair = Field(description="The two features: planes and cylinders.")
    value: Annotated[float, Field(ge=0, le=180)] = Field(
        description="Degrees: 0 to 180 between outward normals, 0 to 90 if one is an axis, which has no sign."
    )
    sigma: Annotated[float, Field(ge=0, le=180)] = Field(
        default=0.0, description="One standard deviation of value, in degrees."
    )


class TouchModel(Strict):
    """A box in the fixture frame; null: no limit."""

    x: Interval | None = Field(default=None, description="[low, high] of x; null: no limit.")
    y: Interval | None = Field(default=None, description="[low, high] of y; null: no limit.")
    z: Interval | None = Field(default=None, description="[low, high] of z; null: no limit.")
