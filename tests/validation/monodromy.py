"""All roots of one generated problem of a kind, from a single root, by monodromy: tracking roots along closed loops.

A random complex pose and random complex features are chosen first, and then contacts that fit them: this gives one
root. A loop along a triangle of random problems permutes the roots of the first problem. The pairs (problem, root) form
an irreducible variety (for each pose the contacts vary over irreducible surfaces), so loops reach every root from any
one. A stored set is called complete if several successive loops have added nothing and its size agrees with the known
count, if there is one.

Writes the files in data/:  python -m tests.validation.monodromy [kind ...]
"""

import itertools
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tests.validation.kinds import KINDS, feature_list
from tests.validation.path_tracking import Steps, track
from tests.validation.study_forms import (
    CYLINDER,
    PLANE,
    ContactSystem,
    Problem,
    conjugate,
    quaternion_product,
)

DATA = Path(__file__).parent / "data"
# Real directions to which the directions of a problem are rotated: perpendicular to each other as far as possible.
COMPASS = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0], [1, 1, 1], [-1, 1, 1], [1, -1, 1]], dtype=float)
COMPASS /= np.linalg.norm(COMPASS, axis=1, keepdims=True)
# A path that jumps to another still ends at a root, so large steps are acceptable.


@dataclass(frozen=True)
class Start:
    """A solved problem of one kind: all its complex roots (k, 8), and the number of last loops that added nothing."""

    problem: Problem
    roots: np.ndarray
    idle_loops: int


def _complex_normal(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return (rng.normal(size=shape) + 1j * rng.normal(size=shape)) / np.sqrt(2)


def _random_features(kind: str, rng: np.random.Generator) -> tuple[tuple[str, ...], tuple[int, ...], tuple]:
    """Types, feature of each contact, and place, direction, w of random complex features.

    Directions are complex but near fixed real ones: a cylinder with s . s near zero is degenerate, and this keeps the
    straight line between any two problems away from such directions.
    """
    types, counts = feature_list(kind)
    f = len(types)
    feature_of_contact = tuple(int(i) for i in np.repeat(np.arange(f), counts))
    directions = COMPASS[:f] + 0.25 * _complex_normal(rng, f, 3)
    return types, feature_of_contact, (_complex_normal(rng, f, 3), directions, 0.6 + 0.3 * _complex_normal(rng, f))


def random_complex_problem(kind: str, rng: np.random.Generator) -> Problem:
    """A random problem in general position; its roots are not known."""
    types, feature_of_contact, (place, direction, w) = _random_features(kind, rng)
    return Problem(types, feature_of_contact, place, direction, w, _complex_normal(rng, 6, 3))


def problem_with_root(kind: str, rng: np.random.Generator) -> tuple[Problem, np.ndarray]:
    """A random complex problem and one of its roots (8,): the pose is drawn first, the contacts fit it."""
    types, feature_of_contact, (place, direction, w) = _random_features(kind, rng)
    on_features = np.array([_point_on(types[f], place[f], direction[f], w[f], rng) for f in feature_of_contact])
    q, t = _complex_normal(rng, 4), _complex_normal(rng, 3)
    norm = q @ q
    vectors = np.hstack([np.zeros((6, 1)), on_features])
    turned = quaternion_product(quaternion_product(q, vectors), conjugate(q))[:, 1:] / norm
    # t = 2 u q* / N and q* q = N give u = t q / 2.
    u = 0.5 * quaternion_product(np.concatenate([[0.0], t]), q)
    root = np.concatenate([q, u])
    return Problem(types, feature_of_contact, place, direction, w, turned + t), root / np.linalg.norm(root)


def _point_on(kind: str, p: np.ndarray, s: np.ndarray, w: complex, rng: np.random.Generator) -> np.ndarray:
    """A random complex point on a complex feature: a plane through p square to s, a sphere, a cylinder."""
    arm = _complex_normal(rng, 3)
    if kind == PLANE:
        return p + arm - (arm @ s) / (s @ s) * s
    if kind == CYLINDER:
        along = (arm @ s) / (s @ s) * s
        arm = arm - along
        return p + along + arm * np.sqrt(w / (arm @ arm))
    return p + arm * np.sqrt(w / (arm @ arm))


def distinct(roots: np.ndarray, tolerance: float = 1e-6) -> np.ndarray:
    """The index of the first of each group of equal points (k, 8) of P7."""
    unit = roots / np.linalg.norm(roots, axis=1, keepdims=True)
    overlap = unit.conj() @ unit.T
    first, second = np.nonzero(np.triu(np.abs(overlap) > 1 - 1e-8, 1))
    # |b - (a.b) a| is accurate for equal points, where 1 - |a.b|^2 would lose half the digits.
    gap = np.linalg.norm(unit[second] - overlap[first, second][:, None] * unit[first], axis=1)
    return np.setdiff1d(np.arange(len(roots)), second[gap < tolerance])


Follow = Callable[[Problem, Problem, np.ndarray, float, float, Steps], tuple[np.ndarray, np.ndarray]]


def follow(
    start: Problem, target: Problem, roots: np.ndarray, begin: float, end: float, steps: Steps
) -> tuple[np.ndarray, np.ndarray]:
    """Follow roots (k, 8) in numpy: their ends and the part of the path completed. compiled_paths.track is faster."""
    return track(ContactSystem(start, target), roots, begin, end, steps)


def solve_by_monodromy(
    kind: str, rng: np.random.Generator, idle: int = 8, most: int = 60, follow: Follow = follow
) -> Start:
    """All roots of a random problem of the kind: loops until idle successive ones have added nothing."""
    home, root = problem_with_root(kind, rng)
    roots, quiet = root[None, :], 0
    for _ in range(most):
        corners = [home, random_complex_problem(kind, rng), random_complex_problem(kind, rng), home]
        moved = roots
        for here, there in itertools.pairwise(corners):
            moved, part = follow(here, there, moved, 0.0, 1.0, Steps(prediction=1e-3))
            moved = moved[part == 1]
        united = np.concatenate([roots, moved])
        united = united[distinct(united)]
        quiet = quiet + 1 if len(united) == len(roots) else 0
        roots = united
        if quiet == idle:
            break
    return Start(home, roots, quiet)


def save(kind: str, start: Start) -> None:
    p = start.problem
    np.savez_compressed(
        DATA / f"{kind}.npz",
        place=p.place,
        direction=p.direction,
        squared_radius=p.squared_radius,
        contacts=p.contacts,
        roots=start.roots,
        idle_loops=start.idle_loops,
    )


def load(kind: str) -> Start:
    """The stored solved problem of the kind. Raises FileNotFoundError if there is none."""
    types, counts = feature_list(kind)
    with np.load(DATA / f"{kind}.npz") as stored:
        numbers = [stored[name] for name in ("place", "direction", "squared_radius", "contacts")]
        feature_of_contact = tuple(int(i) for i in np.repeat(np.arange(len(types)), counts))
        return Start(Problem(types, feature_of_contact, *numbers), stored["roots"], int(stored["idle_loops"]))


def main(kinds: list[str]) -> None:
    for kind in kinds or list(KINDS):
        start = solve_by_monodromy(kind, np.random.default_rng(20240611))
        print(f"{kind:40s} {len(start.roots):4d} roots, last {start.idle_loops} loops added none", flush=True)
        save(kind, start)


if __name__ == "__main__":
    main(sys.argv[1:])
