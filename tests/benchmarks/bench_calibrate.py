"""Time to calibrate all parameters of a seven-axis robot from 552 touches, as a multiple of one SVD.

OMP_NUM_THREADS=1 python -m tests.benchmarks.bench_calibrate [ROUNDS]
"""

import sys

import numpy as np

from tests.benchmarks.clock import best_of_each, heading, table
from tests.calibration.test_real_robots import OFFSETS, motoman

PLANES = ("wall", "higher", "lower")
MATRIX = np.random.default_rng(1).standard_normal((500, 100))
"""The matrix of the reference decomposition."""


def main(rounds: int) -> None:
    works = {
        "svd": lambda: np.linalg.svd(MATRIX, full_matrices=False),
        "joint offsets and tip": lambda: motoman(OFFSETS, PLANES),
        "all parameters": lambda: motoman(("all",), PLANES),
    }
    best = best_of_each(works, rounds)
    print(heading(f"552 touches of three planes, best of {rounds}") + "\n")
    rows = [(name, f"{best[name]:.2f}", f"{best[name] / best['svd']:.0f}") for name in list(works)[1:]]
    print(table(("unknown", "s", "times one SVD of 500 x 100"), rows))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3)
