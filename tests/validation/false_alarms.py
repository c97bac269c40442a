"""How often good contacts do not fit, by chi-square or one contact: python -m tests.validation.false_alarms.

Residuals are noise projected off the six directions of a pose, written here; the limits are scipy's.
"""

import numpy as np
from scipy import stats

from tactfix.noise import chi_square_limit, normal_limit
from tests.support.problems import PLATE, touch_all

DRAWS, CHUNK = 40_000_000, 1_000_000


def main() -> None:
    truth = touch_all(PLATE, {"plate": 6, "pin": 6, "ball": 6}, np.random.default_rng(0), sigma=0.02, tip=2.0)
    points = truth.points - truth.points.mean(axis=0)
    jacobian = np.hstack([np.cross(points, truth.normals) / 100.0, truth.normals])
    # An orthonormal basis of what a pose leaves of the residuals: chi-square is that of twelve normal numbers.
    left = np.linalg.svd(jacobian)[0][:, 6:]
    sizes = np.linalg.norm(left, axis=1)
    assert abs(chi_square_limit(12) - stats.chi2.isf(1e-6, 12)) < 1e-6
    rng = np.random.default_rng(1)
    sums = alone = either = 0
    for _ in range(DRAWS // CHUNK):
        noise = rng.standard_normal((CHUNK, 12), dtype=np.float32)
        above = (noise**2).sum(axis=1) > chi_square_limit(12)
        out = (np.abs(noise @ left.T.astype(np.float32)) > normal_limit(18) * sizes.astype(np.float32)).any(axis=1)
        sums, alone, either = sums + above.sum(), alone + out.sum(), either + (above | out).sum()
    share = 1e6 * either / DRAWS
    print(f"of {DRAWS:,}: chi-square {sums}, one contact {alone}, either {either}: {share:.2f} in a million")


if __name__ == "__main__":
    main()
