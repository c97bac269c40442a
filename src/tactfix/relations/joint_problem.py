"""What contacts and relations ask of the surfaces of a fixture that is not one rigid body, and its linear model.

Unknown are the displacements of every feature. Contacts, and relations with a sigma, are observations; relations with
sigma 0 are constraints.
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
"""Ratio of singular values below which constraints that hold are dependent: rounding of unit vectors with some to
spare."""
REDUNDANT, MOST_REDUNDANT = 10.0, 1e-3
"""Rank tolerance of the constraint Jacobian: REDUNDANT times the current constraint violation, at most MOST_REDUNDANT.
Redundant constraints, such as three axes parallel pair by pair, have slightly different gradients until they hold, and
must count once."""
LEAST_SIGMA = 1e-12
"""A relation surer than this share of the fixture's size is exact."""


@frozen_value
class JointProblem:
    """What is known: contacts, sigmas (n,) of their residuals, relations; scale is a length of the fixture.

    wanted: what residuals over sigma, those of the relations with a sigma behind, shall be instead of zero.
    """

    contacts: Contacts
    sigmas: Floats
    relations: tuple[Relation, ...]
    scale: float
    wanted: Floats | float = 0.0


@frozen_value
class JointFit:
    """Surfaces of least chi-square for one choice of branches, and the linear model there.

    equations: of the relations, their bases where the surfaces are. observed (m,): residuals over sigma,
    less what is wanted, three of a contact on a point; feature by feature, those of the relations with a sigma behind.
    violation (k,): what is missing to the constraints (rad, fixture sizes). jacobian (m, width) of observed and
    constraints (k, width), both with lengths in units of scale; columns: where each feature's displacement is.
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
        """The sum of the squares of all that is observed."""
        return float(self.observed @ self.observed)

    @cached_property
    def missing(self) -> float:
        """The most by which a constraint fails."""
        return float(np.abs(self.violation).max(initial=0.0))

    @property
    def dof(self) -> int:
        """Observations beyond the unknowns that the constraints leave."""
        return len(self.jacobian) - int(self.span.shape[1])

    @property
    def resolution(self) -> float:
        """Share of the largest singular value of the constraints below which they say nothing new."""
        return min(max(CONSTRAINT_RANK, REDUNDANT * self.missing), MOST_REDUNDANT)

    @cached_property
    def span(self) -> Floats:
        """An orthonormal basis (width, k) of the displacements that keep the constraints."""
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
    """The fit as it stands."""
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
    """What contacts ask of the surfaces, feature by feature and over sigma (m,), and its Jacobian (m, width).

    One number for each contact, three of one on a point. sigmas (n,) of the residuals.
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
