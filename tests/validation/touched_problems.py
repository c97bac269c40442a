"""Problems of pose_problems with more contacts, noise and approaches, and as fixture files.

No code is shared with the package: normals, noise and obstacles are computed here.
"""

from dataclasses import dataclass, replace

import numpy as np

from tests.validation.pose_problems import (
    Feature,
    PoseProblem,
    distances,
    problem_number,
    random_direction,
    touched_again,
)

MOST_TILT = np.radians(45.0)
# Length of an approach if something blocks it farther out.
NEAR_START = 1.0


@dataclass(frozen=True)
class Touched:
    """A problem as reported: noisy tip centres (problem.points), approaches (n, 3); approach_distance None: any."""

    problem: PoseProblem
    sigma: float
    approaches: np.ndarray
    approach_distance: float | None

    @property
    def names(self) -> list[str]:
        return [f"f{i}" for i in self.problem.feature_of_contact]

    def fixture_yaml(self) -> str:
        lines = ["tactfix: 1", "name: made-up", "units: mm"]
        if self.approach_distance is not None:
            lines.append(f"probe: {{approach_distance: {self.approach_distance}}}")
        lines.append("features:")
        lines += [f"  f{i}: {{{_entry(f)}}}" for i, f in enumerate(self.problem.features)]
        return "\n".join(lines) + "\n"

    def contacts_csv(self) -> str:
        heads = ["# units: mm", f"# tip_radius: {self.problem.tip_radius}", f"# sigma: {_number(self.sigma)}"]
        rows = zip(self.names, self.problem.points, self.approaches, strict=True)
        lines = [",".join([name, *map(_number, [*x, *a])]) for name, x, a in rows]
        return "\n".join([*heads, "feature,x,y,z,ax,ay,az", *lines]) + "\n"


def _number(value: float) -> str:
    """A number with all digits, without exponent."""
    return np.format_float_positional(value, unique=True, trim="0")


def _vector(v: np.ndarray) -> str:
    return "[" + ", ".join(map(_number, v)) + "]"


def _entry(f: Feature) -> str:
    if f.type == "plane":
        return f"type: plane, point: {_vector(f.point)}, normal: {_vector(f.direction)}"
    size = f"radius: {_number(f.radius)}, side: {f.side}"
    if f.type == "sphere":
        return f"type: sphere, {size}, center: {_vector(f.point)}"
    return f"type: cylinder, {size}, point: {_vector(f.point)}, direction: {_vector(f.direction)}"


def touched_number(kind: str, more: int, layout: str, seed: int, number: int) -> Touched:
    """One problem of a numbered series: six contacts of the kind, and additional random ones; sigma 1 to 100 um.

    Raises ValueError if in no layout of the kind a probe can reach the contacts.
    """
    rng = np.random.default_rng([seed, number, more, *kind.encode(), 0, *layout.encode()])
    for _ in range(200):
        exact = touched_again(problem_number(kind, layout, int(rng.integers(2**31)), number), more, rng)
        outward = _outward_normals(exact)
        approaches = -_tilted(outward, rng)
        if not _is_clear(exact, approaches, NEAR_START):
            continue
        start = None if _is_clear(exact, approaches, np.inf) else NEAR_START
        sigma = float(10 ** rng.uniform(-3, -1))
        noise = sigma * rng.standard_normal(len(outward))
        return Touched(replace(exact, points=exact.points + noise[:, None] * outward), sigma, approaches, start)
    raise ValueError(f"no layout of kind {kind!r} that a probe can reach")


def _outward_normals(problem: PoseProblem) -> np.ndarray:
    """Normals out of the material (n, 3), in base, at the true pose."""
    gradients = distances(problem, problem.base_from_fixture)[1]
    signs = [-1.0 if problem.features[f].side == "inner" else 1.0 for f in problem.feature_of_contact]
    return np.array(signs)[:, None] * gradients @ problem.base_from_fixture[:3, :3].T


def _tilted(normals: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The normals, each tilted by a random angle up to MOST_TILT."""
    across = np.cross(normals, [random_direction(rng) for _ in normals])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    angle = rng.uniform(0, MOST_TILT, (len(normals), 1))
    return np.cos(angle) * normals + np.sin(angle) * across


def _is_clear(problem: PoseProblem, approaches: np.ndarray, length: float) -> bool:
    """Whether each approach of this length keeps clear of all other balls and bars, at the true pose."""
    pose = problem.base_from_fixture
    body, steps = (problem.points - pose[:3, 3]) @ pose[:3, :3], -approaches @ pose[:3, :3]
    return all(
        _passes(other, x, step, length)
        for x, step, own in zip(body, steps, problem.feature_of_contact, strict=True)
        for number, other in enumerate(problem.features)
        if number != own and other.type != "plane" and other.side == "outer"
    )


def _passes(feature: Feature, x: np.ndarray, step: np.ndarray, length: float) -> bool:
    """Whether the segment from x by length * step stays outside the feature with a small clearance."""
    arm = x - feature.point
    if feature.type == "cylinder":
        arm = arm - (arm @ feature.direction) * feature.direction
        step = step - (step @ feature.direction) * feature.direction
    gone = min(max(0.0, -(arm @ step) / max(step @ step, 1e-12)), length)
    return bool(np.linalg.norm(arm + gone * step) > feature.radius + 2.0)
