"""Time to read and locate each shipped fixture in process, as a multiple of one singular value decomposition.

OMP_NUM_THREADS=1 python tests/benchmarks/bench_in_process.py [ROUNDS]
"""

import sys

import numpy as np
from clock import ROOT, best_of_each, heading, table

from tactfix import load_contacts, load_fixture, locate

FIXTURES = ("cylinder-sphere", "three-spheres", "three-planes", "robot-cell-plate", "machine-tool-ball-bar")
MATRIX = np.random.default_rng(1).standard_normal((100, 100))
"""The matrix of the reference decomposition."""


def main(rounds: int) -> None:
    rows = []
    for name in FIXTURES:
        file, contacts_file = ROOT / f"fixtures/{name}.yaml", ROOT / f"samples/{name}/contacts.csv"
        fixture = load_fixture(file)
        contacts = load_contacts(contacts_file, fixture)
        best = best_of_each(
            {
                "svd": lambda: np.linalg.svd(MATRIX),
                "fixture": lambda file=file: load_fixture(file),
                "contacts": lambda path=contacts_file, fixture=fixture: load_contacts(path, fixture),
                "locate": lambda fixture=fixture, contacts=contacts: locate(fixture, contacts),
            },
            rounds,
        )
        status = locate(fixture, contacts).status
        times = (f"{1e3 * best[part]:.2f}" for part in ("fixture", "contacts", "locate"))
        rows.append((f"`{name}`", len(contacts), status, *times, f"{best['locate'] / best['svd']:.1f}"))
    print(heading(f"In process, best of {rounds}") + "\n")
    columns = (
        "fixture",
        "contacts",
        "status",
        "read fixture, ms",
        "read contacts, ms",
        "locate, ms",
        "locate / SVD of 100 x 100",
    )
    print(table(columns, rows))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 30)
