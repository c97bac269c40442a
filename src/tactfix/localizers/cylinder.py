"""Cylinders through contacts: five or more, or four of known radius.

1. Contacts are centred and scaled (`unit_contacts`), and refused where infinitely many cylinders pass through them.
2. A well spread sample of them is searched: the cylinders through a minimal subset are starts. If these may not be all,
   further subsets and a covering of all directions follow (`cylinder_search`).
3. A minimal set: the zeros are refined, multiple ones too (`cylinder_refinement`). A redundant set: the starts are
   followed for a few steps, and those that may explain the contacts are refined on all of them by weighted least
   squares.
4. The distinct minima that noise can explain are returned, best first; of a redundant set the best one in any case.

Eqs. 16-45 and fig. 5 for five contacts; I. G. Macdonald, J. Pach and T. Theobald 2001 for four of known radius.
"""

import numpy as np

from tactfix.geometry.arrays import Floats, farthest_first
from tactfix.geometry.surfaces import Cylinder, signed_axis
from tactfix.localizers.candidate import SurfaceCandidate, candidates_of, determination
from tactfix.localizers.cylinder_refinement import CylinderProblem, distinct, distinct_roots, refined_roots
from tactfix.localizers.cylinder_search import CYLINDER_CONTACTS, FREE_CYLINDER_CONTACTS, starting_states
from tactfix.localizers.unit_contacts import (
    UnitContacts,
    refuse_coincident,
    refuse_collinear,
    refuse_two_parallel_lines,
    unit_contacts,
)
from tactfix.noise import chi_square_limit

_SAMPLE = 24
"""Contacts that the search uses, well spread; the others take part in the refinement. The time of a start grows with
them, and 24 are far more than the five unknowns. Of 417 random problems with 4 to 14 noisy contacts on cylinders and
spheres 12 change one, by a minimum that noise does not explain."""

_CYLINDER_START_STEPS = 10
"""Steps of every start of a redundant set, before most are dropped: those near a minimum have nearly converged. Of
the same problems 5 and 20 steps change two, whose sum of squares is nearly flat (free radius, noise of 5 per cent; a
double root)."""

_CYLINDER_GIVEN_UP = 1e3
"""A start whose chi-square exceeds this multiple of the limit after those steps is dropped, except the best few:
residuals of 30 times those that noise may leave. 100 and 10,000 change none of 278 of the same problems."""

_GLANCE = 6
"""Steps from the zeros of the first minimal subset before the test whether they are all (`_are_all`): zeros of five
of the contacts are near the minimum for all, and only weakly determined ones move far."""

_WELL_DETERMINED = 3e-3
"""A cylinder is well determined if one sigma moves it by less than this share of the contacts' extent. Of 6,000 tidy
and random problems one minimal subset lost 63 cylinders. All of these were close to others that one sigma moves by more
than four times as much."""

_BEST, _CYLINDER_RIVAL = 3, 4.0
"""The best _BEST starts within _CYLINDER_RIVAL times the least chi-square are always followed: the least-squares
optimum must be among them, and is returned even if noise does not explain it."""


def localize_cylinder(
    points: Floats, radius: float | None = None, sigmas: Floats | float | None = None
) -> tuple[SurfaceCandidate, ...]:
    """Every cylinder that explains the contacts.

    Local minima of the weighted sum of (distance of x_i from the axis - radius)^2 over the axis, and over the radius
    if it is not given.

    points (n, 3): tip centres or surface points, n >= 4 with radius, n >= 5 without; radius: offset radius, of the
    tip's centres; sigmas (n,) or one number, along the normal, or None for exact contacts: all in one unit.
    Returns the minima whose chi-square noise can explain, best first, and of a redundant set always the global minimum.
    Five contacts: up to six cylinders, each of its own radius; four of known radius: up to twelve. A double root is
    returned once and marked poorly determined, also if noise has made it complex. The result is empty for four contacts
    too far apart, or five in a plane on a hyperbola. The direction of an axis is that of `signed_axis`.
    Raises DegenerateContactsError if infinitely many cylinders pass through the contacts: too few of them differ, all
    lie on one line, or, without a known radius, on two parallel lines.
    Source: eqs. 16-45 and fig. 5 (five contacts); Macdonald, Pach and Theobald 2001 (four of known radius).
    """
    contacts = unit_contacts(points, sigmas)  # step 1
    _refuse(contacts, radius is not None)
    size = None if radius is None else radius / contacts.scale
    problem = CylinderProblem(contacts.points, contacts.weights, radius is not None)
    return _candidates(problem, contacts, _minima(problem, contacts, size))  # steps 2 to 4


def _refuse(contacts: UnitContacts, radius_known: bool) -> None:
    """Raise if infinitely many cylinders pass through the contacts."""
    refuse_coincident("cylinder", contacts, CYLINDER_CONTACTS if radius_known else FREE_CYLINDER_CONTACTS)
    refuse_collinear("cylinder", contacts)
    if not radius_known:
        refuse_two_parallel_lines("cylinder", contacts)


def _minima(problem: CylinderProblem, contacts: UnitContacts, radius: float | None) -> Floats:
    """All local minima (B, 7) of the problem that may explain the contacts, from starts by a sample of them."""
    index = farthest_first(contacts.points, _SAMPLE)
    points, weights = contacts.points[index], contacts.weights[index]
    sample = CylinderProblem(points, weights, radius is not None)
    lots = starting_states(points, weights, radius, contacts.sigma)
    dof = len(points) - (FREE_CYLINDER_CONTACTS if radius is None else CYLINDER_CONTACTS)
    if dof == 0:
        slack = contacts.sigma * np.sqrt(chi_square_limit(0)) / float(weights.min())
        return refined_roots(sample, next(lots), slack)[0]
    first = next(lots)
    states, chi2, order = _first_look(sample, first, contacts.sigma, _GLANCE)
    if not _are_all(sample, states[order], chi2[order], dof, contacts.sigma):
        every = np.concatenate([first, next(lots)])
        states, chi2, order = _first_look(sample, every, contacts.sigma, _CYLINDER_START_STEPS)
    return problem.refined(states[_worth_following(order, chi2, dof)])


def _first_look(problem: CylinderProblem, states: Floats, sigma: float, steps: int) -> tuple[Floats, Floats, list[int]]:
    """The states (B, 7) after a few steps, their chi-squares (B,), and the distinct ones, best first."""
    states = problem.refined(states, steps)
    residuals, _ = problem.evaluate(states, np.arange(len(states)))
    chi2 = np.sum(residuals**2, axis=1) / sigma**2
    return states, chi2, distinct(states, chi2)


def _are_all(problem: CylinderProblem, states: Floats, chi2: Floats, dof: int, sigma: float) -> bool:
    """Whether distinct states (B, 7), best first, are all that explain the contacts: then they are well determined.

    A minimal subset loses a cylinder only if its contacts do not clearly distinguish it from another one, and that one
    is then weakly determined.
    """
    limit = chi_square_limit(dof)
    explaining = states[chi2 <= limit]
    if not len(explaining) or ((chi2 > limit) & (chi2 <= _CYLINDER_GIVEN_UP * limit)).any():
        return False
    condition, poor = determination(problem.evaluate, problem.step, explaining, sigma)
    return not poor.any() and float(condition.max()) * sigma < _WELL_DETERMINED


def _worth_following(order: list[int], chi2: Floats, dof: int) -> list[int]:
    """The starts, given in order of chi-square, that may lead to an explanation or to the optimum."""
    explaining = _CYLINDER_GIVEN_UP * chi_square_limit(dof)
    rivals = [i for i in order[:_BEST] if chi2[i] <= _CYLINDER_RIVAL * chi2[order[0]]]
    return [i for i in order if chi2[i] <= explaining or i in rivals]


def _candidates(problem: CylinderProblem, contacts: UnitContacts, states: Floats) -> tuple[SurfaceCandidate, ...]:
    """The distinct states that noise can explain, best first; of a redundant set always the best one."""
    residuals, jacobians = problem.evaluate(states, np.arange(len(states)))
    chi2 = np.sum(residuals**2, axis=1) / contacts.sigma**2
    dof = len(contacts.points) - jacobians.shape[-1]
    order = distinct_roots(problem, states, chi2, contacts.rounding)
    kept = [i for rank, i in enumerate(order) if chi2[i] <= chi_square_limit(dof) or (rank == 0 and dof > 0)]
    if not kept:
        return ()
    condition, poor = determination(problem.evaluate, problem.step, states[kept], contacts.sigma)
    distances = residuals[kept] / contacts.weights * contacts.scale
    origin, scale = contacts.origin, contacts.scale
    cylinders = (Cylinder(origin + scale * s[:3], signed_axis(s[3:6]), float(s[6] * scale)) for s in states[kept])
    return candidates_of(cylinders, chi2[kept], distances, condition, poor)
