"""Spheres from fewer contacts than they need, and known distances of the centre from surfaces that are located.

1. Contacts and distances become loci of the centre: spheres, cylinders and planes, in units of the radius about the
   contacts' mean. A centre on an axis lies in two planes. Fewer than three loci leave a curve, and are refused.
2. Triples of loci with at least one contact are intersected (`center_loci`), a dozen at most. Triples that share a
   curve are skipped.
3. Every point is refined by weighted least squares over all loci, exact distances weighing most (`least_squares`).
4. The distinct centres that noise can explain are returned, best first; of a redundant set the best one in any case.

Eqs. 48-51.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, islice
from typing import TypeAlias

import numpy as np

from tactfix.errors import DegenerateContactsError
from tactfix.geometry.arrays import TINY, Bools, Floats, Frozen, Ints, UnitVector, basis_across, lengths
from tactfix.geometry.surfaces import Sphere
from tactfix.localizers.candidate import SurfaceCandidate, candidates_of, determination, distinct_explanations
from tactfix.localizers.center_loci import CylinderLocus, Locus, PlaneLocus, SphereLocus, meeting_points
from tactfix.localizers.least_squares import refined
from tactfix.localizers.unit_contacts import ROUNDING, effective_sigmas
from tactfix.values import frozen_value

_UNKNOWNS = 3
"""Coordinates of a centre."""

_MOST_TRIPLES = 12
"""Triples of loci that are intersected at most, of many contacts and distances. A centre that explains all is near a
point of every triple, so that one triple would do if none were degenerate."""

_EXACT_DISTANCE = 1e-3
"""Sigma of an exact distance, as a share of that of a contact: its residual is then a thousandth of theirs, and weights
of 1e3 cost three of sixteen digits."""

_CENTER_SIGHT_STEPS, _CENTER_IN_SIGHT = 8, 1e-3
"""As _CYLINDER_SIGHT_STEPS and _CYLINDER_IN_SIGHT of `cylinder_refinement`, for the roots of three loci."""

_ON_AXIS = 3.0
"""Distance from an axis, in sigma, up to which a centre is taken to lie on it: the gradient of such a distance has no
defined direction, and noise of three sigma can put a centre on the axis to either side."""


@frozen_value
class CenterDistance:
    """The centre is at a distance from a located point, such as the centre of another sphere."""

    center: Frozen
    distance: float
    sigma: float = 0.0


@frozen_value
class AxisDistance:
    """The centre is at a distance >= 0 from the axis through point along direction."""

    point: Frozen
    direction: UnitVector
    distance: float
    sigma: float = 0.0


@frozen_value
class PlaneDistance:
    """The centre is at a signed distance from the plane through point, positive on the side of normal."""

    point: Frozen
    normal: UnitVector
    distance: float
    sigma: float = 0.0


Distance: TypeAlias = CenterDistance | AxisDistance | PlaneDistance


def localize_sphere_at_distances(
    points: Floats,
    radius: float,
    distances: tuple[Distance, ...],
    sigmas: Floats | float | None = None,
) -> tuple[SurfaceCandidate, ...]:
    """Every sphere of known radius that explains the contacts and keeps the distances of its centre.

    Solves |x_i - c| = radius together with the distance of c from each centre, axis and plane: exactly for three
    conditions in all, by weighted least squares from all solutions of three of them for more.

    points (n, 3), n >= 1: tip centres or surface points; radius: offset radius, of the tip's centres; distances: with
    one sigma each, 0 if exact; sigmas (n,) or one number, of the contacts, or None for exact ones.
    Returns all real centres, best first: up to four from two contacts and an axis, up to eight from one contact and two
    axes; near-tangent ones once and marked poorly determined. A centre on an axis (distance 0) counts as two distances.
    Raises DegenerateContactsError for fewer than three conditions, or conditions that leave a curve of centres.
    Source: eqs. 48-51.
    """
    origin, scale = points.mean(axis=0), radius  # step 1
    rounding = ROUNDING * _reach(points, radius, distances)
    deviations = np.hypot(effective_sigmas(points, sigmas), rounding)
    exact = max(rounding, _EXACT_DISTANCE * float(deviations.min()))
    loci: list[Locus] = [SphereLocus((x - origin) / scale, 1.0) for x in points]
    noise = [float(s) for s in deviations]
    for distance in distances:
        sigma = float(np.hypot(distance.sigma, exact))
        found = _loci(distance, origin, scale, _ON_AXIS * sigma)
        loci += found
        noise += [sigma] * len(found)
    _refuse_too_few(loci)
    # Weights up to one for the refinement, whose tolerances are those of unit size; 1/sigma to judge what it found.
    search = CenterProblem.of(loci, min(noise) / np.array(noise))
    starts = _starts(loci, len(points))  # step 2
    if len(loci) == _UNKNOWNS:
        starts = _in_sight_of_a_root(search, starts, min(noise) / scale)
    states = refined(search.evaluate, search.step, starts)  # step 3
    problem = replace(search, weights=float(np.mean(deviations)) / np.array(noise))
    # Step 4.
    return _candidates(problem, states, float(np.mean(deviations)) / scale, origin, scale, len(points))


def _reach(points: Floats, radius: float, distances: tuple[Distance, ...]) -> float:
    """The largest number in the equations: their rounding is proportional to it."""
    places = [d.center if isinstance(d, CenterDistance) else d.point for d in distances]
    return float(np.max(np.abs([radius, *(d.distance for d in distances), *np.ravel(points), *np.ravel(places)])))


def _refuse_too_few(loci: list[Locus]) -> None:
    if len(loci) < _UNKNOWNS:
        reason = f"{len(loci)} contacts and distances leave the centre free"
        raise DegenerateContactsError("sphere", reason, len(loci) / _UNKNOWNS, 1.0, "touch again")


def _loci(distance: Distance, origin: Floats, scale: float, nothing: float) -> list[Locus]:
    """The loci of the centre, in units of scale about origin; a distance up to nothing counts as zero."""
    match distance:
        case PlaneDistance():
            height = float((distance.point - origin) @ distance.normal) + distance.distance
            return [PlaneLocus(distance.normal, height / scale)]
        case AxisDistance() if distance.distance <= nothing:
            place = (distance.point - origin) / scale
            return [PlaneLocus(n, float(n @ place)) for n in basis_across(distance.direction)]
        case AxisDistance():
            return [CylinderLocus((distance.point - origin) / scale, distance.direction, distance.distance / scale)]
        case CenterDistance() if distance.distance <= nothing:
            return [PlaneLocus(n, float(n @ (distance.center - origin)) / scale) for n in np.eye(3)]
        case CenterDistance():
            return [SphereLocus((distance.center - origin) / scale, distance.distance / scale)]


def _starts(loci: list[Locus], contacts: int) -> Floats:
    """Centres (k, 3) on three loci each, one of them a contact's (step 2)."""
    triples = [t for t in combinations(range(len(loci)), 3) if t[0] < contacts]
    starts, refusal = [], None
    for first, second, third in islice(triples, _MOST_TRIPLES):
        try:
            starts.append(meeting_points((loci[first], loci[second], loci[third])))
        except DegenerateContactsError as error:
            refusal = error
    if not starts and refusal is not None:
        raise refusal
    return np.concatenate(starts)


def _in_sight_of_a_root(problem: "CenterProblem", starts: Floats, slack: float) -> Floats:
    """The starts after a few steps, without those that lead to no root: the real parts of complex zeros.

    slack: weighted residual that noise may leave.
    """
    states = refined(problem.evaluate, problem.step, starts, _CENTER_SIGHT_STEPS)
    misses = np.abs(problem.evaluate(states, np.arange(len(states)))[0]).max(axis=1, initial=0.0)
    return np.asarray(states[misses <= max(_CENTER_IN_SIGHT, 30 * slack)])


@frozen_value
class CenterProblem:
    """m loci as arrays, and their weights (m,); a state is the centre (3,).

    places (m, 3): their centres, points or feet of the origin; axes (m, 3): directions of axes, normals of planes, zero
    for spheres; distances (m,) from centre or axis, zero for planes; flat (m,): which are planes. Residuals are
    weight * (distance - known distance).
    """

    places: Floats
    axes: Floats
    distances: Floats
    flat: Bools
    weights: Floats

    @staticmethod
    def of(loci: Sequence[Locus], weights: Floats) -> "CenterProblem":
        """The problem of these loci."""
        places, axes, distances = zip(*map(_as_numbers, loci), strict=True)
        flat = np.array([isinstance(locus, PlaneLocus) for locus in loci])
        return CenterProblem(np.array(places), np.array(axes), np.array(distances), flat, weights)

    def evaluate(self, states: Floats, index: Ints) -> tuple[Floats, Floats]:
        """Residuals (B, m) and Jacobians (B, m, 3) of centres (B, 3)."""
        del index
        misses, gradients = self.misses(states)
        return misses * self.weights, gradients * self.weights[:, None]

    def misses(self, centers: Floats) -> tuple[Floats, Floats]:
        """Distances (B, m) of centres (B, 3) from each locus, and their gradients (B, m, 3)."""
        arms = centers[:, None] - self.places
        along = np.einsum("bmi,mi->bm", arms, self.axes)
        arms -= along[..., None] * self.axes
        length = lengths(arms)
        gradients = arms / np.maximum(length, TINY)[..., None]
        misses = length - self.distances
        if self.flat.any():
            misses = np.where(self.flat, along, misses)
            gradients = np.where(self.flat[:, None], self.axes, gradients)
        return misses, gradients

    def step(self, states: Floats, change: Floats) -> Floats:
        """The centres after a change (B, 3)."""
        return states + change


def _as_numbers(locus: Locus) -> tuple[Floats, Floats, float]:
    """Place (3,), axis (3,) and distance of a locus, as `CenterProblem` has them."""
    match locus:
        case PlaneLocus():
            return locus.offset * locus.normal, locus.normal, 0.0
        case SphereLocus():
            return locus.center, np.zeros(3), locus.distance
        case CylinderLocus():
            return locus.point, locus.direction, locus.distance


def _candidates(
    problem: CenterProblem, states: Floats, sigma: float, origin: Floats, radius: float, contacts: int
) -> tuple[SurfaceCandidate, ...]:
    """The distinct centres that noise can explain, best first; of a redundant set always the best one."""
    residuals, _ = problem.evaluate(states, np.arange(len(states)))
    chi2 = np.sum(residuals**2, axis=1) / sigma**2
    dof = len(problem.weights) - _UNKNOWNS
    kept = distinct_explanations(states, chi2, dof)
    if not kept:
        return ()
    _, poor = determination(problem.evaluate, problem.step, states[kept], sigma)
    condition = _condition(problem, states[kept])
    distances = residuals[kept, :contacts] / problem.weights[:contacts] * radius
    spheres = (Sphere(origin + radius * state, radius) for state in states[kept])
    return candidates_of(spheres, chi2[kept], distances, condition, poor)


def _condition(problem: CenterProblem, centers: Floats) -> Floats:
    """The condition (B,) of each centre (B, 3): displacement over that of its loci, whatever their sigmas."""
    smallest = np.linalg.svd(problem.misses(centers)[1], compute_uv=False)[:, -1]
    return np.asarray(1.0 / np.maximum(smallest, TINY))
