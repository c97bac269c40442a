"""False alarms of good contacts, by chi-square or one contact: python -m tests.validation.false_alarms [draws].

By importance sampling: half of the draws have residuals whose chi-square is near its limit, half have one normalised
residual beyond its limit, and each draw is weighted by its true density. Residuals are computed here to first order in
the noise; the limits are compared with scipy's. Then the same noise is given to locate.
"""

from argparse import ArgumentParser
from collections.abc import Mapping

import numpy as np
from scipy import stats

from tactfix.localization.locate import locate
from tactfix.noise import chi_square_limit, normal_limit
from tests.support.problems import BALLS, CORNER, PLATE, Patch, Truth, placed, touch_all

SIGMA = 0.02
CASES: Mapping[str, tuple[Mapping[str, Patch], int]] = {
    "plate, pin, ball: 9 contacts": (PLATE, 3),
    "plate, pin, ball: 18 contacts": (PLATE, 6),
    "plate, pin, ball: 30 contacts": (PLATE, 10),
    "three balls: 12 contacts": (BALLS, 4),
    "three planes: 9 contacts": (CORNER, 3),
}


class RareNoise:
    """Noise of good contacts near the limits. left (n, d): orthonormal basis of the residuals that no pose removes."""

    def __init__(self, truth: Truth) -> None:
        arms = truth.points - truth.points.mean(axis=0)
        jacobian = np.hstack([np.cross(arms, truth.normals) / np.abs(arms).max(), truth.normals])
        basis = np.linalg.svd(jacobian)[0]
        self.span, self.left = basis[:, :6], basis[:, 6:]
        self.count, self.dof = self.left.shape
        self.units = self.left / np.linalg.norm(self.left, axis=1, keepdims=True)
        self.all, self.one = chi_square_limit(self.dof), normal_limit(self.count)
        assert abs(self.all - stats.chi2.isf(1e-6, self.dof)) < 1e-6
        assert abs(self.one - stats.norm.isf(0.5e-6 / self.count)) < 1e-6
        self.wide = np.sqrt(self.all / self.dof)

    def draw(self, draws: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Residuals over sigma in the basis left (draws, d), and their weights (draws,)."""
        wide = self.wide * rng.standard_normal((draws - draws // 2, self.dof))
        which = self.units[rng.integers(self.count, size=draws // 2)]
        ahead = rng.choice([-1.0, 1.0], draws // 2) * (self.one + rng.exponential(1 / self.one, draws // 2))
        noise = rng.standard_normal((draws // 2, self.dof))
        one = noise + (ahead - (noise * which).sum(axis=1))[:, None] * which
        drawn = np.vstack([wide, one])
        return drawn, 1 / (0.5 * self._wide_density(drawn) + 0.5 * self._one_density(drawn))

    def _wide_density(self, drawn: np.ndarray) -> np.ndarray:
        """Density of the widened normal distribution, over that of the noise."""
        return np.exp((drawn**2).sum(axis=1) / 2 * (1 - 1 / self.wide**2)) / self.wide**self.dof

    def _one_density(self, drawn: np.ndarray) -> np.ndarray:
        """Density of draws with one residual beyond its limit, over that of the noise."""
        sizes = np.abs(drawn @ self.units.T)
        beyond = np.where(sizes > self.one, self.one / 2 * np.exp(-self.one * (sizes - self.one)), 0.0)
        return (beyond / stats.norm.pdf(sizes)).mean(axis=1)

    def alarms(self, drawn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which draws are beyond the limit of chi-square, and which beyond that of one contact."""
        return (drawn**2).sum(axis=1) > self.all, (np.abs(drawn @ self.units.T) > self.one).any(axis=1)


def rate(alarms: np.ndarray, weights: np.ndarray) -> str:
    """The rate in a million, with one standard error."""
    weighed = 1e6 * alarms * weights
    return f"{weighed.mean():.3f} +- {weighed.std() / np.sqrt(len(weighed)):.3f}"


def alarms_of_locate(
    patches: Mapping[str, Patch], truth: Truth, seldom: RareNoise, drawn: np.ndarray, rng
) -> np.ndarray:
    """Which draws locate calls inconsistent."""
    reported = truth.contacts()
    fixture, wrong = placed(patches), []
    for left in drawn:
        noise = SIGMA * (seldom.left @ left + seldom.span @ rng.standard_normal(6))
        contacts = truth.contacts(points=reported.points + noise[:, None] * truth.normals)
        wrong.append(locate(fixture, contacts, explain=False).status == "inconsistent")
    return np.array(wrong)


def main(draws: int, located: int) -> None:
    print("| contacts | chi-square | one contact | either | either, by locate |\n| --- | --- | --- | --- | --- |")
    for name, (patches, each) in CASES.items():
        rng = np.random.default_rng(1)
        truth = touch_all(patches, dict.fromkeys(patches, each), rng, sigma=SIGMA, tip=2.0)
        seldom = RareNoise(truth)
        drawn, weights = seldom.draw(draws, rng)
        above, out = seldom.alarms(drawn)
        rates = [rate(which, weights) for which in (above, out, above | out)]
        drawn, weights = seldom.draw(located, rng)
        rates.append(rate(alarms_of_locate(patches, truth, seldom, drawn, rng), weights) if located else "")
        print(f"| {name} | {' | '.join(rates)} |", flush=True)


if __name__ == "__main__":
    reader = ArgumentParser(description=__doc__)
    reader.add_argument("draws", type=int, nargs="?", default=1_000_000)
    reader.add_argument("--located", type=int, default=1000, help="how many draws locate is asked about")
    arguments = reader.parse_args()
    main(arguments.draws, arguments.located)
