"""Spheres through contacts: three with a known radius, four without, or any number more.

1. Contacts are centred and scaled (`unit_contacts`), and refused if infinitely many spheres pass through them.
2. There are two starts. If the radius is known: the centres above and below the circle that fits best in the contacts'
   plane (eqs. 3-10). If not: the linear least squares of |x|^2 - 2 c . x = constant, and its mirror image in that
   plane.
3. Of a redundant set both take a few steps, and those that may explain the contacts are kept.
4. These are refined by weighted least squares of the distances from the centre (`least_squares`).
5. The distinct minima that noise can explain are returned, best first; of a redundant set the best one in any case.

Eqs. 3-10 for three contacts; N. A. Duffie and others 1984 for four.
"""

import numpy as np

from tactfix.geometry.arrays import TINY, Floats, Ints, lengths
from tactfix.geometry.surfaces import Sphere
from tactfix.localizers.candidate import SurfaceCandidate, candidates_of, determination, distinct_explanations
from tactfix.localizers.least_squares import refined
from tactfix.localizers.unit_contacts import (
    UnitContacts,
    refuse_coincident,
    refuse_collinear,
    refuse_coplanar,
    unit_contacts,
)
from tactfix.noise import chi_square_limit
from tactfix.values import frozen_value

SPHERE_CONTACTS, FREE_SPHERE_CONTACTS = 3, 4
"""Contacts that leave finitely many spheres of known radius, and of free radius."""

_SPHERE_START_STEPS = 6
"""Steps of both starts of a redundant set before one may be dropped: the linear fit starts near a minimum."""

_SPHERE_GIVEN_UP, _SPHERE_RIVAL = 1e3, 4.0
"""After those steps a start is dropped if its chi-square exceeds _SPHERE_GIVEN_UP times the limit and _SPHERE_RIVAL
times the least."""


def localize_sphere(
    points: Floats, radius: float | None = None, sigmas: Floats | float | None = None
) -> tuple[SurfaceCandidate, ...]:
    """Every sphere that explains the contacts.

    Local minima of the weighted sum of (|x_i - c| - radius)^2 over c, and over the radius if it is not given.

    points (n, 3): tip centres or surface points, n >= 3 with radius, n >= 4 without; radius: offset radius, of the
    tip's centres; sigmas (n,) or one number, along the normal, or None for exact contacts: all in one unit.
    Returns the minima whose chi-square noise can explain, best first, and of a redundant set always the global minimum.
    Three contacts: two centres, mirror images in their plane; one, marked poorly determined, if they lie on a great
    circle within noise; none if they lie farther apart.
    Raises DegenerateContactsError if too few contacts differ, all lie on one line, or, without a known radius, all in
    one plane.
    Source: eqs. 3-10 for three contacts; Duffie and others 1984 for four.
    """
    contacts = unit_contacts(points, sigmas)  # step 1
    # Step 2.
    if radius is None:
        refuse_coincident("sphere", contacts, FREE_SPHERE_CONTACTS)
        refuse_coplanar("sphere", contacts)
        problem, states = SphereProblem(contacts.points, contacts.weights, radius_known=False), _free_states(contacts)
    else:
        refuse_coincident("sphere", contacts, SPHERE_CONTACTS)
        refuse_collinear("sphere", contacts)
        problem = SphereProblem(contacts.points, contacts.weights, radius_known=True)
        states = _known_states(contacts, radius / contacts.scale)
    if len(contacts.points) > SPHERE_CONTACTS + (radius is None):
        # Step 3.
        states = _worth_following(
            problem, contacts.sigma, refined(problem.evaluate, problem.step, states, _SPHERE_START_STEPS)
        )
    states = refined(problem.evaluate, problem.step, states)  # step 4
    return _candidates(problem, contacts, states)  # step 5


def _worth_following(problem: "SphereProblem", sigma: float, states: Floats) -> Floats:
    """The states, after a few steps, that may explain the contacts or lead to the optimum."""
    residuals, _ = problem.evaluate(states, np.arange(len(states)))
    chi2 = np.sum(residuals**2, axis=1) / sigma**2
    worth = chi2 <= np.maximum(_SPHERE_GIVEN_UP * chi_square_limit(len(problem.points)), _SPHERE_RIVAL * chi2.min())
    return np.asarray(states[worth])


@frozen_value
class SphereProblem:
    """Contacts (n, 3) of unit size and weights (n,); a state is (centre (3,), radius)."""

    points: Floats
    weights: Floats
    radius_known: bool

    def evaluate(self, states: Floats, index: Ints) -> tuple[Floats, Floats]:
        """Residuals (B, n), weight * (distance from the centre - radius), and Jacobians (B, n, 3 or 4)."""
        del index
        arms = self.points - states[:, None, :3]
        distance = lengths(arms)
        slopes = arms * (-self.weights / np.maximum(distance, TINY))[..., None]
        if not self.radius_known:
            slopes = np.concatenate([slopes, np.broadcast_to(-self.weights[:, None], (*distance.shape, 1))], axis=-1)
        return self.weights * (distance - states[:, 3:]), slopes

    def step(self, states: Floats, change: Floats) -> Floats:
        """The states after a change (B, 3 or 4) of centre and radius."""
        moved = states.copy()
        moved[:, : change.shape[1]] += change
        return moved


def _free_states(contacts: UnitContacts) -> Floats:
    """The sphere that makes |x|^2 - 2 c . x as constant as can be, and its mirror image in the contacts' plane."""
    points, weights = contacts.points, contacts.weights
    design = np.column_stack([2 * points, np.ones(len(points))])
    solution, *_ = np.linalg.lstsq(design * weights[:, None], weights * np.sum(points**2, axis=1), rcond=None)
    center = solution[:3]
    normal = np.linalg.svd(points, full_matrices=False)[2][-1]
    centers = np.array([center, center - 2 * (center @ normal) * normal])
    radii = np.mean(lengths(points - centers[:, None]), axis=1)
    return np.column_stack([centers, radii])


def _known_states(contacts: UnitContacts, radius: float) -> Floats:
    """The centres above and below the best circle in the contacts' plane, with the known radius."""
    points, weights = contacts.points, contacts.weights
    axes = np.linalg.svd(points, full_matrices=False)[2]
    flat = points @ axes[:2].T
    design = np.column_stack([2 * flat, np.ones(len(points))])
    solution, *_ = np.linalg.lstsq(design * weights[:, None], weights * np.sum(flat**2, axis=1), rcond=None)
    rho_squared = solution[2] + solution[:2] @ solution[:2]
    middle, height = solution[:2] @ axes[:2], np.sqrt(max(radius**2 - rho_squared, 0.0))
    centers = [middle + height * axes[2], middle - height * axes[2]] if height > 0 else [middle]
    if len(points) > SPHERE_CONTACTS:
        # For contacts around a whole sphere the centre is near their mean.
        centers.append(np.zeros(3))
    return np.column_stack([np.array(centers), np.full(len(centers), radius)])


def _candidates(problem: SphereProblem, contacts: UnitContacts, states: Floats) -> tuple[SurfaceCandidate, ...]:
    """The distinct states that noise can explain, best first; of a redundant set always the best one."""
    residuals, jacobians = problem.evaluate(states, np.arange(len(states)))
    chi2 = np.sum(residuals**2, axis=1) / contacts.sigma**2
    dof = len(contacts.points) - jacobians.shape[-1]
    kept = distinct_explanations(states, chi2, dof)
    if not kept:
        return ()
    states = states[kept]
    distances = residuals[kept] / contacts.weights * contacts.scale
    condition, poor = determination(problem.evaluate, problem.step, states, contacts.sigma)
    spheres = (Sphere(contacts.origin + contacts.scale * s[:3], float(s[3] * contacts.scale)) for s in states)
    return candidates_of(spheres, chi2[kept], distances, condition, poor)
