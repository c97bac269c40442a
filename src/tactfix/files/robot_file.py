"""The calibrated robot as text: the corrected URDF, or Denavit-Hartenberg rows as YAML."""

from pathlib import Path
from textwrap import wrap
from typing import Final

import numpy as np

from tactfix.calibration.independence import asked_for
from tactfix.calibration.result import Calibration
from tactfix.errors import UsageError
from tactfix.files.cell_file import CellFile
from tactfix.kinematics.denavit_hartenberg import corrected_rows
from tactfix.kinematics.urdf import UrdfRobot, corrected_urdf

_ROW_WIDTH: Final = 78
"""Line width of the YAML rows, in characters: no number is split."""


def write_robot(cell: CellFile, result: Calibration) -> str:
    """Write the calibrated robot as `tactfix calibrate` prints it.

    Parameters
    ----------
    cell : CellFile
        The nominal robot and its probe.
    result : Calibration
        The result of `calibrate` for this cell.

    Returns
    -------
    str
        The corrected URDF, or Denavit-Hartenberg rows as YAML.

    Raises
    ------
    UsageError
        status is not "calibrated".

    Notes
    -----
    In a URDF only the origins change; the sigmas are in comments.

    Examples
    --------
    >>> cell = tactfix.load_cell("samples/robot-calibration/cell.yaml")
    >>> touches = tactfix.load_touches("samples/robot-calibration/touches.csv", cell)
    >>> text = tactfix.write_robot(cell, tactfix.calibrate(cell, touches))
    >>> text.splitlines()[-2][:14]
    '  - [0.0, 80.0'
    """
    if not result.is_written:
        raise UsageError(f"the robot is {result.status}, so it is not written: {'; '.join(result.reasons)}")
    return robot_text(cell, result)


def robot_text(file: CellFile, result: Calibration) -> str:
    """The robot with the parameters of a calibration, and their sigmas as comments."""
    notes = _notes(result)
    if isinstance(file.robot, UrdfRobot):
        return corrected_urdf(file.robot, result.values[:-1], notes)
    rows = corrected_rows(file.robot.rows, file.robot.convention, file.robot.chain, result.values[:-1])
    offset = file.tip_offset + result.values[-4:-1]
    lines = [f"# {note}" for note in notes]
    lines += [f"convention: {file.robot.convention}", "rows: # a, d, alpha_deg, theta_deg, beta_deg where not 0"]
    for row in rows:
        numbers = [row.a, row.d, *np.rad2deg([row.alpha, row.theta]).tolist()]
        numbers += [float(np.rad2deg(row.beta))] if row.beta else []
        lines += wrap(
            ", ".join(repr(float(number)) for number in numbers),
            width=_ROW_WIDTH,
            initial_indent="  - [",
            subsequent_indent="     ",
        )
        lines[-1] += "]"
    types = ["fixed" if row.joint is None else "prismatic" if row.joint.is_prismatic else "revolute" for row in rows]
    if set(types) != {"revolute"}:
        lines.append(f"types: [{', '.join(types)}]")
    lines.append(f"tip_offset: [{', '.join(repr(float(value)) for value in offset)}]")
    return "\n".join(lines) + "\n"


def check_output(file: CellFile, output: Path | None, *, is_printed: bool) -> None:
    """UsageError if the extension of output does not match the robot's format, or the format cannot hold the tip.

    is_printed: whether the robot is printed if output is None.
    """
    if isinstance(file.robot, UrdfRobot) and not file.robot.has_place_for_tip:
        names = [p.name for p, asked in zip(file.cell.parameters, asked_for(file.cell), strict=True) if asked]
        wanted_robot = is_printed if output is None else output.suffix.lower() not in (".json", ".html")
        if wanted_robot and any(name.startswith("tip.") for name in names):
            message = (
                f"tip_link {file.robot.joints[-1].child!r} moves with the last joint: the URDF has no place for the tip"
            )
            raise UsageError(f"{message}; name a link with a fixed joint as tip_link, or write the JSON")
    wanted = (".urdf", ".xml") if isinstance(file.robot, UrdfRobot) else (".yaml", ".yml")
    if output is not None and output.suffix.lower() not in (*wanted, ".json", ".html"):
        raise UsageError(f"{output}: this robot is written as {wanted[0]}; or name a .json or .html file")


def _notes(result: Calibration) -> list[str]:
    x, y, z = (repr(round(float(value), 9) + 0.0) for value in result.tip.flange_from_tip[:3, 3])
    return [
        f"calibrated by tactfix; shrinkage {result.shrinkage:g}",
        f"tip ({result.units}) in {result.tip.flange}:",
        f"{x} {y} {z}",
        "parameter, error of the nominal robot, sigma",
        *(f"{item.name} {item.value:.6g} {item.sigma:.2g} {item.unit}" for item in result.parameters if item.sigma > 0),
    ]
