"""Checks plain values against the JSON Schema of fixture files, for the keywords that pydantic generates.

pydantic is imported only to explain errors: importing it and building its validators takes longer than the rest of
locating a fixture.
"""

import json
import math
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final

# Keywords that need no check here: annotations, discriminator (implied by oneOf), and type (checked first).
_NOTES: Final = frozenset({"$schema", "$defs", "title", "description", "default", "discriminator", "type"})


@cache
def _fixture_schema() -> Mapping[str, Any]:
    schema: Mapping[str, Any] = json.loads(fixture_schema())
    return schema


def fixture_schema() -> str:
    """JSON Schema (draft 2020-12) of format 1, as text with a newline at its end."""
    return (fixtures_folder() / "tactfix.schema.json").read_text(encoding="utf-8")


def fixtures_folder() -> Path:
    """The folder of the shipped fixture files and schema: in the installed package, or next to src in a checkout."""
    packaged = Path(__file__).parents[1] / "fixtures"
    return packaged if packaged.is_dir() else Path(__file__).parents[3] / "fixtures"


def is_well_formed(value: Any) -> bool:
    """Whether value, read from a file, is valid against the schema of fixture files."""
    schema = _fixture_schema()
    return conforms(value, schema, schema["$defs"])


def is_section(section: str, value: Any) -> bool:
    """Whether value is valid as a section (probe, frame) of a fixture file."""
    schema = _fixture_schema()
    return conforms(value, schema["properties"][section], schema["$defs"])


def is_entry(section: str, value: Any) -> bool:
    """Whether value is valid as one entry of a section: a feature, a distance, an angle, a touch box."""
    schema = _fixture_schema()
    of_section = schema["properties"][section]
    return conforms(value, of_section.get("additionalProperties") or of_section["items"], schema["$defs"])


def conforms(value: Any, schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> bool:
    """Whether value is valid against schema; numbers must be finite, as they are in JSON.

    Raises KeyError for an unsupported keyword of JSON Schema, so that no restriction is ignored.
    """
    # Type first: the other keywords depend on it.
    if "type" in schema and not _TYPE_CHECKS[schema["type"]](value):
        return False
    return all(_keeps(value, word, schema, definitions) for word in schema if word not in _NOTES)


def _keeps(value: Any, word: str, schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> bool:
    """Whether value satisfies one keyword of the schema."""
    argument = schema[word]
    if word in _SIMPLE:
        return _SIMPLE[word](value, argument)
    if word == "$ref":
        return conforms(value, definitions[argument.removeprefix("#/$defs/")], definitions)
    if word in ("anyOf", "oneOf"):
        return any(conforms(value, choice, definitions) for choice in argument)
    parts = _RESTRICTED_PARTS[word](value, schema)
    return all(inner is not False and conforms(part, inner, definitions) for part, inner in parts)


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value)


_TYPE_CHECKS: Final[Mapping[str, Callable[[Any], bool]]] = {
    "object": lambda value: isinstance(value, dict),
    "array": lambda value: isinstance(value, list),
    "string": lambda value: isinstance(value, str),
    "integer": lambda value: type(value) is int,
    "boolean": lambda value: isinstance(value, bool),
    "number": _is_number,
    "null": lambda value: value is None,
}
_SIMPLE: Final[Mapping[str, Callable[[Any, Any], bool]]] = {
    "const": lambda value, argument: type(value) is type(argument) and value == argument,
    "enum": lambda value, argument: isinstance(value, str) and value in argument,
    "required": lambda value, argument: all(key in value for key in argument),
    "minimum": lambda value, argument: value >= argument,
    "maximum": lambda value, argument: value <= argument,
    "exclusiveMinimum": lambda value, argument: value > argument,
    "minLength": lambda value, argument: len(value) >= argument,
    "minItems": lambda value, argument: len(value) >= argument,
    "maxItems": lambda value, argument: len(value) <= argument,
    "minProperties": lambda value, argument: len(value) >= argument,
    "maxProperties": lambda value, argument: len(value) <= argument,
}
# The parts of a value that a keyword restricts, each with its schema; False allows no value.
_RESTRICTED_PARTS: Final[Mapping[str, Callable[[Any, Mapping[str, Any]], Iterable[tuple[Any, Any]]]]] = {
    "properties": lambda value, schema: [
        (value[key], inner) for key, inner in schema["properties"].items() if key in value
    ],
    "additionalProperties": lambda value, schema: [
        (part, schema["additionalProperties"]) for key, part in value.items() if key not in schema.get("properties", ())
    ],
    "propertyNames": lambda value, schema: [(key, schema["propertyNames"]) for key in value],
    "items": lambda value, schema: [(part, schema["items"]) for part in value],
}
