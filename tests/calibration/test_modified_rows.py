"""A robot by modified Denavit-Hartenberg rows, from its cell file to the rows written, against Craig's own matrices."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from tactfix.cli.app import run
from tactfix.geometry.arrays import Floats
from tests.calibration.test_calibrate import off

ROWS = np.array(
    [
        [0.0, 160.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 90.0, 90.0, 0.0],
        [425.0, 0.0, 0.0, 0.0, 0.0],
        [392.0, 133.0, 0.0, 90.0, 0.0],
        [0.0, 100.0, 90.0, 0.0, 0.0],
        [0.0, 100.0, -90.0, 0.0, 0.0],
    ]
)
"""a, d (mm), alpha, theta, beta (deg): three parallel axes, and a wrist."""
TIP = np.array([40.0, 0.0, 120.0])
SEATS = {"a": (0.0, 0.0, 0.0), "b": (60.0, 0.0, 0.0), "c": (0.0, 80.0, 20.0)}
PLACES = {
    "front": ((500, 0, 150), (0, 0, 0.3)),
    "left": ((100, 450, 300), (0.3, 0, 1.2)),
    "high": ((400, -300, 600), (0, 0.6, -0.5)),
}
NOISE = 0.03


def tips(rows: Floats, tip: Floats, joints: Floats) -> Floats:
    """The tip (n, 3) at joints (n, 6) in deg: Craig's eq. 3.6, and Hayati's rotation about y."""
    frame = np.eye(4)
    for (a, d, alpha, theta, beta), q in zip(rows, joints.T, strict=True):
        before = np.eye(4)
        before[:3, :3] = Rotation.from_euler("XY", [alpha, beta], degrees=True).as_matrix()
        before[:3, 3] = [a, 0, 0]
        after = np.zeros((len(joints), 4, 4))
        after[:, :3, :3] = Rotation.from_rotvec(np.outer(theta + q, [0, 0, 1]), degrees=True).as_matrix()
        after[:, 2:, 3] = [d, 1]
        frame = frame @ before @ after
    return frame[:, :3, :3] @ tip + frame[:, :3, 3]


def reached(rows: Floats, tip: Floats, target: Floats, rng: np.random.Generator) -> Floats:
    """Joints (6,) in deg that put the tip on target (3,), by Newton's method."""
    while True:
        q = rng.uniform(-100, 100, 6)
        for _ in range(30):
            here, *displaced = tips(rows, tip, np.vstack([q, q + 1e-5 * np.eye(6)]))
            if np.abs(here - target).max() < 1e-8:
                return (q + 180) % 360 - 180
            change = np.linalg.lstsq((np.array(displaced).T - here[:, None]) / 1e-5, target - here, rcond=None)[0]
            q = q + change * min(1.0, 30 / np.abs(change).max())


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Floats, Floats]:
    """A folder with a cell and touches of a robot with errors, its true rows, and its true tip."""
    folder, rng = tmp_path_factory.mktemp("modified"), np.random.default_rng(4)
    sizes = np.array([0.4, 0.4, 0.15, 0.2, 0.15]) * np.ones((6, 1))
    sizes[np.abs(np.sin(np.deg2rad(ROWS[:, 2]))) > 0.1, 4] = 0.0
    rows, tip = ROWS + rng.normal(size=(6, 5)) * sizes, TIP + rng.normal(size=3) * 2
    lines = ["# joints: deg", "place,feature,q1,q2,q3,q4,q5,q6"]
    for place, (origin, turns) in PLACES.items():
        for seat, point in SEATS.items():
            middle = np.array(origin) + Rotation.from_euler("xyz", turns).apply(point)
            for _ in range(5):
                joints = reached(rows, tip, middle + rng.normal(size=3) * NOISE, rng)
                lines.append(",".join([place, seat, *(repr(float(q)) for q in joints)]))
    (folder / "touches.csv").write_text("\n".join(lines) + "\n")
    seats = "".join(f"  {seat}: {{type: point, point: {list(point)}}}\n" for seat, point in SEATS.items())
    (folder / "seats.yaml").write_text(f"tactfix: 1\nname: seats\nunits: mm\nfeatures:\n{seats}")
    (folder / "cell.yaml").write_text(f"""tactfix_cell: 1
units: mm
robot: {{dh: {{convention: modified, rows: {ROWS[:, :4].tolist()}}}}}
probe: {{tip_radius: 5.0, sigma: {NOISE}, tip_offset: {TIP.tolist()}}}
unknown: all
prior: {{joint_offset: 0.3, length: 0.6, angle: 0.3, tip: 5.0}}
fixtures: {{seats: seats.yaml}}
places: {{front: seats, left: seats, high: seats}}
""")
    return folder, rows, tip


def test_the_rows_written_are_those_of_the_robot(
    simulated: tuple[Path, Floats, Floats], capsys: pytest.CaptureFixture[str]
) -> None:
    folder, rows, tip = simulated
    out = folder / "robot.yaml"
    assert run(["calibrate", str(folder / "cell.yaml"), str(folder / "touches.csv"), "--json", "-o", str(out)]) == 0
    report = json.loads(capsys.readouterr().out)
    written = yaml.safe_load(out.read_text())
    assert written["convention"] == "modified"
    found = np.array([(*row, 0.0) if len(row) == 4 else row for row in written["rows"]])
    joints = np.random.default_rng(1).uniform(-100, 100, (200, 6))
    true_tips = tips(rows, tip, joints)
    nominal, calibrated = tips(ROWS, TIP, joints), tips(found, np.array(written["tip_offset"]), joints)
    assert off(nominal, true_tips) > 2
    assert off(calibrated, true_tips) < 3 * report["prediction"]["after"] < 0.5
    # A parameter that is not correlated with others, such as the angle of the wrist, agrees with the true robot's.
    alpha = next(item for item in report["parameters"] if item["name"] == "joint_6.alpha")
    assert alpha["identified"]
    assert abs(alpha["value"] - (rows - ROWS)[5, 2]) < 4 * alpha["sigma"] < 0.4
