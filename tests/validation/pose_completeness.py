"""Counts of poses that the package misses: its search for all poses against path tracking in pose_oracle.

    pip install '.[study]'
    python -m tests.validation.pose_completeness --problems 10000 --jobs 2 --record out.jsonl
    python -m tests.validation.pose_completeness --kind cylinder4+sphere2 --layout even --replay 17

Problems are numbered: --first N continues after another run, --record stores finished blocks and does not repeat them,
--replay prints one problem with all poses of both methods. Set OMP_NUM_THREADS=1.

    poses       real poses of the oracle; multiple: multiple roots among them, which are not compared
    missed      regular poses of the oracle with no pose of the package nearby; with miss: problems with such poses
    near        the same for nearly double poses (the contacts' Jacobian is almost singular), which depend on noise
    extra       exact poses of the package that the oracle does not have: the oracle missed them
    inexact     poses of the package within sigma of every contact, with no exact one nearby: two complex poses
    lost        problems whose true pose, always a regular one, the package did not find; needs no oracle
    raised      problems in which the package raised an exception
    suspect     problems with unaccounted paths: the oracle itself may lack a pose
"""

import argparse
import time
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tests.validation.blocks import by_row, numbered, options_of_series
from tests.validation.compiled_poses import COMPILED
from tests.validation.kinds import STUDIED
from tests.validation.pose_oracle import ON_SURFACE, OracleAnswer, all_real_poses
from tests.validation.pose_problems import PoseProblem, misfit, oracle_features, problem_number, settled, stiffness
from tests.validation.poses_of_package import poses_of_package

# Largest difference of equal poses: entries of the rotation, and shifts of the contacts in units of their spread.
SAME = 1e-3
NEARLY_SINGULAR = 1e-4
COUNTED = ("poses", "multiple", "missed", "near", "with miss", "extra", "inexact", "lost", "raised", "suspect")


@dataclass
class Tally:
    """Counts, milliseconds of processor time of oracle and package for each problem, and remarks to print."""

    counts: Counter[str] = field(default_factory=Counter)
    oracle: list[float] = field(default_factory=list)
    package: list[float] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def row(self) -> str:
        numbers = "".join(f"{self.counts[head]:10d}" for head in COUNTED)
        times = f"{np.median(self.oracle):10.1f}{np.median(self.package):10.1f}{np.max(self.package):10.1f}"
        return f"{len(self.oracle):9d}{numbers}{times}"


def poses_of_oracle(problem: PoseProblem) -> OracleAnswer:
    return all_real_poses(oracle_features(problem), problem.feature_of_contact, problem.points, problem.rho, COMPILED)


def gaps(some: np.ndarray, others: np.ndarray, problem: PoseProblem) -> np.ndarray:
    """Differences (k, m) of poses: of the contacts transformed into the fixture frame, and of the axes."""
    spread = np.sqrt(problem.points.var(axis=0).sum())
    center = problem.points.mean(axis=0)
    centers = [np.einsum("kji,kj->ki", p[:, :3, :3], center - p[:, :3, 3]) for p in (some, others)]
    shifts = np.abs(centers[0][:, None] - centers[1][None]).max(axis=2) / spread
    turns = np.abs(some[:, None, :3, :3] - others[None, :, :3, :3]).max(axis=(2, 3))
    return np.asarray(np.maximum(shifts, turns))


def nearest(some: np.ndarray, others: np.ndarray, problem: PoseProblem) -> np.ndarray:
    """The difference (k,) of each pose from the nearest of the others."""
    return gaps(some, others, problem).min(axis=1, initial=np.inf)


def is_exact(problem: PoseProblem, pose: np.ndarray) -> bool:
    """Whether near this pose there is one at which every contact is exactly on its surface."""
    end = settled(problem, pose)
    spread = np.sqrt(problem.points.var(axis=0).sum())
    return bool(misfit(problem, end) < 10 * ON_SURFACE * spread and nearest(end[None], pose[None], problem) < SAME)


def examine(kind: str, layout: str, seed: int, number: int, tally: Tally) -> None:
    """Add one problem to the tally."""
    problem = problem_number(kind, layout, seed, number)
    name = f"{kind} --layout {layout} --seed {seed} --replay {number}"
    began = time.process_time()
    oracle = poses_of_oracle(problem)
    middle = time.process_time()
    try:
        found = poses_of_package(problem)
    except Exception as error:
        found = np.zeros((0, 4, 4))
        tally.counts["raised"] += 1
        tally.remarks.append(f"raised   {name}  {type(error).__name__}: {error}")
    ended = time.process_time()
    regular = oracle.poses[~oracle.multiple]
    away = nearest(regular, found, problem)
    missed = [(gap, stiffness(problem, pose)) for gap, pose in zip(away, regular, strict=True) if gap > SAME]
    near = sum(stiff < NEARLY_SINGULAR for _, stiff in missed)
    strange = found[nearest(found, oracle.poses, problem) > SAME]
    extra = sum(is_exact(problem, pose) for pose in strange)
    lost = nearest(problem.base_from_fixture[None], found, problem)[0] > SAME
    tally.counts.update(poses=len(regular), multiple=int(oracle.multiple.sum()), missed=len(missed) - near, near=near)
    tally.counts.update({"with miss": int(len(missed) > near), "extra": extra, "inexact": len(strange) - extra})
    tally.counts.update(lost=int(lost), suspect=int(oracle.suspicious > 0))
    tally.oracle.append(round(1e3 * (middle - began), 2))
    tally.package.append(round(1e3 * (ended - middle), 2))
    tally.remarks += [
        f"missed   {name}  stiffness {stiff:.1e}, next pose {gap:.1e} away, {len(missed)} of {len(regular)}"
        for gap, stiff in missed
        if stiff >= NEARLY_SINGULAR
    ]
    if lost:
        tally.remarks.append(f"lost     {name}")
    if extra:
        tally.remarks.append(f"extra    {name}  {extra}")


def block(kind: str, layout: str, seed: int, first: int, count: int) -> dict[str, Any] | str:
    """Results of some problems of one series as a dict for JSON; or why there are none."""
    try:
        poses_of_oracle(problem_number(kind, layout, seed, first))  # compiles, and reads the start
        tally = Tally()
        for number in range(first, first + count):
            examine(kind, layout, seed, number, tally)
    except ValueError as nothing:
        return str(nothing)
    return dict(vars(tally))


def run(options: argparse.Namespace) -> None:
    """Run all blocks of all rows; print remarks as they arise, and a row after its last block."""
    numbers = numbered(options.first, options.problems)
    rows = {
        (kind, layout): [(kind, layout, options.seed, *block_numbers) for block_numbers in numbers]
        for kind in options.kind
        for layout in options.layout
    }
    print(f"{'kind':32s} {'layout':14s}{'count':>9s}" + "".join(f"{head:>10s}" for head in HEADS), flush=True)
    for name, result, all_results in by_row(rows, block, options.jobs, options.record):
        for remark in [] if isinstance(result, str) else result["remarks"]:
            print(f"    {remark}", flush=True)
        if all_results is not None:
            print(f"{name[0]:32s} {name[1]:14s}{total(all_results)}", flush=True)


HEADS = (*COUNTED, "oracle ms", "median ms", "worst ms")


def total(results: list[dict[str, Any] | str]) -> str:
    """The numbers of a row, or why there are none."""
    tally = Tally()
    for result in results:
        if isinstance(result, str):
            return f"  {result}"
        tally.counts.update(result["counts"])
        tally.oracle += result["oracle"]
        tally.package += result["package"]
    return tally.row()


def replay(kind: str, layout: str, seed: int, number: int) -> None:
    """Print one problem, every pose of the oracle with the package's nearest pose, and poses of the package alone."""
    problem = problem_number(kind, layout, seed, number)
    oracle, found = poses_of_oracle(problem), poses_of_package(problem)
    truth = problem.base_from_fixture
    for f in problem.features:
        size = "" if f.type == "plane" else f" {f.side}, radius {f.radius!r}"
        print(f"{f.type} at {f.point.tolist()}, direction {f.direction.tolist()}{size}")
    print(f"tip radius {problem.tip_radius}, contacts:")
    for f, x in zip(problem.feature_of_contact, problem.points, strict=True):
        print(f"  {f} {x.tolist()}")
    print(
        f"oracle: {oracle.paths} paths, {oracle.finite} finite, {oracle.singular} singular, "
        f"{oracle.diverged} diverged, {oracle.suspicious} suspicious, {oracle.runs} runs"
    )
    print(f"real poses: oracle {len(oracle.poses)}, package {len(found)}")
    print(f"{'':10s}{'stiffness':>11s}{'misfit mm':>11s}{'nearest':>11s}")
    for pose, multiple, gap in zip(oracle.poses, oracle.multiple, nearest(oracle.poses, found, problem), strict=True):
        label = "multiple" if multiple else ("MISSED" if gap > SAME else "")
        is_true = "  true" if nearest(pose[None], truth[None], problem)[0] < SAME else ""
        print(f"{label:10s}{stiffness(problem, pose):11.1e}{misfit(problem, pose):11.1e}{gap:11.1e}{is_true}")
        if label:
            print(
                " " * 10
                + np.array2string(pose, max_line_width=200, prefix=" " * 10, formatter={"float": "{:.17g}".format})
            )
    for pose, gap in zip(found, nearest(found, oracle.poses, problem), strict=True):
        if gap > SAME:
            label = "extra" if is_exact(problem, pose) else "inexact"
            print(
                f"{label:10s}{stiffness(problem, pose):11.1e}{misfit(problem, pose):11.1e}{gap:11.1e}  of the package"
            )
    if nearest(truth[None], found, problem)[0] > SAME:
        print("LOST: the true pose is not among the package's")


def main() -> None:
    options = options_of_series(__doc__, STUDIED).parse_args()
    if options.replay is None:
        run(options)
    else:
        replay(options.kind[0], options.layout[0], options.seed, options.replay)


if __name__ == "__main__":
    main()
