"""Which contacts the best pose speaks against, and what would be left of chi-square without some of them.

Near the best pose the residuals over sigma run linearly with its motion, r + J d, so that no search is needed to tell
what leaving contacts out can gain:

1. r and an orthonormal basis of the columns of J are taken at the best pose; H is the projection on them.
2. Without contact i chi-square falls by r_i^2 / (1 - H_ii), the square of its normalised residual.
3. That is repeated without the contact that gains most, for a wrong one hides behind those that a worse one pulls away.
4. Without all of a set S chi-square falls by r_S' (I - H_SS)^-1 r_S.

Source: case deletion, Cook and Weisberg, Residuals and Influence in Regression, 1982; for one contact Baarda's data
snooping (`data_snooping`).
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Placement
from tactfix.geometry.arrays import TINY, Floats, Ints
from tactfix.noise import chi_square_limit
from tactfix.poses.pose_fit import SMALLEST_RATIO, sensitivity, with_known
from tactfix.poses.solution import Solution
from tactfix.values import frozen_value

SEEN = 1e-3
"""Share of a residual that no motion of the fixture makes up for, below which leaving the contact out gains nothing."""
DELETIONS_ORDERED = 20
"""Contacts that are ordered with those before them left out; the others are ordered as they then stand."""
ROUGHLY = 4.0
"""Times its limit that chi-square may be without some contacts, while the pose is still where they have pulled it."""


@frozen_value
class Doubts:
    """scaled (n,): residuals over sigma at the best pose; span (n, k): what motions of the fixture do to them.

    The columns of span are orthonormal.
    """

    scaled: Floats
    span: Floats

    @staticmethod
    def of(contacts: Contacts, sigmas: Floats, best: Solution, placement: Placement | None = None) -> "Doubts":
        """At the best pose; sigmas (n,) of the residuals, placement: what is known of the pose beforehand."""
        seen, _ = with_known(sensitivity(contacts, best.normals, sigmas), placement, best.base_from_fixture)
        return Doubts(best.residuals / sigmas, span_of(seen.reduced[: len(contacts)]))  # step 1

    @cached_property
    def normalized(self) -> Floats:
        """Sizes (n,) of the residuals over their own standard deviation after the fit; none where nothing is left."""
        return np.sqrt(self._gains(np.arange(len(self.scaled))))

    @cached_property
    def singly(self) -> list[int]:
        """Indices of the contacts, those first without which, and no other, chi-square would fall most."""
        return [int(i) for i in np.argsort(-self._gains(np.arange(len(self.scaled))), kind="stable")]

    @cached_property
    def order(self) -> list[int]:
        """Indices of the contacts: each of the first the one without which chi-square would fall most, if those before
        it were left out already, for a wrong contact hides behind those that a worse one pulls away; then the others.
        """
        left, chosen = np.arange(len(self.scaled)), []
        for _ in range(min(DELETIONS_ORDERED, len(left) - self.span.shape[1] - 1)):
            worst = int(np.argmax(self._gains(left)))  # step 3
            chosen.append(int(left[worst]))
            left = np.delete(left, worst)
        return chosen + [int(i) for i in left[np.argsort(-self._gains(left), kind="stable")]]

    def _gains(self, left: Ints) -> Floats:
        """How much chi-square of those left (k,) would fall without each of them: r^2 / (1 - leverage)."""
        span = np.linalg.qr(self.span[left])[0]
        residuals = self.scaled[left] - span @ (span.T @ self.scaled[left])
        return np.asarray(residuals**2 / np.maximum(1 - (span**2).sum(axis=1), SEEN))  # step 2

    def gain(self, index: Sequence[int]) -> float:
        """How much chi-square would fall without these contacts."""
        chosen = list(index)
        left = np.eye(len(chosen)) - self.span[chosen] @ self.span[chosen].T
        own = self.scaled[chosen]
        return float(own @ np.linalg.pinv(left, rcond=SEEN, hermitian=True) @ own)  # step 4

    def share_left(self, index: Sequence[int]) -> float:
        """The share of chi-square that would be left without these contacts."""
        return 1 - self.gain(index) / max(float(self.scaled @ self.scaled), TINY)

    def are_all(self, index: Sequence[int]) -> bool:
        """Whether all others would be explained, or nearly, without these contacts."""
        left = float(self.scaled @ self.scaled) - self.gain(index)
        return left <= ROUGHLY * chi_square_limit(len(self.scaled) - len(index) - self.span.shape[1])


def span_of(jacobian: Floats) -> Floats:
    """An orthonormal basis (n, k) of what motions of the fixture do to residuals over sigma; jacobian (n, u)."""
    span, values, _ = np.linalg.svd(jacobian, full_matrices=False)
    return np.asarray(span[:, values > SMALLEST_RATIO * values[0]])
