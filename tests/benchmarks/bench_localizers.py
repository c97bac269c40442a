"""Time of the localizers, as multiples of a batch of 6x6 eigenvalue problems timed in the same run.

    OMP_NUM_THREADS=1 python -m tests.benchmarks.bench_localizers

Every figure is the best of several runs, in processor time, on one core. The eigenvalues of a 6x6 matrix are the least
cost of a cylinder through five contacts if it is computed by a companion or action matrix.
"""

import time

import numpy as np

from tactfix.localizers.cylinder import localize_cylinder
from tactfix.localizers.plane import localize_plane
from tactfix.localizers.sphere import localize_sphere
from tactfix.stacks.five_contact_cylinders import cylinders_through_five
from tactfix.stacks.sphere_centers import sphere_centers
from tests.support.common_tangents import tangent_lines

BULK, REPEATS = 16_384, 15


def best(call, repeats=REPEATS):
    """Processor seconds of the fastest of several calls."""
    call()
    times = []
    for _ in range(repeats):
        began = time.process_time_ns()
        call()
        times.append((time.process_time_ns() - began) * 1e-9)
    return min(times)


def bars(rng, count, n):
    """n contacts on each of count unit cylinders in random directions."""
    angle, z = rng.uniform(0, 2 * np.pi, (count, n)), rng.uniform(-1, 1, (count, n))
    q, _ = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    return np.stack([np.cos(angle), np.sin(angle), z], axis=-1) @ np.swapaxes(q, -1, -2)


def balls(rng, count, n):
    v = rng.normal(size=(count, n, 3))
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def main():
    rng = np.random.default_rng(0)
    matrices = rng.normal(size=(BULK // 8, 6, 6))
    yardstick = best(lambda: np.linalg.eigvals(matrices)) / len(matrices)
    print(f"6x6 eigenvalues, numpy, in a batch: {yardstick * 1e6:.2f} us each (the yardstick)\n")
    print(f"{'in bulk':45} {'us each':>9} {'a second':>11} {'yardsticks':>11}")
    fives, threes = bars(rng, BULK, 5), balls(rng, 4 * BULK, 3)
    for name, call, count in (
        ("cylinder, 5 contacts, all of up to six", lambda: cylinders_through_five(fives), BULK),
        ("sphere, 3 contacts, both centres", lambda: sphere_centers(threes, 1.0), 4 * BULK),
    ):
        each = best(call) / count
        print(f"{name:45} {each * 1e6:9.3f} {1 / each:11,.0f} {each / yardstick:11.3f}")
    print(f"\n{'one at a time':45} {'ms':>9} {'':>11} {'yardsticks':>11}")
    noise = 1e-4
    for name, kind, n, radius in (
        ("plane, 3 contacts", "plane", 3, None),
        ("sphere, 3 contacts, radius known", "sphere", 3, 1.0),
        ("sphere, 20 contacts", "sphere", 20, None),
        ("cylinder, 4 contacts, radius known", "cylinder", 4, 1.0),
        ("cylinder, 5 contacts, radius known", "cylinder", 5, 1.0),
        ("cylinder, 5 contacts", "cylinder", 5, None),
        ("cylinder, 12 contacts", "cylinder", 12, None),
        ("cylinder, 12 contacts, radius known", "cylinder", 12, 1.0),
        ("cylinder, 1000 contacts", "cylinder", 1000, None),
        ("cylinder, 10000 contacts", "cylinder", 10_000, None),
    ):
        sets = (bars if kind == "cylinder" else balls)(rng, 6, n)
        sets = sets + noise * rng.normal(size=sets.shape) if n > 5 else sets
        each = best(lambda kind=kind, sets=sets, radius=radius: [_one(kind, x, radius, noise) for x in sets], 4) / len(
            sets
        )
        print(f"{name:45} {each * 1e3:9.2f} {'':11} {each / yardstick:11.0f}")
    centers = rng.normal(size=(6, 4, 3))
    each = best(lambda: [tangent_lines(c, np.full(4, 0.8)) for c in centers], 4) / len(centers)
    print(f"{'tangent lines of 4 spheres':45} {each * 1e3:9.2f} {'':11} {each / yardstick:11.0f}")


def _one(kind, points, radius, sigma):
    if kind == "plane":
        return localize_plane(points, sigma)
    return (localize_sphere if kind == "sphere" else localize_cylinder)(points, radius, sigma)


if __name__ == "__main__":
    main()
