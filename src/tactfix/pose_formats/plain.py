"""The dialects with the exact matrix, all digits: matrix, json, yaml, csv, npy; and ROS TransformStamped."""

import io
import json
import re
import warnings
from collections.abc import Mapping
from tokenize import TokenError
from typing import Any, Final

import numpy as np
import yaml

from tactfix.formats import LOCATE_SCHEMA
from tactfix.geometry.arrays import Floats
from tactfix.pose_formats.dialect import Dialect, Numbers, decoded
from tactfix.pose_formats.matrix_text import read_matrix
from tactfix.pose_formats.orientation import Quaternion
from tactfix.pose_formats.pose import Pose, PoseSyntaxError, rigid_matrix, syntax_error
from tactfix.pose_formats.ros_text import is_echo, read_echo
from tactfix.settings import LOCATE_JSON
from tactfix.units import UNITS
from tactfix.wording import printable
from tactfix.yaml_tree import read_tree

POSE_SCHEMA: Final = "tactfix/pose/1"
_MOST_BYTES: Final = 1 << 16
"""Largest .npy file that is read: far more than its header and the 16 numbers of a pose."""
# As in YAML and shells, # directly after a number or word does not begin a comment: -20#.5 is malformed.
_REMARK: Final = re.compile(r"(?<![\w.+-])#")
_ROS: Final = Numbers(("x", "y", "z", "qx", "qy", "qz", "qw"), "m", Quaternion(scalar_first=False), "")


def _write_rows(separator: str) -> Any:
    def write(pose: Pose, remarks: tuple[str, ...]) -> str:
        head = [f"# {remark}" for remark in remarks]
        if separator == ",":
            head = [f"# units: {pose.units}", *head] if pose.units else head
        rows = [separator.join(repr(float(value) + 0.0) for value in row) for row in pose.base_from_fixture]
        return "\n".join([*head, *rows]) + "\n"

    return write


def _read_rows(text: str | bytes) -> Pose:
    """The matrix, with or without brackets; '# units: mm' on a line of its own gives the unit."""
    units, rows = None, []
    for number, line in enumerate(decoded(text).splitlines(), 1):
        content, remark = (*_REMARK.split(line, maxsplit=1), "")[:2]
        key, _, value = remark.partition(":")
        if key.strip().lower() == "units":
            units = _units(value.strip(), number)
        rows.append(content)
    return Pose(rigid_matrix(read_matrix("\n".join(rows))), units)


def _units(value: object, line: int | None = None) -> str | None:
    if value is None or value in UNITS:
        return None if value is None else str(value)
    raise syntax_error(f"units {value!r} are not known", f"write one of {', '.join(UNITS)}", line)


def _fields(pose: Pose) -> dict[str, object]:
    """The keys and values for JSON and YAML, as in the JSON of locate."""
    covariance = None if pose.covariance is None else pose.covariance.tolist()
    return {
        "schema": POSE_SCHEMA,
        "fixture": pose.fixture,
        "units": pose.units,
        "status": "located",
        "transform": (pose.base_from_fixture + 0.0).tolist(),
        "covariance": covariance,
    }


def _write_json(pose: Pose, remarks: tuple[str, ...]) -> str:
    return json.dumps(_fields(pose), indent=1) + "\n"


def _write_yaml(pose: Pose, remarks: tuple[str, ...]) -> str:
    return _commented(remarks) + yaml.safe_dump(_fields(pose), sort_keys=False, default_flow_style=None, width=200)


def _commented(remarks: tuple[str, ...]) -> str:
    return "".join(f"# {remark}\n" for remark in remarks)


def _read_json(text: str | bytes) -> Pose:
    remedy = "give " + LOCATE_JSON
    try:
        tree = json.loads(decoded(text), object_pairs_hook=_without_twins)
    except json.JSONDecodeError as error:
        raise syntax_error(f"is not JSON: {error.msg}", remedy, error.lineno) from error
    except RecursionError:
        raise syntax_error("is not a pose: its brackets are nested too deep", remedy) from None
    except ValueError as error:  # an integer of thousands of digits
        raise syntax_error(f"contains a number that cannot be read: {error}", remedy) from error
    return _from_tree(tree)


def _without_twins(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object; PoseSyntaxError for a duplicate key, of which json would silently keep the last."""
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise syntax_error(f"{twice!r} is given twice in one object", "remove one of the two")
    return found


def _read_yaml(text: str | bytes) -> Pose:
    """One document, or the same pose in each of several: ros2 topic echo ends each message with ---."""
    content = decoded(text)
    if is_echo(content):
        return Pose(_ROS.pose(read_echo(content)), "m")
    poses = [_read_document(document) for document in _documents(content)]
    if any(not np.array_equal(pose.base_from_fixture, poses[0].base_from_fixture) for pose in poses):
        raise syntax_error(f"contains {len(poses)} poses, and they differ", "keep one of them")
    return poses[0]


def _documents(text: str) -> list[str]:
    """The non-empty documents of a YAML text, each after empty lines that keep its line numbers."""
    found, first = [], 0
    lines = text.splitlines()
    for number, line in enumerate([*lines, "---"]):
        if line.rstrip() == "---":
            inside = lines[first:number]
            if any(row.strip() and not row.lstrip().startswith("#") for row in inside):
                found.append("\n" * first + "\n".join(inside))
            first = number + 1
    return found or [text]


def _read_document(text: str) -> Pose:
    tree = read_tree(text)
    if tree.problems:
        raise PoseSyntaxError(tree.problems)
    return _from_tree(tree.value)


def _from_tree(tree: object) -> Pose:
    """The pose in a parsed JSON or YAML document: locate's, tactfix's own, or a message of ROS."""
    if not isinstance(tree, Mapping):
        raise syntax_error("contains no 'transform'", "give " + LOCATE_JSON + ", or a pose that tactfix has written")
    parts = _ros_parts(tree)
    if parts is not None:
        return _from_ros(*parts)
    if "transform" not in tree:
        raise syntax_error("contains no 'transform'", "give " + LOCATE_JSON + ", or a pose that tactfix has written")
    schema, status = tree.get("schema", POSE_SCHEMA), tree.get("status", "located")
    if schema not in (POSE_SCHEMA, LOCATE_SCHEMA):
        raise syntax_error(f"schema is {schema!r}", f"give {LOCATE_SCHEMA} or {POSE_SCHEMA}")
    if status != "located" or tree["transform"] is None:
        raise syntax_error(f"status is {status!r}: there is no pose in it", "locate the fixture first")
    covariance = tree.get("covariance")
    return Pose(
        rigid_matrix(_array(tree["transform"], "transform"), "transform"),
        _units(tree.get("units")),
        None if covariance is None else _covariance(_array(covariance, "covariance")),
        printable(str(tree.get("fixture") or "")),
    )


def _ros_parts(tree: Mapping[str, Any]) -> tuple[object, object] | None:
    """Position and orientation of a message: Transform, Pose, one of them stamped, a list of one, a hand-eye file."""
    for key, inner in (("transforms", 0), ("transform", None), ("pose", None)):
        value = tree.get(key)
        if inner is not None and isinstance(value, list) and len(value) == 1:
            value = value[0]
        if isinstance(value, Mapping):
            return _ros_parts(value)
    if isinstance(tree.get("transformation"), Mapping):  # calibration file of easy_handeye
        flat = tree["transformation"]
        return flat, {axis: flat.get(f"q{axis}") for axis in "xyzw"}
    if "translation" in tree or "rotation" in tree:
        return tree.get("translation"), tree.get("rotation")
    if "position" in tree or "orientation" in tree:
        return tree.get("position"), tree.get("orientation")
    return None


def _from_ros(position: object, orientation: object) -> Pose:
    """Position in m, orientation as quaternion x, y, z, w."""
    remedy = "write translation x y z, rotation x y z w"
    if not isinstance(position, Mapping) or not isinstance(orientation, Mapping):
        raise syntax_error("is not a TransformStamped", remedy)
    parts = [position.get(axis) for axis in "xyz"] + [orientation.get(axis) for axis in "xyzw"]
    if any(part is None for part in parts):
        raise syntax_error("is not a TransformStamped", remedy)
    numbers = _array(parts, "transform")
    if not np.isfinite(numbers).all():
        raise syntax_error("transform contains a value that is not a finite number", "write numbers")
    return Pose(_ROS.pose(numbers), "m")


def _array(values: object, name: str) -> Floats:
    """Numbers as an array; text, booleans and ragged rows are refused."""
    try:
        array = np.array(values)
    except ValueError as error:
        raise syntax_error(f"{name} has rows of different length", "write rows of equal length") from error
    if array.dtype.kind not in "if":
        raise syntax_error(f"{name} contains something that is not a number", "write numbers")
    return array.astype(np.float64)


def _covariance(matrix: Floats) -> Floats:
    """A covariance (6, 6), symmetric and positive semidefinite, or PoseSyntaxError."""
    remedy = "give the covariance of locate, rx ry rz (rad) tx ty tz (units), or none"
    if matrix.shape != (6, 6) or not np.isfinite(matrix).all():
        raise syntax_error("covariance is not 6 x 6 finite numbers", remedy)
    # Rotation and translation have different units: check the correlations, which have none.
    sigma = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    scale = np.outer(sigma, sigma)
    correlation = np.divide(matrix, scale, out=np.zeros_like(matrix), where=scale > 0)
    asymmetric = np.abs(correlation - correlation.T).max() > 1e-6
    if asymmetric or np.any(np.diag(matrix) < 0) or np.linalg.eigvalsh((correlation + correlation.T) / 2)[0] < -1e-6:
        raise syntax_error("covariance is not a covariance", remedy)
    return (matrix + matrix.T) / 2


def _write_npy(pose: Pose, remarks: tuple[str, ...]) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, pose.base_from_fixture, allow_pickle=False)
    return buffer.getvalue()


def _plain_array(data: bytes) -> object:
    """The array of a .npy file; raises the error of numpy for a damaged file, without warnings."""
    if len(data) > _MOST_BYTES:
        raise ValueError
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return np.load(io.BytesIO(data), allow_pickle=False)


def _read_npy(data: str | bytes) -> Pose:
    try:
        if isinstance(data, str):
            raise ValueError
        matrix = _plain_array(data)
    except (ValueError, TypeError, SyntaxError, TokenError, EOFError, OSError, MemoryError, OverflowError) as error:
        raise syntax_error("is not a numpy array", "save it with numpy.save") from error
    return Pose(rigid_matrix(_array(matrix, "the array"), "the array"), None)


def _write_ros(pose: Pose, remarks: tuple[str, ...]) -> str:
    x, y, z, qx, qy, qz, qw = _ROS.of(pose.base_from_fixture).tolist()
    message = {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "base"},
        "child_frame_id": "fixture",
        "transform": {"translation": {"x": x, "y": y, "z": z}, "rotation": {"x": qx, "y": qy, "z": qz, "w": qw}},
    }
    return _commented(remarks) + yaml.safe_dump(message, sort_keys=False)


PLAIN_DIALECTS: Final = (
    Dialect("matrix", "4 x 4 matrix, four lines for numpy.loadtxt", _write_rows(" "), _read_rows, has_units=False),
    Dialect("json", "JSON with units and covariance", _write_json, _read_json),
    Dialect("yaml", "YAML with units and covariance", _write_yaml, _read_yaml, comments=True),
    Dialect("csv", "4 x 4 matrix with commas, '# units' before it", _write_rows(","), _read_rows, comments=True),
    Dialect("npy", "4 x 4 numpy array", _write_npy, _read_npy, has_units=False),
    Dialect(
        "ros", "ROS TransformStamped as YAML: quaternion x, y, z, w", _write_ros, _read_yaml, "m", _ROS, comments=True
    ),
)
