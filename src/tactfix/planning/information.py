"""The information matrix of the pose from a set of contacts, and three criteria of optimality.

The residual of a contact with outward normal n at p changes by n . v + (p x n) . w with a motion (w, v), so its row is
[p x n, n] / sigma, and the information of a set is the sum of row row^T; its inverse is the covariance of the pose.
Points are relative to the middle of the fixture in units of its radius, so that all six columns have one unit and the
criteria do not depend on the unit of length. A contact on a point has three such rows, one along each axis.

1. Prior information is added, and constrained motions are projected out; a small ridge makes sets of few contacts
   invertible.
2. With one row more the criterion follows in closed form: the covariance by Sherman and Morrison, the determinant by
   its lemma, the smallest eigenvalue from the secular equation.
3. With several rows more each sum is decomposed.

V. V. Fedorov: Theory of optimal experiments, 1972, for the determinant; G. H. Golub: Some modified matrix eigenvalue
problems, 1973, for the eigenvalue.
"""

from typing import Final, Literal, TypeAlias, get_args

import numpy as np

from tactfix.geometry.arrays import TINY, Floats, Frozen
from tactfix.geometry.rigid import skew
from tactfix.placement import Placement
from tactfix.poses.placement_terms import terms_in_fixture
from tactfix.values import frozen_value

Criterion: TypeAlias = Literal["worst", "d", "e"]
CRITERIA: Final[tuple[Criterion, ...]] = get_args(Criterion)

_RIDGE = 1e-8
"""Information, as a share of one contact's, that makes sets of too few contacts invertible. It changes the sigma of a
motion that one contact determines by 5e-9 of it."""
_BISECTIONS = 24
"""Halvings of the interval in which the smallest eigenvalue of a rank-one update lies: 2^-24 is 6e-8 of it, less
than WORTH_A_STEP (1e-6) of the objective."""


def rows_of(points: Floats, normals: Floats, sigmas: Floats, centre: Floats, radius: float) -> Floats:
    """Rows (n, 6) of contacts at points (n, 3) with unit normals (n, 3) and sigmas (n,): rotation first."""
    arms = (points - centre) / radius
    return np.asarray(np.hstack([np.cross(arms, normals), normals]) / sigmas[:, None])


def flat(rows: Floats) -> Floats:
    """All rows (k, 6) of touches with one row each (m, 6) or several (m, r, 6)."""
    return rows.reshape(-1, 6)


@frozen_value
class Known:
    """The prior on the pose, in the columns of the rows.

    rows (m, 6): those of a measured pose, which counts as six contacts. basis (6, u): the unconstrained motions.
    """

    rows: Frozen
    basis: Frozen

    @property
    def unknowns(self) -> int:
        """The number of unknowns of the pose."""
        return len(self.basis.T)

    @property
    def information(self) -> Floats:
        """The information (6, 6) of the measured pose."""
        return np.asarray(self.rows.T @ self.rows)

    def covariance(self, information: Floats) -> Floats:
        """The covariance (6, 6) of the pose from the information (6, 6) of contacts; 0 for constrained motions."""
        known = self.basis.T @ (information + self.information) @ self.basis
        return np.asarray(self.basis @ np.linalg.solve(known, self.basis.T))


NOTHING_KNOWN: Final = Known(np.zeros((0, 6)), np.eye(6))


def known_of(placement: Placement | None, base_from_fixture: Floats | None, centre: Floats, radius: float) -> Known:
    """The prior of a placement at the pose base_from_fixture (4, 4), in the columns of `rows_of`."""
    if placement is None or base_from_fixture is None:
        return NOTHING_KNOWN
    basis, rows = terms_in_fixture(placement, base_from_fixture, centre, radius)
    return Known(rows, basis)


@frozen_value
class Objective:
    """The criterion that is minimized. corners (k, 3): scaled points of the fixture for "worst".

    known: the prior; constrained motions have no variance, and count in no criterion.

    worst: the largest variance of a corner's position in any direction. d: minus the logarithm of the determinant of
    the information (D-optimal). e: minus its smallest eigenvalue, the square of the rows' smallest singular value.
    """

    criterion: Criterion
    corners: Frozen
    sigma: float
    known: Known = NOTHING_KNOWN

    def scores(self, information: Floats, rows: Floats) -> Floats:
        """The score (m,) of the information (6, 6) with each of the rows (m, 6), or blocks of them (m, r, 6), added."""
        basis = self.known.basis  # step 1
        ridge = _RIDGE / self.sigma**2 * np.eye(self.known.unknowns)
        information = basis.T @ (information + self.known.information) @ basis + ridge
        rows = rows @ basis
        if rows.ndim == 3:  # step 3
            return self._of_sums(information + np.swapaxes(rows, 1, 2) @ rows)
        match self.criterion:  # step 2
            case "worst":
                return self._worst(np.asarray(np.linalg.inv(information)), rows)
            case "d":
                gain = np.log1p(np.einsum("mi,ij,mj->m", rows, np.linalg.inv(information), rows))
                return np.asarray(-np.linalg.slogdet(information)[1] - gain)
            case "e":
                return -smallest_eigenvalues(information, rows)

    def _of_sums(self, information: Floats) -> Floats:
        """The score (m,) of each information (m, u, u)."""
        match self.criterion:
            case "worst":
                seen = self._seen()
                variances = seen @ np.linalg.inv(information)[:, None] @ np.swapaxes(seen, 1, 2)
                return np.asarray(np.linalg.eigvalsh(variances)[..., -1].max(axis=1))
            case "d":
                return np.asarray(-np.linalg.slogdet(information)[1])
            case "e":
                return np.asarray(-np.linalg.eigvalsh(information)[:, 0])

    def _seen(self) -> Floats:
        """Displacements v + w x x of each corner x by the unconstrained motions (k, 3, u)."""
        steady = np.broadcast_to(np.eye(3), (len(self.corners), 3, 3))
        return np.asarray(np.concatenate([-skew(self.corners), steady], axis=2) @ self.known.basis)

    def score(self, information: Floats) -> float:
        """The score of the information (6, 6)."""
        return float(self.scores(information, np.zeros((1, 6)))[0])

    def sigma_of(self, score: float) -> float:
        """The score as a standard deviation: the largest (worst), the geometric mean (d), of the weakest motion (e)."""
        match self.criterion:
            case "worst":
                return float(np.sqrt(score))
            case "d":
                return float(np.exp(score / (2 * self.known.unknowns)))
            case "e":
                return float(1 / np.sqrt(-score)) if score < 0 else np.inf

    def _worst(self, covariance: Floats, rows: Floats) -> Floats:
        # Sherman and Morrison: C - C j j^T C / (1 + j^T C j), seen at each corner.
        seen = self._seen()
        gain = rows @ covariance
        shrink = 1 + (gain * rows).sum(axis=1)
        change = ((gain / np.sqrt(shrink)[:, None]) @ seen.reshape(-1, self.known.unknowns).T).reshape(len(rows), -1, 3)
        variances = seen @ covariance @ np.swapaxes(seen, 1, 2)
        return np.asarray(_largest_eigenvalues(variances, change).max(axis=1))


def _largest_eigenvalues(variances: Floats, change: Floats) -> Floats:
    """Largest eigenvalues (m, k) of variances (k, 3, 3) - change change^T for change (m, k, 3), in closed form.

    The trigonometric solution of the characteristic cubic: exact to rounding for the largest eigenvalue, and a hundred
    times faster than a stack of iterations.
    """
    x, y, z = change[..., 0], change[..., 1], change[..., 2]
    a, b, c = variances[:, 0, 0] - x * x, variances[:, 1, 1] - y * y, variances[:, 2, 2] - z * z
    d, e, f = variances[:, 0, 1] - x * y, variances[:, 0, 2] - x * z, variances[:, 1, 2] - y * z
    mean = (a + b + c) / 3
    a, b, c = a - mean, b - mean, c - mean
    spread = np.sqrt((a * a + b * b + c * c + 2 * (d * d + e * e + f * f)) / 6)
    determinant = a * (b * c - f * f) - d * (d * c - e * f) + e * (d * f - b * e)
    cosine = np.clip(determinant / np.maximum(2 * spread**3, TINY), -1.0, 1.0)
    return np.asarray(mean + 2 * spread * np.cos(np.arccos(cosine) / 3))


def smallest_eigenvalues(information: Floats, rows: Floats) -> Floats:
    """Smallest eigenvalues (m,) of information (u, u) + row row^T for rows (m, u).

    Bisection of the secular equation 1 + sum z_k^2 / (lambda_k - mu) = 0 between the two smallest eigenvalues, which
    interlace those of the update (Golub 1973).
    """
    eigenvalues, vectors = np.linalg.eigh(information)
    z2 = (rows @ vectors) ** 2
    low = np.full(len(rows), eigenvalues[0])
    high = np.minimum(np.append(eigenvalues, np.inf)[1], eigenvalues[0] + z2.sum(axis=1))
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        gaps = eigenvalues - middle[:, None]
        # The sign of the secular function times the only negative gap: no division by a gap of zero.
        above = gaps[:, 0] + z2[:, 0] + gaps[:, 0] * (z2[:, 1:] / np.maximum(gaps[:, 1:], TINY)).sum(1)
        low, high = np.where(above > 0, middle, low), np.where(above > 0, high, middle)
    return np.asarray((low + high) / 2)
