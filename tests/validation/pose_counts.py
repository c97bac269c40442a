"""The number of complex poses of six contacts on four or more features.

`monodromy` generates a problem of the kind with one root and tracks closed loops of problems until several successive
loops find nothing new. That does not prove a count, but a count is shipped (src/tactfix/design/pose_counts.json) only
if two problems of the kind, from different seeds, agree. Kinds of two and three features are in `kinds`.

    pip install '.[study]'
    python -m tests.validation.pose_counts [kind ...]          (without a kind all)
"""

import sys
from collections.abc import Iterator
from itertools import product
from time import process_time

import numpy as np

from tests.validation import compiled_paths
from tests.validation.kinds import KINDS, TYPE_ORDER, kind_of
from tests.validation.monodromy import solve_by_monodromy

IDLE, LOOPS = 6, 40
# Six contacts on four or more features, so at most three on one feature.
SHARES = ((3, 1, 1, 1), (2, 2, 1, 1), (2, 1, 1, 1, 1), (1, 1, 1, 1, 1, 1))


def kinds() -> Iterator[str]:
    """Every kind of four features or more, the fewest cylinders first."""
    found = {
        kind_of(list(zip(types, counts, strict=True)))
        for counts in SHARES
        for types in product(TYPE_ORDER, repeat=len(counts))
    }
    yield from sorted(found - set(KINDS), key=lambda kind: (kind.count("cylinder"), kind))


def main(names: list[str]) -> None:
    for kind in names or kinds():
        start, counts = process_time(), []
        for seed in (1, 2):
            found = solve_by_monodromy(kind, np.random.default_rng(seed), IDLE, LOOPS, compiled_paths.track)
            counts.append(len(found.roots) if found.idle_loops == IDLE else None)
        print(f"{kind:60s} {counts[0]} {counts[1]} {process_time() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
