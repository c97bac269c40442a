"""Format 1 of cell files: the robot, its probe, what is unknown of it, and the fixtures at their places."""

import json
from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from tactfix.fixture_format.entry_schema import Length, Name, Strict, Vector
from tactfix.fixture_format.pose_schema import Matrix, PlacementModel
from tactfix.units import Unit

Numbers: TypeAlias = Annotated[list[float], Field(min_length=4, max_length=5)]
Range: TypeAlias = Annotated[list[float], Field(min_length=2, max_length=2)]


def cell_schema() -> str:
    """JSON Schema (draft 2020-12) of cell files, as text with a newline at its end."""
    schema = CellDocument.model_json_schema(by_alias=True)
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "tactfix cell"}
    return json.dumps({**head, **{key: value for key, value in schema.items() if key != "title"}}, indent=2) + "\n"


class DhModel(Strict):
    """Denavit-Hartenberg rows."""

    convention: Literal["standard", "modified"] = Field(description="standard, or modified (Craig).")
    rows: Annotated[list[Numbers], Field(min_length=1)] = Field(
        description="One row a joint: a, d, alpha, theta in units and degrees; fifth, where axes are parallel, beta."
    )
    types: list[Literal["revolute", "prismatic", "fixed"]] | None = Field(
        default=None, description="The type of each row's joint; all revolute where not given."
    )


class RobotModel(Strict):
    """The nominal robot: a URDF and its tip link, or Denavit-Hartenberg rows."""

    urdf: Name | None = Field(default=None, description="A URDF file, relative to this file's folder.")
    tip_link: Name | None = Field(default=None, description="The link of the URDF whose origin is the tip's centre.")
    base_link: Name | None = Field(default=None, description="Where the chain begins; the URDF's root if not given.")
    dh: DhModel | None = Field(default=None, description="Rows instead of a URDF.")
    joint_ranges: list[Range] | None = Field(
        default=None, description="Where the robot will work: [low, high] of each joint, degrees or units."
    )


class CellProbeModel(Strict):
    """The probe on the robot's flange."""

    tip_radius: Annotated[float, Field(ge=0)] = Field(description="Radius of the tip.")
    sigma: Length | None = Field(default=None, description="One standard deviation of a touch along the normal.")
    tip_offset: Vector | None = Field(default=None, description="The tip's centre in the frame of the flange or link.")


class PriorModel(Strict):
    """One sigma of what the nominal robot may be off by, at most."""

    joint_offset: Length | None = Field(default=None, description="Of a joint's zero, degrees.")
    length: Length | None = Field(default=None, description="Of a length, in units.")
    angle: Length | None = Field(default=None, description="Of the direction of an axis, degrees.")
    tip: Length | None = Field(default=None, description="Of the tip's place on the flange, in units.")


class PlaceModel(Strict):
    """A fixture at a place of which something is known."""

    fixture: Name = Field(description="One of fixtures.")
    placement: PlacementModel | None = Field(default=None, description="As in a fixture file.")
    place: dict[Name, str | Matrix] | None = Field(
        default=None,
        description="Rigidly joined to another: {of: base_plate, matrix: [[...], ...]}, or any pose format.",
    )


class CellDocument(Strict):
    """The whole file."""

    # Not Literal[1]: true and 1.0 equal 1.
    tactfix_cell: int = Field(ge=1, le=1, description="The version of this format.", json_schema_extra={"const": 1})
    units: Unit = Field(description="Unit of every length in this file.")
    robot: RobotModel
    probe: CellProbeModel
    unknown: Literal["all"] | Annotated[list[Name], Field(min_length=1)] = Field(
        description="all; or joint_offsets, tip, tip_radius, and parameters by name, joint_3.offset."
    )
    prior: PriorModel
    fixtures: Annotated[dict[Name, Name], Field(min_length=1)] = Field(description="Fixture files by name.")
    places: Annotated[dict[Name, Name | PlaceModel], Field(min_length=1)] = Field(
        description="The fixture at each place; where it stands is unknown."
    )
