"""Drift: a steady motion that no single check can separate from noise, found in the last checks together.

With motions x_i (6,) since the reference, i = 1 ... n, and weights w_i = (i - m) / sum((i - m)^2), m the mean of i, the
least-squares slope is b = sum(w_i x_i). The weights sum to zero, so the error of the reference, which all checks share,
cancels: without a drift cov(b) = sum(w_i^2 C_i), C_i by the contacts of the i-th check alone. T^2 = b^T cov(b)^-1 b is
then chi-square with 6 degrees of freedom, for any number of checks from three on.

1. The last checks are used, at most WINDOW; fewer than three show no drift.
2. The weights w_i follow from their number.
3. The slope is b, the motion from one check to the next.
4. Its covariance is that of the contacts of each check alone.
5. The probability that T^2 is as large without a drift (p-value) says whether there is one.

H. Hotelling, "Multivariate quality control", in Techniques of Statistical Analysis, McGraw-Hill 1947, for T^2, here
with known covariances; A. F. Bissell, "The performance of control charts and cusums under linear trend", Applied
Statistics 33 (1984) 145-151, for why the charts of single checks and of means are slow to detect a trend.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from tactfix.geometry.arrays import Frozen
from tactfix.pose_formats.comparison import chance_of
from tactfix.values import frozen_value

WINDOW: Final = 30
"""Number of last checks that are used: a drift that begins after a year of rest must not be diluted by that year."""
FEWEST_CHECKS: Final = 3
"""Fewest checks for a slope: of two it is their difference."""
CHANCE: Final = 1e-3
"""p-value below which a drift, or a movement, is significant."""


@frozen_value
class CheckRecord:
    """The record of one check for the history. Lengths in units; motions (rad, units) in base axes, about the origin.

    Parameters
    ----------
    time : str
        ISO 8601 with zone.
    fixture, units : str
        Name of the fixture, and the unit of all lengths.
    reference : (4, 4) array
        The reference pose.
    motion : (6,) array
        Rotation and translation since the reference.
    covariance : (6, 6) array
        Of the motion by the errors of this check's contacts.
    reference_covariance : (6, 6) array
        Of the motion by the error of the reference, which all checks share.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> yesterday = tactfix.locate(fixture, contacts).pose
    >>> tactfix.check(fixture, contacts, yesterday).record.units
    'mm'
    """

    time: str
    fixture: str
    units: str
    reference: Frozen
    motion: Frozen
    covariance: Frozen
    reference_covariance: Frozen


@frozen_value
class Drift:
    """The steady part of the motion over the last checks.

    per_check (6,): rotation (rad) and translation (units) from one check to the next, base axes, about the fixture's
    origin, with covariance (6, 6). chance: the p-value of T^2, None if a component has no variance.
    """

    checks: int
    per_check: Frozen
    covariance: Frozen
    chance: float | None

    @property
    def detected(self) -> bool:
        """Whether the p-value is below CHANCE."""
        return self.chance is not None and self.chance < CHANCE


def drift_of(records: Sequence[CheckRecord]) -> Drift | None:
    """The drift over the last checks, at most WINDOW, of one reference, oldest first; None for fewer than three."""
    if len(records) < FEWEST_CHECKS:
        return None
    last = records[-WINDOW:]  # step 1
    # Step 2.
    weights = np.arange(len(last)) - (len(last) - 1) / 2
    weights /= weights @ weights
    slope = weights @ np.array([record.motion for record in last])  # step 3
    # Steps 4 and 5.
    covariance = np.einsum("i,ijk->jk", weights**2, np.array([record.covariance for record in last]))
    return Drift(len(last), slope, covariance, chance_of(slope, covariance))
