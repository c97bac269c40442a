"""The calibrated robot as text: the corrected URDF, or Denavit-Hartenberg rows as YAML."""

from pathlib import Path

import numpy as np

from tactfix.calibration.result import Calibration
from tactfix.errors import UsageError
from tactfix.files.cell_file import CellFile
from tactfix.kinematics.denavit_hartenberg import corrected_rows
from tactfix.kinematics.urdf import UrdfRobot, corrected_urdf


def write_robot(cell: CellFile, result: Calibration) -> str:
    """Write the calibrated robot as `tactfix calibrate` prints it.

    Parameters
    ----------
    cell : CellFile
        What was calibrated.
    result : Calibration
        What `calibrate` found of it.

    Returns
    -------
    str
        The corrected URDF, or Denavit-Hartenberg rows as YAML.

    Raises
    ------
    UsageError
        Nothing has checked the robot, that is, status is not "calibrated".

    Notes
    -----
    Of a URDF only the origins change; the sigmas stand in comments.

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
        lines.append(f"  - [{', '.join(repr(float(number)) for number in numbers)}]")
    types = ["fixed" if row.joint is None else "prismatic" if row.joint.is_prismatic else "revolute" for row in rows]
    if set(types) != {"revolute"}:
        lines.append(f"types: [{', '.join(types)}]")
    lines.append(f"tip_offset: [{', '.join(repr(float(value)) for value in offset)}]")
    return "\n".join(lines) + "\n"


def check_output(file: CellFile, output: Path | None) -> None:
    """UsageError where the ending of output is not that of the robot's format."""
    wanted = (".urdf", ".xml") if isinstance(file.robot, UrdfRobot) else (".yaml", ".yml")
    if output is not None and output.suffix.lower() not in (*wanted, ".json", ".html"):
        raise UsageError(f"{output}: this robot is written as {wanted[0]}; or name a .json or .html file")


def _notes(result: Calibration) -> list[str]:
    head = [f"calibrated by tactfix; shrinkage {result.shrinkage:g}", "parameter, error of the nominal robot, sigma"]
    return head + [
        f"{item.name} {item.value:.6g} {item.sigma:.2g} {item.unit}" for item in result.parameters if item.sigma > 0
    ]
