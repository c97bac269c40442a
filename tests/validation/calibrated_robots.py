"""Errors of calibrated robots of several kinds over their joint ranges, compared with the predicted errors.

    python -m tests.validation.calibrated_robots [NAME ...] [--draws N]

Each robot is a URDF with random errors in every origin. It touches three seats at three places, 45 touches with noise
of 0.03 mm, and is calibrated by the command; the URDF written is compared with the true one. Kinematics use xml.etree
and scipy, postures are found by Newton's method. Over many draws the rms ratio of actual to predicted error is 1 if
the sigmas are correct.
"""

import argparse
import contextlib
import io
import json
import tempfile
import xml.etree.ElementTree as ET
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
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
    "gantry": (
        Axis((0, 0, 0), kind="prismatic", axis=(1, 0, 0), limits=(0, 1)),
        Axis((0, 0, 0.1), kind="prismatic", axis=(0, 1, 0), limits=(-0.6, 0.6)),
        Axis((0, 0, 0.5), kind="prismatic", axis=(0, 0, -1), limits=(-0.5, 0.5)),
        Axis((0, 0, -0.05)),
        Axis((0, 0, -0.08), (_RIGHT, 0, 0), limits=(-1.8, 1.8)),
        Axis((0.03, -0.15, 0.02), kind="fixed"),
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


@lru_cache(maxsize=4)
def parts(text: str) -> tuple[tuple[str | None, Any, Any, Any], ...]:
    """For each joint of a URDF from `urdf`: type, origin (3,) in m, rotation (3, 3), and unit axis (3,) or None."""
    found = []
    for joint in ET.fromstring(text).findall("joint"):
        origin, axis = joint.find("origin"), joint.find("axis")
        xyz, rpy = (np.array(origin.get(key).split(), dtype=float) for key in ("xyz", "rpy"))  # type: ignore[union-attr]
        along = None if axis is None else np.array(axis.get("xyz").split(), dtype=float)  # type: ignore[union-attr]
        unit = None if along is None else along / np.linalg.norm(along)
        found.append((joint.get("type"), xyz, Rotation.from_euler("xyz", rpy).as_matrix(), unit))
    return tuple(found)


def tips(text: str, joints: Any) -> Any:
    """The tip (n, 3) in mm of a URDF from `urdf`, at joints (n, k) in the order of the chain."""
    joints = np.asarray(joints)
    turn, place = np.broadcast_to(np.eye(3), (len(joints), 3, 3)), np.zeros((len(joints), 3))
    left = iter(joints.T)
    for kind, origin, rotation, axis in parts(text):
        place, turn = place + turn @ origin, turn @ rotation
        if kind == "prismatic":
            place = place + (turn @ axis) * next(left)[:, None]
        elif kind != "fixed":
            turn = turn @ Rotation.from_rotvec(np.outer(next(left), axis)).as_matrix()
    return 1e3 * place


def with_errors(axes: tuple[Axis, ...], rng: np.random.Generator) -> tuple[Axis, ...]:
    """The robot with errors of 0.5 mm and 0.2 degrees (1 sigma) for each axis of every origin, and 2 mm at the tip."""
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
    step = 1e-6 * np.eye(len(low))
    while True:
        joints = rng.uniform(low, high)
        for _ in range(40):
            here, *displaced = tips(text, np.vstack([joints, joints + step]))
            if np.abs(here - target).max() < 1e-6:
                break
            change = np.linalg.lstsq((np.array(displaced).T - here[:, None]) / 1e-6, target - here, rcond=1e-6)[0]
            joints = joints + change * min(1.0, 0.5 / np.abs(change).max())
        else:
            continue
        if (joints >= low).all() and (joints <= high).all():
            return joints


def off(points: Any, true: Any) -> float:
    """The rms distance after the best rigid motion (Kabsch)."""
    a, b = points - points.mean(axis=0), true - true.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    turn = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return float(np.sqrt(((a @ turn - b) ** 2).sum(axis=1).mean()))


def study(name: str, folder: Path, draw: int = 0) -> tuple[float, float, float] | int:
    """Simulate touches of a robot and calibrate it: rms error before, after and predicted (mm), or the exit status."""
    rng = np.random.default_rng(draw)
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
        return status
    report = json.loads(printed.getvalue())
    joints = rng.uniform(low, high, (150, len(moving)))
    true_tips = tips(true, joints)
    before, after = (off(tips(text, joints), true_tips) for text in (nominal, out.read_text()))
    return before, after, report["prediction"]["after"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(ROBOTS))
    parser.add_argument("--draws", type=int, default=1)
    arguments = parser.parse_args()
    for name in arguments.names or ROBOTS:
        found = []
        for draw in range(arguments.draws):
            with tempfile.TemporaryDirectory() as folder:
                outcome = study(name, Path(folder), draw)
            if isinstance(outcome, int):
                print(f"{name}, draw {draw}: exit status {outcome}", flush=True)
                continue
            found.append(outcome)
            print(
                f"{name}: off {outcome[0]:.2f} mm, calibrated {outcome[1]:.3f} mm, predicted {outcome[2]:.3f} mm",
                flush=True,
            )
        ratios = np.array([after / predicted for _, after, predicted in found])
        if len(ratios) > 1:
            print(f"{name}: off by {ratios.min():.2f} to {ratios.max():.2f} times what was predicted,", end=" ")
            print(f"rms {np.sqrt((ratios**2).mean()):.2f}, {len(ratios)} robots")


if __name__ == "__main__":
    main()
