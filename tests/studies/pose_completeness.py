"""Poses that the package misses, counted: its search for all poses against path tracking in oracles/pose_oracle.

    python -m studies.pose_completeness --kind cylinder4+sphere2 --problems 100        (from tests/)

A miss is a regular real pose of the oracle with no pose of the package next to it; near: the same where two poses are
nearly one (the contacts' Jacobian is almost singular there), which noise of the contacts would decide either way.
Extra is the reverse; it should be zero, since every pose either side reports is checked against the contacts. Problems
with suspicious paths are counted apart: there the oracle itself may lack a pose.
"""

import argparse
import time
from collections import Counter
from collections.abc import Iterator

import numpy as np
from oracles.kinds import KINDS
from oracles.pose_oracle import OracleAnswer, all_real_poses
from oracles.pose_problems import TIDY, PoseProblem, oracle_features, random_problem, stiffness

from tactfix.contacts import Contacts
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface
from tactfix.poses import all_poses

SIGMA = 1e-5  # mm: far above rounding, far below the gaps between poses.
# Largest difference of two equal poses: rotation entries, and shifts of the contacts in units of their spread.
SAME = 1e-3
NEARLY_SINGULAR = 1e-4


def poses_of_package(problem: PoseProblem) -> np.ndarray:
    """What the package finds (k, 4, 4): the only place that knows how it is called."""
    surfaces: dict[str, Surface] = {}
    for number, f in enumerate(problem.features):
        side = "outer" if f.side == "outer" else "inner"
        surfaces[f"f{number}"] = {
            "plane": lambda f=f: Plane(f.point, f.direction),
            "sphere": lambda f=f, side=side: Sphere(f.point, f.radius, side),
            "cylinder": lambda f=f, side=side: Cylinder(f.point, f.direction, f.radius, side),
        }[f.type]()
    n = len(problem.points)
    contacts = Contacts(
        features=tuple(f"f{i}" for i in problem.feature_of_contact),
        points=problem.points,
        approaches=np.full((n, 3), np.nan),
        sigmas=np.full(n, SIGMA),
        tip_radius=problem.tip_radius,
        rows=tuple(range(1, n + 1)),
        ids=(None,) * n,
    )
    return np.asarray(all_poses(surfaces, contacts, np.full(n, SIGMA)).poses)


def gap(a: np.ndarray, b: np.ndarray, problem: PoseProblem) -> float:
    """How far the contacts, taken into the fixture frame, and the axes are apart under two poses, dimensionless."""
    spread = np.sqrt(problem.points.var(axis=0).sum())
    center = problem.points.mean(axis=0)
    shift = a[:3, :3].T @ (center - a[:3, 3]) - b[:3, :3].T @ (center - b[:3, 3])
    return float(max(np.abs(a[:3, :3] - b[:3, :3]).max(), np.abs(shift).max() / spread))


def unmatched(wanted: np.ndarray, given: np.ndarray, problem: PoseProblem) -> list[np.ndarray]:
    """The wanted poses with none of the given next to them."""
    return [a for a in wanted if all(gap(a, b, problem) > SAME for b in given)]


def compare(problem: PoseProblem, counts: Counter[str]) -> tuple[float, float]:
    """Adds one problem to the counts; seconds of processor time of the oracle and of the package."""
    began = time.process_time()
    oracle: OracleAnswer = all_real_poses(
        oracle_features(problem), problem.feature_of_contact, problem.points, problem.rho
    )
    middle = time.process_time()
    found = poses_of_package(problem)
    ended = time.process_time()
    regular = oracle.poses[~oracle.multiple]
    missed = unmatched(regular, found, problem)
    extra = unmatched(found, oracle.poses, problem)
    near = sum(stiffness(problem, pose) < NEARLY_SINGULAR for pose in missed)
    counts.update(
        poses=len(regular),
        multiple=int(oracle.multiple.sum()),
        missed=len(missed) - near,
        near=near,
        with_miss=int(len(missed) > near),
        extra=len(extra),
        suspicious=int(oracle.suspicious > 0),
        diverged=oracle.diverged,
    )
    return middle - began, ended - middle


def study(kind: str, layout: str, count: int, seed: int) -> str:
    """One row of the table."""
    counts: Counter[str] = Counter()
    times = np.array([compare(problem, counts) for problem in problems(kind, layout, count, seed)])
    oracle, package = 1e3 * times.mean(axis=0)
    worst = 1e3 * times[:, 1].max()
    columns = ("poses", "multiple", "missed", "near", "with_miss", "extra", "suspicious")
    numbers = "".join(f"{counts[name]:10d}" for name in columns)
    return f"{kind:32s} {layout:14s}{count:7d}{numbers}{oracle:10.0f}{package:10.1f}{worst:10.1f}"


def problems(kind: str, layout: str, count: int, seed: int) -> Iterator[PoseProblem]:
    rng = np.random.default_rng([seed, *kind.encode(), *layout.encode()])
    for _ in range(count):
        yield random_problem(kind, rng, tidy=None if layout == "loose" else layout)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", nargs="+", choices=list(KINDS), default=list(KINDS), metavar="KIND")
    parser.add_argument("--layout", nargs="+", choices=["loose", *TIDY], default=["loose", *TIDY])
    parser.add_argument("--problems", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    heads = (
        "poses",
        "multiple",
        "missed",
        "near",
        "with miss",
        "extra",
        "suspicious",
        "oracle ms",
        "all ms",
        "worst ms",
    )
    print(f"{'kind':32s} {'layout':14s}{'count':>7s}" + "".join(f"{head:>10s}" for head in heads))
    for kind in options.kind:
        for layout in options.layout:
            try:
                print(study(kind, layout, options.problems, options.seed), flush=True)
            except ValueError as nothing:
                print(f"{kind:32s} {layout:14s}  {nothing}", flush=True)


if __name__ == "__main__":
    main()
