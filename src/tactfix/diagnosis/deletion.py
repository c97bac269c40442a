"""Case deletion: by how much chi-square falls when some contacts are left out, to first order at the best pose.

Near the best pose the residuals over sigma are linear in a small motion d of the fixture, r + J d. So the fall of
chi-square follows from r and J, without a new search:

1. r and an orthonormal basis of the columns of J are taken at the best pose; H is the projection on them.
2. Without contact i chi-square falls by r_i^2 / (1 - H_ii), the square of its normalised residual.
3. The contact with the largest fall is deleted and step 2 is repeated: one gross error can mask a second one.
4. Without all of a set S chi-square falls by r_S' (I - H_SS)^-1 r_S.

Source: case deletion, Cook and Weisberg, Residuals and Influence in Regression, 1982; for one contact Baarda's data
snooping (`data_snooping`).
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import TINY, Floats, Ints
from tactfix.noise import chi_square_limit
from tactfix.placement import Placement
from tactfix.poses.pose_fit import SMALLEST_RATIO, sensitivity, with_known
from tactfix.poses.solution import Solution
from tactfix.values import frozen_value

LEAST_REDUNDANCY = 1e-3
"""Smallest redundancy number 1 - H_ii (no unit) that a contact is taken to have. A contact with less fixes a motion of
the fixture nearly alone: its residual is nearly zero whatever its error is, and r_i^2 / (1 - H_ii) is noise divided by
noise."""
DELETIONS_ORDERED = 20
"""Contacts that are deleted one after the other; the rest are ordered by one deletion each. As many as the largest of
`staged.JOINT_DELETIONS`, so that gross errors that mask each other are all found. Only masking makes a
difference: 5, 10 and 40 give the same diagnoses of the 42 sets of `staged`."""
ROUGH_LIMIT = 4.0
"""Times its limit that chi-square of the others may be after a deletion, by the linear model at a pose that the deleted
contacts have displaced. 2 and 8 give the same diagnoses of the 42 sets of `staged`."""
DELETION_REGULARIZATION = 1e-9
"""Added to the diagonal of I - H_SS (no unit), which is singular if the contacts of a set are the only ones to fix a
motion. Far above rounding, far below any redundancy number that counts."""


@frozen_value
class CaseDeletion:
    """scaled (n,): residuals over sigma at the best pose; span (n, k): an orthonormal basis of the columns of J."""

    scaled: Floats
    span: Floats

    @staticmethod
    def of(contacts: Contacts, sigmas: Floats, best: Solution, placement: Placement | None = None) -> "CaseDeletion":
        """At the best pose; sigmas (n,) of the residuals, placement: what is known of the pose beforehand."""
        seen, _ = with_known(sensitivity(contacts, best.normals, sigmas), placement, best.base_from_fixture)
        return CaseDeletion(best.residuals / sigmas, span_of(seen.reduced[: len(contacts)]))  # step 1

    @cached_property
    def normalized(self) -> Floats:
        """Absolute normalised residuals (n,): residuals over their own standard deviation after the fit."""
        return np.sqrt(self._gains(np.arange(len(self.scaled))))

    @cached_property
    def singly(self) -> list[int]:
        """Indices of the contacts, in decreasing order of the fall of chi-square when that contact alone is deleted."""
        return [int(i) for i in np.argsort(-self._gains(np.arange(len(self.scaled))), kind="stable")]

    @cached_property
    def order(self) -> list[int]:
        """Indices of the contacts in the order of stepwise deletion (step 3), the others behind them.

        Each of the first is the contact with the largest fall of chi-square after those before it have been deleted.
        """
        left, chosen = np.arange(len(self.scaled)), []
        for _ in range(min(DELETIONS_ORDERED, len(left) - self.span.shape[1] - 1)):
            worst = int(np.argmax(self._gains(left)))  # step 3
            chosen.append(int(left[worst]))
            left = np.delete(left, worst)
        return chosen + [int(i) for i in left[np.argsort(-self._gains(left), kind="stable")]]

    def _gains(self, left: Ints) -> Floats:
        """The fall of the chi-square of those left (k,) when each of them is deleted: r^2 / (1 - leverage)."""
        span = np.linalg.qr(self.span[left])[0]
        residuals = self.scaled[left] - span @ (span.T @ self.scaled[left])
        return np.asarray(residuals**2 / np.maximum(1 - (span**2).sum(axis=1), LEAST_REDUNDANCY))  # step 2

    def gain(self, index: Sequence[int]) -> float:
        """The fall of chi-square when these contacts are deleted together."""
        chosen = list(index)
        left = np.eye(len(chosen)) - self.span[chosen] @ self.span[chosen].T
        own = self.scaled[chosen]
        return float(own @ np.linalg.pinv(left, rcond=LEAST_REDUNDANCY, hermitian=True) @ own)  # step 4

    def remaining_share(self, index: Sequence[int]) -> float:
        """The share of chi-square that remains when these contacts are deleted."""
        return 1 - self.gain(index) / max(float(self.scaled @ self.scaled), TINY)

    def is_explained_without(self, index: Sequence[int]) -> bool:
        """Whether the other contacts are consistent, to within ROUGH_LIMIT, when these are deleted."""
        left = float(self.scaled @ self.scaled) - self.gain(index)
        return left <= ROUGH_LIMIT * chi_square_limit(len(self.scaled) - len(index) - self.span.shape[1])


def span_of(jacobian: Floats) -> Floats:
    """An orthonormal basis (n, k) of the columns of the Jacobian (n, u) of the residuals over sigma."""
    span, values, _ = np.linalg.svd(jacobian, full_matrices=False)
    return np.asarray(span[:, values > SMALLEST_RATIO * values[0]])


def falls_without(residuals: Floats, span: Floats, sets: Ints) -> Floats:
    """The fall (s,) of chi-square when each of the sets (s, k) of equations is deleted; residuals (n,) over sigma.

    span (n, u): an orthonormal basis of the columns of their Jacobian. All sets at once, step 4 for each.
    """
    own = residuals - span @ (span.T @ residuals)
    left = np.eye(len(own)) - span @ span.T + DELETION_REGULARIZATION * np.eye(len(own))
    gains = np.linalg.solve(left[sets[:, :, None], sets[:, None, :]], own[sets][..., None])[..., 0]
    return np.asarray(np.einsum("si,si->s", own[sets], gains))
