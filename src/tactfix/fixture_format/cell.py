"""Checks the plain values of a cell file against its models, and reports every problem in terms of the file."""

from typing import Annotated, Any, Final, Literal, TypeAlias

from pydantic import Field, ValidationError

from tactfix.fixture_format.entries import Finding, Path, unknown_key
from tactfix.fixture_format.entry_schema import Length, Name, Strict, Vector
from tactfix.fixture_format.pydantic_errors import LIST_ERRORS, number_remedy, place_of, shown
from tactfix.fixture_format.schema import Matrix, PlacementModel, schema_text
from tactfix.units import Unit, which_unit
from tactfix.wording import did_you_mean

Numbers: TypeAlias = Annotated[list[float], Field(min_length=4, max_length=5)]
Range: TypeAlias = Annotated[list[float], Field(min_length=2, max_length=2)]


def cell_schema() -> str:
    """JSON Schema (draft 2020-12) of cell files, as text with a newline at its end."""
    return schema_text(CellDocument, "tactfix cell")


class DhModel(Strict):
    """Denavit-Hartenberg rows."""

    convention: Literal["standard", "modified"] = Field(description="standard, or modified (Craig).")
    rows: Annotated[list[Numbers], Field(min_length=1)] = Field(
        description="One row per joint: a, d, alpha, theta in units and degrees; beta as fifth if axes are parallel."
    )
    types: list[Literal["revolute", "prismatic", "fixed"]] | None = Field(
        default=None, description="The type of each row's joint; by default all are revolute."
    )


class RobotModel(Strict):
    """The nominal robot: a URDF and its tip link, or Denavit-Hartenberg rows."""

    urdf: Name | None = Field(default=None, description="A URDF file, relative to this file's folder.")
    tip_link: Name | None = Field(default=None, description="The link of the URDF whose origin is the tip's centre.")
    base_link: Name | None = Field(default=None, description="The first link of the chain; by default the URDF's root.")
    dh: DhModel | None = Field(default=None, description="Rows instead of a URDF.")
    joint_ranges: list[Range] | None = Field(
        default=None, description="The working range of the robot: [low, high] of each joint, degrees or units."
    )


class CellProbeModel(Strict):
    """The probe on the robot's flange."""

    tip_radius: Annotated[float, Field(ge=0)] = Field(description="Radius of the tip.")
    sigma: Length | None = Field(default=None, description="One standard deviation of a touch along the normal.")
    tip_offset: Vector | None = Field(default=None, description="The tip's centre in the frame of the flange or link.")


class PriorModel(Strict):
    """Upper limits of the sigmas of the nominal robot's errors."""

    joint_offset: Length | None = Field(default=None, description="Of a joint's zero, degrees.")
    length: Length | None = Field(default=None, description="Of a length, in units.")
    angle: Length | None = Field(default=None, description="Of the direction of an axis, degrees.")
    tip: Length | None = Field(default=None, description="Of the tip's position in the flange frame, in units.")


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
        description="The fixture at each place; its pose is unknown."
    )


_CELL_KEYS = {"dh": ("convention", "rows", "types"), "prior": ("joint_offset", "length", "angle", "tip")}


def read_cell(value: Any) -> CellDocument | list[Finding]:
    """The validated document of the plain values, or the findings."""
    if not isinstance(value, dict):
        return [Finding((), "the file is not a mapping of keys to values", "begin with tactfix_cell: 1, then units:")]
    try:
        document = CellDocument.model_validate(value)
    except ValidationError as error:
        found = {_finding(detail) for detail in error.errors(include_url=False) if not _is_other_form(detail, value)}
        return sorted(found, key=lambda finding: tuple(map(str, finding.path)))
    return [*_robot_findings(document), *_place_findings(document)] or document


def _is_other_form(error: Any, value: dict[str, Any]) -> bool:
    """Whether an error is about the union member that the entry does not use, such as a name for a mapping."""
    location = error["loc"]
    if location[0] == "places" and len(location) == 3 and isinstance(error["input"], dict):
        return True
    return location[0] == "unknown" and isinstance(value.get("unknown"), list) and "literal['all']" in location


def _finding(error: Any) -> Finding:
    kind = error["type"]
    location = tuple(part for part in error["loc"] if not str(part).startswith(("constrained-", "function-", "list[")))
    tags = ("PlaceModel", "literal['all']", "str", "text", "matrix", "sigma")
    path: Path = tuple(part for i, part in enumerate(location) if i < 2 or part not in tags)
    if len(path) > 1 and path[0] == "unknown" and path[1] in tags:
        path = path[:1]
    where = place_of(path)
    if kind == "extra_forbidden":
        return unknown_key(path, _known(path))
    if kind == "missing":
        parent = path[:-1]
        whole = where.rpartition(".")[0] or "the file"
        return Finding(parent, f"{whole} has no {path[-1]}", f"add {path[-1]}:", at_key=bool(parent))
    return Finding(
        path, f"{where} is {shown(error['input'])}", _remedy(kind, path, error["input"], error.get("ctx", {}))
    )


_SEVERAL: Final = {
    "unknown": "write all, or a list: [joint_offsets, tip]",
    "rows": "write one row for each joint: [a, d, alpha, theta], and beta if axes are parallel",
    "types": "write one type for each row: [revolute, prismatic]",
    "joint_ranges": "write [low, high] for each joint",
    "tip_offset": "write three numbers: [0.0, 0.0, 120.0]",
    "fixtures": "write a name for each file: {plate: plate.yaml}",
    "places": "write the fixture at each place: {front: plate}",
}
"""Remedy if a list or a mapping is needed, by the key."""


def _remedy(kind: str, path: Path, value: Any, context: Any) -> str:
    key = next((part for part in reversed(path) if isinstance(part, str)), "")
    if key in _SEVERAL and (kind in (*LIST_ERRORS, "dict_type") or key == "unknown"):
        return _SEVERAL[key]
    if path == ("tactfix_cell",):
        return "this tactfix reads format 1: write tactfix_cell: 1, or install a newer tactfix"
    if path == ("units",):
        return which_unit(str(value))
    if kind == "literal_error":
        return f"write one of: {context['expected']}".replace("'", "")
    return number_remedy(kind, value, context) or "see the JSON Schema of cell files for what is allowed here"


def _known(path: Path) -> tuple[str, ...]:
    """The valid keys at the location of an unknown one."""
    model: Any = CellDocument
    for part in path[:-1]:
        if str(part) in _CELL_KEYS:
            return _CELL_KEYS[str(part)]
        fields = getattr(model, "model_fields", {})
        if str(part) in fields:
            model = fields[str(part)].annotation
    return tuple(getattr(model, "model_fields", ("fixture", "placement", "place")))


def _robot_findings(document: CellDocument) -> list[Finding]:
    robot = document.robot
    if (robot.urdf is None) == (robot.dh is None):
        message = "robot has both urdf and dh" if robot.urdf is not None else "robot has neither urdf nor dh"
        return [
            Finding(
                ("robot",), message, "write {urdf: robot.urdf, tip_link: tip} or {dh: {convention: ..., rows: ...}}"
            )
        ]
    if robot.urdf is not None and robot.tip_link is None:
        return [Finding(("robot",), "robot has no tip_link", "name the link of the URDF that is the tip's centre")]
    if robot.dh is not None and robot.dh.types is not None and len(robot.dh.types) != len(robot.dh.rows):
        message = f"{len(robot.dh.types)} types for {len(robot.dh.rows)} rows"
        return [Finding(("robot", "dh", "types"), message, "write one type for each row")]
    return []


def _place_findings(document: CellDocument) -> list[Finding]:
    found = []
    for name, entry in document.places.items():
        fixture = entry if isinstance(entry, str) else entry.fixture
        if fixture not in document.fixtures:
            message = f"place {name!r} has the fixture {fixture!r}, which is not among fixtures"
            found.append(Finding(("places", name), message, did_you_mean(fixture, document.fixtures)))
        if not isinstance(entry, str) and entry.place is not None:
            found += _joined_findings(document, name, entry.place)
    return found


def _joined_findings(document: CellDocument, name: str, joined: dict[str, Any]) -> list[Finding]:
    path = ("places", name, "place")
    other = joined.get("of")
    if isinstance(other, str) and other not in document.places:
        message = f"place {name!r} is joined to {other!r}, which is not among places"
        return [Finding(path, message, did_you_mean(other, document.places))]
    if other is None or len(joined) != 2:
        message = f"place {name!r} must be joined to one place by one pose"
        return [
            Finding(path, message, "write place: {of: base_plate, matrix: [[...], ...]}, or a pose in another format")
        ]
    if document.places[name].placement is not None:  # type: ignore[union-attr]
        message = f"place {name!r} is joined to {other!r} and has a placement of its own"
        return [Finding(path, message, f"keep one; a placement of {other!r} applies to both")]
    visited = {name}
    while isinstance(other, str):
        if other in visited:
            return [
                Finding(
                    path,
                    f"place {name!r} is joined to itself, directly or through others",
                    "unjoin one of these places",
                )
            ]
        visited.add(other)
        entry = document.places[other]
        other = None if isinstance(entry, str) or entry.place is None else entry.place.get("of")
    return []
