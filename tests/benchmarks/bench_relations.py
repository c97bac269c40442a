"""Time to locate fixtures by relations: 20 kinds, ten contact sets each, correct and wrong; the slowest is printed.

Processor time, also as a multiple of a 100 x 100 SVD in the same run. Exits with 1 if a set takes longer than LONGEST.

OMP_NUM_THREADS=1 python -m tests.benchmarks.bench_relations [KIND...]
"""

import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import tactfix
from tests.benchmarks.clock import best_of_each, heading, table
from tests.validation.relation_geometry import KINDS, Angle
from tests.validation.relation_touches import Touched, by_relations, touches

LONGEST = 2.0
"""Largest accepted time (s) with at most 30 contacts, for any status."""
SIGMA = 0.01
ANGLES = ((60.0, 0.0), (89.9, 0.02), (0.02, 0.02))
"""Value and sigma (deg) of a kind's angle: a regular one, one near the fold at 90, and one near parallel."""


def angle_of(kind: str, number: int, rng: np.random.Generator) -> Angle:
    """The angle of a contact set: the three angles in turn, if the kind allows them."""
    allows = KINDS[kind].allows
    fitting = [Angle.drawn(*pair, rng) for pair in ANGLES if allows and allows(Angle(*pair, pair[0], 0.0))]
    return fitting[number % len(fitting)] if fitting else Angle(0.0, 0.0, 0.0, 0.0)


def as_touched(touched: Touched, rng: np.random.Generator) -> Touched:
    return touched


def scaled(factor: float) -> Callable[[Touched, np.random.Generator], Touched]:
    return lambda touched, rng: replace(touched, points=touched.points * factor)


def one_off(touched: Touched, rng: np.random.Generator) -> Touched:
    row, points = rng.integers(len(touched.names)), touched.points.copy()
    points[row] += 1.5 * touched.normals[row]
    return replace(touched, points=points)


def labels_exchanged(touched: Touched, rng: np.random.Generator) -> Touched:
    """The contacts with the labels of two contacts on different features exchanged."""
    names = list(touched.names)
    one = int(rng.integers(len(names)))
    other = int(rng.choice([i for i, name in enumerate(names) if name != names[one]]))
    names[one], names[other] = names[other], names[one]
    return replace(touched, names=tuple(names))


def too_few(touched: Touched, rng: np.random.Generator) -> Touched:
    """Three contacts on each feature, at random places."""
    return _only(touched, lambda name: 3)


def one_feature_short(touched: Touched, rng: np.random.Generator) -> Touched:
    """Two contacts on the first feature, all contacts on the others."""
    return _only(touched, lambda name: 2 if name == touched.names[0] else 9)


def _only(touched: Touched, most: Callable[[str], int]) -> Touched:
    kept = [i for i, name in enumerate(touched.names) if touched.names[:i].count(name) < most(name)]
    parts = {n: getattr(touched, n)[kept] for n in ("points", "normals", "approaches")}
    return replace(touched, names=tuple(touched.names[i] for i in kept), **parts)


def reversed_approaches(touched: Touched, rng: np.random.Generator) -> Touched:
    return replace(touched, approaches=-touched.approaches)


SETS = {
    "nominal": as_touched,
    "noisy": as_touched,
    "noisy, another angle": as_touched,
    "inches": scaled(1 / 25.4),
    "mm for inches": scaled(25.4),
    "one off": one_off,
    "labels exchanged": labels_exchanged,
    "too few": too_few,
    "a feature short": one_feature_short,
    "approaches reversed": reversed_approaches,
}


def problems(kind: str, folder: Path) -> Iterator[tuple[str, Callable[[], tactfix.LocateResult]]]:
    """The ten contact sets of a kind: the name of the change made to each, and a function that locates it."""
    for number, (name, change) in enumerate(SETS.items()):
        rng = np.random.default_rng([number, *kind.encode()])
        part = KINDS[kind].make(angle_of(kind, number, rng))
        base = np.eye(4)
        base[:3, 3] = rng.uniform(-300, 300, 3)
        if name != "nominal":
            base[:3, :3] = Rotation.random(random_state=rng).as_matrix()
        touched = change(touches(part, base, rng, nominal=name == "nominal"), rng)
        noise = None if name == "nominal" else rng.standard_normal(len(touched.names))
        (folder / "fixture.yaml").write_text(by_relations(part))
        (folder / "contacts.csv").write_text(touched.csv(SIGMA, noise))
        fixture = tactfix.load_fixture(folder / "fixture.yaml")
        contacts = tactfix.load_contacts(folder / "contacts.csv", fixture)
        yield name, lambda fixture=fixture, contacts=contacts: tactfix.locate(fixture, contacts)


def main(kinds: list[str]) -> int:
    matrix = np.random.default_rng(1).normal(size=(100, 100))
    unit = best_of_each({"svd": lambda: np.linalg.svd(matrix)}, 30)["svd"]
    rows, worst = [], 0.0
    with tempfile.TemporaryDirectory() as folder:
        for kind in kinds:
            spent: list[tuple[float, str, str]] = []
            for name, work in problems(kind, Path(folder)):
                begun = time.process_time()
                result = work()
                spent.append((time.process_time() - begun, name, result.status))
            times = sorted(spent)
            seconds, name, status = times[-1]
            worst = max(worst, seconds)
            late = sum(t > LONGEST for t, *_ in spent)
            rows.append(
                (kind, f"{1e3 * times[5][0]:.0f}", f"{1e3 * seconds:.0f}", f"{seconds / unit:.0f}", name, status, late)
            )
            print(*rows[-1], file=sys.stderr, flush=True)
    print(heading("Locating fixtures by relations, ten contact sets of each kind") + "\n")
    columns = ("kind", "ms: median", "worst", "x SVD", "which is", "verdict", f"over {LONGEST:g} s")
    print(table(columns, rows))
    return int(worst > LONGEST)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:] or list(KINDS)))
