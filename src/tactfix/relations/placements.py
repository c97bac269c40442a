"""Damped least squares over the places of all features, from many starts side by side.

`joint` fits one placement to convergence and keeps relations with sigma 0 exactly. If features can be located neither
alone nor as one body, many starts are needed to meet every solution. Here hundreds run side by side. Every relation is
an observation, its sigma at least LEAST_RELATION_SIGMA times that of the contacts. Joint fits start at the ends.

A feature is a point p and a direction d, of an axis or a normal. With q = p' - p, residuals as lengths:

    contact x   (x - p).d - t,   +-(|x - p| or |(x - p) - ((x - p).d) d| - r) - t,   x - p of a point
    angle       s (atan2(|d x d'|, +-d.d') - value),   s (d -+ d') if parallel
    distance    q.d - value of a plane,   |q| - value,   |q across an axis| - value,   |q.(d x d')| / |d x d'| - value

Here t is the radius of the tip, r that of the feature, and s the fixture's size.

Each placement uses the nearest branch of each relation. The placements are the first axis of all arrays.

1. The residuals of all placements are evaluated.
2. Forward differences give their derivatives by three shifts and at most two tilts of each feature.
3. Each placement takes a Levenberg-Marquardt step, no displacement longer than LONGEST_DISPLACEMENT.
4. If chi-square has fallen, the step is kept and the damping lowered; else it is undone and the damping raised.

5. After every PLACEMENT_STEPS of steps 2 to 4 only those placements go on whose chi-square still falls towards its
   limit.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.feature import Feature
from tactfix.fixture import Fixture, Relation
from tactfix.geometry.arrays import TINY, Bools, Floats, Ints, basis_across, cross, lengths, unit
from tactfix.geometry.nearest import ALMOST_PARALLEL, direction_of
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, reference_point
from tactfix.noise import chi_square_limit
from tactfix.relations.equations import off
from tactfix.relations.joint_problem import JointProblem
from tactfix.relations.parallels import parallel_pairs
from tactfix.values import frozen_value

PLACEMENT_STEPS, MOST_PLACEMENT_STEPS = 20, 200
"""Levenberg-Marquardt steps of the placements, before those that have converged are left where they are, and at most.
Ten accepted ones bring the damping from 1e-2 to LEAST_PLACEMENT_DAMPING. Where relations are known better than
contacts, some need 160: with 40, one minimum was listed as up to 51 ends, and the search did not converge."""
STILL_FALLING = 0.01
"""Fall of chi-square over PLACEMENT_STEPS, as a share of it or of 1, above which a placement goes on."""
PLACEMENT_SIGHT = 100.0
"""Multiple of the limit of chi-square above which a placement does not go on, as `joint.JOINT_GIVEN_UP`."""
PLACEMENT_DIFFERENCE = 1e-6
"""Step (rad, fixture sizes) of the forward differences: their second-order error is of this size, their rounding 1e-10.
Both are far below what an iterated step needs."""
LEAST_RELATION_SIGMA = 0.3
"""Least sigma of a relation here, as a share of the contacts' smallest sigma. With much smaller ones least squares must
follow curved, narrow valleys in short steps; a joint fit keeps the relations exactly afterwards."""
PLACEMENT_DAMPING, LEAST_PLACEMENT_DAMPING, MOST_PLACEMENT_DAMPING = 1e-2, 1e-9, 1e6
"""Damping as a share of the diagonal: at the start, where placements are random and Gauss-Newton steps are too long;
the least, as `diagnosis.trial_fits.SINGULAR_DAMPING`; and the most, which makes a millionth of a Gauss-Newton step."""
DIAGONAL_FLOOR = 1e-9
"""Added to the diagonal of the normal matrix, as a share of its largest entry: the matrix stays regular, and an unknown
without any derivative is not moved. It changes no motion that is determined better than 3e-5 of the best one."""
LONGEST_DISPLACEMENT = 0.5
"""Longest displacement in one step (rad, fixture sizes). A tilt of 0.5 turns a direction by atan 0.5 = 0.464 rad,
within 7 per cent; longer steps would deviate from the computed rotation."""

Places: TypeAlias = tuple[Floats, Floats]
"""Points and directions (..., 3) of one feature, one for each placement."""


@frozen_value
class Term:
    """Residuals (..., count) over sigma of the features named, from the places of each."""

    names: tuple[str, ...]
    values: Callable[..., Floats]
    count: int


def settled(
    fixture: Fixture, problem: JointProblem, starts: Sequence[Mapping[str, Surface]]
) -> tuple[list[dict[str, Surface]], Floats]:
    """The end of each start: its surfaces, and chi-square there (S,)."""
    like, terms = starts[0], _terms(fixture, problem)
    columns, sizes = _columns(like, _length(problem))
    ends = {name: _places([start[name] for start in starts]) for name in like}
    places, all_chi2, falling = ends, np.full(len(starts), np.inf), np.arange(len(starts))
    residuals = _residuals(terms, places)  # step 1
    chi2, damping = np.einsum("sm,sm->s", residuals, residuals), np.full(len(starts), PLACEMENT_DAMPING)
    in_sight = PLACEMENT_SIGHT * chi_square_limit(len(problem.contacts))
    for _ in range(0, MOST_PLACEMENT_STEPS, PLACEMENT_STEPS):
        before = chi2
        for _ in range(PLACEMENT_STEPS):
            jacobian = _jacobian(terms, places, residuals, columns, sizes)  # step 2
            ahead = _moved(places, columns, _step(residuals, jacobian, damping) * sizes)  # step 3
            new_residuals = _residuals(terms, ahead)
            new_chi2 = np.einsum("sm,sm->s", new_residuals, new_residuals)
            better = new_chi2 < chi2  # step 4
            places = {name: _chosen(better, ahead[name], one) for name, one in places.items()}
            residuals = np.where(better[:, None], new_residuals, residuals)
            chi2 = np.where(better, new_chi2, chi2)
            damping = np.where(better, 0.2 * damping, 5 * damping)
            damping = np.clip(damping, LEAST_PLACEMENT_DAMPING, MOST_PLACEMENT_DAMPING)
        all_chi2[falling] = chi2
        ends = {name: _replaced(ends[name], falling, places[name]) for name in ends}
        goes_on = (chi2 < in_sight) & (before - chi2 > STILL_FALLING * (1 + chi2))  # step 5
        if not goes_on.any():
            break
        falling, residuals, chi2, damping = falling[goes_on], residuals[goes_on], chi2[goes_on], damping[goes_on]
        places = {name: (points[goes_on], along[goes_on]) for name, (points, along) in places.items()}
    return [{name: _at(like[name], ends[name], number) for name in like} for number in range(len(starts))], all_chi2


def _replaced(ones: Places, index: Ints, others: Places) -> Places:
    """The places with those of an index replaced."""
    points, directions = ones[0].copy(), ones[1].copy()
    points[index], directions[index] = others
    return points, directions


def _length(problem: JointProblem) -> float:
    """The size of the fixture; for planes related by angles alone, the spread of the contacts."""
    return max(problem.scale, problem.contacts.spread)


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


def _chosen(which: Bools, ones: Places, others: Places) -> Places:
    return np.where(which[:, None], ones[0], others[0]), np.where(which[:, None], ones[1], others[1])


def _residuals(terms: Sequence[Term], places: Mapping[str, Places]) -> Floats:
    return np.concatenate([term.values(*(places[name] for name in term.names)) for term in terms], axis=-1)


def _jacobian(
    terms: Sequence[Term], places: Mapping[str, Places], residuals: Floats, columns: Mapping[str, slice], sizes: Floats
) -> Floats:
    """Derivatives (S, m, width) of the residuals (S, m) by differences."""
    jacobian = np.zeros((*residuals.shape, len(sizes)))
    for name, index in columns.items():
        own = np.diag(PLACEMENT_DIFFERENCE * sizes[index])[:, None]
        moved, row = {**places, name: _displaced(places[name], own)}, 0
        for term in terms:
            rows = slice(row, row + term.count)
            if name in term.names:
                ahead = term.values(*(moved[other] for other in term.names))
                jacobian[:, rows, index] = np.moveaxis(ahead - residuals[:, rows], 0, -1) / PLACEMENT_DIFFERENCE
            row += term.count
    return jacobian


def _step(residuals: Floats, jacobian: Floats, damping: Floats) -> Floats:
    """Damped steps (S, width); an unknown without any derivative stays."""
    transposed = np.swapaxes(jacobian, 1, 2)
    normal, gradient = transposed @ jacobian, transposed @ residuals[..., None]
    diagonal = np.einsum("sii->si", normal)
    floor = DIAGONAL_FLOOR * diagonal.max(axis=1, keepdims=True) + TINY
    diagonal += damping[:, None] * diagonal + floor
    step = -np.linalg.solve(normal, gradient)[..., 0]
    return np.asarray(step * np.minimum(1.0, LONGEST_DISPLACEMENT / (np.abs(step).max(axis=1, keepdims=True) + TINY)))


def _terms(fixture: Fixture, problem: JointProblem) -> list[Term]:
    contacts, smallest = problem.contacts, float(problem.sigmas.min())
    terms = [
        _contact_term(fixture.features[name], contacts.on(name), problem.sigmas[index])
        for name, index in contacts.by_feature.items()
    ]
    parallel, length = parallel_pairs(problem.relations), _length(problem)
    for relation in problem.relations:
        one, other = (fixture.features[name] for name in relation.between)
        if relation.kind == "angle":
            sigma = max(length * relation.sigma, LEAST_RELATION_SIGMA * smallest)
            terms.append(_angle_term(relation, one, other, length / sigma))
        else:
            sigma = max(relation.sigma, LEAST_RELATION_SIGMA * smallest)
            terms.append(_distance_term(relation, one, other, frozenset(relation.between) in parallel, 1 / sigma))
    return [term for term in terms if term.count]


def _contact_term(feature: Feature, contacts: Contacts, sigmas: Floats) -> Term:
    points, tip, radius = contacts.points, contacts.tip_radius, feature.radius or 0.0
    sign = -1.0 if feature.side == "inner" else 1.0

    def values(place: Places) -> Floats:
        arms, along = points - place[0][..., None, :], place[1][..., None]
        if feature.type == "point":
            return (arms / sigmas[:, None]).reshape(*arms.shape[:-2], -1)
        heights = arms @ along
        if feature.type == "plane":
            return np.asarray((heights[..., 0] - tip) / sigmas)
        if feature.type == "cylinder":
            arms = arms - heights * place[1][..., None, :]
        return np.asarray((sign * (lengths(arms) - radius) - tip) / sigmas)

    return Term((feature.name,), values, feature.equations * len(points))


def _angle_term(relation: Relation, one: Feature, other: Feature, weight: float) -> Term:
    is_signed, is_parallel = one.type == other.type == "plane", off(relation) == 0
    has_directions = {one.type, other.type} <= {"plane", "cylinder"}

    def values(first: Places, second: Places) -> Floats:
        a, b = first[1], second[1]
        cosine = np.einsum("...i,...i->...", a, b)[..., None]
        sense = np.where(cosine < 0, -1.0, 1.0)
        if is_parallel:
            return weight * (a - (np.sign(np.cos(relation.value)) if is_signed else sense) * b)
        angle = np.arctan2(lengths(cross(a, b))[..., None], cosine if is_signed else sense * cosine)
        return np.asarray(weight * (angle - relation.value))

    return Term(relation.between, values, (3 if is_parallel else 1) if has_directions else 0)


def _distance_term(relation: Relation, one: Feature, other: Feature, parallel: bool, weight: float) -> Term:
    kinds, value = (one.type, other.type), relation.value

    def from_plane(first: Places, second: Places) -> Floats:
        (p, normal), (q, _) = (first, second) if kinds[0] == "plane" else (second, first)
        height = np.einsum("...i,...i->...", q - p, normal)[..., None]
        is_signed = {"sphere", "point"} & set(kinds)
        return np.asarray(weight * (height - value if is_signed else np.abs(height) - value))

    def values(first: Places, second: Places) -> Floats:
        gap, a, b = second[0] - first[0], first[1], second[1]
        flat = gap - np.einsum("...i,...i->...", gap, a)[..., None] * a
        if kinds != ("cylinder", "cylinder"):
            flat = flat - np.einsum("...i,...i->...", gap, b)[..., None] * b
            return np.asarray(weight * (lengths(flat)[..., None] - value))
        normal = cross(a, b)
        sine = lengths(normal)[..., None]
        askew = np.abs(np.einsum("...i,...i->...", gap, normal))[..., None] / np.maximum(sine, TINY)
        spacing = lengths(flat)[..., None]
        return np.asarray(weight * (np.where(parallel | (sine < ALMOST_PARALLEL), spacing, askew) - value))

    return Term(relation.between, from_plane if "plane" in kinds else values, 1)
