"""The least-squares problem of a fixture that is not one rigid body, and its linear model.

The unknowns are the displacements of every feature. Contacts, and relations with a sigma, are observations; relations
with sigma 0 are constraints.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Relation
from tactfix.geometry.arrays import TINY, Floats
from tactfix.geometry.charts import displaced, equations, equations_jacobian
from tactfix.geometry.surfaces import Surface
from tactfix.relations.equations import Equation, carried, chart_lengths, columns_of, linear_equations
from tactfix.values import frozen_value

CONSTRAINT_RANK = 1e-9
"""Ratio of singular values of the constraint Jacobian below which constraints that hold are dependent. The rounding of
unit vectors gives a ratio of about 1e-15."""
REDUNDANT, MOST_REDUNDANT = 10.0, 1e-3
"""Rank tolerance of the constraint Jacobian: REDUNDANT times the current constraint violation, at most MOST_REDUNDANT.
Redundant constraints, such as three axes parallel pair by pair, have slightly different gradients until they hold, and
must count once."""
LEAST_SIGMA = 1e-12
"""Relations with a sigma below this share of the fixture's size are taken as exact. As observations their rows would be
many orders of magnitude larger than those of contacts, and rounding would decide the fit."""


@frozen_value
class JointProblem:
    """The data: contacts, sigmas (n,) of their residuals, relations; scale: a length of the fixture.

    wanted: target values of the residuals over sigma, those of contacts first, then those of relations with a sigma.
    """

    contacts: Contacts
    sigmas: Floats
    relations: tuple[Relation, ...]
    scale: float
    wanted: Floats | float = 0.0


@frozen_value
class JointFit:
    """Surfaces of least chi-square for one choice of branches, and the linear model there.

    equations: of the relations, with bases at these surfaces. observed (m,): residuals over sigma less their targets,
    three for a contact on a point, feature by feature; then those of the relations with a sigma. violation (k,): the
    residuals of the constraints (rad, fixture sizes). jacobian (m, width) of observed and constraints (k, width), both
    with lengths in units of scale; columns: of each feature's displacement.
    """

    surfaces: Mapping[str, Surface]
    equations: tuple[Equation, ...]
    observed: Floats
    violation: Floats
    jacobian: Floats
    constraints: Floats
    columns: Mapping[str, slice]
    lengths: Floats

    @cached_property
    def chi2(self) -> float:
        """The sum of squares of all observations."""
        return float(self.observed @ self.observed)

    @cached_property
    def missing(self) -> float:
        """The largest violation of a constraint (rad, fixture sizes)."""
        return float(np.abs(self.violation).max(initial=0.0))

    @property
    def dof(self) -> int:
        """Degrees of freedom: observations less the unknowns that the constraints leave free."""
        return len(self.jacobian) - int(self.span.shape[1])

    @property
    def resolution(self) -> float:
        """Rank tolerance of the constraints, as a share of their largest singular value."""
        return min(max(CONSTRAINT_RANK, REDUNDANT * self.missing), MOST_REDUNDANT)

    @cached_property
    def span(self) -> Floats:
        """An orthonormal basis (width, k) of the null space of the constraints."""
        if not len(self.constraints):
            return np.eye(self.jacobian.shape[1])
        _, values, directions = np.linalg.svd(self.constraints, full_matrices=True)
        rank = int((values > self.resolution * max(values[0], TINY)).sum())
        return np.asarray(directions[rank:].T)

    def spread(self) -> tuple[Floats, Floats]:
        """A factor S (width, m) of the covariance S S^T of the displacements, and the free displacements (k, width).

        In scaled units; S has no part along free displacements.
        """
        span = self.span
        # R of a QR factorization has the singular values of all rows, however many contacts there are.
        triangle = np.linalg.qr(self.jacobian @ span, mode="r")
        _, values, motions = np.linalg.svd(triangle, full_matrices=True)
        known = np.zeros(len(motions), dtype=bool)
        known[: len(values)] = values > CONSTRAINT_RANK * max(values[0] if len(values) else 0.0, TINY)
        factor = span @ motions[known].T / values[known[: len(values)]]
        return np.asarray(factor), np.asarray((span @ motions[~known].T).T)


def moved_by(fit: JointFit, step: Floats) -> dict[str, Surface]:
    """The surfaces after a step (width,) in scaled units."""
    return {
        name: displaced(surface, step[fit.columns[name]] * fit.lengths[fit.columns[name]])
        for name, surface in fit.surfaces.items()
    }


def linearized(problem: JointProblem, surfaces: Mapping[str, Surface], equations: Sequence[Equation]) -> JointFit:
    """The linear model at these surfaces."""
    columns, width = columns_of(surfaces)
    lengths = chart_lengths(surfaces, problem.scale)
    values, rows = contact_observations(problem.contacts, problem.sigmas, surfaces)
    observed, observed_rows = [values], [rows]
    exact, exact_rows = [np.zeros(0)], [np.zeros((0, width))]
    equations = tuple(carried(equation, surfaces) for equation in equations)
    for equation, (value, jacobian) in zip(equations, linear_equations(equations, surfaces), strict=True):
        unit = equation.unit(problem.scale)
        if equation.spread > LEAST_SIGMA * unit:
            observed.append(value / equation.spread)
            observed_rows.append(jacobian / equation.spread)
        else:
            exact.append(value / unit)
            exact_rows.append(jacobian / unit)
    return JointFit(
        surfaces=surfaces,
        equations=equations,
        observed=np.concatenate(observed) - problem.wanted,
        violation=np.concatenate(exact),
        jacobian=np.vstack(observed_rows) * lengths,
        constraints=np.vstack(exact_rows) * lengths,
        columns=columns,
        lengths=lengths,
    )


def contact_observations(contacts: Contacts, sigmas: Floats, surfaces: Mapping[str, Surface]) -> tuple[Floats, Floats]:
    """Residuals over sigma (m,) of the contacts, feature by feature, and their Jacobian (m, width).

    One for each contact, three for one on a point. sigmas (n,) of the residuals.
    """
    columns, width = columns_of(surfaces)
    observed, rows = [np.zeros(0)], [np.zeros((0, width))]
    for name, index in contacts.by_feature.items():
        weights = 1 / sigmas[index, None]
        observed.append((weights * equations(surfaces[name], contacts.points[index], contacts.tip_radius)).ravel())
        own = weights[..., None] * equations_jacobian(surfaces[name], contacts.points[index])
        rows.append(np.zeros((len(observed[-1]), width)))
        rows[-1][:, columns[name]] = own.reshape(len(observed[-1]), -1)
    return np.concatenate(observed), np.vstack(rows)
