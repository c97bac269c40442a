"""Data snooping: touches whose residual is larger than noise makes any, one after the other.

The residual of a touch, over the standard deviation that it has after the fit, is standard normal if its error is.

1. The linearised equations of robot and places stand side by side, the rows of the prior below them.
2. The rows kept are fitted anew by the linear model; each residual is taken over its own standard deviation.
3. The search ends where the largest is no more than chance gives in one set of touches of a million, as wide as the
   variance of the rest has it, or where a tenth of the touches is set aside.
4. Else its touch is set aside with all its rows, and the rest is looked at again.

W. Baarda: A testing procedure for use in geodetic networks, 1968.
"""

from statistics import NormalDist
from typing import Final

import numpy as np

from tactfix.calibration.equations import Group
from tactfix.calibration.estimation import Eliminated
from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.noise import REJECTED_IN_ERROR

_MOST_SET_ASIDE: Final = 0.1
"""Of the touches, that can be set aside: with more the rest says nothing of what is right."""


def outliers(
    groups: tuple[Group, ...], parts: tuple[Eliminated, ...], values: Floats, prior: Floats, free: Bools
) -> tuple[tuple[int, ...], float]:
    """The data rows of suspicious touches, the worst first, and the variance factor of the others.

    parts: linearised at values (m,). prior (m,): its sigmas.
    """
    rows, design, owner = _stacked(groups, parts, values, prior, free)  # step 1
    kept = np.ones(len(rows), dtype=bool)
    named: list[int] = []
    count = sum(len(group.touches) for group in groups)
    limit = -NormalDist().inv_cdf(REJECTED_IN_ERROR / count / 2)
    while True:
        normalised, variance = _normalised(rows, design, kept)  # step 2
        worst = int(np.argmax(np.where(kept & (owner >= 0), np.abs(normalised), -1.0)))
        scale = np.sqrt(max(variance, 1.0))
        if len(named) >= _MOST_SET_ASIDE * count or abs(normalised[worst]) <= limit * scale:
            return tuple(named), variance  # step 3
        named.append(int(owner[worst]))  # step 4
        kept &= owner != owner[worst]


def _stacked(
    groups: tuple[Group, ...], parts: tuple[Eliminated, ...], values: Floats, prior: Floats, free: Bools
) -> tuple[Floats, Floats, Ints]:
    """Rows, the design with robot and places side by side, and the data row that owns each (-1: none)."""
    robot = np.concatenate([part.block.robot[:, free] for part in parts])
    places = np.zeros((len(robot), sum(part.block.place.shape[1] for part in parts)))
    first = column = 0
    owner = []
    for group, part in zip(groups, parts, strict=True):
        size, width = part.block.place.shape
        places[first : first + size, column : column + width] = part.block.place
        first, column = first + size, column + width
        rows = np.array([*group.touches.rows, -1])
        owner.append(rows[part.block.touch])
    believed = np.hstack([np.diag(1 / prior[free]), np.zeros((int(free.sum()), places.shape[1]))])
    design = np.vstack([np.hstack([robot, places]), believed])
    missed = [*(part.block.residuals for part in parts), values[free] / prior[free]]
    held = np.full(int(free.sum()), -1)
    return np.concatenate(missed), design, np.concatenate([*owner, held])


def _normalised(rows: Floats, design: Floats, kept: Bools) -> tuple[Floats, float]:
    """Residuals over their own standard deviation after a linear refit of the rows kept, and their variance factor."""
    basis, values, _ = np.linalg.svd(design[kept], full_matrices=False)
    basis = basis[:, values > 1e-9 * values[0]]
    left = rows[kept] - basis @ (basis.T @ rows[kept])
    redundancy = np.maximum(1 - (basis**2).sum(axis=1), 1e-6)
    found = np.zeros(len(rows))
    found[kept] = left / np.sqrt(redundancy)
    freedom = max(float(redundancy.sum()), 1.0)
    return found, float(left @ left / freedom)
