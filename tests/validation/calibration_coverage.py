"""Coverage of the 95 per cent intervals of calibrate for the parameters of simulated six-axis robots.

    python -m tests.validation.calibration_coverage [DRAWS] [--seed N]

Each draw is another robot with errors drawn from the prior, and other touches: three seats at three places, six touches
each, noise of sigma in every direction. The kinematics and their inverse are those of `support.arms`. Errors are drawn
for an independent set of parameters, so that each has a unique true value; this set follows from the geometry of the
arm (Everett and Hsu) and is written out here.
"""

import argparse
import time
from dataclasses import dataclass, field

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
    """Counts: calibrated robots, rejected robots, and by kind of parameter whether each was within its interval."""

    robots: int = 0
    refused: int = 0
    within: dict[str, list[bool]] = field(default_factory=dict)

    def __str__(self) -> str:
        kinds = [f"{share(within)} of {len(within)} by kind {kind}" for kind, within in self.within.items()]
        every = [inside for within in self.within.values() for inside in within]
        head = f"{self.robots} calibrated, {self.refused} refused; {share(every)} of {len(every)} parameters"
        return f"{head} within 95 per cent ({', '.join(kinds)})"


def share(within: list[bool]) -> str:
    """The coverage in per cent."""
    return f"{100.0 * np.mean(within):.2f}" if within else "none"


def coverage(draws: int, seed: int) -> Coverage:
    """Count over this number of robots."""
    found = Coverage()
    cell = arm_cell(("all",), {name: fixture(dict(SEATS)) for name in ("front", "left", "high")})
    kinds = {parameter.name: parameter.kind for parameter in cell.parameters}
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
                inside = abs(item.value - true) <= NORMAL_95 * item.sigma
                found.within.setdefault(kinds[item.name], []).append(inside)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("draws", nargs="?", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    start = time.process_time()
    found = coverage(arguments.draws, arguments.seed)
    print(f"{found}; {time.process_time() - start:.0f} s")


if __name__ == "__main__":
    main()
