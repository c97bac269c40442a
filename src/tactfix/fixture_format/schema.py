"""Format 1 of fixture files: these models are its one description, the JSON Schema made of them its one other form."""

import json
from collections.abc import Iterable
from typing import Annotated, Any, Final, TypeAlias

from pydantic import Discriminator, Field, Tag

from tactfix.fixture_format.entry_schema import (
    AngleModel,
    DistanceModel,
    FeatureModel,
    Length,
    Name,
    ProbeModel,
    Strict,
    TouchModel,
)
from tactfix.placement import Direction as FreeDirection
from tactfix.units import Unit


class CenterOf(Strict):
    """The centre of a sphere, or a point."""

    center_of: Name = Field(description="A sphere or point: the origin is its centre.")


class FootOf(Strict):
    """The point of one feature that is nearest to another."""

    foot_of: Name = Field(description="The feature to project: a sphere or point, or a cylinder if 'on' is one too.")
    on: Name = Field(
        description="A cylinder or plane; the origin is the point of its axis or face nearest to 'foot_of'."
    )


class MeetOf(Strict):
    """The point at which features intersect."""

    meet_of: Annotated[list[Name], Field(min_length=2, max_length=3)] = Field(
        description="Three planes, or a cylinder and a plane: the origin is where planes, or axis and plane, intersect."
    )


class Along(Strict):
    """The direction of an axis or an outward normal."""

    along: Name = Field(description="A cylinder (its axis, of either sign) or a plane (its outward normal).")


class FromTo(Strict):
    """The direction from one feature to another."""

    from_: Name = Field(alias="from", description="The feature from which the axis points.")
    to: Name = Field(description="The feature to which the axis points.")


class Opposite(Strict):
    """The reverse of a direction."""

    opposite: "Direction" = Field(description="The direction that is reversed: along, or from and to.")


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
    """An origin and two of x, y, z: the first one written is exact, the second is made perpendicular to it."""

    origin: Origin = Field(description="Where the origin is: center_of, foot_of and on, or meet_of.")
    x: AxisModel | None = Field(default=None, description="Direction of x: along, from and to, or opposite of one.")
    y: AxisModel | None = Field(default=None, description="Direction of y: along, from and to, or opposite of one.")
    z: AxisModel | None = Field(default=None, description="Direction of z: along, from and to, or opposite of one.")


Turn: TypeAlias = Annotated[float, Field(gt=0, le=180)]
"""An angle above zero, in degrees."""
Row: TypeAlias = Annotated[list[float], Field(min_length=4, max_length=4)]
Matrix: TypeAlias = Annotated[list[Row], Field(min_length=4, max_length=4)]


def _text_or_matrix(value: Any) -> str | None:
    return "text" if isinstance(value, str) else "matrix" if isinstance(value, list) else None


PoseText: TypeAlias = Annotated[
    Annotated[str, Tag("text")] | Annotated[Matrix, Tag("matrix")], Discriminator(_text_or_matrix)
]
"""A pose as text in some format, or as four rows of four numbers."""


class PoseFile(Strict):
    """A file with a pose."""

    file: Name = Field(description="A pose file in any format that tactfix reads, relative to this file's folder.")


class WithinModel(Strict):
    """Limits of the difference between the fixture's pose and near."""

    translation: Length = Field(description="Largest displacement of the fixture's origin.")
    rotation: Turn = Field(description="Largest angle of rotation, in degrees.")


class PlacementSigma(Strict):
    """The uncertainty of a measured near."""

    translation: Length = Field(description="One standard deviation of each coordinate of the fixture's origin.")
    rotation: Turn = Field(description="One standard deviation of each component of the rotation, in degrees.")


def _file_or_sigma(value: Any) -> str | None:
    return None if not isinstance(value, dict) else "file" if "file" in value else "sigma"


MeasuredSigma: TypeAlias = Annotated[
    Annotated[PoseFile, Tag("file")] | Annotated[PlacementSigma, Tag("sigma")],
    Discriminator(_file_or_sigma),
]


class PlacementModel(Strict):
    """What is known beforehand of the fixture's pose."""

    near: Annotated[dict[Name, PoseText], Field(min_length=1, max_length=1)] = Field(
        description="A pose by the name of its format, {kuka: '{X 1200, ...}'}; or {matrix: [[...], ...]}, {file: ...}."
    )
    within: WithinModel | None = Field(default=None, description="Limits; a pose beyond them is rejected.")
    sigma: MeasuredSigma | None = Field(
        default=None, description="near is a measurement with this sigma, or with the covariance of a file."
    )
    free: Annotated[list[FreeDirection], Field(min_length=1, max_length=6)] | None = Field(
        default=None, description="Only these may differ from near: along and about the axes of base."
    )


DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"


def schema_text(model: type[Strict], title: str) -> str:
    """The JSON Schema (draft 2020-12) of a model as text, with a newline at its end."""
    schema = model.model_json_schema(by_alias=True)
    head = {"$schema": DIALECT, "title": title}
    return json.dumps({**head, **{key: value for key, value in schema.items() if key != "title"}}, indent=2) + "\n"


class FixtureDocument(Strict):
    """A tactfix fixture file: the features that a probe touches, and where they are."""

    # Not Literal[1]: true and 1.0 equal 1.
    tactfix: int = Field(ge=1, le=1, description="Version of this file format.", json_schema_extra={"const": 1})
    name: str | None = Field(default=None, min_length=1, description="Name of the fixture; by default the file's name.")
    units: Unit = Field(description="The unit of every length in this file. Angles are degrees.")
    probe: ProbeModel = Field(
        default=ProbeModel(), description="The probe; defaults for contact files without these values."
    )
    features: dict[Name, FeatureModel] = Field(min_length=1, description="The features to be touched, by name.")
    distances: list[DistanceModel] = Field(default=[], description="Known distances between features.")
    angles: list[AngleModel] = Field(default=[], description="Known angles between features.")
    frame: FrameModel | None = Field(
        default=None, description="How the frame is built from the features; not needed if these have known places."
    )
    touch: dict[Name, TouchModel] = Field(
        default={}, description="Where each surface may be touched: a box in the fixture frame."
    )
    placement: PlacementModel | None = Field(
        default=None, description="What is known beforehand of the fixture's pose in base."
    )
