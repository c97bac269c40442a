"""Problems with a known answer: a rigid fixture, a true pose, and contacts computed on the moved surfaces.

Lengths are mm; fixtures are 40 to 250 mm wide, the pose is up to two metres from the origin of base. Nothing here is
shared with the package: rotations come from QR of normal numbers, contacts from angles on each surface.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tests.validation.kinds import feature_list

Tidy = Literal["even", "symmetric", "axis-parallel"]
TIDY: tuple[Tidy, ...] = ("even", "symmetric", "axis-parallel")
LAYOUTS = ("loose", *TIDY, "mixed", "far")
FAR = 1e4


@dataclass(frozen=True)
class Feature:
    """A feature in the fixture frame: point on the plane, centre, or point of the axis; normal or axis, unit (3,)."""

    type: str
    point: np.ndarray
    direction: np.ndarray
    radius: float
    side: str


@dataclass(frozen=True)
class PoseProblem:
    """Six contacts (6, 3) of tip centres in base; rho (6,) their distance from plane, centre or axis; the true pose."""

    kind: str
    features: tuple[Feature, ...]
    feature_of_contact: np.ndarray
    points: np.ndarray
    rho: np.ndarray
    tip_radius: float
    base_from_fixture: np.ndarray


def random_problem(kind: str, rng: np.random.Generator, tidy: Tidy | None = None, bores: bool = False) -> PoseProblem:
    """A problem of the kind that leaves no motion free at its true pose; tidy as people lay out contacts by hand.

    even: square fixtures, contacts evenly spaced on circles, any pose. symmetric: a fixture with mirror planes and
    contacts in mirrored pairs, any pose. axis-parallel: all on the axes of base, the pose a quarter-turn one.
    bores: some spheres and cylinders of a tidy fixture are touched from inside; of a loose one they always are.
    """
    for _ in range(1000):
        problem = _draw(kind, rng, tidy, bores)
        if stiffness(problem, problem.base_from_fixture) > 1e-3:
            return problem
    raise ValueError(f"no {tidy or 'random'} layout found that locates a fixture of kind {kind!r}")


def problem_number(kind: str, layout: str, seed: int, number: int) -> PoseProblem:
    """One problem of a numbered series, which can so be made alone.

    layout: loose, a tidy one, mixed (a tidy one with bosses and bores) or far (loose, 10 m from the origin of base and
    of the fixture). Raises ValueError as random_problem does.
    """
    rng = np.random.default_rng([seed, number, *kind.encode(), 0, *layout.encode()])
    if layout == "mixed":
        return random_problem(kind, rng, TIDY[rng.integers(len(TIDY))], bores=True)
    if layout == "far":
        return _far_away(random_problem(kind, rng), rng)
    return random_problem(kind, rng, next((tidy for tidy in TIDY if tidy == layout), None))


def touched_again(problem: PoseProblem, more: int, rng: np.random.Generator) -> PoseProblem:
    """The problem with some more contacts, on any of its features and anywhere on them."""
    chosen = rng.integers(len(problem.features), size=more)
    rho_of_feature = {int(f): float(r) for f, r in zip(problem.feature_of_contact, problem.rho, strict=True)}
    rho = np.array([rho_of_feature[int(f)] for f in chosen])
    added = [_contacts(problem.features[f], r, 1, rng, None)[0] for f, r in zip(chosen, rho, strict=True)]
    pose = problem.base_from_fixture
    points = np.array(added).reshape(-1, 3) @ pose[:3, :3].T + pose[:3, 3]
    return replace(
        problem,
        feature_of_contact=np.concatenate([problem.feature_of_contact, chosen]),
        points=np.concatenate([problem.points, points]),
        rho=np.concatenate([problem.rho, rho]),
    )


def random_direction(rng: np.random.Generator) -> np.ndarray:
    direction = rng.normal(size=3)
    return direction / np.linalg.norm(direction)


def _far_away(problem: PoseProblem, rng: np.random.Generator) -> PoseProblem:
    """The same problem with both origins moved away, FAR in every coordinate."""
    in_base, in_fixture = FAR * rng.choice([-1.0, 1.0], 3), FAR * rng.choice([-1.0, 1.0], 3)
    pose = problem.base_from_fixture.copy()
    pose[:3, 3] += in_base - pose[:3, :3] @ in_fixture
    features = tuple(replace(f, point=f.point + in_fixture) for f in problem.features)
    return replace(problem, features=features, points=problem.points + in_base, base_from_fixture=pose)


def _draw(kind: str, rng: np.random.Generator, tidy: Tidy | None, bores: bool) -> PoseProblem:
    types, counts = feature_list(kind)
    place = _loose_features if tidy is None else _square_features
    tip = float(rng.choice([0.0, 1.5]))
    features = place(types, rng, symmetric=tidy == "symmetric")
    if bores:
        features = tuple(f if f.type == "plane" or rng.integers(2) else replace(f, side="inner") for f in features)
    rho = np.array([f.radius + (tip if f.side == "outer" else -tip) for f in features])
    on_features = np.concatenate(
        [_contacts(f, float(r), n, rng, tidy) for f, r, n in zip(features, rho, counts, strict=True)]
    )
    pose = _quarter_turn_pose(rng) if tidy == "axis-parallel" else _random_pose(rng)
    index = np.repeat(np.arange(len(types)), counts)
    points = on_features @ pose[:3, :3].T + pose[:3, 3]
    return PoseProblem(kind, features, index, points, rho[index], tip, pose)


def oracle_features(problem: PoseProblem) -> list[tuple[str, np.ndarray] | tuple[str, np.ndarray, np.ndarray]]:
    """The features as pose_oracle.all_real_poses takes them."""
    return [(f.type, f.point) if f.type == "sphere" else (f.type, f.point, f.direction) for f in problem.features]


def stiffness(problem: PoseProblem, pose: np.ndarray) -> float:
    """Smallest over largest singular value of the contact Jacobian at a pose, lengths by the contacts' spread."""
    body = (problem.points - pose[:3, 3]) @ pose[:3, :3]
    normals = np.array([_normal(problem.features[f], x) for f, x in zip(problem.feature_of_contact, body, strict=True)])
    arm = body - body.mean(axis=0)
    arm /= np.sqrt((arm**2).sum(axis=1).mean())
    values = np.linalg.svd(np.hstack([normals, np.cross(arm, normals)]), compute_uv=False)
    return float(values[-1] / values[0])


def misfit(problem: PoseProblem, pose: np.ndarray) -> float:
    """Largest distance of a contact from its offset surface at a pose."""
    return float(np.abs(distances(problem, pose)[0]).max())


def settled(problem: PoseProblem, pose: np.ndarray, steps: int = 30) -> np.ndarray:
    """Where plain Newton steps on the six distances, shortened to a tenth of a turn, lead from a pose."""
    unit = np.sqrt(problem.points.var(axis=0).sum())
    for _ in range(steps):
        off, normals, body = distances(problem, pose)
        # y = R^T (x - t), R -> R exp([w]), t -> t + R v: dy = y cross w - v. The fixture's origin may be far away.
        center = body.mean(axis=0)
        jacobian = np.hstack([np.cross(normals, body - center), -normals * unit])
        step = np.linalg.lstsq(jacobian, -off, rcond=1e-12)[0]
        step *= min(1.0, 0.6 / max(np.abs(step).max(), 1e-300))
        turn, shift = _rotation_by(step[:3]), unit * step[3:]
        moved = pose.copy()
        moved[:3, :3] = pose[:3, :3] @ turn
        moved[:3, 3] = pose[:3, 3] + pose[:3, :3] @ (center + shift - turn @ center)
        pose = moved
        if np.abs(step).max() < 1e-14:
            break
    return pose


def _rotation_by(w: np.ndarray) -> np.ndarray:
    """The rotation by about the rotation vector w: Cayley's map."""
    skew = 0.5 * np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    return np.asarray(np.linalg.solve(np.eye(3) - skew, np.eye(3) + skew))


def distances(problem: PoseProblem, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How far (n,) the contacts are off their offset surfaces, gradients and contacts (n, 3) in the fixture frame."""
    body = (problem.points - pose[:3, 3]) @ pose[:3, :3]
    touched = [problem.features[f] for f in problem.feature_of_contact]
    normals = np.array([_normal(f, x) for f, x in zip(touched, body, strict=True)])
    off = np.sum(normals * (body - [f.point for f in touched]), axis=1) - problem.rho
    return off, normals, body


def _normal(feature: Feature, x: np.ndarray) -> np.ndarray:
    if feature.type == "plane":
        return feature.direction
    arm = x - feature.point
    if feature.type == "cylinder":
        arm = arm - (arm @ feature.direction) * feature.direction
    return arm / np.linalg.norm(arm)


def _random_rotation(rng: np.random.Generator) -> np.ndarray:
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def _random_pose(rng: np.random.Generator) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = _random_rotation(rng), rng.uniform(-1000, 1000, 3)
    return pose


def _quarter_turn_pose(rng: np.random.Generator) -> np.ndarray:
    pose = np.eye(4)
    signed = np.eye(3)[rng.permutation(3)] * rng.choice([-1.0, 1.0], 3)
    pose[:3, :3] = signed * np.array([1.0, 1.0, np.linalg.det(signed)])
    pose[:3, 3] = 50.0 * rng.integers(-20, 21, 3)
    return pose


def _loose_features(types: tuple[str, ...], rng: np.random.Generator, symmetric: bool) -> tuple[Feature, ...]:
    """Features anywhere in a box of 200 mm, in any direction; the fixture's own frame may be far away."""
    del symmetric
    offset = rng.uniform(-500, 500, 3) * rng.integers(2)
    return tuple(
        Feature(
            t,
            offset + rng.uniform(-100, 100, 3),
            _random_rotation(rng)[0],
            0.0 if t == "plane" else float(rng.uniform(6, 40)),
            "outer" if t == "plane" else str(rng.choice(["outer", "inner"])),
        )
        for t in types
    )


def _square_features(types: tuple[str, ...], rng: np.random.Generator, symmetric: bool) -> tuple[Feature, ...]:
    """Features as drawn on graph paper, along x, y or z, or a cylinder in multiples of 15 degrees from them.

    symmetric: every second feature of a type is the mirror image, in x = 0, of the one before it.
    """
    size = 10.0 * rng.integers(2, 12)
    axes = np.eye(3)[rng.permutation(3)]
    features: list[Feature] = []
    for i, t in enumerate(types):
        paired = symmetric and i > 0 and types[i - 1] == t and i % 2 == 1
        if paired:
            last = features[-1]
            mirrored = last.direction if t == "plane" else last.direction * [-1.0, 1.0, 1.0]
            direction = axes[i % 3] if abs(mirrored @ last.direction) > 0.99 else mirrored
            features.append(Feature(t, last.point * [-1.0, 1.0, 1.0], direction, last.radius, last.side))
            continue
        point = size * rng.integers(-2, 3, 3) / 2.0
        direction = axes[i % 3]
        if t == "cylinder" and rng.integers(2):
            angle = np.pi / 12 * rng.integers(0, 12)
            direction = np.cos(angle) * axes[i % 3] + np.sin(angle) * axes[(i + 1) % 3]
        radius = 0.0 if t == "plane" else float(rng.choice([6.35, 10.0, 12.7, 20.0, 25.4]))
        features.append(Feature(t, point, direction, radius, "outer"))
    return tuple(features)


def _contacts(feature: Feature, rho: float, n: int, rng: np.random.Generator, tidy: Tidy | None) -> np.ndarray:
    """n points (n, 3) of the offset surface, in the fixture frame."""
    frame = _frame(feature.direction, rng if tidy is None else None)
    local = _loose_local if tidy is None else _tidy_local
    return feature.point + local(feature.type, rho, n, rng, tidy) @ frame


def _frame(direction: np.ndarray, rng: np.random.Generator | None) -> np.ndarray:
    """Rows x, y, z with z along the direction; x, y along the coordinate axes where they can be, or at random."""
    helper = np.eye(3)[np.argmin(np.abs(direction))] if rng is None else rng.normal(size=3)
    x = np.cross(direction, helper)
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(direction, x), direction])


def _loose_local(kind: str, rho: float, n: int, rng: np.random.Generator, tidy: Tidy | None) -> np.ndarray:
    """Random points around the feature's own z axis: a plate of 160 mm, a whole ball, a length of four radii."""
    del tidy
    if kind == "plane":
        return np.column_stack([rng.uniform(-80, 80, (n, 2)), np.full(n, rho)])
    angle = rng.uniform(0, 2 * np.pi, n)
    if kind == "cylinder":
        return np.column_stack([rho * np.cos(angle), rho * np.sin(angle), rng.uniform(-2, 2, n) * max(rho, 15.0)])
    z = rng.uniform(-1, 1, n)
    return rho * np.column_stack([np.sqrt(1 - z**2) * np.cos(angle), np.sqrt(1 - z**2) * np.sin(angle), z])


def _tidy_local(kind: str, rho: float, n: int, rng: np.random.Generator, tidy: Tidy | None) -> np.ndarray:
    """Points people would choose: evenly around, in mirrored pairs, or on the axes."""
    if kind == "plane":
        grid = 10.0 * np.array([[x, y] for x in range(-4, 5) for y in range(-4, 5)])
        spots = rng.choice(grid, n, replace=False)
        if tidy == "symmetric" and n >= 2:
            across = rng.permutation([-1.0, 1.0])
            spots[0] = np.where(spots[0] == 0, 10.0, spots[0])
            spots[1] = spots[0] * across
        return np.column_stack([spots, np.full(n, rho)])
    angle = _tidy_angles(n, rng, tidy)
    if kind == "cylinder":
        half = 5.0 * rng.integers(1, 6)
        heights = np.where(np.arange(n) % 2 == 0, -half, half) if rng.integers(2) else np.linspace(-half, half, n)
        return np.column_stack([rho * np.cos(angle), rho * np.sin(angle), heights if n > 1 else np.zeros(1)])
    if tidy == "axis-parallel":
        poles = np.vstack([np.eye(3), -np.eye(3)])
        return rho * poles[rng.choice(6, n, replace=False)]
    latitude = np.pi / 12 * rng.integers(0, 5)
    ring = [np.cos(latitude) * np.cos(angle), np.cos(latitude) * np.sin(angle), np.full(n, np.sin(latitude))]
    return rho * np.column_stack(ring)


def _tidy_angles(n: int, rng: np.random.Generator, tidy: Tidy | None) -> np.ndarray:
    if tidy == "axis-parallel":
        return np.pi / 2 * rng.choice(4, n, replace=False)
    start = np.pi / 12 * rng.integers(24)
    if tidy == "even":
        return start + 2 * np.pi / n * np.arange(n)
    pairs = np.pi / 12 * rng.integers(1, 12, n)
    return np.where(np.arange(n) % 2 == 0, pairs, -np.roll(pairs, 1))
