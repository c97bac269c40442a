"""Fixtures by relations against the same fixtures by geometry: 20 kinds, angles near every fold, exact and measured.

    python -m tests.validation.relations_study [--problems 200] [--journal FILE] [--kind block] [--angle 90]

Each cell is a kind, an angle and its sigma, a base along the part's axes or rotated, and nominal or noisy contacts.
Counted are: located; located with an error beyond 8 sigma of the covariance (wrong), or beyond the 95 per cent
ellipsoid; ambiguous with and without the true pose in the list; inconsistent; underdetermined, and underdetermined
although the same contacts are located by geometry; another status than by geometry, if exact relations determine the
shape; another status with the base rotated, for bases along the axes; numpy warnings; more than 2 s of processor time.
Each problem is written to the journal and not repeated: the full study takes four hours of one processor, and can be
interrupted and resumed.
"""

import argparse
import json
import sys
import tempfile
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import astuple, dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import beta

import tactfix
from tests.validation.relation_geometry import KINDS, Angle, Part
from tests.validation.relation_touches import COUNTS, Touched, by_geometry, by_relations, touches

ANGLES = (0.0, 0.02, 0.3, 45.0, 89.5, 89.9, 89.99, 90.0, 179.99, 180.0)
SIGMAS = (0.0, 0.005, 0.02, 0.1)
SIGMA = 0.01
NINETY_FIVE = 12.592
"""Chi-square that six degrees of freedom exceed in one of twenty cases (tables)."""
WRONG = 64.0
"""The square of eight sigma."""


@dataclass(frozen=True)
class Cell:
    """One combination of the parameters of the study."""

    kind: str
    angle: float
    sigma: float
    turned: bool
    noisy: bool


def cells(kinds: list[str]) -> Iterator[Cell]:
    """All combinations that the kinds allow."""
    for kind in kinds:
        allows = KINDS[kind].allows
        pairs = [(a, s) for a in ANGLES for s in SIGMAS if allows and allows(Angle(a, s, a, 0.0))] or [(0.0, 0.0)]
        for angle, sigma in pairs:
            for turned in (False, True):
                yield from (Cell(kind, angle, sigma, turned, noisy) for noisy in (False, True))


def drawn(cell: Cell, seed: int) -> tuple[Part, Touched, np.ndarray | None, Touched]:
    """A part, its touches and their noise in standard deviations, and the same touches in the other base."""
    place = [int(1e3 * cell.angle), int(1e3 * cell.sigma), cell.turned]
    rng = np.random.default_rng([seed, *cell.kind.encode(), *place])
    part = KINDS[cell.kind].make(Angle.drawn(cell.angle, cell.sigma, rng))
    base = np.eye(4)
    base[:3, 3] = rng.uniform(-300, 300, 3)
    touched = touches(part, base, rng, nominal=not cell.noisy)
    noise = rng.standard_normal(len(touched.names)) if cell.noisy else None
    away = turned_by(Rotation.random(random_state=rng).as_matrix(), touched)
    return (part, away, noise, touched) if cell.turned else (part, touched, noise, away)


def problem(cell: Cell, seed: int, folder: Path) -> Counter:
    """The counts for one part and one set of contacts."""
    part, touched, noise, away = drawn(cell, seed)
    begun = time.process_time()
    fixture = loaded(by_relations(part), folder)
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        result = located(fixture, touched, noise, folder)
    took = time.process_time() - begun
    tally = judged(result, touched, cell.noisy)
    tally["problems"] += 1
    tally["numpy warned"] += len(warned)
    tally[f"{'slow' if took > 2 else 'quick'}"] += 1
    fixed = cell.sigma == 0 and KINDS[cell.kind].fixes_shape(cell.angle)
    if fixed or result.status != "located":
        reference = located(loaded(by_geometry(part), folder), touched, noise, folder, explain=False)
        tally["freed"] += reference.status == "located" and result.status == "underdetermined"
        tally["not as by geometry"] += fixed and reference.status != result.status
    if not cell.turned:
        tally["turned otherwise"] += located(fixture, away, noise, folder, explain=False).status != result.status
    tally["ms"] = round(1e3 * took)
    return tally


def turned_by(turn: np.ndarray, touched: Touched) -> Touched:
    """The same part and touches in a base that is rotated about its origin."""
    big = np.eye(4)
    big[:3, :3] = turn
    vectors = {n: getattr(touched, n) @ turn.T for n in ("points", "normals", "approaches")}
    frames = {n: big @ getattr(touched, n) for n in ("base_from_part", "base_from_fixture")}
    return replace(touched, **vectors, **frames)


def loaded(text: str, folder: Path) -> tactfix.Fixture:
    """The fixture, from a file as a user has it."""
    file = folder / "fixture.yaml"
    file.write_text(text)
    return tactfix.load_fixture(file)


def located(
    fixture: tactfix.Fixture, touched: Touched, noise: np.ndarray | None, folder: Path, explain: bool = True
) -> tactfix.LocateResult:
    """The package's result, from contacts in a file as a user has them."""
    contacts = folder / "contacts.csv"
    contacts.write_text(touched.csv(SIGMA, noise))
    return tactfix.locate(fixture, tactfix.load_contacts(contacts, fixture), explain=explain)


def judged(result: tactfix.LocateResult, touched: Touched, noisy: bool) -> Counter:
    """The status, and whether it is correct."""
    tally = Counter({result.status: 1})
    if result.status == "located":
        error = pose_error(result.base_from_fixture, touched.base_from_fixture)
        square = float(error @ np.linalg.pinv(result.covariance, rcond=1e-14) @ error)
        tally["wrong"] += square > WRONG
        tally["noisy located"] += noisy
        tally["covered"] += noisy and square <= NINETY_FIVE
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
    "ambiguous",
    "truth not listed",
    "inconsistent",
    "underdetermined",
    "freed",
    "not as by geometry",
    "turned otherwise",
    "numpy warned",
    "slow",
)
RIGHT = ("problems", "located", "ambiguous", "quick", "covered", "noisy located", "ms")
"""What is counted and is no complaint."""


def study(chosen: list[Cell], problems: range, journal: Path) -> list[tuple[Cell, int, Counter]]:
    """The result of each problem of each cell, read from the journal if present, else computed and appended."""
    found = list(read_journal(journal))
    done = {(cell, number) for cell, number, _ in found}
    with journal.open("a") as out, tempfile.TemporaryDirectory() as folder:
        for number in problems:
            # Shuffled, so that an interrupted run has covered all kinds.
            for cell in (chosen[i] for i in np.random.default_rng(number).permutation(len(chosen))):
                if (cell, number) in done:
                    continue
                tally = problem(cell, number, Path(folder))
                print(json.dumps([astuple(cell), number, tally]), file=out, flush=True)
                found.append((cell, number, tally))
                odd = {name for name in tally if tally[name]} - set(RIGHT)
                if odd:
                    print(number, astuple(cell), sorted(odd), file=sys.stderr, flush=True)
    return [entry for entry in found if entry[0] in chosen and entry[1] in problems]


def read_journal(journal: Path) -> Iterator[tuple[Cell, int, Counter]]:
    """The results of earlier runs."""
    for line in journal.read_text().splitlines() if journal.exists() else ():
        cell, number, tally = json.loads(line)
        yield Cell(*cell), number, Counter(tally)


def table(found: list[tuple[Cell, int, Counter]], row: str) -> Iterator[str]:
    """Sums of all tallies, with a line for each value of one of the fields of a cell."""
    sums: dict[object, Counter] = defaultdict(Counter)
    times: dict[object, list[float]] = defaultdict(list)
    for cell, _, tally in found:
        for key in (getattr(cell, row), "all"):
            sums[key] += tally
            times[key].append(tally["ms"])
    yield f"| {row} | " + " | ".join(SHOWN) + " | covered, 95 % between | ms: median, worst |"
    yield "| --- |" + " --- |" * (len(SHOWN) + 2)
    for key, tally in sums.items():
        spent = f"{np.median(times[key]):.0f}, {max(times[key]):.0f}"
        yield f"| {key} | " + " | ".join(str(tally[name]) for name in SHOWN) + f" | {coverage(tally)} | {spent} |"


def coverage(tally: Counter) -> str:
    """The share of noisy located problems covered by the 95 per cent ellipsoid, with its Clopper-Pearson interval."""
    hits, of = tally["covered"], tally["noisy located"]
    if not of:
        return ""
    low = beta.ppf(0.025, hits, of - hits + 1) if hits else 0.0
    high = beta.ppf(0.975, hits + 1, of - hits) if hits < of else 1.0
    return f"{100 * hits / of:.1f} %, {100 * low:.1f} to {100 * high:.1f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", type=int, default=200, help="in each cell")
    parser.add_argument("--first", type=int, default=0, help="number of the first problem")
    parser.add_argument("--journal", type=Path, default=Path("relations_study.jsonl"), help="what has been done")
    parser.add_argument("--kind", action="append", choices=list(KINDS))
    parser.add_argument("--angle", action="append", type=float, choices=ANGLES)
    parser.add_argument(
        "--contacts", metavar="P,C,S", help="on each plane, cylinder and sphere, noisy ones alone; default 5,7,5"
    )
    given = parser.parse_args()
    chosen = [c for c in cells(given.kind or list(KINDS)) if c.angle in (given.angle or ANGLES)]
    if given.contacts:
        COUNTS.update(zip(("plane", "cylinder", "sphere"), map(int, given.contacts.split(",")), strict=True))
        chosen = [cell for cell in chosen if cell.noisy]  # a few of the nominal ones leave a motion free
    found = study(chosen, range(given.first, given.first + given.problems), given.journal)
    for row in ("kind", "angle", "sigma"):
        print(*table(found, row), sep="\n", end="\n\n")


if __name__ == "__main__":
    main()
