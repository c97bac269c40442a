"""The parts that the results of every status have: candidates, surfaces, and the residuals of the contacts."""

from collections.abc import Sequence

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.charts import rigid_displacements
from tactfix.geometry.nearest import same_surface
from tactfix.geometry.surfaces import Surface
from tactfix.locate_result import LocateResult
from tactfix.poses.solution import Solution
from tactfix.results import Candidate, ContactResidual, Reason, Status

SAME_SURFACE = 1e-6
"""Rad up to which surfaces have one direction, and share of a free motion up to which it leaves a surface in place: as
`geometry.scale.SPECIAL_POSITION`."""


def candidate_of(solution: Solution, reasons: tuple[Reason, ...]) -> Candidate:
    """A solution as a candidate with the reasons that reject it."""
    return Candidate(solution.base_from_fixture, solution.surfaces, solution.chi2, solution.rms, reasons)


def common_result(
    fixture: Fixture, contacts: Contacts, status: Status, fits: Sequence[Solution], dof: int, limit: float
) -> LocateResult:
    """The result without candidates and pose.

    fits: the solutions that are left, all solutions if none is; the best first. contacts: with the tip of the best.
    """
    best = next(iter(fits), None)
    return LocateResult(
        fixture=fixture.name,
        units=fixture.units,
        status=status,
        base_from_fixture=None,
        covariance=None,
        dof=dof,
        chi2=best.chi2 if best else None,
        chi2_limit=limit,
        rms=best.rms if best else None,
        candidates=(),
        surfaces=_agreed(fits, contacts) if fits and status != "inconsistent" else {},
        contacts=_contact_residuals(contacts, best) if best else (),
    )


def _agreed(solutions: Sequence[Solution], contacts: Contacts) -> dict[str, Surface]:
    """The features that have the same place in every solution."""
    first, *others = solutions
    length = _place_tolerance(first, contacts)
    return {
        name: surface
        for name, surface in first.surfaces.items()
        if _is_determined(surface, first)
        and all(same_surface(surface, other.surfaces[name], length, SAME_SURFACE) for other in others)
    }


def _is_determined(surface: Surface, solution: Solution) -> bool:
    """Whether none of the free motions moves the surface."""
    if not len(solution.free_twists):
        return True
    moves = rigid_displacements(surface, np.zeros(3)) @ solution.free_twists.T
    return bool(np.abs(moves).max(initial=0.0) <= SAME_SURFACE * np.abs(solution.free_twists).max(initial=0.0))


def _place_tolerance(solution: Solution, contacts: Contacts) -> float:
    """Tolerance of a comparison of places: three times the largest sigma of a contact's place, or of a contact."""
    finite = solution.place_sigmas[np.isfinite(solution.place_sigmas)]
    return 3 * float(max(finite.max(initial=0.0), contacts.sigmas.max()))


def _contact_residuals(contacts: Contacts, solution: Solution) -> tuple[ContactResidual, ...]:
    """How each contact fits a solution."""
    cosine = -np.einsum("ij,ij->i", contacts.approaches, solution.normals)
    angles = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    return tuple(
        ContactResidual(row, feature, float(residual), None if np.isnan(angle) else float(angle))
        for row, feature, residual, angle in zip(
            contacts.rows, contacts.features, solution.residuals, angles, strict=True
        )
    )
