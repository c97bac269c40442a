"""Covariance of the numbers of a located surface, also near a double root.

1. The contacts are scaled to unit size, and the surface becomes a state of its least-squares problem.
2. The singular value decomposition of the Jacobian gives independent directions of the parameters.
3. Along each the standard deviation is sigma / s, s the singular value, but at most sqrt(2 sigma / c): there the
   curvature c of the residuals changes them by one sigma. This is the smaller one at a double root, where s = 0.
4. Differences give the derivatives of the surface's numbers by the parameters.
"""

import numpy as np

from tactfix.geometry.arrays import Floats, Frozen
from tactfix.geometry.surfaces import Cylinder, Plane, SidedSurface, Sphere
from tactfix.localizers.candidate import PROBE
from tactfix.localizers.cylinder_refinement import CylinderProblem
from tactfix.localizers.plane import PlaneProblem
from tactfix.localizers.sphere import SphereProblem
from tactfix.localizers.unit_contacts import UnitContacts, unit_contacts
from tactfix.values import frozen_value

_SURFACE_STEP = 1e-5
"""Step of the central differences from parameters to the numbers of a surface, in problems of unit size: near the cube
root of the rounding of doubles, 6e-6. Rounding is 2e-11 and the third order 1e-10."""


@frozen_value
class SurfaceCovariance:
    """The numbers of a surface and their covariance (q, q).

    numbers (q,): plane: point, normal; sphere: center, radius; cylinder: point, direction, radius. The covariance is
    singular: a direction has unit length, and the point of an axis or plane moves only perpendicular to the axis or
    along the normal. weakest: the largest standard deviation of a parameter, in units of the contacts' extent or rad.
    """

    numbers: Frozen
    covariance: Frozen
    weakest: float


def surface_covariance(
    surface: SidedSurface, points: Floats, sigmas: Floats | float | None, *, radius_known: bool
) -> SurfaceCovariance:
    """Covariance of a surface that was fitted to contacts, from the Jacobian of its residuals.

    surface: the offset surface of the contacts (radius of the tip's centres; a plane through them); points (n, 3),
    sigmas (n,), one number or None: as given to the localizer; radius_known: the radius has no uncertainty.
    """
    contacts = unit_contacts(points, sigmas)  # step 1
    problem, state = _problem(surface, contacts, radius_known)
    index = np.zeros(1, dtype=np.intp)
    residuals, jacobian = problem.evaluate(state[None], index)
    u, singular, vh = np.linalg.svd(jacobian[0], full_matrices=False)  # step 2
    deviations = np.empty(len(vh))
    for k, direction in enumerate(vh):  # step 3
        ahead, _ = problem.evaluate(problem.step(state[None], PROBE * direction[None]), index)
        behind, _ = problem.evaluate(problem.step(state[None], -PROBE * direction[None]), index)
        curvature = abs(u[:, k] @ (ahead + behind - 2 * residuals)[0]) / PROBE**2
        with np.errstate(divide="ignore"):
            deviations[k] = min(contacts.sigma / abs(singular[k]), np.sqrt(2 * contacts.sigma / np.float64(curvature)))
    steps = _SURFACE_STEP * np.eye(len(vh))  # step 4
    stack = np.broadcast_to(state, (len(vh), len(state)))
    numbers_from_parameters = (problem.step(stack, steps) - problem.step(stack, -steps)).T / (2 * _SURFACE_STEP)
    factors = _lengths(surface, contacts.scale)[:, None] * numbers_from_parameters @ vh.T * deviations
    return SurfaceCovariance(_numbers(surface), factors @ factors.T, float(deviations.max()))


def _problem(
    surface: SidedSurface, contacts: UnitContacts, radius_known: bool
) -> tuple[PlaneProblem | SphereProblem | CylinderProblem, Floats]:
    """The least-squares problem of a surface and its state there."""
    points, weights = contacts.points, contacts.weights
    match surface:
        case Plane():
            place = (surface.point - contacts.origin) / contacts.scale
            return PlaneProblem(points, weights), np.concatenate([place, surface.normal])
        case Sphere():
            place = (surface.center - contacts.origin) / contacts.scale
            return SphereProblem(points, weights, radius_known), np.append(place, surface.radius / contacts.scale)
        case Cylinder():
            place = (surface.point - contacts.origin) / contacts.scale
            state = np.concatenate([place, surface.direction, [surface.radius / contacts.scale]])
            return CylinderProblem(points, weights, radius_known), state


def _numbers(surface: SidedSurface) -> Floats:
    match surface:
        case Plane():
            return np.concatenate([surface.point, surface.normal])
        case Sphere():
            return np.append(surface.center, surface.radius)
        case Cylinder():
            return np.concatenate([surface.point, surface.direction, [surface.radius]])


def _lengths(surface: SidedSurface, scale: float) -> Floats:
    """The unit of each number of a surface: scale for lengths, 1 for directions."""
    match surface:
        case Plane():
            return np.repeat([scale, 1.0], 3)
        case Sphere():
            return np.full(4, scale)
        case Cylinder():
            return np.append(np.repeat([scale, 1.0], 3), scale)
