"""All contacts and all relations at once: least squares over the surfaces of a fixture that is not one rigid body.

Unknown are the displacements of every feature. Contacts and relations with a sigma are observations; relations with
sigma 0 hold exactly. Each step solves  min |r + J d|^2  subject to  c + C d = 0  in the null space of C.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Relation
from tactfix.geometry.arrays import TINY, Floats
from tactfix.geometry.charts import displaced, equations, equations_jacobian
from tactfix.geometry.surfaces import Point, Sphere, Surface
from tactfix.noise import chi_square_limit
from tactfix.relations.equations import all_relations, columns_of

Linear: TypeAlias = tuple[Floats, Floats]
"""Right-hand sides of the linear model: residuals over sigma (m,), and what is missing to the exact relations (k,)."""

MOST_STEPS = 60
MOST_DAMPINGS = 16
LEAST_DAMPING = 1e-12
"""The first damping, as a share of the square of the Jacobian's norm; then ten times that, and so on."""
RANK = 1e-9
REDUNDANT, MOST_REDUNDANT = 10.0, 1e-3
"""Times what is missing to the relations: relations that say the same, such as three axes parallel pair by pair, differ
by so much of their directions as long as they do not hold, and must not be taken for as many different ones."""
TRUSTED_STEP = 1e-6
"""A step this short (rad, fixture sizes) is taken as it is: what the linear model leaves out is rounding."""
HOPELESS = 100.0
"""A fit so many times above its limit that has all but stopped improving is not followed to the last digit."""
LEAST_SIGMA = 1e-12
"""A relation surer than this share of the fixture's size is exact."""


@dataclass(frozen=True, slots=True, eq=False)
class JointProblem:
    """What is known: contacts, sigmas (n,) of their residuals, relations; scale is a length of the fixture.

    wanted: what residuals over sigma, those of the relations with a sigma behind, shall be instead of zero.
    """

    contacts: Contacts
    sigmas: Floats
    relations: tuple[Relation, ...]
    scale: float
    wanted: Floats | float = 0.0


@dataclass(frozen=True, eq=False)
class JointFit:
    """Surfaces of least chi-square, and the linear model there.

    observed (m,): residuals over sigma, less what is wanted, three of a contact on a point; feature by feature, those
    of the relations with a sigma behind. missing: the most by which an exact relation fails (rad, fixture sizes).
    jacobian (m, width) of observed and constraints (k, width), both with lengths in units of scale; columns: where
    each feature's displacement is.
    """

    surfaces: Mapping[str, Surface]
    observed: Floats
    chi2: float
    missing: float
    jacobian: Floats
    constraints: Floats
    columns: Mapping[str, slice]
    lengths: Floats

    @property
    def dof(self) -> int:
        """Observations beyond the unknowns that the constraints leave."""
        return len(self.jacobian) - int(self.span.shape[1])

    @property
    def resolution(self) -> float:
        """Share of the largest singular value of the constraints below which they say nothing new."""
        return min(max(RANK, REDUNDANT * self.missing), MOST_REDUNDANT)

    @cached_property
    def span(self) -> Floats:
        """An orthonormal basis (width, k) of the displacements that keep the exact relations."""
        if not len(self.constraints):
            return np.eye(self.jacobian.shape[1])
        _, values, directions = np.linalg.svd(self.constraints, full_matrices=True)
        rank = int((values > self.resolution * max(values[0], TINY)).sum())
        return np.asarray(directions[rank:].T)

    def spread(self) -> tuple[Floats, Floats]:
        """A factor S (width, m) of the covariance S S^T of all displacements, and what is free (k, width).

        In scaled units; free displacements are left out of S.
        """
        span = self.span
        # The triangle has the singular values of all rows, however many contacts there are.
        triangle = np.linalg.qr(self.jacobian @ span, mode="r")
        _, values, motions = np.linalg.svd(triangle, full_matrices=True)
        known = np.zeros(len(motions), dtype=bool)
        known[: len(values)] = values > RANK * max(values[0] if len(values) else 0.0, TINY)
        factor = span @ motions[known].T / values[known[: len(values)]]
        return np.asarray(factor), np.asarray((span @ motions[~known].T).T)


def joint_fit(problem: JointProblem, surfaces: Mapping[str, Surface]) -> JointFit:
    """Levenberg-Marquardt from surfaces (in base) to the nearest least chi-square with all exact relations kept.

    Without damping a start next to a double root would creep along the direction that nothing resists.
    """
    fit, target = _linearized(problem, surfaces)
    damping = 0.0
    for _ in range(MOST_STEPS):
        size, damping, better = _improved(problem, fit, target, damping)
        if better is None:
            break
        new, target = better
        gain = abs(fit.chi2 - new.chi2)
        settled = size < 1e-9 or (gain <= 1e-13 * new.chi2 and new.missing < 1e-12)
        hopeless = new.chi2 > HOPELESS * chi_square_limit(new.dof) and gain < 0.01 * new.chi2 and new.missing < 1e-9
        fit = new
        if settled or hopeless:
            break
    return _restored(problem, fit, target)


def _improved(
    problem: JointProblem, fit: JointFit, target: Linear, damping: float
) -> tuple[float, float, tuple[JointFit, Linear] | None]:
    """The size of the first step that improves the fit, more and more damped; the next damping; the new fit."""
    stiffness = float(np.linalg.norm(fit.jacobian))
    size = np.inf
    for _ in range(MOST_DAMPINGS):
        step, price = _step(fit, *target, damping)
        size = float(np.abs(step).max(initial=0.0))
        step = step * min(1.0, 0.5 / max(size, TINY))
        new, new_target = _linearized(problem, _displaced(fit, step))
        if _merit(new, price, stiffness) < _merit(fit, price, stiffness) or size < TRUSTED_STEP:
            return size, damping / 10 if damping > LEAST_DAMPING * stiffness**2 else 0.0, (new, new_target)
        damping = max(10 * damping, LEAST_DAMPING * stiffness**2)
    return size, damping, None


def _restored(problem: JointProblem, fit: JointFit, target: Linear) -> JointFit:
    """The fit moved onto the exact relations by the shortest way, where they do not quite hold yet."""
    for _ in range(3):
        if fit.missing < 1e-13:
            break
        onto = np.linalg.lstsq(fit.constraints, -target[1], rcond=fit.resolution)[0]
        fit, target = _linearized(problem, _displaced(fit, onto * min(1.0, 0.5 / np.abs(onto).max())))
    return fit


def fit_at(problem: JointProblem, fit: JointFit, step: Floats) -> JointFit:
    """The fit as it stands after a step (width,) in scaled units, moved onto the exact relations."""
    return _restored(problem, *_linearized(problem, _displaced(fit, step)))


def _merit(fit: JointFit, price: float, stiffness: float) -> float:
    """Chi-square and, in the same coin, what is missing to the exact relations.

    price is above the Lagrange multipliers, so that giving up a relation never pays (exact penalty); the square keeps
    far starts from buying chi-square with relations.
    """
    return fit.chi2 + price * fit.missing + (stiffness * fit.missing) ** 2


def _displaced(fit: JointFit, step: Floats) -> dict[str, Surface]:
    return {
        name: displaced(surface, step[fit.columns[name]] * fit.lengths[fit.columns[name]])
        for name, surface in fit.surfaces.items()
    }


def _linearized(problem: JointProblem, surfaces: Mapping[str, Surface]) -> tuple[JointFit, Linear]:
    """The fit as it stands, and the right-hand sides: residuals over sigma, and what is missing to exact relations."""
    columns, width = columns_of(surfaces)
    lengths = _lengths(surfaces, columns, width, problem.scale)
    contacts = problem.contacts
    observed, observed_rows = [], []
    for name, index in contacts.by_feature.items():
        weights = 1 / problem.sigmas[index, None]
        observed.append((weights * equations(surfaces[name], contacts.points[index], contacts.tip_radius)).ravel())
        own = weights[..., None] * equations_jacobian(surfaces[name], contacts.points[index])
        observed_rows.append(np.zeros((len(observed[-1]), width)))
        observed_rows[-1][:, columns[name]] = own.reshape(len(observed[-1]), -1)
    exact, exact_rows = [np.zeros(0)], [np.zeros((0, width))]
    linear = all_relations(problem.relations, surfaces, problem.scale)
    for relation, (value, jacobian) in zip(problem.relations, linear, strict=True):
        unit = problem.scale if relation.kind == "distance" else 1.0
        if relation.sigma > LEAST_SIGMA * unit:
            observed.append(value / relation.sigma)
            observed_rows.append(jacobian / relation.sigma)
        else:
            exact.append(value / unit)
            exact_rows.append(jacobian / unit)
    residual, missing = np.concatenate(observed) - problem.wanted, np.concatenate(exact)
    fit = JointFit(
        surfaces=surfaces,
        observed=residual,
        chi2=float((residual**2).sum()),
        missing=float(np.abs(missing).max(initial=0.0)),
        jacobian=np.vstack(observed_rows) * lengths,
        constraints=np.vstack(exact_rows) * lengths,
        columns=columns,
        lengths=lengths,
    )
    return fit, (residual, missing)


def _lengths(surfaces: Mapping[str, Surface], columns: Mapping[str, slice], width: int, scale: float) -> Floats:
    """What one unit of each displacement is: 1 rad for tilts, the fixture's scale for shifts."""
    lengths = np.full(width, scale)
    for name, surface in surfaces.items():
        if not isinstance(surface, Sphere | Point):
            lengths[columns[name].start : columns[name].start + 2] = 1.0
    return lengths


def _step(fit: JointFit, residual: Floats, missing: Floats, damping: float) -> tuple[Floats, float]:
    """The displacement that the linearised problem asks for, in scaled units, and twice what the relations cost there.

    That cost is the sum of the Lagrange multipliers: the chi-square that is lost per unit of what is missing.
    """
    width = fit.jacobian.shape[1]
    onto = np.linalg.lstsq(fit.constraints, -missing, rcond=fit.resolution)[0] if len(missing) else np.zeros(width)
    span = fit.span
    rows, right = fit.jacobian @ span, -(residual + fit.jacobian @ onto)
    if damping > 0:
        free = rows.shape[1]
        rows, right = np.vstack([rows, np.sqrt(damping) * np.eye(free)]), np.concatenate([right, np.zeros(free)])
    within = np.linalg.lstsq(rows, right, rcond=RANK)[0]
    step = np.asarray(onto + span @ within, dtype=np.float64)
    if not len(missing):
        return step, 0.0
    pull = 2 * fit.jacobian.T @ (residual + fit.jacobian @ step)
    return step, 2 * float(np.abs(np.linalg.lstsq(fit.constraints.T, pull, rcond=fit.resolution)[0]).sum())
