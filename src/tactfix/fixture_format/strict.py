"""What all models share: unknown keys, nan, infinity and wrong types are errors, and nothing is converted."""

from typing import Annotated, TypeAlias

from pydantic import BaseModel, ConfigDict, Field


class Strict(BaseModel):
    """Base of the models of the file."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)


Name: TypeAlias = Annotated[str, Field(min_length=1)]
"""The name of a feature of this file."""
Vector: TypeAlias = Annotated[list[float], Field(min_length=3, max_length=3)]
"""Three numbers x, y, z in the fixture frame."""
Length: TypeAlias = Annotated[float, Field(gt=0)]
"""A length above zero, in the file's units."""
Sigma: TypeAlias = Annotated[float, Field(ge=0)]
"""One standard deviation, zero for something exactly known."""
