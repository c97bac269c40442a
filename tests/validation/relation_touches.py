"""Touches of a part, its true frame and its two fixture files, without code of the package."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from tests.validation.relation_geometry import Part, Thing

COUNTS = {"plane": 5, "cylinder": 7, "sphere": 5}
APPROACH = 8.0
"""Degrees off the normal, at most, from which touches are approached."""


@dataclass(frozen=True)
class Touched:
    """The part's own frame in base (4, 4), the true pose of the fixture frame, and one touch in a row, all in base."""

    base_from_part: np.ndarray
    base_from_fixture: np.ndarray
    names: tuple[str, ...]
    points: np.ndarray
    normals: np.ndarray
    approaches: np.ndarray

    def csv(self, sigma: float, noise: np.ndarray | None) -> str:
        """The contact file; noise (n,): standard normal numbers, None for nominal contacts."""
        off = 0.0 if noise is None else sigma * noise[:, None] * self.normals
        lines = ["# units: mm", f"# sigma: {sigma}", "# tip_radius: 0", "feature,x,y,z,ax,ay,az"]
        for name, point, approach in zip(self.names, self.points + off, self.approaches, strict=True):
            lines.append(",".join([name, *(f"{v:.12g}" for v in (*point, *approach))]))
        return "\n".join(lines) + "\n"


def touches(part: Part, base_from_part: np.ndarray, rng: np.random.Generator, nominal: bool) -> Touched:
    """Touches distributed over the part's features: random, or regular along the part's axes."""
    turn, shift = base_from_part[:3, :3], base_from_part[:3, 3]
    names, points, normals = [], [], []
    for name, thing in part.things.items():
        for number in range(COUNTS[thing.kind]):
            point, normal = _touch(thing, number, rng, nominal)
            names.append(name)
            points.append(turn @ point + shift)
            normals.append(turn @ normal)
    points, normals = np.array(points), np.array(normals)
    across = np.cross(normals, rng.normal(size=normals.shape))
    across /= np.linalg.norm(across, axis=1)[:, None]
    angle = 0.0 if nominal else np.radians(rng.uniform(0, APPROACH, (len(normals), 1)))
    approaches = -Rotation.from_rotvec(angle * across).apply(normals)
    pose = base_from_part @ frame_of(part)
    return Touched(base_from_part, pose, tuple(names), points, normals, approaches)


def _touch(thing: Thing, number: int, rng: np.random.Generator, nominal: bool) -> tuple[np.ndarray, np.ndarray]:
    u = np.linalg.svd(thing.along[None])[2][1]
    v = np.cross(thing.along, u)
    inward = -1.0 if thing.side == "inner" else 1.0
    if thing.kind == "plane":
        a, b = CORNERS[number] if nominal else rng.uniform(-1, 1, 2)
        return thing.at + thing.half * (a * u + b * v), thing.along
    turn = number * 2 * np.pi / COUNTS[thing.kind] if nominal else rng.uniform(0, 2 * np.pi)
    out = np.cos(turn) * u + np.sin(turn) * v
    if thing.kind == "cylinder":
        height = (number % 2) * 2 - 1 if nominal else rng.uniform(-1, 1)
        return thing.at + thing.half * height * thing.along + thing.radius * out, inward * out
    rise = (number % 3) * 0.4 - 0.4 if nominal else rng.uniform(-0.8, 0.8)
    out = np.sqrt(1 - rise**2) * out + rise * thing.along
    return thing.at + thing.radius * out, inward * out


CORNERS = [(-1, -1), (1, -1), (1, 1), (-1, 1), (0, 0.5)]


def frame_of(part: Part) -> np.ndarray:
    """part_from_fixture (4, 4): the frame recipe applied to the features of the part."""
    letters = [key for key in part.frame if key != "origin"]
    first = _axis(part.frame[letters[0]], part.things)
    second = _axis(part.frame[letters[1]], part.things)
    second = second - (second @ first) * first
    axes = {letters[0]: first, letters[1]: second / np.linalg.norm(second)}
    for third, (one, other) in {"x": "yz", "y": "zx", "z": "xy"}.items():
        if third not in axes:
            axes[third] = np.cross(axes[one], axes[other])
    frame = np.eye(4)
    frame[:3, :3] = np.column_stack([axes["x"], axes["y"], axes["z"]])
    frame[:3, 3] = _origin(part.frame["origin"], part.things)
    return frame


def _axis(rule, things: Mapping[str, Thing]) -> np.ndarray:
    if "opposite" in rule:
        return -_axis(rule["opposite"], things)
    if "along" in rule:
        return things[rule["along"]].along
    near, far = _feet(things[rule["from"]], things[rule["to"]])
    return (far - near) / np.linalg.norm(far - near)


def _origin(rule, things: Mapping[str, Thing]) -> np.ndarray:
    if "center_of" in rule:
        return things[rule["center_of"]].at
    if "foot_of" in rule:
        return _feet(things[rule["foot_of"]], things[rule["on"]])[1]
    met = [things[name] for name in rule["meet_of"]]
    if len(met) == 3:
        normals = np.array([thing.along for thing in met])
        return np.linalg.solve(normals, [thing.at @ thing.along for thing in met])
    axis, face = met
    return axis.at + ((face.at - axis.at) @ face.along) / (axis.along @ face.along) * axis.along


def _feet(one: Thing, other: Thing) -> tuple[np.ndarray, np.ndarray]:
    """The points of two features that are nearest to each other, by least squares over the positions on their axes."""
    kinds = (one.kind, other.kind)
    if "plane" in kinds:
        if kinds == ("plane", "sphere"):
            return other.at - ((other.at - one.at) @ one.along) * one.along, other.at
        return one.at, one.at - ((one.at - other.at) @ other.along) * other.along
    free = [(thing.along if thing.kind == "cylinder" else np.zeros(3)) for thing in (one, other)]
    parallel = np.linalg.norm(np.cross(*free)) < 0.02 and "sphere" not in kinds
    columns = np.column_stack([0 * free[0] if parallel else free[0], -free[1]])
    heights = np.linalg.lstsq(columns, other.at - one.at, rcond=None)[0]
    return one.at + heights[0] * free[0], other.at + heights[1] * free[1]


def by_relations(part: Part) -> str:
    """The fixture file that gives distances and angles."""
    file = _head(part)
    for kind, one, other, value, sigma in part.relations:
        file.setdefault(f"{kind}s", []).append({"between": [one, other], "value": value, "sigma": sigma})
    file["frame"] = {key: dict(rule) for key, rule in part.frame.items()}
    return yaml.safe_dump(file, sort_keys=False)


def by_geometry(part: Part) -> str:
    """The fixture file that gives places, in the frame of the recipe."""
    file, inverse = _head(part), np.linalg.inv(frame_of(part))
    for name, thing in part.things.items():
        at = (inverse @ [*thing.at, 1.0])[:3].tolist()
        along = (inverse[:3, :3] @ thing.along).tolist()
        place = {"sphere": {"center": at}, "plane": {"point": at, "normal": along}}
        file["features"][name].update(place.get(thing.kind, {"point": at, "direction": along}))
    return yaml.safe_dump(file, sort_keys=False)


def _head(part: Part) -> dict:
    features = {}
    for name, thing in part.things.items():
        features[name] = {"type": thing.kind}
        if thing.kind != "plane":
            features[name] |= {"radius": thing.radius, "side": thing.side}
    head = {"tactfix": 1, "name": "part", "units": "mm", "probe": {"approach_distance": 2.0}, "features": features}
    return head | ({"touch": {n: dict(b) for n, b in part.touch.items()}} if part.touch else {})
