"""The features of a fixture file: planes, spheres, cylinders, with or without their place in the fixture frame."""

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field

from tactfix.fixture_format.strict import Length, Sigma, Strict, Vector

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
