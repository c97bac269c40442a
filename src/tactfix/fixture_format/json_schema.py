"""Checks plain values against the JSON Schema of fixture files, for the keywords that pydantic generates.

pydantic does this too, and is used to explain errors; but importing it and building its validators takes longer than
the rest of locating a fixture.
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
    """The folder of the shipped fixture files and schema: in the installed package, beside src in a checkout."""
    packaged = Path(__file__).parents[1] / "fixtures"
    return packaged if packaged.is_dir() else Path(__file__).parents[3] / "fixtures"


def is_well_formed(value: Any) -> bool:
    """Whether value, read from a file, keeps to the schema of fixture files."""
    schema = _fixture_schema()
    return conforms(value, schema, schema["$defs"])


def is_section(section: str, value: Any) -> bool:
    """Whether value keeps to the schema of a section (probe, frame) of a fixture file."""
    schema = _fixture_schema()
    return conforms(value, schema["properties"][section], schema["$defs"])


def is_entry(section: str, value: Any) -> bool:
    """Whether value keeps to the schema of one entry of a section: a feature, a distance, an angle, a touch box."""
    schema = _fixture_schema()
    of_section = schema["properties"][section]
    return conforms(value, of_section.get("additionalProperties") or of_section["items"], schema["$defs"])


def conforms(value: Any, schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> bool:
    """Whether value keeps to schema; a number must be finite too, which JSON takes for granted.

    Raises KeyError for a keyword of JSON Schema that is not known here, so that no restriction is ignored.
    """
    # The type first: the other keywords depend on it.
    if "type" in schema and not _TYPE_CHECKS[schema["type"]](value):
        return False
    return all(_keeps(value, word, schema, definitions) for word in schema if word not in _NOTES)


def _keeps(value: Any, word: str, schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> bool:
    """Whether value keeps to one word of the schema."""
    said = schema[word]
    if word in _SIMPLE:
        return _SIMPLE[word](value, said)
    if word == "$ref":
        return conforms(value, definitions[said.removeprefix("#/$defs/")], definitions)
    if word in ("anyOf", "oneOf"):
        return any(conforms(value, choice, definitions) for choice in said)
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
    "const": lambda value, said: type(value) is type(said) and value == said,
    "enum": lambda value, said: isinstance(value, str) and value in said,
    "required": lambda value, said: all(key in value for key in said),
    "minimum": lambda value, said: value >= said,
    "maximum": lambda value, said: value <= said,
    "exclusiveMinimum": lambda value, said: value > said,
    "minLength": lambda value, said: len(value) >= said,
    "minItems": lambda value, said: len(value) >= said,
    "maxItems": lambda value, said: len(value) <= said,
    "minProperties": lambda value, said: len(value) >= said,
    "maxProperties": lambda value, said: len(value) <= said,
}
# The parts of a value that a word restricts, each with its schema; False lets nothing be there.
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
