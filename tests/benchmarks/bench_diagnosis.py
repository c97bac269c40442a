"""How long a verdict with a diagnosis takes: every mistake, thirty contacts at most, on every fixture of the study.

    OMP_NUM_THREADS=1 python -m tests.benchmarks.bench_diagnosis [CONTACTS]

Processor seconds on one core, and how many singular value decompositions of 200 x 200 (timed in between, in the same
run) that is; for each mistake the slowest fixture, best of two.
"""

import sys

import numpy as np

from tactfix.localization.locate import locate
from tests.benchmarks.clock import best_of_each, heading, table
from tests.support.problems import placed
from tests.validation.made_mistakes import FIXTURES, MISTAKES

MOST_CONTACTS = 30
ROUNDS = 2


def slowest(mistake: str, matrix: np.ndarray, most: int) -> tuple[float, float, str, int]:
    """Seconds, ratio to the decomposition, fixture and contacts of the slowest verdict on this mistake."""
    found = []
    for name, (patches, counts) in FIXTURES.items():
        each = tuple(most // len(counts) for _ in counts)
        case = MISTAKES[mistake](patches, each, np.random.default_rng(len(name)))
        if case is None:
            continue
        fixture = placed(case.said)
        works = {"verdict": lambda f=fixture, c=case: locate(f, c.contacts), "svd": lambda: np.linalg.svd(matrix)}
        best = best_of_each(works, ROUNDS)
        found.append((best["verdict"], best["verdict"] / best["svd"], name, len(case.contacts)))
    return max(found)


def main() -> None:
    matrix = np.random.default_rng(0).normal(size=(200, 200))
    print(heading("Verdicts with a diagnosis") + "\n")
    most = int(sys.argv[1]) if len(sys.argv) > 1 else MOST_CONTACTS
    rows = []
    for mistake in MISTAKES:
        seconds, ratio, name, count = slowest(mistake, matrix, most)
        rows.append((mistake, name, count, f"{seconds:.2f}", f"{ratio:.0f}"))
    print(table(("mistake", "slowest on", "contacts", "s", "SVDs of 200 x 200"), rows))
    worst = max(rows, key=lambda row: float(row[3]))
    print(f"\nworst: {worst[0]} on {worst[1]}, {worst[3]} s")


if __name__ == "__main__":
    main()
