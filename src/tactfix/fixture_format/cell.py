"""The plain values of a cell file, held to the models, with every problem in the words of the file."""

from typing import Any

from pydantic import ValidationError

from tactfix.fixture_format.cell_schema import CellDocument
from tactfix.fixture_format.problems import Finding, Path
from tactfix.wording import did_you_mean

_CELL_KEYS = {"dh": ("convention", "rows", "types"), "prior": ("joint_offset", "length", "angle", "tip")}


def read_cell(value: Any) -> CellDocument | list[Finding]:
    """The document that value says, or what is wrong with it."""
    if not isinstance(value, dict):
        return [Finding((), "the file is not a mapping of keys to values", "begin with tactfix_cell: 1, then units:")]
    try:
        document = CellDocument.model_validate(value)
    except ValidationError as error:
        found = {_finding(detail) for detail in error.errors(include_url=False) if not _is_other_form(detail, value)}
        return sorted(found, key=lambda finding: tuple(map(str, finding.path)))
    return [*_robot_findings(document), *_place_findings(document)] or document


def _is_other_form(error: Any, value: dict[str, Any]) -> bool:
    """Whether this is why an entry is none of the other form that it could have: a name where a mapping stands."""
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
    where = ".".join(f"#{part + 1}" if isinstance(part, int) else part for part in path) or "the file"
    if kind == "extra_forbidden":
        return Finding(path, f"unknown key {path[-1]!r}", did_you_mean(str(path[-1]), _known(path)), at_key=True)
    if kind == "missing":
        parent = path[:-1]
        whole = where.rpartition(".")[0] or "the file"
        return Finding(parent, f"{whole} has no {path[-1]}", f"add {path[-1]}:", at_key=bool(parent))
    remedy = "write all, or a list: [joint_offsets, tip]" if path == ("unknown",) else _lowered(str(error["msg"]))
    return Finding(path, f"{where} is {error['input']!r}", remedy)


def _known(path: Path) -> tuple[str, ...]:
    """The keys that may stand where an unknown one does."""
    model: Any = CellDocument
    for part in path[:-1]:
        if str(part) in _CELL_KEYS:
            return _CELL_KEYS[str(part)]
        fields = getattr(model, "model_fields", {})
        if str(part) in fields:
            model = fields[str(part)].annotation
    return tuple(getattr(model, "model_fields", ("fixture", "placement", "place")))


def _lowered(message: str) -> str:
    return message[:1].lower() + message[1:]


def _robot_findings(document: CellDocument) -> list[Finding]:
    robot = document.robot
    if (robot.urdf is None) == (robot.dh is None):
        what = "robot has both urdf and dh" if robot.urdf is not None else "robot has neither urdf nor dh"
        return [
            Finding(("robot",), what, "write {urdf: robot.urdf, tip_link: tip} or {dh: {convention: ..., rows: ...}}")
        ]
    if robot.urdf is not None and robot.tip_link is None:
        return [Finding(("robot",), "robot has no tip_link", "name the link of the URDF that is the tip's centre")]
    if robot.dh is not None and robot.dh.types is not None and len(robot.dh.types) != len(robot.dh.rows):
        what = f"{len(robot.dh.types)} types for {len(robot.dh.rows)} rows"
        return [Finding(("robot", "dh", "types"), what, "write one type for each row")]
    return []


def _place_findings(document: CellDocument) -> list[Finding]:
    found = []
    for name, entry in document.places.items():
        fixture = entry if isinstance(entry, str) else entry.fixture
        if fixture not in document.fixtures:
            what = f"place {name!r} has the fixture {fixture!r}, which is not among fixtures"
            found.append(Finding(("places", name), what, did_you_mean(fixture, document.fixtures)))
        if not isinstance(entry, str) and entry.place is not None:
            found += _joined_findings(document, name, entry.place)
    return found


def _joined_findings(document: CellDocument, name: str, joined: dict[str, Any]) -> list[Finding]:
    path = ("places", name, "place")
    other = joined.get("of")
    if isinstance(other, str) and other not in document.places:
        what = f"place {name!r} is joined to {other!r}, which is not among places"
        return [Finding(path, what, did_you_mean(other, document.places))]
    if other is None or len(joined) != 2:
        what = f"place {name!r} must be joined to one place by one pose"
        return [Finding(path, what, "write place: {of: base_plate, matrix: [[...], ...]}, or a pose in another format")]
    if document.places[name].placement is not None:  # type: ignore[union-attr]
        what = f"place {name!r} is joined to {other!r} and has a placement of its own"
        return [Finding(path, what, f"keep one; a placement of {other!r} holds for both")]
    seen = {name}
    while isinstance(other, str):
        if other in seen:
            return [
                Finding(path, f"place {name!r} is joined to itself in the end", "leave one place of them by itself")
            ]
        seen.add(other)
        entry = document.places[other]
        other = None if isinstance(entry, str) or entry.place is None else entry.place.get("of")
    return []
