"""Fixtures, poses and touches with a known true pose.

Of the package only its input types are used (Fixture, Contacts, surfaces): rotations come from scipy's Rotation,
places of touches from angles and heights computed here, and noise is one normal number along the surface normal of
each touch.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

from tactfix.contacts import Contacts
from tactfix.feature import Feature
from tactfix.fixture import AxisRule, Fixture, FrameRecipe, OriginRule, Probe, Relation, TouchBox
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface

INF = float("inf")


@dataclass(frozen=True)
class Patch:
    """One surface in the fixture frame, as the generator describes it.

    kind: plane, sphere or cylinder; at: point or centre; along: outward normal or axis; length: half length of the
    touched part of a cylinder, half width of that of a plane; up: touches of a sphere have height above up * radius
    along z (-1: all around).
    """

    kind: str
    at: Sequence[float]
    along: Sequence[float] = (0.0, 0.0, 1.0)
    radius: float = 0.0
    side: str = "outer"
    length: float = 10.0
    up: float = -1.0
    middle: float = 0.0

    def surface(self, scale: float = 1.0) -> Surface:
        at = np.asarray(self.at, float) * scale
        if self.kind == "plane":
            return Plane(at, self.along)
        if self.kind == "sphere":
            return Sphere(at, self.radius * scale, self.side)
        return Cylinder(at, self.along, self.radius * scale, self.side)

    def clears(self, point: np.ndarray, approach: np.ndarray) -> bool:
        """Whether the approach line to a point does not intersect this ball or unbounded bar."""
        if self.kind == "plane" or self.side == "inner":
            return True
        arm, step = point - np.asarray(self.at, float), -approach
        if self.kind == "cylinder":
            along = np.asarray(self.along, float) / np.linalg.norm(self.along)
            arm, step = arm - (arm @ along) * along, step - (step @ along) * along
        far = max(0.0, -(arm @ step) / max(step @ step, 1e-12))
        return bool(np.linalg.norm(arm + far * step) > self.radius)

    def touch(self, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """A random point of the surface and the outward normal there."""
        along = np.asarray(self.along, float) / np.linalg.norm(self.along)
        u = np.linalg.svd(along[None])[2][1]
        v = np.cross(along, u)
        angle = rng.uniform(0, 2 * np.pi)
        at, sign = np.asarray(self.at, float), 1.0 if self.side == "outer" else -1.0
        if self.kind == "plane":
            a, b = rng.uniform(-self.length, self.length, 2)
            return at + a * u + b * v, along
        if self.kind == "sphere":
            z = rng.uniform(self.up, 1.0)
            out = np.array([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z])
        else:
            out = np.cos(angle) * u + np.sin(angle) * v
            at = at + (self.middle + rng.uniform(-self.length, self.length)) * along
        return at + self.radius * out, sign * out


@dataclass(frozen=True)
class Truth:
    """The true pose, and touches (points on the surfaces and outward normals, in base)."""

    pose: np.ndarray
    names: tuple[str, ...]
    points: np.ndarray
    normals: np.ndarray
    approaches: np.ndarray
    sigma: float
    tip: float
    feature_sigmas: Mapping[str, float] = field(default_factory=dict)

    def repeated(self, times: int) -> "Truth":
        """The same touches, each repeated this number of times."""
        many = {n: np.repeat(getattr(self, n), times, axis=0) for n in ("points", "normals", "approaches")}
        return replace(self, names=tuple(np.repeat(self.names, times)), **many)

    def contacts(self, rng: np.random.Generator | None = None, **changes) -> Contacts:
        """Contacts as the probe reports them: tip centres, with noise along the normal if rng is given."""
        off = np.full(len(self.names), self.tip)
        if rng is not None:
            own = np.array([self.feature_sigmas.get(n, 0.0) for n in self.names])
            off = off + np.sqrt(self.sigma**2 + own**2) * rng.standard_normal(len(self.names))
        fields = {
            "features": self.names,
            "points": self.points + off[:, None] * self.normals,
            "approaches": self.approaches,
            "sigmas": np.full(len(self.names), self.sigma),
            "tip_radius": self.tip,
            "rows": tuple(range(1, len(self.names) + 1)),
            "ids": (None,) * len(self.names),
        }
        return Contacts(**{**fields, **changes})


def rotation(rng: np.random.Generator) -> np.ndarray:
    return Rotation.random(random_state=rng).as_matrix()


def pose_of(turn: np.ndarray, shift: Sequence[float]) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, shift
    return pose


def random_pose(rng: np.random.Generator, reach: float = 500.0) -> np.ndarray:
    return pose_of(rotation(rng), rng.uniform(-reach, reach, 3))


def tilted(normals: np.ndarray, rng: np.random.Generator, degrees: float) -> np.ndarray:
    """Approaches into the material, tilted from the normals by up to this number of degrees."""
    turns = Rotation.from_rotvec(np.radians(rng.uniform(0, degrees, (len(normals), 1))) * _across(normals, rng))
    return -turns.apply(normals)


def _across(normals: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    other = np.cross(normals, rng.normal(size=normals.shape))
    return other / np.linalg.norm(other, axis=1, keepdims=True)


def touch_all(
    patches: Mapping[str, Patch],
    counts: Mapping[str, int],
    rng: np.random.Generator,
    *,
    pose: np.ndarray | None = None,
    sigma: float = 1e-3,
    tip: float = 0.0,
    cone: float = 15.0,
    scale: float = 1.0,
    feature_sigmas: Mapping[str, float] | None = None,
) -> Truth:
    """Random touches, counts[name] on each feature, that a probe can reach on a straight line from far away.

    All lengths of patches, sigma and tip are multiplied by scale.
    """
    pose = random_pose(rng) if pose is None else np.array(pose, float)
    pose[:3, 3] *= scale
    names = tuple(name for name, n in counts.items() for _ in range(n))
    drawn = [_reachable_touch(patches, name, rng, cone, tip) for name in names]
    points, normals, approaches = (np.array(part).reshape(-1, 3) for part in zip(*drawn, strict=True))
    turn = pose[:3, :3]
    own = {n: s * scale for n, s in (feature_sigmas or {}).items()}
    return Truth(
        pose,
        names,
        scale * points @ turn.T + pose[:3, 3],
        normals @ turn.T,
        approaches @ turn.T,
        sigma * scale,
        tip * scale,
        own,
    )


def _reachable_touch(patches, name, rng, cone, tip):
    """A point, outward normal and approach on one feature that does not intersect the others."""
    for _ in range(1000):
        point, normal = patches[name].touch(rng)
        approach = tilted(normal[None], rng, cone)[0] if cone else -normal
        others = (patch for other, patch in patches.items() if other != name)
        if all(patch.clears(point + tip * normal, approach) for patch in others):
            return point, normal, approach
    raise AssertionError(f"{name} cannot be reached")


def box(x=(-INF, INF), y=(-INF, INF), z=(-INF, INF), scale: float = 1.0) -> TouchBox:
    return TouchBox(scale * np.array([x[0], y[0], z[0]]), scale * np.array([x[1], y[1], z[1]]))


def feature(name: str, patch: Patch, scale: float = 1.0, sigma: float = 0.0, place: bool = True) -> Feature:
    radius = None if patch.kind == "plane" else patch.radius * scale
    return Feature(name, patch.kind, radius, patch.side, sigma * scale, patch.surface(scale) if place else None)


def placed(patches: Mapping[str, Patch], touch=None, *, scale=1.0, units="mm", sigmas=None, approach=None) -> Fixture:
    """A rigid fixture by geometry."""
    features = {n: feature(n, p, scale, (sigmas or {}).get(n, 0.0)) for n, p in patches.items()}
    return Fixture("placed", units, Probe(None, None, approach), features, (), None, touch or {})


def related(patches, relations, recipe, touch=None, *, scale=1.0, units="mm", sigmas=None) -> Fixture:
    """A fixture by relations: the same features without places, with relations and a frame recipe."""
    features = {n: feature(n, p, scale, (sigmas or {}).get(n, 0.0), place=False) for n, p in patches.items()}
    return Fixture("related", units, Probe(), features, tuple(relations), recipe, touch or {})


def distance(one: str, other: str, value: float, sigma: float = 0.0) -> Relation:
    return Relation("distance", (one, other), value, sigma)


def angle(one: str, other: str, degrees: float, sigma_degrees: float = 0.0) -> Relation:
    return Relation("angle", (one, other), float(np.radians(degrees)), float(np.radians(sigma_degrees)))


def recipe(origin: tuple, first: tuple, second: tuple) -> FrameRecipe:
    """origin: (kind, *features); first and second: (axis, kind, *features), kind with a leading '-' for opposite."""

    def rule(axis, kind, *names):
        return axis, AxisRule(kind.lstrip("-"), names, kind.startswith("-"))

    return FrameRecipe(OriginRule(origin[0], origin[1:]), rule(*first), rule(*second))


def pose_error(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """(d_rot, d_t) of the contract: R_true = exp([d_rot]) R, t_true = t + d_t."""
    turn = Rotation.from_matrix(true[:3, :3] @ found[:3, :3].T).as_rotvec()
    return np.concatenate([turn, true[:3, 3] - found[:3, 3]])


def angle_off(found: np.ndarray, true: np.ndarray) -> float:
    return float(np.linalg.norm(pose_error(found, true)[:3]))


# Fixtures that several tests use. ---------------------------------------------------------------------------

CYLINDER_SPHERE = {
    "bar": Patch("cylinder", (0, 0, 0), (0, 1, 0), 1.0, length=1.75, middle=2.25),
    "ball": Patch("sphere", (3, 0, 0), radius=1.0),
}
CYLINDER_SPHERE_RECIPE = recipe(("foot_of", "ball", "bar"), ("y", "along", "bar"), ("x", "from_to", "bar", "ball"))
CYLINDER_SPHERE_TOUCH = {"bar": box(y=(0.2, 6.0))}

PLATE = {
    "plate": Patch("plane", (0, 0, 0), (0, 0, 1), length=150.0),
    "pin": Patch("cylinder", (0, 0, 0), (0, 0, 1), 10.0, length=20.0, middle=26.0),
    "ball": Patch("sphere", (300.0, 180.0, 60.0), radius=19.05, up=-0.4),
}
CORNER = {
    "right": Patch("plane", (0, -50, -50), (1, 0, 0), length=45.0),
    "back": Patch("plane", (-50, 0, -50), (0, 1, 0), length=45.0),
    "top": Patch("plane", (-50, -50, 0), (0, 0, 1), length=45.0),
}
BALLS = {
    "a": Patch("sphere", (0, 0, 0), radius=12.7, up=-0.6),
    "b": Patch("sphere", (180, 0, 0), radius=12.7, up=-0.6),
    "c": Patch("sphere", (50, 140, 0), radius=12.7, up=-0.6),
}


def ball_distances(sigma: float = 0.0) -> list[Relation]:
    at = {n: np.array(p.at, float) for n, p in BALLS.items()}
    pairs = [("a", "b"), ("a", "c"), ("b", "c")]
    return [distance(m, n, float(np.linalg.norm(at[m] - at[n])), sigma) for m, n in pairs]


BALLS_RECIPE = recipe(("center_of", "a"), ("x", "from_to", "a", "b"), ("y", "from_to", "a", "c"))
