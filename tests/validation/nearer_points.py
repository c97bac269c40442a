"""Coverage of fixtures by relations whose sigma points are computed nearer, since a fold lies at two sigma.

    python -m tests.validation.nearer_points [--problems 2000] [--sigma 0.1]

Parts of `relations_study` with exact relations and contacts of a larger sigma, so that balls on a small cap and short
bars have such a fold more often. Counted are located results and those covered by the 95 per cent ellipsoid, apart for
results whose sigma points are at `joint_sigma_points.NEARER_POINTS` sigma.
"""

import argparse
import tempfile
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np

from tactfix.relations import joint_sigma_points
from tests.validation import relations_study
from tests.validation.relation_geometry import KINDS
from tests.validation.relation_touches import by_relations


def spreads() -> list[int]:
    """The number of distances at which the sigma points of each solution were computed, in order; grows with use."""
    counts: list[int] = []
    curved_spread = joint_sigma_points.curved_spread

    def counted(*given):
        *before, solve, nearer = given
        counts.append(0)

        def solved(steps):
            counts[-1] += 1
            return solve(steps)

        return curved_spread(*before, solved, nearer)

    joint_sigma_points.curved_spread = counted
    return counts


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", type=int, default=2000)
    parser.add_argument("--sigma", type=float, default=0.1, help="of the contacts, mm")
    given = parser.parse_args()
    relations_study.SIGMA = given.sigma
    cells = [c for c in relations_study.cells(list(KINDS)) if c.noisy and c.sigma == 0]
    counts, tallies = spreads(), defaultdict[bool, Counter](Counter)
    rng = np.random.default_rng(20261130)
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(given.problems):
            cell = cells[rng.integers(len(cells))]
            part, touched, noise, _ = relations_study.drawn(cell, seed)
            counts.clear()
            fixture = relations_study.loaded(by_relations(part), Path(folder))
            result = relations_study.located(fixture, touched, noise, Path(folder), explain=False)
            tallies[max(counts, default=0) > 1] += relations_study.judged(result, touched, cell.noisy)
    for nearer, tally in tallies.items():
        print("nearer points:" if nearer else "others:", dict(tally), relations_study.coverage(tally))


if __name__ == "__main__":
    main()
