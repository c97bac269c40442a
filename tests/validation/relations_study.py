"""Fixtures by relations against the same contacts by geometry: 20 kinds, angles next to every fold, exact and measured.

    cd tests; python -m tests.validation.relations_study --problems 1 [--seed 1] [--kind "bar on plate"] [--verbose]

Each cell is a kind, an angle and its sigma, the base along the part's axes or turned, contacts nominal or noisy.
Counted are: located; located with an error beyond 8 sigma of the covariance (wrong), or beyond that of 95 per cent;
ambiguous, the truth listed or not; inconsistent; underdetermined, and so where the same contacts are located by
geometry; another verdict than by geometry, where exact relations fix the shape; another verdict with the base turned.
"""

import argparse
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import tactfix
from tests.validation.relation_geometry import KINDS, Angle
from tests.validation.relation_touches import Touched, by_geometry, by_relations, touches

ANGLES = (0.0, 0.02, 0.3, 45.0, 89.5, 89.9, 89.99, 90.0, 179.99, 180.0)
SIGMAS = (0.0, 0.005, 0.02, 0.1)
SIGMA = 0.01
NINETY_FIVE = 12.592
"""Chi-square that six degrees of freedom exceed in one of twenty cases (tables)."""
WRONG = 64.0
"""The square of eight sigma."""


@dataclass(frozen=True)
class Cell:
    """One combination of what the study varies."""

    kind: str
    angle: float
    sigma: float
    turned: bool
    noisy: bool


def cells(kinds: list[str]) -> Iterator[Cell]:
    """All that the kinds allow."""
    for kind in kinds:
        allows = KINDS[kind].allows
        pairs = [(a, s) for a in ANGLES for s in SIGMAS if allows and allows(Angle(a, s, a, 0.0))] or [(0.0, 0.0)]
        for angle, sigma in pairs:
            for turned in (False, True):
                yield from (Cell(kind, angle, sigma, turned, noisy) for noisy in (False, True))


def problem(cell: Cell, seed: int, folder: Path) -> Counter:
    """What comes out for one part and one set of contacts."""
    rng = np.random.default_rng([seed, *cell.kind.encode(), int(1e3 * cell.angle), int(1e3 * cell.sigma)])
    part = KINDS[cell.kind].make(Angle.drawn(cell.angle, cell.sigma, rng))
    base = np.eye(4)
    base[:3, 3] = rng.uniform(-300, 300, 3)
    touched = touches(part, base, rng, nominal=not cell.noisy)
    noise = rng.standard_normal(len(touched.names)) if cell.noisy else None
    away = turned_by(Rotation.random(random_state=rng).as_matrix(), touched)
    if cell.turned:
        touched, away = away, touched
    files = folder / "relations.yaml", folder / "geometry.yaml"
    files[0].write_text(by_relations(part))
    files[1].write_text(by_geometry(part))
    begun = time.process_time()
    result = located(files[0], touched, noise, folder)
    took = time.process_time() - begun
    tally = judged(result, touched)
    tally["problems"] += 1
    tally[f"{'slow' if took > 2 else 'quick'}"] += 1
    fixed = cell.sigma == 0 and is_fixed(cell.kind, cell.angle)
    if fixed or result.status != "located":
        reference = located(files[1], touched, noise, folder)
        tally["freed"] += reference.status == "located" and result.status == "underdetermined"
        tally["not as by geometry"] += fixed and reference.status != result.status
    tally["turned otherwise"] += located(files[0], away, noise, folder).status != result.status
    tally["worst ms"] = round(1e3 * took)
    return tally


@lru_cache
def is_fixed(kind: str, angle: float) -> bool:
    """Whether exact relations fix the shape of a kind, as design-check says."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "fixture.yaml"
        file.write_text(by_relations(KINDS[kind].make(Angle(angle, 0.0, angle, 0.0))))
        report = tactfix.design_check(tactfix.load_fixture(file))
    return all(finding.code != "relations_incomplete" for finding in report.findings)


def turned_by(turn: np.ndarray, touched: Touched) -> Touched:
    """The same part and touches in a base that is turned about its origin."""
    big = np.eye(4)
    big[:3, :3] = turn
    vectors = {n: getattr(touched, n) @ turn.T for n in ("points", "normals", "approaches")}
    frames = {n: big @ getattr(touched, n) for n in ("base_from_part", "base_from_fixture")}
    return replace(touched, **vectors, **frames)


def located(file: Path, touched: Touched, noise: np.ndarray | None, folder: Path) -> tactfix.LocateResult:
    """What the package says, from files as a user has them."""
    fixture = tactfix.load_fixture(file)
    contacts = folder / "contacts.csv"
    contacts.write_text(touched.csv(SIGMA, noise))
    return tactfix.locate(fixture, tactfix.load_contacts(contacts, fixture))


def judged(result: tactfix.LocateResult, touched: Touched) -> Counter:
    """The verdict, and whether it is right."""
    tally = Counter({result.status: 1})
    if result.status == "located":
        error = pose_error(result.base_from_fixture, touched.base_from_fixture)
        square = float(error @ np.linalg.pinv(result.covariance, rcond=1e-14) @ error)
        tally["wrong"] += square > WRONG
        tally["covered"] += square <= NINETY_FIVE
    if result.status == "ambiguous":
        errors = [pose_error(c.base_from_fixture, touched.base_from_fixture) for c in result.candidates if c.accepted]
        near = [np.linalg.norm(e[:3]) < 0.02 and np.linalg.norm(e[3:]) < 2.0 for e in errors]
        tally["truth not listed"] += not any(near)
    return tally


def pose_error(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """(d_rot, d_t): R_true = exp([d_rot]) R, t_true = t + d_t."""
    turn = Rotation.from_matrix(true[:3, :3] @ found[:3, :3].T).as_rotvec()
    return np.concatenate([turn, true[:3, 3] - found[:3, 3]])


SHOWN = (
    "problems",
    "located",
    "wrong",
    "covered",
    "ambiguous",
    "truth not listed",
    "inconsistent",
    "underdetermined",
    "freed",
    "not as by geometry",
    "turned otherwise",
    "slow",
    "worst ms",
)


def study(problems: int, seed: int, kinds: list[str], verbose: bool = False) -> dict[str, Counter]:
    """Tallies by kind."""
    found: dict[str, Counter] = {}
    with tempfile.TemporaryDirectory() as folder:
        for cell in cells(kinds):
            for number in range(problems):
                tally = problem(cell, 1000 * seed + number, Path(folder))
                worst = max(found.get(cell.kind, Counter())["worst ms"], tally["worst ms"])
                found[cell.kind] = found.get(cell.kind, Counter()) + tally
                found[cell.kind]["worst ms"] = worst
                odd = [name for name in SHOWN[2:-1] if tally[name] and name != "covered"]
                if verbose and odd:
                    print(cell, 1000 * seed + number, odd, flush=True)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", type=int, default=1, help="in each cell")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", action="append", choices=list(KINDS))
    parser.add_argument("--verbose", action="store_true")
    given = parser.parse_args()
    found = study(given.problems, given.seed, given.kind or list(KINDS), given.verbose)
    print("| kind | " + " | ".join(SHOWN) + " |\n| --- |" + " --- |" * len(SHOWN))
    everything = sum(found.values(), Counter())
    everything["worst ms"] = max(tally["worst ms"] for tally in found.values())
    for kind, tally in {**found, "all": everything}.items():
        print(f"| {kind} | " + " | ".join(str(tally[name]) for name in SHOWN) + " |")


if __name__ == "__main__":
    main()
