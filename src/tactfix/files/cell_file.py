"""Cell files: reads YAML as a cell and its robot, or reports every problem with its line and column."""

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactfix.calibration.cell import Cell, Place, Prior
from tactfix.calibration.independence import asked_for
from tactfix.errors import FileError
from tactfix.files.fixture_file import load_fixture, placed
from tactfix.files.reading import decode, read_bytes
from tactfix.fixture import Fixture
from tactfix.fixture_format.cell import read_cell
from tactfix.fixture_format.entries import Finding
from tactfix.fixture_format.placement import check_placement, read_placement
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import homogeneous
from tactfix.geometry.surfaces import rescaled
from tactfix.kinematics.chain import Chain, Joint
from tactfix.kinematics.denavit_hartenberg import Convention, Row, chain_of_rows
from tactfix.kinematics.urdf import UrdfRobot, urdf_robot
from tactfix.kinematics.urdf_syntax import UrdfError
from tactfix.placement import Placement
from tactfix.relations.realization import realize
from tactfix.units import factor
from tactfix.values import frozen_value
from tactfix.wording import did_you_mean
from tactfix.yaml_tree import read_tree

if TYPE_CHECKING:
    from tactfix.fixture_format.cell import CellDocument
    from tactfix.pose_formats.pose import Pose


@frozen_value
class DhRobot:
    """Denavit-Hartenberg rows, lengths in the cell's units, and their chain."""

    rows: tuple[Row, ...]
    convention: Convention
    chain: Chain


@frozen_value
class CellFile:
    """A cell, and the other values of its file.

    Attributes
    ----------
    cell : Cell
        Robot, prior, fixtures and places; lengths in cell.units, angles in rad.
    robot : UrdfRobot or DhRobot
        The nominal robot, from which `write_robot` makes the calibrated one.
    tip_offset : (3,) array
        The nominal tip centre in the frame of tip_link or of the last row, in cell.units.
    sigma : float or None
        Default for touches without a sigma, in cell.units.

    Examples
    --------
    >>> tactfix.load_cell("samples/robot-calibration/cell.yaml").tip_offset.shape
    (3,)
    """

    cell: Cell
    robot: UrdfRobot | DhRobot
    tip_offset: Floats
    sigma: float | None


def load_cell(path: str | Path) -> CellFile:
    """Read a cell file (YAML): a robot, its probe, and the fixtures at its places.

    Parameters
    ----------
    path : str or Path
        The file; relative paths in it start from its directory.

    Returns
    -------
    CellFile

    Raises
    ------
    FileError
        With every problem of the file, or of the files it names.

    Notes
    -----
    Fixtures are converted to the cell's unit, angles to rad.

    Examples
    --------
    >>> tactfix.load_cell("samples/robot-calibration/cell.yaml").cell.units
    'mm'
    """
    tree = read_tree(decode(str(path), read_bytes(path)))
    document = read_cell(tree.value) if tree.is_complete else []
    if isinstance(document, list) or tree.problems:
        findings = document if isinstance(document, list) else []
        raise FileError(str(path), [*tree.problems, *(placed(finding, tree) for finding in findings)])
    folder = Path(path).parent
    offset = np.array(document.probe.tip_offset or [0.0, 0.0, 0.0])
    robot = _robot(document, folder, offset)
    try:
        cell = _cell(document, robot, _tip(robot, offset), _places(document, tree.value, folder))
    except _CellError as error:
        raise FileError(str(path), [placed(finding, tree) for finding in error.findings]) from None
    return CellFile(cell, robot, offset, document.probe.sigma)


class _CellError(Exception):
    def __init__(self, *findings: Finding) -> None:
        self.findings = findings
        super().__init__()


def _robot(document: "CellDocument", folder: Path, offset: Floats) -> UrdfRobot | DhRobot:
    robot = document.robot
    if robot.dh is not None:
        types = robot.dh.types or ["revolute"] * len(robot.dh.rows)
        rows = tuple(
            _row(numbers, type_, k) for k, (numbers, type_) in enumerate(zip(robot.dh.rows, types, strict=True))
        )
        return DhRobot(
            rows, robot.dh.convention, chain_of_rows(rows, robot.dh.convention, homogeneous(np.eye(3), offset))
        )
    assert robot.urdf is not None
    assert robot.tip_link is not None
    file = folder / robot.urdf
    # Invalid UTF-8 is preserved: the unchanged parts of the URDF are written again byte for byte.
    text = read_bytes(file).decode("utf-8", errors="surrogateescape")
    decode(str(file), read_bytes(file))
    try:
        return urdf_robot(text, robot.tip_link, robot.base_link, factor("m", document.units), offset)
    except UrdfError as error:
        raise FileError(str(file), [error.problem]) from None


def _tip(robot: UrdfRobot | DhRobot, offset: Floats) -> tuple[str, Floats]:
    """Name of the frame that carries the tip, and the nominal tip pose (4, 4) in it."""
    flange_from_tip = homogeneous(np.eye(3), offset)
    if isinstance(robot, DhRobot):
        return "flange (the frame of the last row)", flange_from_tip
    flange, flange_from_link = robot.flange
    return flange, flange_from_link @ flange_from_tip


def _row(numbers: list[float], type_: str, index: int) -> Row:
    a, d, alpha, theta, beta = (*numbers, 0.0)[:5]
    joint = None if type_ == "fixed" else Joint(f"row {index + 1}", type_ == "prismatic")
    return Row(a, d, math.radians(alpha), math.radians(theta), math.radians(beta), joint)


def _cell(
    document: "CellDocument", robot: UrdfRobot | DhRobot, tip: tuple[str, Floats], places: dict[str, Place]
) -> Cell:
    sigmas = document.prior
    prior = Prior(
        math.radians(sigmas.joint_offset or 0.0),
        sigmas.length or 0.0,
        math.radians(sigmas.angle or 0.0),
        sigmas.tip or 0.0,
    )
    unknown = ("all",) if document.unknown == "all" else tuple(document.unknown)
    names = {joint.name: f"joint_{k + 1}" for k, joint in enumerate(robot.chain.joints)}
    unknown = tuple(_canonical(name, names) for name in unknown)
    ranges = _ranges(document, robot.chain)
    cell = Cell(document.units, robot.chain, document.probe.tip_radius, unknown, prior, places, ranges, *tip)
    known = ("all", "joint_offsets", "tip", *(parameter.name for parameter in cell.parameters))
    unlisted = [name for name in unknown if name not in known]
    if unlisted:
        index = unknown.index(unlisted[0])
        remedy = did_you_mean(unlisted[0], known)
        raise _CellError(Finding(("unknown", index), f"there is no parameter {unlisted[0]!r}", remedy))
    for parameter, is_unknown in zip(cell.parameters, asked_for(cell), strict=True):
        if is_unknown and not prior.sigma(parameter):
            message = f"prior has no {parameter.kind}, which {parameter.name} needs"
            raise _CellError(
                Finding(("prior",), message, f"add {parameter.kind}: the sigma of the nominal robot's error")
            )
    return cell


def _canonical(name: str, joints: dict[str, str]) -> str:
    """The name of a parameter with the URDF name of its joint (elbow.offset) replaced by joint_k."""
    joint, dot, rest = name.rpartition(".")
    return f"{joints[joint]}.{rest}" if dot and joint in joints else name


def _ranges(document: "CellDocument", chain: Chain) -> Floats | None:
    if document.robot.joint_ranges is None:
        return None
    ranges = np.array(document.robot.joint_ranges)
    if len(ranges) != len(chain.joints) or not (ranges[:, 0] < ranges[:, 1]).all():
        message = f"joint_ranges are {len(ranges)}, the robot has {len(chain.joints)} joints"
        if len(ranges) == len(chain.joints):
            worst = int(np.flatnonzero(ranges[:, 0] >= ranges[:, 1])[0])
            message = f"range {worst + 1} of joint_ranges goes from {ranges[worst, 0]:g} to {ranges[worst, 1]:g}"
        remedy = "write [low, high] for each joint, low below high"
        raise _CellError(Finding(("robot", "joint_ranges"), message, remedy))
    turns = np.array([not joint.is_prismatic for joint in chain.joints])
    return np.asarray(np.where(turns[:, None], np.deg2rad(ranges), ranges))


def _places(document: "CellDocument", value: Any, folder: Path) -> dict[str, Place]:
    fixtures = {}
    for name, file in document.fixtures.items():
        fixture = load_fixture(folder / file)
        fixtures[name] = _in_units(_rigid(name, fixture), document.units)

    def pose_files(file: str) -> "Pose":
        from tactfix.files.pose_file import load_pose

        return load_pose(folder.absolute() / file)

    places = {}
    entries = value["places"]
    for name, entry in document.places.items():
        if isinstance(entry, str):
            places[name] = Place(name, fixtures[entry], _own_placement(document, name, entry, fixtures))
            continue
        placement = _own_placement(document, name, entry.fixture, fixtures) if entry.place is None else None
        if entry.placement is not None:
            placement = _placement(entries[name]["placement"], name, document.units, pose_files)
        of, of_from_place = None, None
        if entry.place is not None:
            of = str(entry.place["of"])
            pose = {key: item for key, item in entries[name]["place"].items() if key != "of"}
            of_from_place = _placement({"near": pose}, name, document.units, pose_files, "place").near
        places[name] = Place(name, fixtures[entry.fixture], placement, of, of_from_place)
    return places


def _rigid(name: str, fixture: Fixture) -> Fixture:
    """The fixture with placed features: unchanged, or from exact relations if they determine a single shape."""
    if fixture.is_placed:
        return fixture
    shapes = () if any(relation.sigma for relation in fixture.relations) else realize(fixture)
    if len(shapes) == 1:
        features = {key: replace(feature, surface=shapes[0][key]) for key, feature in fixture.features.items()}
        return replace(fixture, features=features, relations=(), frame=None)
    why = f"fit {len(shapes)} shapes" if shapes else "have a sigma, or allow several shapes"
    message = f"fixture {name!r} has relations between its features that {why}"
    raise _CellError(
        Finding(("fixtures", name), message, "write its features by geometry: plane: point and normal, ...")
    )


def _own_placement(document: "CellDocument", name: str, fixture: str, fixtures: dict[str, Fixture]) -> Placement | None:
    """The placement in the fixture's own file; an error if the fixture is used at several places."""
    placement = fixtures[fixture].placement
    users = [entry if isinstance(entry, str) else entry.fixture for entry in document.places.values()]
    entry = document.places[name]
    if placement is None or (not isinstance(entry, str) and entry.placement is not None):
        return None
    if users.count(fixture) > 1:
        message = (
            f"the file of fixture {fixture!r} has a placement, and the fixture is at {users.count(fixture)} places"
        )
        raise _CellError(Finding(("places", name), message, "give each of these places a placement of its own"))
    return placement


def _placement(entry: Any, name: str, units: str, pose_files: Any, key: str = "placement.near") -> Placement:
    found = list(check_placement(entry)) or read_placement(entry, units, pose_files)
    if isinstance(found, list):
        raise _CellError(
            *(Finding(("places", name), item.message.replace("placement.near", key), item.remedy) for item in found)
        )
    return found


def _in_units(fixture: Fixture, units: str) -> Fixture:
    """The fixture with the lengths that a calibration uses converted to units."""
    if fixture.units == units:
        return fixture
    unit = factor(units, fixture.units)
    features = {}
    for name, feature in fixture.features.items():
        assert feature.surface is not None
        surface = rescaled(feature.surface, np.zeros(3), unit)
        features[name] = replace(feature, sigma=feature.sigma / unit, surface=surface)
    known = None if fixture.placement is None else _placement_times(fixture.placement, 1 / unit)
    return replace(fixture, units=units, features=features, placement=known)


def _placement_times(placement: Placement, ratio: float) -> Placement:
    """A placement with its lengths multiplied by ratio."""
    near = placement.near.copy()
    near[:3, 3] *= ratio
    within, covariance = placement.within, placement.covariance
    if covariance is not None:
        units = np.array([1.0] * 3 + [ratio] * 3)
        covariance = covariance * np.outer(units, units)
    limits = None if within is None else (within[0] * ratio, within[1])
    return Placement(near, limits, covariance, placement.free)
