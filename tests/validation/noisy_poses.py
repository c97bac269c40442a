"""Noisy contacts by the public interface: is the true pose among the candidates, and is "located" ever a wrong pose?

    python -m tests.validation.noisy_poses --problems 1000 --jobs 2 --record out.jsonl
    python -m tests.validation.noisy_poses --kind cylinder4+sphere2 --more 1 --layout even --replay 17

Six to nine contacts on fixtures of 40 to 250 mm, up to metres from the origin, with noise of 1 to 100 um along the
normals and approaches up to 45 degrees off them; no touch boxes. Set OMP_NUM_THREADS=1.

    located, ambig, underdet, inconsist     number of problems with each status
    false       located farther from the true pose, by the returned covariance, than noise explains once in a million,
                and not at the least-squares pose reached from the true one; must be zero
    beyond      located as far, but at that least-squares pose: the covariance is too small
    lost        no candidate is the true pose or the least-squares pose reached from it; not for underdetermined
    fell        that candidate exists, but was eliminated
    raised      an exception
    covered     per cent of located poses whose 95 per cent ellipsoid covers the true pose, without false ones
"""

import argparse
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

import tactfix
from tests.validation.blocks import by_row, numbered, options_of_series
from tests.validation.kinds import STUDIED
from tests.validation.pose_problems import PoseProblem, distances
from tests.validation.touched_problems import Touched, touched_number

ANOTHER = chi2.isf(1e-6, 6)
INNER = chi2.ppf(0.95, 6)
STATUSES = {"located": "located", "ambiguous": "ambig", "underdetermined": "underdet", "inconsistent": "inconsist"}
COUNTED = (*STATUSES.values(), "false", "beyond", "lost", "fell", "raised")
# Upper bounds of the worst sigma of rotation (rad), one for each row of the second table.
ROTATION_SIGMAS = (0.001, 0.005, 0.02, 0.05, 0.1, np.inf)


@dataclass
class Tally:
    """Counts; milliseconds of processor time of each problem; [worst rotation sigma, distance] of each located one."""

    counts: Counter[str] = field(default_factory=Counter)
    times: list[float] = field(default_factory=list)
    sure: list[list[float]] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    def row(self) -> str:
        numbers = "".join(f"{self.counts[head]:10d}" for head in COUNTED)
        inside = [distance <= INNER for _, distance in self.sure]
        covered = f"{100 * np.mean(inside):10.1f}" if inside else f"{'':10s}"
        return f"{len(self.times):9d}{numbers}{covered}{np.median(self.times):10.1f}{np.max(self.times):10.1f}"


@dataclass(frozen=True)
class Judge:
    """The independent computations of the study for one problem."""

    touched: Touched

    @property
    def problem(self) -> PoseProblem:
        return self.touched.problem

    @cached_property
    def settled(self) -> np.ndarray:
        """The least-squares pose reached from the true pose."""
        return self.settled_from(self.problem.base_from_fixture)

    def settled_from(self, start: np.ndarray) -> np.ndarray:
        """The least-squares pose reached from a start, by scipy."""
        middle = self.problem.points.mean(axis=0)
        spread = np.sqrt(self.problem.points.var(axis=0).sum())

        def moved(step: np.ndarray) -> np.ndarray:
            pose, turn = start.copy(), Rotation.from_rotvec(step[:3]).as_matrix()
            pose[:3, :3] = turn @ start[:3, :3]
            pose[:3, 3] = turn @ (start[:3, 3] - middle) + middle + spread * step[3:]
            return pose

        def residuals(step: np.ndarray) -> np.ndarray:
            return self.residuals(moved(step))

        fit = least_squares(residuals, np.zeros(6), method="lm", xtol=1e-14, ftol=1e-14, gtol=1e-14, max_nfev=2000)
        return moved(fit.x)

    def residuals(self, pose: np.ndarray) -> np.ndarray:
        """The residuals of all contacts in sigmas."""
        return distances(self.problem, pose)[0] / self.touched.sigma

    def distance(self, pose: np.ndarray, other: np.ndarray) -> float:
        """Squared distance of two poses in sigmas of the contacts, linearized at the pose that gives more."""
        return max(self.seen(pose, other, pose), self.seen(pose, other, other))

    def seen(self, pose: np.ndarray, other: np.ndarray, at: np.ndarray) -> float:
        """The same, with the contacts' Jacobian at a third pose."""
        step, middle = self.step(pose, other), self.problem.points.mean(axis=0)
        normals = distances(self.problem, at)[1] @ at[:3, :3].T
        jacobian = np.hstack([np.cross(self.problem.points - middle, normals), normals])
        return float(np.sum((jacobian @ step / self.touched.sigma) ** 2))

    def step(self, pose: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Rotation vector from one pose to the other, and shift of the fixture's point at the contacts' mean."""
        middle = self.problem.points.mean(axis=0)
        moved_middle = other[:3, :3] @ (pose[:3, :3].T @ (middle - pose[:3, 3])) + other[:3, 3]
        return np.concatenate([Rotation.from_matrix(other[:3, :3] @ pose[:3, :3].T).as_rotvec(), moved_middle - middle])

    def by_covariance(self, pose: np.ndarray, covariance: np.ndarray) -> float:
        """Squared distance of the true pose in sigmas of a covariance about the fixture's origin."""
        x, y, z = self.problem.points.mean(axis=0) - pose[:3, 3]
        lever = np.eye(6)
        lever[3:, :3] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
        step = self.step(pose, self.problem.base_from_fixture)
        return float(step @ np.linalg.solve(lever @ covariance @ lever.T, step))

    def is_planted(self, pose: np.ndarray) -> bool:
        """Whether a pose agrees with the true one within noise, or is the least-squares pose reached from it."""
        planted = self.problem.base_from_fixture
        return self.distance(pose, planted) <= ANOTHER or self.distance(pose, self.settled) <= 1.0


def located(touched: Touched) -> tactfix.LocateResult:
    """The package's result."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "fixture.yaml"
        path.write_text(touched.fixture_yaml())
        fixture = tactfix.load_fixture(path)
    problem = touched.problem
    contacts = tactfix.contacts_from_arrays(
        touched.names, problem.points, touched.approaches, sigma=touched.sigma, tip_radius=problem.tip_radius
    )
    return tactfix.locate(fixture, contacts, explain=False)


def examine(name: str, touched: Touched, tally: Tally) -> None:
    """Add one problem to the tally."""
    began = time.process_time()
    try:
        result = located(touched)
    except Exception as error:
        tally.counts["raised"] += 1
        tally.remarks.append(f"raised   {name}  {type(error).__name__}: {error}")
        return
    tally.times.append(round(1e3 * (time.process_time() - began), 2))
    tally.counts[STATUSES[result.status]] += 1
    judge = Judge(touched)
    if result.base_from_fixture is not None and result.covariance is not None:
        _judge_located(name, judge, result, tally)
    planted = [c for c in result.candidates if judge.is_planted(c.base_from_fixture)]
    if not planted and result.status != "underdetermined":
        tally.counts["lost"] += 1
        tally.remarks.append(f"lost     {name}  {result.status}, {len(result.candidates)} candidates")
    elif planted and not any(c.accepted for c in planted):
        tally.counts["fell"] += 1
        tally.remarks.append(f"fell     {name}  {result.status}: {planted[0].reasons[0].message}")


def _judge_located(name: str, judge: Judge, result: tactfix.LocateResult, tally: Tally) -> None:
    assert result.base_from_fixture is not None
    assert result.covariance is not None
    distance = judge.by_covariance(result.base_from_fixture, result.covariance)
    worst = float(np.sqrt(np.linalg.eigvalsh(result.covariance[:3, :3])[-1]))
    if distance <= ANOTHER or judge.is_planted(result.base_from_fixture):
        tally.sure.append([worst, distance])
    if distance <= ANOTHER:
        return
    category = "beyond" if judge.is_planted(result.base_from_fixture) else "false"
    tally.counts[category] += 1
    warnings = "; ".join(result.warnings) or "no warning"
    tally.remarks.append(
        f"{category:9s}{name}  distance {distance**0.5:.3g} sigma, rotation sigma {worst:.2g}; {warnings}"
    )


def block(kind: str, more: int, layouts: str, seed: int, first: int, count: int) -> dict[str, Any]:
    """Results of some problems of one series, with the layouts in turn, as a dict for JSON."""
    tally, names = Tally(), layouts.split()
    for number in range(first, first + count):
        layout = names[number % len(names)]
        name = f"{kind} --more {more} --layout {layout} --seed {seed} --replay {number}"
        try:
            touched = touched_number(kind, more, layout, seed, number)
        except ValueError:
            tally.counts["not made"] += 1
            continue
        examine(name, touched, tally)
    return dict(vars(tally))


def run(options: argparse.Namespace) -> None:
    """Run all blocks; print remarks as they arise, a row after its last block, and coverage at the end."""
    blocks = numbered(options.first, options.problems)
    rows = {
        (kind, more): [(kind, more, " ".join(options.layout), options.seed, *numbers) for numbers in blocks]
        for kind in options.kind
        for more in options.more
    }
    heads = ("count", *COUNTED, "covered", "median ms", "worst ms")
    print(f"{'kind':32s} {'contacts':8s}{heads[0]:>9s}" + "".join(f"{head:>10s}" for head in heads[1:]), flush=True)
    everything = Tally()
    for (kind, more), result, results in by_row(rows, block, options.jobs, options.record):
        for remark in result["remarks"]:
            print(f"    {remark}", flush=True)
        if results is not None:
            tally = total(results)
            print(f"{kind:32s} {6 + more:8d}" + (tally.row() if tally.times else "  no such layout"), flush=True)
            everything = total([dict(vars(everything)), dict(vars(tally))])
    print(f"{'all':32s} {'':8s}{everything.row()}")
    print_coverage(np.array(everything.sure).reshape(-1, 2))


def total(results: list[dict[str, Any]]) -> Tally:
    tally = Tally()
    for result in results:
        tally.counts.update(result["counts"])
        tally.times += result["times"]
        tally.sure += result["sure"]
    return tally


def print_coverage(sure: np.ndarray) -> None:
    """How often the ellipsoid covers the true pose, by the sigma of the rotation."""
    print(f"{'worst sigma of rotation, rad':32s}{'located':>10s}{'covered':>10s}{'+-':>8s}")
    low = 0.0
    for high in ROTATION_SIGMAS:
        inside = sure[(sure[:, 0] >= low) & (sure[:, 0] < high), 1] <= INNER
        if len(inside):
            error = 100 * np.sqrt(0.05 * 0.95 / len(inside))
            print(f"{f'{low:g} to {high:g}':32s}{len(inside):10d}{100 * inside.mean():10.1f}{error:8.1f}")
        low = high


def replay(kind: str, more: int, layout: str, seed: int, number: int, folder: Path | None) -> None:
    """Print one problem, every candidate and its distance from the true pose; write its files into a folder."""
    touched = touched_number(kind, more, layout, seed, number)
    judge, result = Judge(touched), located(touched)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "fixture.yaml").write_text(touched.fixture_yaml())
        (folder / "contacts.csv").write_text(touched.contacts_csv())
    planted = touched.problem.base_from_fixture
    print(touched.fixture_yaml() + touched.contacts_csv())
    print(f"true:\n{planted}\nleast squares leads from there {judge.distance(planted, judge.settled) ** 0.5:.3g} sigma")
    off = judge.residuals(judge.settled)
    print(f"to chi-square {off @ off:.3g}; the package's limit is {result.chi2_limit:.3g}")
    print(f"{result.status}, warnings {result.warnings}")
    print(f"{'chi2':>10s}{'from truth':>14s}{'settled':>10s}  in sigmas")
    for c in result.candidates:
        gaps = [judge.distance(c.base_from_fixture, other) ** 0.5 for other in (planted, judge.settled)]
        reasons = "; ".join(reason.message for reason in c.reasons) or "accepted"
        print(f"{c.chi2:10.3g}{gaps[0]:14.3g}{gaps[1]:10.3g}  {reasons}")
    if result.base_from_fixture is not None and result.covariance is not None:
        distance = judge.by_covariance(result.base_from_fixture, result.covariance)
        print(f"located {distance**0.5:.3g} sigma of its covariance from the true pose")


def main() -> None:
    parser = options_of_series(__doc__, STUDIED)
    parser.add_argument("--more", nargs="+", type=int, default=[0, 1, 2, 3], help="contacts beyond the six of the kind")
    parser.add_argument("--save", type=Path, metavar="FOLDER", help="with --replay: write its fixture and contact file")
    options = parser.parse_args()
    if options.replay is None:
        run(options)
    else:
        replay(options.kind[0], options.more[0], options.layout[0], options.seed, options.replay, options.save)


if __name__ == "__main__":
    main()
