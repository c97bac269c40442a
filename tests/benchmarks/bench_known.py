"""Time of locate in process with prior knowledge of the pose (limits, a measured pose), and with an unknown tip.

OMP_NUM_THREADS=1 python -m tests.benchmarks.bench_known [ROUNDS]
"""

import sys
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from itertools import cycle, islice, product

import numpy as np
from scipy.spatial.transform import Rotation

from tactfix import Contacts, Fixture, load_contacts, load_fixture, locate
from tactfix.placement import Placement
from tests.benchmarks.clock import ROOT, best_of_each, heading, table
from tests.support.flange_touches import PLATE, fixture_of
from tests.support.problems import BALLS, CORNER, Patch, placed, touch_all
from tests.support.problems import PLATE as SUPPORT_PLATE
from tests.unknowns.test_unknown_tip import plate_problem

MATRIX = np.random.default_rng(1).standard_normal((100, 100))
"""The matrix of the reference decomposition."""
NAMES = ("cylinder-sphere", "three-spheres", "three-planes", "robot-cell-plate", "machine-tool-ball-bar")


def main(rounds: int) -> None:
    problem = plate_problem(1, 4, 45.0)
    cell, contacts = fixture_of(PLATE), problem.contacts
    works = {
        "svd": lambda: np.linalg.svd(MATRIX),
        "tip known": lambda: locate(cell, contacts.with_tip(problem.tip - contacts.tip_offset, 3.0)),
        "tip unknown": lambda: locate(cell, contacts, unknown=["tip"]),
    }
    best = best_of_each(works, rounds)
    print(heading(f"In process, best of {rounds}") + "\n")
    rows = [
        (name, len(contacts), f"{1e3 * best[name]:.1f}", f"{best[name] / best['svd']:.1f}")
        for name in ("tip known", "tip unknown")
    ]
    print(table(("plate, pin and ball, four tool orientations", "contacts", "ms", "x SVD of 100 x 100"), rows))
    rows = []
    for name in NAMES:
        fixture = load_fixture(ROOT / f"fixtures/{name}.yaml")
        touched = load_contacts(ROOT / f"samples/{name}/contacts.csv", fixture)
        found = locate(fixture, touched)
        scale = touched.spread / 10
        yesterday = {
            "within": Placement(found.base_from_fixture, (scale, np.radians(5))),
            "sigma": Placement(found.base_from_fixture, sigma=found.covariance),
        }
        works = {"svd": lambda: np.linalg.svd(MATRIX), "without": lambda f=fixture, c=touched: locate(f, c)}
        for how, placement in yesterday.items():
            placed = replace(fixture, placement=placement)
            # A measured pose requires a rigid fixture.
            if how == "within" or fixture.is_placed:
                works[how] = lambda f=placed, c=touched: locate(f, c)
        best = best_of_each(works, rounds)
        ratios = (f"{best[how] / best['without']:.2f}" if how in best else "" for how in yesterday)
        rows.append((f"`{name}`", f"{1e3 * best['without']:.1f}", f"{best['without'] / best['svd']:.1f}", *ratios))
    columns = ("fixture", "without, ms", "x SVD of 100 x 100", "with limits, x without", "measured, x without")
    print("\n" + table(columns, rows))
    print("\n" + table(("contacts", "slowest, ms", "x SVD of 100 x 100"), few_contacts(best["svd"])))


def few_contacts(unit: float) -> list[tuple[str, ...]]:
    """One to six contacts and a pose measured to 50 mm and 0.3 rad: the slowest of twelve problems for each count."""
    rows = []
    for count in (1, 2, 3, 4, 6):
        took = 0.0
        for patches, seed in product((CORNER, SUPPORT_PLATE, BALLS), range(4)):
            fixture, contacts = badly_measured(patches, count, np.random.default_rng(seed))
            begun = time.process_time()
            locate(fixture, contacts)
            took = max(took, time.process_time() - begun)
        rows.append((str(count), f"{1e3 * took:.0f}", f"{took / unit:.0f}"))
    return rows


def badly_measured(patches: Mapping[str, Patch], count: int, rng: np.random.Generator) -> tuple[Fixture, Contacts]:
    """A fixture whose pose was measured to 50 mm and 0.3 rad, and this number of contacts."""
    counts = Counter(islice(cycle(patches), count))
    truth = touch_all(patches, counts, rng, sigma=0.05)
    off = rng.standard_normal(6) * ([0.3] * 3 + [50.0] * 3)
    near = truth.pose.copy()
    near[:3, :3] = Rotation.from_rotvec(off[:3]).as_matrix() @ near[:3, :3]
    near[:3, 3] += off[3:]
    return replace(placed(patches), placement=Placement(near, sigma=(50.0, 0.3))), truth.contacts(rng)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 30)
