"""Damped least squares over the places of all features, from many starts side by side.

`joint` fits one placement to convergence and keeps relations with sigma 0 exactly. If features can be located neither
alone nor as one body, many starts are needed to meet every solution. Here hundreds run side by side. Every relation is
an observation. Joint fits start at the ends.

The placements are the first axis of all arrays; the residuals are those of `placement_residuals`.

1. Relations first have a sigma of at least 30 times that of the contacts, then of 0.3 (RELATION_SLACKS): a placement
   first fits the contacts of each feature, and then the relations. Steps 2 to 7 are done for each of the two.
2. The residuals are evaluated; of the second time only those placements go on that are within PLACEMENT_SIGHT.
3. Forward differences give their derivatives by three shifts and at most two tilts of each feature.
4. Each placement takes a Levenberg-Marquardt step, no displacement longer than LONGEST_DISPLACEMENT.
5. From its end a second-order correction leads to the residuals that the linear model predicts, as in `joint`. The
   better of the two is taken.
6. If chi-square has fallen, the step is kept and the damping lowered; else it is undone and the damping raised.
7. After PLACEMENT_STEPS of steps 3 to 6 those placements go on, the second time, whose chi-square still falls towards
   its limit: they are next to a fold, where J is nearly singular and the curvature of the residuals decides. Their
   second derivatives along the WEAK_DIRECTIONS are added to the normal matrix (Newton's method, positive part only).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tactfix.fixture import Fixture
from tactfix.geometry.arrays import TINY, Bools, Floats, Ints, basis_across, unit
from tactfix.geometry.charts import dimension
from tactfix.geometry.nearest import direction_of
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, reference_point
from tactfix.noise import chi_square_limit
from tactfix.relations.joint_problem import JointProblem
from tactfix.relations.placement_residuals import Places, Term, terms_of
from tactfix.values import frozen_value

PLACEMENT_STEPS, CURVED_STEPS, MOST_PLACEMENT_STEPS = 20, 5, 200
"""Levenberg-Marquardt steps of the placements, before those that have converged are left where they are; steps with
second derivatives between further checks; and all at most. Ten accepted ones bring the damping from 1e-2 to
LEAST_PLACEMENT_DAMPING. Without second derivatives some need 160 where relations are known better than contacts: one
minimum was listed as up to 51 ends, and the search did not converge."""
STILL_FALLING = 0.02
"""Fall of chi-square since the last check, as a share of it or of 1, above which a placement goes on. With 0.01 planes
with two contacts each take up to 690 steps with second derivatives, 185 with 0.02; with 0.05 two bars on a plate end at
13 places, one of them no minimum."""
PLACEMENT_SIGHT = 100.0
"""Multiple of the limit of chi-square above which a placement does not go on, as `joint.JOINT_GIVEN_UP`."""
PLACEMENT_DIFFERENCE = 1e-6
"""Step (rad, fixture sizes) of the forward differences: their second-order error is of this size, their rounding 1e-10.
Both are far below what an iterated step needs."""
RELATION_SLACKS = (30.0, 0.3)
"""Least sigma of a relation, as a share of the contacts' smallest sigma, at first and then. With much smaller ones at
once least squares must follow curved, narrow valleys in short steps: of 60 fixtures with two or three contacts on each
feature, one in twenty had less than 3.8 per cent of placements that reached a solution, and has 14 per cent. Smaller
ones than 0.3 are not needed, since a joint fit keeps the relations exactly afterwards."""
PLACEMENT_DAMPING, LEAST_PLACEMENT_DAMPING, MOST_PLACEMENT_DAMPING = 1e-2, 1e-9, 1e6
"""Damping as a share of the diagonal: at the start, where placements are random and Gauss-Newton steps are too long;
the least, as `diagnosis.trial_fits.SINGULAR_DAMPING`; and the most, which makes a millionth of a Gauss-Newton step."""
DIAGONAL_FLOOR = 1e-9
"""Added to the diagonal of the normal matrix, as a share of its largest entry: the matrix stays regular, and an unknown
without any derivative is not moved. It changes no motion that is determined better than 3e-5 of the best one."""
WEAK_DIRECTIONS = 4
"""Directions of the smallest singular values of J along which second derivatives are computed: a bar with three
contacts next to a fold has two or three. With 4, 256 placements of two bars on a plate at 89.99 deg have 24 ends;
with 3 or fewer 64 to 77, most of them not at a minimum."""
CURVATURE_DIFFERENCE = 1e-3
"""Step (rad, fixture sizes) of the second differences: residuals of 1e4 sigma a unit have a rounding of 1e-12, so of
1e-6 in the second derivative; third-order terms are a thousandth of second-order ones."""
LONGEST_DISPLACEMENT = 0.5
"""Longest displacement in one step (rad, fixture sizes). A tilt of 0.5 turns a direction by atan 0.5 = 0.464 rad,
within 7 per cent; longer steps would deviate from the computed rotation."""


def settled(
    fixture: Fixture, problem: JointProblem, starts: Sequence[Mapping[str, Surface]]
) -> tuple[list[dict[str, Surface]], Floats]:
    """The end of each start: its surfaces, and chi-square there (S,)."""
    like, length = starts[0], max(problem.scale, problem.contacts.spread)
    columns, sizes = _columns(like, length)
    places = {name: _places([start[name] for start in starts]) for name in like}
    immobile = len(sizes) - sum(dimension(surface) for surface in like.values())
    in_sight = PLACEMENT_SIGHT * chi_square_limit(len(problem.contacts))
    chi2 = np.zeros(len(starts))
    for slack, most_steps in zip(RELATION_SLACKS, (PLACEMENT_STEPS, MOST_PLACEMENT_STEPS), strict=True):  # step 1
        descent = Descent(terms_of(fixture, problem, length, slack), columns, sizes, immobile, in_sight)
        places, chi2 = descent.ends(places, chi2 < in_sight, most_steps)
    return [{name: _at(like[name], places[name], number) for name in like} for number in range(len(starts))], chi2


@frozen_value
class Descent:
    """Least squares of these terms; columns and sizes as in `_columns`.

    immobile: displacements that have no effect. in_sight: chi-square up to which a placement goes on.
    """

    terms: Sequence[Term]
    columns: Mapping[str, slice]
    sizes: Floats
    immobile: int
    in_sight: float

    def ends(self, starts: Mapping[str, Places], followed: Bools, most_steps: int) -> tuple[dict[str, Places], Floats]:
        """The places after at most so many steps of those followed (S,), and the chi-square of all (S,)."""
        ends, residuals = dict(starts), self._residuals(starts)  # step 2
        all_chi2 = _squares(residuals)
        falling = np.flatnonzero(followed)
        places, residuals, chi2 = _those(starts, falling), residuals[falling], all_chi2[falling]
        damping = np.full(len(falling), PLACEMENT_DAMPING)
        for number in range(PLACEMENT_STEPS, most_steps + 1, CURVED_STEPS):
            before, curved = chi2, number > PLACEMENT_STEPS
            for _ in range(CURVED_STEPS if curved else PLACEMENT_STEPS):
                ahead, new_residuals = self._ahead(places, residuals, damping, curved)
                better = _squares(new_residuals) < chi2  # step 6
                places, residuals = _chosen(better, ahead, places), _where(better, new_residuals, residuals)
                chi2 = _squares(residuals)
                damping = np.where(better, 0.2 * damping, 5 * damping)
                damping = np.clip(damping, LEAST_PLACEMENT_DAMPING, MOST_PLACEMENT_DAMPING)
            all_chi2[falling] = chi2
            ends = {name: _replaced(ends[name], falling, places[name]) for name in ends}
            goes_on = (chi2 < self.in_sight) & (before - chi2 > STILL_FALLING * (1 + chi2))  # step 7
            if not goes_on.any():
                break
            falling, residuals, chi2, damping = falling[goes_on], residuals[goes_on], chi2[goes_on], damping[goes_on]
            places = _those(places, goes_on)
        return ends, all_chi2

    def _ahead(
        self, places: Mapping[str, Places], residuals: Floats, damping: Floats, curved: bool
    ) -> tuple[dict[str, Places], Floats]:
        """The places after a step, corrected or not, and the residuals there."""
        jacobian = self._jacobian(places, residuals)  # step 3
        curvature = self._curvature(places, residuals, jacobian) if curved else 0.0
        step = _step(residuals, jacobian, damping, curvature)  # step 4
        ahead = _moved(places, self.columns, step * self.sizes)
        there = self._residuals(ahead)
        neglected = there - residuals - (jacobian @ step[..., None])[..., 0]  # step 5
        further = _moved(ahead, self.columns, _step(neglected, jacobian, damping, curvature) * self.sizes)
        further_there = self._residuals(further)
        nearer = _squares(further_there) < _squares(there)
        return _chosen(nearer, further, ahead), _where(nearer, further_there, there)

    def _curvature(self, places: Mapping[str, Places], residuals: Floats, jacobian: Floats) -> Floats:
        """The part (S, width, width) of the normal matrix due to the curvature of residuals along weak directions."""
        _, directions = np.linalg.eigh(np.swapaxes(jacobian, 1, 2) @ jacobian)
        weak = np.swapaxes(directions[..., self.immobile : self.immobile + WEAK_DIRECTIONS], 1, 2)
        count = weak.shape[1]

        def moved(step: Floats) -> Floats:
            return self._residuals(_moved(places, self.columns, CURVATURE_DIFFERENCE * step * self.sizes))

        ahead = [moved(weak[:, i]) for i in range(count)]
        curvature = np.zeros((len(residuals), count, count))
        for i in range(count):
            second = ahead[i] - 2 * residuals + moved(-weak[:, i])
            curvature[:, i, i] = np.einsum("sm,sm->s", residuals, second)
            for j in range(i):
                second = moved(weak[:, i] + weak[:, j]) - ahead[i] - ahead[j] + residuals
                curvature[:, i, j] = curvature[:, j, i] = np.einsum("sm,sm->s", residuals, second)
        values, axes = np.linalg.eigh(curvature / CURVATURE_DIFFERENCE**2)
        along = np.swapaxes(axes, 1, 2) @ weak
        return np.asarray(np.swapaxes(along, 1, 2) @ (np.maximum(values, 0.0)[..., None] * along))

    def _residuals(self, places: Mapping[str, Places]) -> Floats:
        return np.concatenate([term.values(*(places[name] for name in term.names)) for term in self.terms], axis=-1)

    def _jacobian(self, places: Mapping[str, Places], residuals: Floats) -> Floats:
        """Derivatives (S, m, width) of the residuals (S, m) by differences."""
        jacobian = np.zeros((*residuals.shape, len(self.sizes)))
        for name, index in self.columns.items():
            own = np.diag(PLACEMENT_DIFFERENCE * self.sizes[index])[:, None]
            moved, row = {**places, name: _displaced(places[name], own)}, 0
            for term in self.terms:
                rows = slice(row, row + term.count)
                if name in term.names:
                    ahead = term.values(*(moved[other] for other in term.names))
                    jacobian[:, rows, index] = np.moveaxis(ahead - residuals[:, rows], 0, -1) / PLACEMENT_DIFFERENCE
                row += term.count
        return jacobian


def _squares(residuals: Floats) -> Floats:
    return np.asarray(np.einsum("sm,sm->s", residuals, residuals))


def _where(which: Bools, ones: Floats, others: Floats) -> Floats:
    return np.where(which[:, None], ones, others)


def _those(places: Mapping[str, Places], index: Ints | Bools) -> dict[str, Places]:
    return {name: (points[index], along[index]) for name, (points, along) in places.items()}


def _replaced(ones: Places, index: Ints, others: Places) -> Places:
    """The places with those of an index replaced."""
    points, directions = ones[0].copy(), ones[1].copy()
    points[index], directions[index] = others
    return points, directions


def _places(surfaces: Sequence[Surface]) -> Places:
    points = np.array([reference_point(surface) for surface in surfaces])
    directions = [direction_of(surface) for surface in surfaces if isinstance(surface, Plane | Cylinder)]
    return points, np.array(directions or np.zeros_like(points))


def _at(like: Surface, places: Places, number: int) -> Surface:
    """The surface at one of the places."""
    point, direction = places[0][number], places[1][number]
    match like:
        case Sphere():
            return replace(like, center=point)
        case Point():
            return Point(point)
        case Plane():
            return Plane(point, direction)
        case Cylinder():
            return replace(like, point=point, direction=direction)


def _columns(like: Mapping[str, Surface], length: float) -> tuple[dict[str, slice], Floats]:
    """The columns of each feature's displacement, and the unit of each column (width,): a length, or 1 rad for a tilt.

    Three shifts for every feature, for simplicity, though a shift of a plane or axis along itself has no effect.
    """
    columns, sizes = {}, np.zeros(0)
    for name, surface in like.items():
        own = [length] * 3 + [1.0] * (2 if isinstance(surface, Plane | Cylinder) else 0)
        columns[name] = slice(len(sizes), len(sizes) + len(own))
        sizes = np.append(sizes, own)
    return columns, sizes


def _moved(places: Mapping[str, Places], columns: Mapping[str, slice], steps: Floats) -> dict[str, Places]:
    """The places after displacements (S, width)."""
    return {name: _displaced(one, steps[:, columns[name]]) for name, one in places.items()}


def _displaced(places: Places, steps: Floats) -> Places:
    """The places (..., S, 3) of one feature after displacements (..., S, 3 or 5)."""
    point, direction = places
    if steps.shape[-1] == 3:
        return point + steps, direction
    return point + steps[..., :3], unit(direction + (steps[..., None, 3:] @ basis_across(direction))[..., 0, :])


def _chosen(which: Bools, ones: Mapping[str, Places], others: Mapping[str, Places]) -> dict[str, Places]:
    """The places of ones where which (S,) is true, else of others."""
    return {
        name: (_where(which, p, others[name][0]), _where(which, d, others[name][1])) for name, (p, d) in ones.items()
    }


def _step(residuals: Floats, jacobian: Floats, damping: Floats, curvature: Floats | float) -> Floats:
    """Damped steps (S, width); an unknown without any derivative stays."""
    transposed = np.swapaxes(jacobian, 1, 2)
    normal, gradient = transposed @ jacobian + curvature, transposed @ residuals[..., None]
    diagonal = np.einsum("sii->si", normal)
    floor = DIAGONAL_FLOOR * diagonal.max(axis=1, keepdims=True) + TINY
    diagonal += damping[:, None] * diagonal + floor
    step = -np.linalg.solve(normal, gradient)[..., 0]
    return np.asarray(step * np.minimum(1.0, LONGEST_DISPLACEMENT / (np.abs(step).max(axis=1, keepdims=True) + TINY)))
