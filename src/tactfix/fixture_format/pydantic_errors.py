"""Errors of pydantic in terms of the file: what is wrong, where, and what to write instead."""

from typing import Any, Final

from pydantic import BaseModel, ValidationError

from tactfix.decimal_text import DECIMAL_COMMA
from tactfix.fixture_format.entries import Finding, Path, unknown_key
from tactfix.fixture_format.entry_schema import (
    AngleModel,
    CylinderModel,
    DistanceModel,
    PlaneModel,
    PointModel,
    ProbeModel,
    SphereModel,
    TouchModel,
)
from tactfix.fixture_format.schema import (
    Along,
    CenterOf,
    FixtureDocument,
    FootOf,
    FrameModel,
    FromTo,
    MeetOf,
    Opposite,
    PlacementModel,
    PlacementSigma,
    PoseFile,
    WithinModel,
)
from tactfix.units import which_unit
from tactfix.wording import did_you_mean

_FEATURES: Final[dict[Any, type[BaseModel]]] = {
    "plane": PlaneModel,
    "sphere": SphereModel,
    "cylinder": CylinderModel,
    "point": PointModel,
}
_RULES: Final[dict[Any, type[BaseModel]]] = {
    "center_of": CenterOf,
    "foot_of": FootOf,
    "meet_of": MeetOf,
    "along": Along,
    "from": FromTo,
    "opposite": Opposite,
}
_ENTRIES: Final[dict[Any, type[BaseModel]]] = {"distances": DistanceModel, "angles": AngleModel, "touch": TouchModel}
_PLACEMENT: Final[dict[Any, type[BaseModel]]] = {"within": WithinModel, "sigma": PlacementSigma, "file": PoseFile}
_KEY_EXAMPLES: Final[dict[str, str]] = {
    "probe": "write probe: {tip_radius: 1.5, sigma: 0.005}",
    "features": "write features: {ball: {type: sphere, radius: 12.7}}",
    "distances": "write distances: [{between: [bar, ball], value: 30.0}], or leave distances out",
    "angles": "write angles: [{between: [top, side], value: 90.0}], or leave angles out",
    "frame": "write frame: {origin: {foot_of: ball, on: bar}, y: {along: bar}, x: {from: bar, to: ball}}",
    "touch": "write touch: {bar: {y: [5.0, 60.0]}}",
    "placement": "write placement: {near: {file: yesterday.json}, within: {translation: 20.0, rotation: 5.0}}",
}


def malformations(value: Any) -> list[Finding]:
    """Findings of schema violations in a fixture file, in the order of the models; empty for a valid file."""
    try:
        FixtureDocument.model_validate(value)
    except ValidationError as error:
        return [_finding(detail) for detail in error.errors(include_url=False)]
    return []


def _finding(error: Any) -> Finding:
    kind, input_, context = error["type"], error["input"], error.get("ctx", {})
    path = _plain_path(error["loc"])
    if kind == "extra_forbidden":
        return unknown_key(path, _known_keys(error["loc"]))
    if kind == "missing":
        key = error["loc"][-1]
        parent = _plain_path(error["loc"][:-1])
        message = f"{place_of(parent)} has no {key}" if parent else f"the file has no key {key!r}"
        return Finding(parent, message, _how_to_add(str(key), parent), at_key=True)
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        return _untagged(path, input_)
    message = f"{place_of(path)} is {shown(input_)}"
    return Finding(path, message, _remedy(kind, path, input_, context))


def _plain_path(location: tuple[str | int, ...]) -> Path:
    """A location of pydantic without the names of union members, which are not in the file."""
    match location:
        case ("frame", _, "opposite", *_):
            tags: tuple[int, ...] = (2, 4)
        case ("features", *_) | ("frame", *_) | ("placement", "sigma", *_):
            tags = (2,)
        case ("placement", "near", *_):
            tags = (3,)
        case _:
            tags = ()
    return tuple(part for index, part in enumerate(location) if index not in tags and part != "[key]")


def place_of(path: Path) -> str:
    """A path in the form used in messages: features.bar, distances.#1."""
    return ".".join(f"#{part + 1}" if isinstance(part, int) else part for part in path) or "the file"


def _known_keys(location: tuple[str | int, ...]) -> list[str]:
    head, *rest = location[:-1] or ("",)
    model: type[BaseModel] = FixtureDocument
    if head == "features":
        model = _FEATURES[rest[1]]
    elif head in _ENTRIES:
        model = _ENTRIES[head]
    elif head == "probe":
        model = ProbeModel
    elif head == "frame":
        model = _RULES[rest[-1]] if rest else FrameModel
    elif head == "placement":
        model = _PLACEMENT[rest[-1]] if rest else PlacementModel
    return [field.alias or name for name, field in model.model_fields.items()]


def _how_to_add(key: str, parent: Path) -> str:
    examples = {
        "tactfix": "begin the file with tactfix: 1",
        "units": "add units: mm, or m, um, in",
        "radius": "add radius: and its length",
        "value": "add value: and the number",
        "between": "add between: [one feature, another]",
        "to": "add to: and a feature",
        "on": "add on: and a cylinder or plane",
        "origin": "add origin: {center_of: a sphere or point}, {foot_of: A, on: B} or {meet_of: [...]}",
        "near": "add near: {file: yesterday.json}, {matrix: [[...], ...]} or a pose by the name of its format",
        "translation": "add translation: and a length",
        "rotation": "add rotation: and degrees",
        **_KEY_EXAMPLES,
    }
    return examples.get(key, f"add {key}:")


def _untagged(path: Path, value: Any) -> Finding:
    place = place_of(path)
    if path[0] == "features":
        if not isinstance(value, dict) or "type" not in value:
            return Finding(path, f"{place} has no type", "add type: plane, sphere, cylinder or point", at_key=True)
        remedy = did_you_mean(str(value["type"]), _FEATURES)
        return Finding(
            (*path, "type"), f"{place} has the unknown type {shown(value['type']).removeprefix('the text ')}", remedy
        )
    if path[0] == "placement":
        remedy = (
            _NEAR_REMEDY if path[1] == "near" else "write {translation: 0.5, rotation: 0.1} or {file: yesterday.json}"
        )
    elif path[1] == "origin":
        remedy = "write {center_of: sphere}, {foot_of: A, on: B} or {meet_of: [plane, plane, plane]}"
    else:
        remedy = "write {along: cylinder or plane}, {from: A, to: B} or {opposite: one of these}"
    return Finding(path, f"{place} is {shown(value)}", remedy)


def shown(value: Any) -> str:
    """A value of the file in the form used in messages."""
    match value:
        case None:
            return "empty"
        case str():
            return f"the text {value!r}" if len(value) <= 40 else f"the text {value[:40]!r}..."
        case bool():
            return str(value).lower()
        case dict():
            return f"a mapping with {', '.join(map(str, value))}" if value else "an empty mapping"
        case list():
            return f"a list of {len(value)}"
        case _:
            return f"{value!r}"


def _remedy(kind: str, path: Path, value: Any, context: Any) -> str:
    if path == ("tactfix",):
        return "this tactfix reads format 1: write tactfix: 1, or install a newer tactfix"
    if path == ("units",):
        return which_unit(str(value))
    if kind == "literal_error":
        return f"write one of: {context['expected']}".replace("'", "")
    if len(path) == 1 and path[0] in _KEY_EXAMPLES:
        return _KEY_EXAMPLES[str(path[0])]
    if kind in LIST_ERRORS or path[1:] == ("near",):
        return _list_remedy(path)
    return number_remedy(kind, value, context) or "see 'tactfix schema' for what is allowed here"


LIST_ERRORS: Final = ("too_short", "too_long", "list_type")
"""Error types of pydantic for a value that is no list, or one of wrong length."""


def number_remedy(kind: str, value: Any, context: Any) -> str | None:
    """Remedy for a value that is no number or name, or out of bounds; None for other errors of pydantic."""
    if kind == "float_type" and isinstance(value, str) and DECIMAL_COMMA.fullmatch(value):
        return f"write a decimal point: {value.replace(',', '.')}"
    return _TYPE_REMEDIES.get(kind) or (_BY_CONTEXT[kind].format(**context) if kind in _BY_CONTEXT else None)


_NEAR_REMEDY: Final = (
    "write one pose: {file: yesterday.json}, {matrix: [[...], ...]}, or the text of any format by its name"
)
_BY_CONTEXT: Final[dict[str, str]] = {
    "greater_than": "write a number above {gt:g}",
    "greater_than_equal": "write a number of at least {ge:g}",
    "less_than_equal": "write a number of at most {le:g}",
}
_TYPE_REMEDIES: Final[dict[str, str]] = {
    "finite_number": "write a finite number",
    "float_type": "write a number such as 12.7 or 1e-3, without quotes, unit or thousands separator",
    "string_type": "write a name; put a name that looks like a number in quotes",
    "string_too_short": "write a name",
}


def _list_remedy(path: Path) -> str:
    if path[:2] == ("placement", "near"):
        return _NEAR_REMEDY
    match path[-1]:
        case "free":
            return "write those of x, y, z, rx, ry, rz that may differ from near: [x, y, rz]"
        case "between":
            return "write two features: [bar, ball]"
        case "meet_of":
            return "write three planes or a cylinder and a plane: [bar, top]"
        case "x" | "y" | "z":
            return "write [low, high], null for no limit"
        case _:
            return "write three numbers: [0.0, 0.0, 0.0]"
