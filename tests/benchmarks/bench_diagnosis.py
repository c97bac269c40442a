"""Time of locate with a diagnosis: every mistake on every fixture of the study, at most thirty contacts.

    OMP_NUM_THREADS=1 python -m tests.benchmarks.bench_diagnosis [CONTACTS]

For each mistake the slowest fixture, best of two runs: processor seconds on one core, and the same as a multiple of a
200 x 200 singular value decomposition that is timed in the same run.
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
    """The slowest diagnosis of this mistake: seconds, ratio to the decomposition, fixture and number of contacts."""
    found = []
    for name, (patches, counts) in FIXTURES.items():
        each = tuple(most // len(counts) for _ in counts)
        case = MISTAKES[mistake](patches, each, np.random.default_rng(len(name)))
        if case is None:
            continue
        fixture = placed(case.in_file)
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
