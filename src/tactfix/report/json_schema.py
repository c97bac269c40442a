"""JSON Schemas of the JSON output of the commands, generated from its types."""

import json
import types
from importlib import import_module
from typing import (
    Annotated,
    Any,
    Final,
    Literal,
    NotRequired,
    Union,
    get_args,
    get_origin,
    get_type_hints,
    is_typeddict,
)

from tactfix.errors import UsageError
from tactfix.wording import did_you_mean

_COMMAND_TYPES: Final = {
    "locate": "json_types:LocateJson",
    "fit": "json_types:FitJson",
    "guide": "json_types:GuideJson",
    "design-check": "json_types_of_design:DesignCheckJson",
    "check": "json_types_of_tools:CheckJson",
    "compare": "json_types_of_tools:CompareJson",
    "plan": "json_types_of_tools:PlanJson",
    "simulate": "json_types_of_tools:SimulateJson",
    "qualify": "json_types_of_tools:QualifyJson",
    "calibrate": "json_types_of_calibration:CalibrateJson",
    "batch": "json_types_of_tools:BatchJson",
}
"""The type of the JSON of each command that prints JSON, by module and name."""
_MORE: Final = {"calibrate-plan": "json_types_of_calibration:CalibratePlanJson"}
"""The same for commands with an option that changes their output."""

JSON_COMMANDS: Final = tuple(_COMMAND_TYPES)
_JSON_TYPES: Final[dict[object, str]] = {
    str: "string",
    bool: "boolean",
    int: "integer",
    float: "number",
    types.NoneType: "null",
}


def schema_of(command: str) -> str:
    """JSON Schema (draft 2020-12) of the JSON of a command, as text. Raises UsageError for a command without JSON."""
    known = {**_COMMAND_TYPES, **_MORE}
    if command not in known:
        raise UsageError(f"no JSON of {command!r}; {did_you_mean(command, known)}")
    module, name = known[command].split(":")
    definitions: dict[str, Any] = {}
    root = _schema(getattr(import_module(f"tactfix.report.{module}"), name), definitions)
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"JSON of tactfix {command}",
        **root,
        "$defs": definitions,
    }
    return json.dumps(schema, indent=2) + "\n"


def _schema(kind: Any, definitions: dict[str, Any]) -> dict[str, Any]:
    """The schema of a type; objects are defined once and referenced."""
    if kind in _JSON_TYPES:
        return {"type": _JSON_TYPES[kind]}
    if is_typeddict(kind):
        if kind.__name__ not in definitions:
            definitions[kind.__name__] = {}  # a type may be recursive
            definitions[kind.__name__] = _object(kind, definitions)
        return {"$ref": f"#/$defs/{kind.__name__}"}
    return _composed(get_origin(kind), get_args(kind), definitions)


def _composed(origin: Any, inner: tuple[Any, ...], definitions: dict[str, Any]) -> dict[str, Any]:
    """The schema of a generic type."""
    if origin is Literal:
        return {"const": inner[0]} if len(inner) == 1 else {"enum": list(inner)}
    if origin in (Union, types.UnionType):
        return {"anyOf": [_schema(one, definitions) for one in inner]}
    part = _schema(inner[-1] if origin is dict else inner[0], definitions)
    if origin is Annotated:
        return {**part, "minItems": inner[1], "maxItems": inner[1]}
    return {"type": "array", "items": part} if origin is list else {"type": "object", "additionalProperties": part}


def _object(kind: Any, definitions: dict[str, Any]) -> dict[str, Any]:
    """An object with all its keys and no others."""
    properties = {}
    for name, of_key in get_type_hints(kind, include_extras=True).items():
        wanted = get_args(of_key)[0] if get_origin(of_key) is NotRequired else of_key
        properties[name] = _schema(wanted, definitions)
    return {
        "type": "object",
        "description": kind.__doc__,
        "properties": properties,
        "required": [name for name in properties if name in kind.__required_keys__],
        "additionalProperties": False,
    }
