"""Generate the contact files of samples/ and their expected results. Run as a script to rewrite them.

Nothing here uses tactfix, so the files are independent reference data: the fixtures are written out again, a touch is a
point and its outward normal in closed form, and the uncertainty follows from the contacts' Jacobian. Noise comes from
Python's generator, whose numbers do not depend on library versions.
"""

import json
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.support.project import ROOT

Vector = NDArray[np.float64]

SAMPLES = ROOT / "samples"
SIGMAS_ALLOWED = 5.0
"""The accepted error of a located pose, in its sigmas in the worst direction."""


@dataclass(frozen=True)
class Touch:
    """One touch in the fixture frame: the feature, a point of its surface, and the outward normal at the point."""

    feature: str
    point: Vector
    normal: Vector


def on_plane(feature: str, normal: Sequence[float], *points: Sequence[float]) -> Iterator[Touch]:
    """Touches of a plane at the given points."""
    for point in points:
        yield Touch(feature, np.array(point, float), np.array(normal, float))


def on_ball(feature: str, center: Sequence[float], radius: float, *directions: Sequence[float]) -> Iterator[Touch]:
    """Touches of an outer sphere in the given directions from its centre."""
    for direction in directions:
        outward = np.array(direction, float) / np.linalg.norm(direction)
        yield Touch(feature, np.array(center, float) + radius * outward, outward)


def along_z(feature: str, radius: float, side: int, *places: tuple[float, float]) -> Iterator[Touch]:
    """Touches of a cylinder about the z axis at (angle in degrees, height); side is 1 for a pin, -1 for a bore."""
    for angle, height in places:
        radial = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0])
        yield Touch(feature, radius * radial + [0.0, 0.0, height], side * radial)


@dataclass(frozen=True)
class Scene:
    """A fixture with its touches, its true pose, and the form of the contact file. Lengths in mm."""

    name: str
    comment: str
    touches: tuple[Touch, ...]
    base_from_fixture: Vector
    tip_radius: float
    sigma: float
    feature_sigma: float
    seed: int
    units: str = "mm"
    normals: bool = False
    relation_sigma: float = 0.0


def pose(turns: Sequence[tuple[str, float]], translation: Sequence[float]) -> Vector:
    """base_from_fixture (4, 4) from rotations about the axes of base in degrees, applied in the given order."""
    matrix = np.eye(4)
    for axis, degrees in turns:
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
        turn = np.eye(3)
        turn[i, i] = turn[j, j] = c
        turn[i, j], turn[j, i] = -s, s
        matrix[:3, :3] = turn @ matrix[:3, :3]
    matrix[:3, 3] = translation
    return matrix


def around(first: float) -> list[tuple[float, float, float]]:
    """Three directions evenly around the z axis, the first at this angle in degrees."""
    angles = [np.radians(first + step) for step in (0, 120, 240)]
    return [(float(np.cos(a)), float(np.sin(a)), 0.1) for a in angles]


def three_balls() -> tuple[Vector, Vector, Vector]:
    """The centres of the three balls from their distances: x from the first to the second, y towards the third."""
    a, b, c = 180.013, 140.006, 210.021
    x = (a * a + b * b - c * c) / (2 * a)
    return np.zeros(3), np.array([a, 0.0, 0.0]), np.array([x, np.sqrt(b * b - x * x), 0.0])


def scenes() -> tuple[Scene, ...]:
    """One scene for each fixture except the paper's, whose contacts are printed in the paper."""
    ball_1, ball_2, ball_3 = three_balls()
    # No approach may pass through another ball.
    turns = (("ball_1", ball_1, 40), ("ball_2", ball_2, 95), ("ball_3", ball_3, 50))
    return (
        Scene(
            "three-spheres",
            "a machine tool touches each ball four times: three times around its equator, once on top",
            tuple(
                touch for name, center, turn in turns for touch in on_ball(name, center, 12.7, *around(turn), (0, 0, 1))
            ),
            pose((("x", 1.5), ("y", -0.8), ("z", 37.0)), (412.5, -168.25, 95.75)),
            tip_radius=2.0,
            sigma=0.01,
            feature_sigma=0.001,
            seed=3,
            relation_sigma=0.002,
        ),
        Scene(
            "three-planes",
            "a measuring machine touches each face three times and logs outward normals",
            (
                *on_plane("right", (1, 0, 0), (0, -15, -15), (0, -85, -20), (0, -50, -85)),
                *on_plane("back", (0, 1, 0), (-15, 0, -20), (-85, 0, -15), (-45, 0, -85)),
                *on_plane("top", (0, 0, 1), (-15, -20, 0), (-80, -15, 0), (-50, -85, 0)),
            ),
            pose((("y", 3.0), ("x", -2.0), ("z", 118.0)), (250.0, 140.5, 61.2)),
            tip_radius=1.5,
            sigma=0.05,
            feature_sigma=0.0,
            seed=9,
            normals=True,
        ),
        Scene(
            "robot-cell-plate",
            "a robot touches plate, pin and ball and reports the tip's centre in metres",
            (
                *on_plane("plate", (0, 0, 1), (-20, -20, 0), (320, -20, 0), (310, 220, 0), (-15, 215, 0)),
                *along_z("pin", 10.0, 1, (20, 12), (110, 12), (200, 12), (290, 12), (65, 40), (245, 40)),
                *on_ball(
                    "ball", (300, 180, 60), 19.05, (1, 0, 0.1), (-1, 0.1, 0), (0, 1, 0.1), (0.1, -1, 0), (0, 0, 1)
                ),
            ),
            pose((("x", 0.6), ("y", -0.4), ("z", -64.0)), (1184.2, -356.7, 412.9)),
            tip_radius=3.0,
            sigma=0.08,
            feature_sigma=0.005,
            seed=12,
            units="m",
        ),
        Scene(
            "machine-tool-ball-bar",
            "a kinematic probe touches face, bush and both balls",
            (
                *on_plane("face", (0, 0, 1), (40, -20, 0), (160, -22, 0), (45, 20, 0)),
                *along_z("bush", 15.0, -1, (0, -6), (90, -6), (180, -6), (270, -6), (45, -20), (225, -20)),
                *on_ball("ball", (200.003, 0.002, 44.998), 12.7, (1, 0, 0.1), (-0.2, 1, 0), (-0.2, -1, 0), (0, 0, 1)),
                *on_ball("small_ball", (99.996, 20.011, 35.004), 9.525, (0.6, -1, 0.2), (0.2, 1, 0.1), (0, 0, 1)),
            ),
            pose((("x", 0.05), ("y", 0.02), ("z", 91.3)), (-312.4, -205.8, -418.6)),
            tip_radius=2.0,
            sigma=0.003,
            feature_sigma=0.0005,
            seed=21,
        ),
    )


def touch_files(scene: Scene) -> dict[str, str]:
    """contacts.csv and expected.json of a scene."""
    numbers = random.Random(scene.seed)
    rotation, translation = scene.base_from_fixture[:3, :3], scene.base_from_fixture[:3, 3]
    scale, digits = (0.001, 7) if scene.units == "m" else (1.0, 4)
    rows = []
    for touch in scene.touches:
        off = scene.tip_radius + np.hypot(scene.sigma, scene.feature_sigma) * numbers.gauss(0.0, 1.0)
        center = rotation @ (touch.point + off * touch.normal) + translation
        approach = rotation @ _approach(touch, numbers)
        direction = rotation @ touch.normal if scene.normals else approach
        rows.append((touch.feature, [f"{v * scale:.{digits}f}" for v in center], [f"{v:.4f}" for v in direction]))
    head = (
        f"# {scene.name}: {scene.comment}",
        f"# units: {scene.units}",
        f"# tip_radius: {scene.tip_radius * scale:g}",
    )
    columns = "feature,x,y,z," + ("nx,ny,nz" if scene.normals else "ax,ay,az")
    lines = [*head, f"# sigma: {scene.sigma * scale:g}", columns, *(",".join([f, *p, *d]) for f, p, d in rows)]
    turn, shift = sigmas(scene)
    expected = {
        "fixture": f"fixtures/{scene.name}.yaml",
        "status": "located",
        "exit": 0,
        "units": "mm",
        "transform": scene.base_from_fixture.tolist(),
        "tolerance": {"rotation": SIGMAS_ALLOWED * turn, "translation": SIGMAS_ALLOWED * shift},
    }
    return {"contacts.csv": "\n".join(lines) + "\n", "expected.json": as_json(expected)}


def _approach(touch: Touch, numbers: random.Random) -> Vector:
    """An approach into the material, some degrees off the normal like programmed moves, never from below."""
    off = np.array([numbers.uniform(-0.08, 0.08) for _ in range(3)])
    direction = -touch.normal + off
    direction[2] = min(direction[2], 0.0)
    return np.asarray(direction / np.linalg.norm(direction))


def sigmas(scene: Scene) -> tuple[float, float]:
    """The largest sigma of rotation (rad) and of the origin (mm), with the features as one rigid body.

    A contact at x with outward normal n moves off its surface by -(n . v) - (x cross n) . w under the twist (w, v).
    The sigma of a distance is added to that of the contacts in quadrature.
    """
    rows = np.array([[*np.cross(t.point, t.normal), *t.normal] for t in scene.touches])
    sigma = float(np.sqrt(scene.sigma**2 + scene.feature_sigma**2 + scene.relation_sigma**2))
    covariance = sigma**2 * np.linalg.inv(rows.T @ rows)
    return (
        float(np.sqrt(np.linalg.eigvalsh(covariance[:3, :3])[-1])),
        float(np.sqrt(np.linalg.eigvalsh(covariance[3:, 3:])[-1])),
    )


# Section 6 of the paper as printed. The axis of the bar passes through (2, 2, 2); the touched part of the bar is on the
# positive side of Y. Approaches along the normals do not eliminate the second centre.
PAPER_POINTS = (
    ("bar", (2.927025, 2.0, 1.625)),
    ("bar", (1.775, 2.8, 1.443785)),
    ("bar", (1.372975, 2.6, 3.11662)),
    ("bar", (2.075, 3.4, 2.185405)),
    ("bar", (3.527025, 3.2, 3.10824)),
    ("ball", (5.456074, 4.6, 2.543645)),
    ("ball", (5.981074, 4.4, 3.841479)),
)
PAPER_Y = np.array([-0.3, -0.6, -0.74162])
PAPER_POINT = np.array([2.0, 2.0, 2.0])
PAPER_CENTERS = (np.array([5.681074, 3.8, 3.09986]), np.array([5.600545, 5.180286, 3.345141]))
PAPER_TOLERANCE = {"rotation": 5e-6, "translation": 5e-6}
"""Rounding of the printed digits, and its effect over three radii."""


def paper_pose(center: Vector) -> Vector:
    """The frame of fig. 6 for a centre of the ball: Y along the bar, X to the ball, origin at its foot on the axis."""
    y = PAPER_Y / np.linalg.norm(PAPER_Y)
    origin = PAPER_POINT + ((center - PAPER_POINT) @ y) * y
    x = (center - origin) / np.linalg.norm(center - origin)
    matrix = np.eye(4)
    matrix[:3] = np.column_stack([x, y, np.cross(x, y), origin])
    return matrix


def paper_approaches(kind: str) -> list[Vector]:
    """Approaches along the normals; "telling" along -y at x6, the first contact on the ball."""
    y = PAPER_Y / np.linalg.norm(PAPER_Y)
    arms = [np.array(p) - PAPER_POINT for feature, p in PAPER_POINTS if feature == "bar"]
    found = [-(arm - (arm @ y) * y) for arm in arms]
    found += [PAPER_CENTERS[0] - np.array(p) for feature, p in PAPER_POINTS if feature == "ball"]
    if kind == "telling":
        found[5] = np.array([0.0, -1.0, 0.0])
    return [v / np.linalg.norm(v) for v in found]


def paper_files() -> dict[str, str]:
    """The seven contacts of section 6 with three kinds of approaches, which give three different results."""
    kinds = (
        ("", "telling", "approached along -y at the first contact on the ball, which tells the two centres apart"),
        ("-normal", "normal", "approached along the normals, which leaves two centres of the ball"),
        ("-no-approach", None, "nothing is said of the approaches, so nothing can fall because of them"),
    )
    files = {}
    for suffix, kind, comment in kinds:
        approaches = [",".join(f"{v:.6f}" for v in a) for a in paper_approaches(kind)] if kind else [",,"] * 7
        points = [f"{feature},{x:.6f},{y:.6f},{z:.6f}" for feature, (x, y, z) in PAPER_POINTS]
        head = [f"# section 6 of the paper; {comment}", "# units: mm", "# tip_radius: 0", "# sigma: 0.000002"]
        rows = [f"{point},{approach}" for point, approach in zip(points, approaches, strict=True)]
        files[f"contacts{suffix}.csv"] = "\n".join([*head, "feature,x,y,z,ax,ay,az", *rows]) + "\n"
        expected: dict[str, object] = {"fixture": "fixtures/cylinder-sphere.yaml"}
        if kind == "telling":
            expected |= {
                "status": "located",
                "exit": 0,
                "units": "mm",
                "transform": paper_pose(PAPER_CENTERS[0]).tolist(),
            }
        else:
            poses = [paper_pose(center).tolist() for center in PAPER_CENTERS]
            expected |= {"status": "ambiguous", "exit": 5, "units": "mm", "transform": None, "poses": poses}
        files[f"expected{suffix}.json"] = as_json(expected | {"tolerance": PAPER_TOLERANCE})
    return files


def as_json(value: dict[str, object]) -> str:
    """JSON with each row of a matrix on its own line."""
    text = json.dumps(value, indent=1)
    lines: list[str] = []
    depth = 0
    for line in text.splitlines():
        if depth and line.strip()[:1] not in "[]":
            lines[-1] += line.strip() + (" " if line.endswith(",") else "")
        elif depth and line.strip() in ("]", "],"):
            lines[-1] += line.strip()
        else:
            lines.append(line)
        depth = int(line.strip() == "[" or (depth and line.strip() not in ("]", "],")))
    return "\n".join(lines) + "\n"


def all_files() -> dict[Path, str]:
    """Every generated file of samples/, by its path below samples/."""
    files = {Path("cylinder-sphere") / name: text for name, text in paper_files().items()}
    for scene in scenes():
        files |= {Path(scene.name) / name: text for name, text in touch_files(scene).items()}
    return files


if __name__ == "__main__":
    for path, text in all_files().items():
        (SAMPLES / path).parent.mkdir(parents=True, exist_ok=True)
        (SAMPLES / path).write_text(text, encoding="utf-8")
