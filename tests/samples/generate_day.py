"""Generate samples/calibration-day/: the logs of a day on which a plate drifts and one touch is wrong.

Run as a script to rewrite the files. As in generate.py nothing uses tactfix.
"""

import random
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tests.samples.generate import SAMPLES, Scene, Vector, scenes

HOURS = (6, 8, 10, 12, 14, 16)
CREEP = np.array([0.02, 0.0, 0.0])
"""The drift of the plate in base, mm an hour, from the first log on."""
SIGMA = 0.08
CHIP_HOUR, CHIP_ROW, CHIP = 12, 9, 0.9
"""Hour, row (from 1) and thickness (mm) of a touch on a chip."""
TOUCHES_OF_ONE_PLACE = 30


def plate() -> Scene:
    """The plate of the robot cell at its pose in the other samples."""
    return next(scene for scene in scenes() if scene.name == "robot-cell-plate")


def log_of(hour: int) -> str:
    """The tip centres at this hour as poses of a Universal Robots controller: metres and rotation vector."""
    scene, numbers = plate(), random.Random(hour)
    rotation, start = scene.base_from_fixture[:3, :3], scene.base_from_fixture[:3, 3]
    centers: list[Vector] = []
    for row, touch in enumerate(scene.touches, 1):
        off = scene.tip_radius + SIGMA * numbers.gauss(0.0, 1.0)
        off += CHIP if (hour, row) == (CHIP_HOUR, CHIP_ROW) else 0.0
        centers.append(rotation @ (touch.point + off * touch.normal) + start + (hour - HOURS[0]) * CREEP)
    return "".join(f"touch_{n}={_pose(center)}\n" for n, center in enumerate(centers, 1))


def _pose(center: Sequence[float] | Vector) -> str:
    x, y, z = (float(value) / 1000 for value in center)
    return f"p[{x:.6f}, {y:.6f}, {z:.6f}, 0.0, 3.141593, 0.0]"


def probe_file() -> str:
    """Repeated touches of one place of the plate."""
    numbers = random.Random(1)
    x, y, z = (float(value) for value in plate().base_from_fixture[:3, 3] + [60.0, 40.0, 3.0])
    head = ("# one place of the plate, touched over and over before the shift", "# units: mm", "# tip_radius: 3")
    rows = (f"plate,{x:.3f},{y:.3f},{z + SIGMA * numbers.gauss(0, 1):.3f},0,0,-1" for _ in range(TOUCHES_OF_ONE_PLACE))
    return "\n".join([*head, f"# sigma: {SIGMA}", "feature,x,y,z,ax,ay,az", *rows]) + "\n"


def day_files() -> dict[Path, str]:
    """Every file of the day, by its path below samples/."""
    folder = Path("calibration-day")
    logs = {folder / f"{hour:02}-00.txt": log_of(hour) for hour in HOURS}
    return {folder / "probe.csv": probe_file(), **logs}


if __name__ == "__main__":
    for path, text in day_files().items():
        (SAMPLES / path).parent.mkdir(parents=True, exist_ok=True)
        (SAMPLES / path).write_text(text, encoding="utf-8")
