"""Format 1 of fixture files: these models are its one description, the JSON Schema made of them its one other form."""

import json
from typing import Final

from pydantic import Field

from tactfix.fixture_format.entry_schema import (
    AngleModel,
    DistanceModel,
    FeatureModel,
    Name,
    ProbeModel,
    Strict,
    TouchModel,
)
from tactfix.fixture_format.pose_schema import FrameModel, PlacementModel
from tactfix.units import Unit

DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"


def generated_schema() -> str:
    """The JSON Schema of these models: what fixtures/tactfix.schema.json must hold, with a newline at its end."""
    schema = FixtureDocument.model_json_schema(by_alias=True)
    head = {"$schema": DIALECT, "title": "tactfix fixture"}
    return json.dumps({**head, **{key: value for key, value in schema.items() if key != "title"}}, indent=2) + "\n"


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
    placement: PlacementModel | None = Field(
        default=None, description="What is known beforehand of where the fixture stands in base."
    )
