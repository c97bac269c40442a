"""The placement in a fixture file: its rules, and its pose, in any pose format."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

from tactfix.errors import FileError, UsageError
from tactfix.fixture_format.entries import Entry, Finding, Path
from tactfix.geometry.arrays import Floats
from tactfix.placement import Placement
from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.pose import Pose, PoseSyntaxError, rigid_matrix
from tactfix.settings import LOCATE_JSON
from tactfix.wording import did_you_mean

PoseFiles: TypeAlias = Callable[[str], Pose]
"""Reads the pose file that a fixture file names; raises FileError."""


class _PoseError(Exception):
    """The pose cannot be read; findings say why."""

    def __init__(self, findings: list[Finding]) -> None:
        self.findings = findings
        super().__init__()


def check_placement(entry: Entry) -> Iterator[Finding]:
    """Findings about the placement; read_placement then reads its poses."""
    (name,) = entry["near"]
    if name not in ("file", *DIALECTS):
        remedy = did_you_mean(name, ("file", *DIALECTS))
        yield Finding(("placement", "near", name), f"there is no pose format {name!r}", remedy, at_key=True)
    elif isinstance(entry["near"][name], list) and name != "matrix":
        remedy = "write {matrix: [[...], ...]} for four rows of four numbers, or the pose as text"
        yield Finding(("placement", "near", name), f"placement.near.{name} is a list", remedy)
    if entry.get("within") is not None and entry.get("sigma") is not None:
        message = "placement has within and sigma"
        yield Finding(
            ("placement", "sigma"), message, "keep within for limits, or sigma for a measurement", at_key=True
        )
    free = entry.get("free") or []
    for index, component in enumerate(free):
        if component in free[:index]:
            yield Finding(("placement", "free", index), f"{component} is given twice", "name each component once")


def read_placement(entry: Entry, units: str, pose_files: PoseFiles) -> Placement | list[Finding]:
    """The placement of an entry without findings of check_placement; lengths in units."""
    try:
        near = _near(entry["near"], units, pose_files)
        sigma = None if entry.get("sigma") is None else _sigma(entry["sigma"], units, pose_files)
    except _PoseError as error:
        return error.findings
    within = entry.get("within")
    limits = None if within is None else (float(within["translation"]), math.radians(within["rotation"]))
    try:
        return Placement(near, limits, sigma, frozenset(entry["free"]) if entry.get("free") else None)
    except UsageError as error:  # a covariance without variance in some direction
        message, _, remedy = str(error).partition("; ")
        return [Finding(("placement", "sigma"), message, remedy)]


def _near(near: Entry, units: str, pose_files: PoseFiles) -> Floats:
    ((name, value),) = near.items()
    path: Path = ("placement", "near", name)
    pose = _of_file(path, value, pose_files) if name == "file" else _of_text(path, name, value)
    return pose.base_from_fixture if pose.units is None else pose.in_units(units).base_from_fixture


def _of_text(path: Path, name: str, value: Any) -> Pose:
    try:
        return Pose(rigid_matrix(value), None) if isinstance(value, list) else DIALECTS[name].read(value)
    except PoseSyntaxError as error:
        findings = [Finding(path, f"placement.near: {problem.what}", problem.remedy) for problem in error.problems]
        raise _PoseError(findings) from None


def _of_file(path: Path, value: str, pose_files: PoseFiles) -> Pose:
    try:
        return pose_files(value)
    except FileError as error:
        raise _PoseError([Finding(path, f"{value}: {p.what}", p.remedy) for p in error.problems]) from None


def _sigma(sigma: Entry, units: str, pose_files: PoseFiles) -> tuple[float, float] | Floats:
    """Sigmas of near: of translation (units) and rotation (rad) per component, or the covariance (6, 6)."""
    if "file" not in sigma:
        return float(sigma["translation"]), math.radians(sigma["rotation"])
    path: Path = ("placement", "sigma", "file")
    pose = _of_file(path, sigma["file"], pose_files)
    if pose.covariance is None:
        message = f"{sigma['file']} has no covariance"
        raise _PoseError([Finding(path, message, "name " + LOCATE_JSON + ", or write translation and rotation")])
    covariance = pose.covariance if pose.units is None else pose.in_units(units).covariance
    assert covariance is not None
    return covariance
