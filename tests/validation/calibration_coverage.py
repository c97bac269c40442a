"""How often the true parameters of a simulated six-axis robot lie within the 95 per cent intervals of calibrate.

    python -m tests.validation.calibration_coverage [DRAWS] [--seed N]

Each draw is another robot, its errors drawn from the prior, and other touches: three seats at three places, six touches
each, noise of sigma in every direction. The robot's kinematics and its inverse are those of `support.arms`. Errors
are drawn for an independent set of parameters, so that each has one true value; which set that is follows from the
geometry of the arm (Everett and Hsu) and is written out here.
"""

import argparse
import time
from dataclasses import dataclass

import numpy as np

from tactfix.calibration.calibrate import calibrate
from tests.support.arms import SEATS, arm_cell, fixture, touched_seats

SIGMA = 0.05
TOUCHES = 6
_LAST = {f"joint_6.{name}" for name in ("offset", "d", "a", "alpha", "beta")}
HELD = _LAST | {"joint_1.offset", "joint_1.d", "joint_3.d"}
"""Parameters that trade off with where the fixtures stand (joint 1), the tip (joint 6) or a parallel axis (joint 3)."""
NORMAL_95 = 1.959964


@dataclass
class Coverage:
    """What has been counted: calibrated robots, parameters, those within, and refused robots."""

    robots: int = 0
    parameters: int = 0
    within: int = 0
    refused: int = 0

    @property
    def share(self) -> float:
        """Of the parameters, in per cent."""
        return 100.0 * self.within / max(self.parameters, 1)


def coverage(draws: int, seed: int) -> Coverage:
    """Count over so many robots."""
    found = Coverage()
    cell = arm_cell(("all",), {name: fixture(dict(SEATS)) for name in ("front", "left", "high")})
    for draw in range(draws):
        rng = np.random.default_rng([seed, draw])
        errors = {
            p.name: float(rng.normal() * cell.prior.sigma(p)) for p in cell.chain.parameters if p.name not in HELD
        }
        result = calibrate(cell, touched_seats(cell, errors, TOUCHES, SIGMA, rng))
        if result.status != "calibrated":
            found.refused += 1
            continue
        found.robots += 1
        for item in result.parameters:
            if item.sigma > 0:
                true = errors.get(item.name, 0.0) * (180 / np.pi if item.unit == "deg" else 1.0)
                found.parameters += 1
                found.within += abs(item.value - true) <= NORMAL_95 * item.sigma
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("draws", nargs="?", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    said = parser.parse_args()
    start = time.process_time()
    found = coverage(said.draws, said.seed)
    print(f"{found.robots} calibrated, {found.refused} refused, {found.parameters} parameters,", end=" ")
    print(f"{found.share:.2f} per cent within 95 per cent; {time.process_time() - start:.0f} s")


if __name__ == "__main__":
    main()
