"""The features that solutions agree on, and the residuals of the contacts, for the result."""

from collections.abc import Sequence

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.charts import rigid_displacements
from tactfix.geometry.nearest import same_surface
from tactfix.geometry.surfaces import Surface
from tactfix.poses.solution import Solution
from tactfix.results import ContactResidual


def agreed(solutions: Sequence[Solution], contacts: Contacts) -> dict[str, Surface]:
    """The features that have the same place in every solution."""
    if not solutions:
        return {}
    first, *others = solutions
    length = _place_tolerance(first, contacts)
    return {
        name: surface
        for name, surface in first.surfaces.items()
        if _is_determined(surface, first)
        and all(same_surface(surface, other.surfaces[name], length, 1e-6) for other in others)
    }


def _is_determined(surface: Surface, solution: Solution) -> bool:
    """Whether none of the free motions moves the surface."""
    if not len(solution.free_twists):
        return True
    moves = rigid_displacements(surface, np.zeros(3)) @ solution.free_twists.T
    return bool(np.abs(moves).max(initial=0.0) <= 1e-6 * np.abs(solution.free_twists).max(initial=0.0))


def _place_tolerance(solution: Solution, contacts: Contacts) -> float:
    """Tolerance of a comparison of places: three times the largest sigma of a contact's place, or of a contact."""
    finite = solution.place_sigmas[np.isfinite(solution.place_sigmas)]
    return 3 * float(max(finite.max(initial=0.0), contacts.sigmas.max()))


def contact_residuals(contacts: Contacts, solution: Solution) -> tuple[ContactResidual, ...]:
    """How each contact fits a solution."""
    cosine = -np.einsum("ij,ij->i", contacts.approaches, solution.normals)
    angles = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    return tuple(
        ContactResidual(row, feature, float(residual), None if np.isnan(angle) else float(angle))
        for row, feature, residual, angle in zip(
            contacts.rows, contacts.features, solution.residuals, angles, strict=True
        )
    )
