"""Counts of poses that the package misses with more than six contacts, where its search takes short cuts.

    python -m tests.validation.redundant_poses --problems 1000 --jobs 2 --record out.jsonl
    python -m tests.validation.redundant_poses --kind cylinder1+plane3+plane2 --layout far --replay 1

Path tracking gives all poses of the six contacts of the kind; each is refined on all noisy contacts by scipy's least
squares, and if it explains them it must be among the package's poses. No code is shared with the package. Noise and
sizes are those of noisy_poses. Set OMP_NUM_THREADS=1.

    poses       poses found in this way that explain all contacts
    missed      of these, those without a pose of the package within a sigma; with miss: problems with such poses
    weak        of these, those determined so weakly that noise decides; not counted as missed
    raised      problems in which the package raised an exception
"""

import argparse
import time
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.stats import chi2

from tests.validation.blocks import by_row, numbered, options_of_series
from tests.validation.kinds import KINDS
from tests.validation.noisy_poses import Judge
from tests.validation.pose_oracle import NUMPY, Method, all_real_poses
from tests.validation.pose_problems import oracle_features, stiffness
from tests.validation.poses_of_package import poses_of_package
from tests.validation.touched_problems import Touched, touched_number

# Probability of a larger chi-square: far within the limit of the package.
LIKELY = 1e-3
WEAK = 1e-4
COUNTED = ("poses", "missed", "with miss", "weak", "raised")


@dataclass
class Tally:
    """Counts, milliseconds of processor time of the package for each problem, and remarks to print."""

    counts: Counter[str] = field(default_factory=Counter)
    times: list[float] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def row(self) -> str:
        numbers = "".join(f"{self.counts[head]:10d}" for head in COUNTED)
        return f"{len(self.times):9d}{numbers}{np.median(self.times):10.1f}{np.max(self.times):10.1f}"


def explaining(touched: Touched, judge: Judge, method: Method = NUMPY) -> list[np.ndarray]:
    """The poses that explain all contacts, refined from all poses of the first six."""
    problem = touched.problem
    six = all_real_poses(
        oracle_features(problem), problem.feature_of_contact[:6], problem.points[:6], problem.rho[:6], method
    )
    limit = chi2.isf(LIKELY, len(problem.points) - 6)
    found: list[np.ndarray] = []
    for start in six.poses:
        pose = judge.settled_from(start)
        if np.sum(judge.residuals(pose) ** 2) <= limit and all(judge.distance(pose, other) > 1 for other in found):
            found.append(pose)
    return found


def examine(name: str, touched: Touched, tally: Tally, method: Method = NUMPY) -> None:
    """Add one problem to the tally."""
    began = time.process_time()
    try:
        poses = poses_of_package(touched.problem, touched.sigma)
    except Exception as error:
        tally.counts["raised"] += 1
        tally.remarks.append(f"raised   {name}  {type(error).__name__}: {error}")
        return
    tally.times.append(round(1e3 * (time.process_time() - began), 2))
    judge = Judge(touched)
    wanted = explaining(touched, judge, method)
    away = [min((judge.distance(pose, other) for other in poses), default=np.inf) for pose in wanted]
    missed = [pose for pose, gap in zip(wanted, away, strict=True) if gap > 1]
    firm = sum(stiffness(touched.problem, pose) >= WEAK for pose in missed)
    tally.counts.update(poses=len(wanted), missed=firm, weak=len(missed) - firm)
    tally.counts.update({"with miss": int(firm > 0)})
    if firm:
        tally.remarks.append(f"missed   {name}  {firm} of {len(wanted)}")


def block(kind: str, layout: str, seed: int, first: int, count: int) -> dict[str, Any]:
    """Results of some problems of one series, in turn with three to twelve additional contacts, as a dict for JSON."""
    from tests.validation.compiled_poses import COMPILED  # needs numba

    tally = Tally()
    for number in range(first, first + count):
        try:
            touched = touched_problem(kind, layout, seed, number)
        except ValueError:
            continue
        examine(f"{kind} --layout {layout} --seed {seed} --replay {number}", touched, tally, COMPILED)
    return dict(vars(tally))


def touched_problem(kind: str, layout: str, seed: int, number: int) -> Touched:
    """One problem of a series. Raises ValueError if in no layout of the kind a probe can reach the contacts."""
    return touched_number(kind, 3 + number % 10, layout, seed, number)


def run(options: argparse.Namespace) -> None:
    """Run all blocks; print remarks as they arise, a row after its last block, and the sum of all."""
    rows = {
        (kind, layout): [
            (kind, layout, options.seed, *numbers) for numbers in numbered(options.first, options.problems)
        ]
        for kind in options.kind
        for layout in options.layout
    }
    heads = "".join(f"{head:>10s}" for head in (*COUNTED, "median ms", "worst ms"))
    print(f"{'kind':32s} {'layout':14s}{'count':>9s}{heads}", flush=True)
    everything: list[dict[str, Any]] = []
    for name, result, results in by_row(rows, block, options.jobs, options.record):
        for remark in result["remarks"]:
            print(f"    {remark}", flush=True)
        everything.append(result)
        if results is not None and any(r["times"] for r in results):
            print(f"{name[0]:32s} {name[1]:14s}{total(results).row()}", flush=True)
    print(f"{'all':47s}{total(everything).row()}")


def total(results: list[dict[str, Any]]) -> Tally:
    """The sum of some blocks."""
    tally = Tally()
    for result in results:
        tally.counts.update(result["counts"])
        tally.times += result["times"]
    return tally


def main() -> None:
    options = options_of_series(__doc__, KINDS).parse_args()
    if options.replay is None:
        run(options)
        return
    kind, layout = options.kind[0], options.layout[0]
    tally = Tally()
    examine("this one", touched_problem(kind, layout, options.seed, options.replay), tally)
    print(*tally.remarks, dict(tally.counts), sep="\n")


if __name__ == "__main__":
    main()
