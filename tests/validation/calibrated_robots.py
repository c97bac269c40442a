"""How far calibrated robots of other kinds than the tests' arm are off over their joint ranges, and what is said of it.

    python -m tests.validation.calibrated_robots [NAME ...]

Each robot is a URDF with errors drawn for every origin. It touches three seats at three places, 45 touches of 0.03 mm,
and is calibrated by the command; the URDF that this writes is held against the true one. Kinematics are those of
xml.etree and scipy, postures are found by scipy's least squares.
"""

import contextlib
import io
import json
import sys
import tempfile
import xml.etree.ElementTree as ET
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tactfix.cli.app import run

NOISE = 0.03
SEATS = {"a": (0.0, 0.0, 0.0), "b": (60.0, 0.0, 0.0), "c": (0.0, 80.0, 20.0)}
ARM_PLACES = {
    "front": ((500, 0, 150), (0, 0, 0.3)),
    "left": ((100, 450, 300), (0.3, 0, 1.2)),
    "high": ((400, -300, 600), (0, 0.6, -0.5)),
}
LEVEL_PLACES = {
    "front": ((450, 0, 150), (0, 0, 0.3)),
    "left": ((250, 350, 200), (0, 0, 1.2)),
    "right": ((300, -300, 120), (0, 0, -0.5)),
}
_RIGHT = np.pi / 2


@dataclass(frozen=True)
class Axis:
    """A joint of a URDF: origin in m and rad, axis, limits."""

    xyz: tuple[float, ...]
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    kind: str = "revolute"
    axis: tuple[float, ...] = (0.0, 0.0, 1.0)
    limits: tuple[float, float] = (-3.0, 3.0)


ROBOTS = {
    "like a UR": (
        Axis((0, 0, 0.1625)),
        Axis((0, 0, 0), (_RIGHT, 0, 0)),
        Axis((-0.425, 0, 0), limits=(-2.8, 2.8)),
        Axis((-0.3922, 0, 0.1333)),
        Axis((0, -0.0997, 0), (_RIGHT, 0, 0)),
        Axis((0, 0.0996, 0), (_RIGHT, np.pi, np.pi)),
        Axis((0.03, 0, 0.12), kind="fixed"),
    ),
    "SCARA": (
        Axis((0, 0, 0.4), limits=(-2.5, 2.5)),
        Axis((0.325, 0, 0), limits=(-2.5, 2.5)),
        Axis((0.275, 0, -0.05), kind="prismatic", axis=(0, 0, -2), limits=(0, 0.3)),
        Axis((0, 0, 0), kind="continuous", axis=(0, 0, -1)),
        Axis((0.04, 0.01, -0.1), kind="fixed"),
    ),
    "seven axes": (
        Axis((0, 0, 0.333), limits=(-2.8, 2.8)),
        Axis((0, 0, 0), (-_RIGHT, 0, 0), limits=(-1.7, 1.7)),
        Axis((0, -0.316, 0), (_RIGHT, 0, 0), limits=(-2.8, 2.8)),
        Axis((0.0825, 0, 0), (_RIGHT, 0, 0), limits=(-3, -0.1)),
        Axis((-0.0825, 0.384, 0), (-_RIGHT, 0, 0), limits=(-2.8, 2.8)),
        Axis((0, 0, 0), (_RIGHT, 0, 0), limits=(0, 3.7)),
        Axis((0.088, 0, 0), (_RIGHT, 0, 0), limits=(-2.8, 2.8)),
        Axis((0.05, 0, 0.2), (0, 0.3, 0), kind="fixed"),
    ),
}


def urdf(axes: tuple[Axis, ...]) -> str:
    """The robot as a URDF whose last link is "tip"."""
    links = [*(f"l{k}" for k in range(len(axes))), "tip"]
    lines = ["<robot name='r'>", *(f"<link name='{link}'/>" for link in links)]
    for k, axis in enumerate(axes):
        xyz, rpy, along = (" ".join(repr(float(v)) for v in values) for values in (axis.xyz, axis.rpy, axis.axis))
        more = "" if axis.kind == "fixed" else f"<axis xyz='{along}'/>"
        if axis.kind in ("revolute", "prismatic"):
            more += f"<limit upper='{axis.limits[1]}' lower='{axis.limits[0]}'/>"
        ends = f"<child link='{links[k + 1]}'/><parent link='{links[k]}'/>"
        lines.append(f"<joint name='A{k + 1}' type='{axis.kind}'>{more}<origin rpy='{rpy}' xyz='{xyz}'/>{ends}</joint>")
    return "\n".join([*lines, "</robot>\n"])


def tips(text: str, joints: Any) -> Any:
    """The tip (n, 3) in mm of a URDF made by `urdf`, its joints being in the order of the chain."""
    found = []
    parts = ET.fromstring(text).findall("joint")
    for amounts in joints:
        turn, origin, left = Rotation.identity(), np.zeros(3), iter(amounts)
        for part in parts:
            numbers = {key: [float(v) for v in value.split()] for key, value in part.find("origin").attrib.items()}  # type: ignore[union-attr]
            origin = origin + turn.apply(numbers["xyz"])
            turn = turn * Rotation.from_euler("xyz", numbers["rpy"])
            if part.get("type") == "fixed":
                continue
            along = np.array([float(v) for v in part.find("axis").get("xyz").split()])  # type: ignore[union-attr]
            along = along / np.linalg.norm(along) * next(left)
            if part.get("type") == "prismatic":
                origin = origin + turn.apply(along)
            else:
                turn = turn * Rotation.from_rotvec(along)
        found.append(1e3 * origin)
    return np.array(found)


def with_errors(axes: tuple[Axis, ...], rng: np.random.Generator) -> tuple[Axis, ...]:
    """Every origin off by 0.5 mm and 0.2 degrees along and about each axis (1 sigma), the tip by 2 mm."""
    off = []
    for axis in axes:
        size = 2e-3 if axis.kind == "fixed" else 0.5e-3
        turn = Rotation.from_euler("xyz", axis.rpy)
        if axis.kind != "fixed":
            turn = turn * Rotation.from_rotvec(rng.normal(size=3) * np.deg2rad(0.2))
        off.append(
            replace(axis, xyz=tuple(np.array(axis.xyz) + rng.normal(size=3) * size), rpy=tuple(turn.as_euler("xyz")))
        )
    return tuple(off)


def reached(text: str, target: Any, low: Any, high: Any, rng: np.random.Generator) -> Any:
    """Joints that put the tip on target (3,)."""
    while True:
        start = rng.uniform(low, high)
        found = least_squares(
            lambda q: tips(text, [q])[0] - target, start, bounds=(low, high), xtol=1e-12, ftol=1e-12, max_nfev=60
        )
        if np.abs(found.fun).max() < 1e-5:
            return found.x


def off(points: Any, true: Any) -> float:
    """The rms distance after the best rigid motion (Kabsch)."""
    a, b = points - points.mean(axis=0), true - true.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    turn = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return float(np.sqrt(((a @ turn - b) ** 2).sum(axis=1).mean()))


def study(name: str, folder: Path) -> str:
    """Make the cell of a robot, touch, calibrate, and hold the result against the truth: one line."""
    rng = np.random.default_rng(0)
    axes = ROBOTS[name]
    nominal, true = urdf(axes), urdf(with_errors(axes, rng))
    moving = [axis for axis in axes if axis.kind != "fixed"]
    low, high = np.array([axis.limits for axis in moving]).T
    units = np.array([1e3 if axis.kind == "prismatic" else np.rad2deg(1.0) for axis in moving])
    places = LEVEL_PLACES if name == "SCARA" else ARM_PLACES
    rows = ["# joints: deg", ",".join(["place", "feature", *(f"q{k + 1}" for k in range(len(moving)))])]
    for place, (origin, turns) in places.items():
        for seat, point in SEATS.items():
            middle = np.array(origin) + Rotation.from_euler("xyz", turns).apply(point)
            for _ in range(5):
                joints = reached(true, middle + rng.normal(size=3) * NOISE, low, high, rng)
                rows.append(",".join([place, seat, *(repr(float(q)) for q in joints * units)]))
    seats = "".join(f"  {seat}: {{type: point, point: {list(point)}}}\n" for seat, point in SEATS.items())
    (folder / "seats.yaml").write_text(f"tactfix: 1\nname: seats\nunits: mm\nfeatures:\n{seats}")
    (folder / "robot.urdf").write_text(nominal)
    (folder / "touches.csv").write_text("\n".join(rows) + "\n")
    (folder / "cell.yaml").write_text(f"""tactfix_cell: 1
units: mm
robot: {{urdf: robot.urdf, tip_link: tip}}
probe: {{tip_radius: 5.0, sigma: {NOISE}}}
unknown: all
prior: {{joint_offset: 0.3, length: 0.6, angle: 0.3, tip: 5.0}}
fixtures: {{seats: seats.yaml}}
places: {{{", ".join(f"{place}: seats" for place in places)}}}
""")
    printed, out = io.StringIO(), folder / "calibrated.urdf"
    with contextlib.redirect_stdout(printed):
        status = run(["calibrate", str(folder / "cell.yaml"), str(folder / "touches.csv"), "--json", "-o", str(out)])
    if status:
        return f"{name}: exit status {status}"
    report = json.loads(printed.getvalue())
    joints = rng.uniform(low, high, (150, len(moving)))
    there = tips(true, joints)
    before, after = (off(tips(text, joints), there) for text in (nominal, out.read_text()))
    return f"{name}: off {before:.2f} mm, calibrated {after:.3f} mm, predicted {report['prediction']['after']:.3f} mm"


def main() -> None:
    for name in sys.argv[1:] or ROBOTS:
        with tempfile.TemporaryDirectory() as folder:
            print(study(name, Path(folder)), flush=True)


if __name__ == "__main__":
    main()
