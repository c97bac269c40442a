"""The tests of a fitted surface: first chi-square, then the approaches (eq. 11)."""

from dataclasses import replace

import numpy as np

from tactfix.contacts import GRAZING, Contacts
from tactfix.fitting.result import FitCandidate
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import (
    Cylinder,
    Plane,
    Side,
    SidedSurface,
    Sphere,
    offset_radius,
    outward_normals,
    residuals,
)
from tactfix.localizers.candidate import SurfaceCandidate
from tactfix.localizers.surface_covariance import SurfaceCovariance, surface_covariance
from tactfix.noise import SURE, chi_square_limit
from tactfix.results import Reason


def judged(candidate: SurfaceCandidate, contacts: Contacts, side: Side, dof: int, radius: float | None) -> FitCandidate:
    """The candidate of the true radius with the reasons to reject it."""
    surface = surface_below_tip(candidate.surface, contacts.tip_radius, side, radius)
    reasons = _misfit(surface, candidate.chi2, contacts, dof)
    doubts: tuple[str, ...] = ()
    if not reasons:
        known = surface_covariance(candidate.surface, contacts.points, contacts.sigmas, radius_known=radius is not None)
        reasons, doubts = _against_approach(surface, known, contacts)
    return FitCandidate(surface, candidate.chi2, candidate.rms, candidate.poorly_determined, reasons, doubts)


def surface_below_tip(offset: SidedSurface, tip_radius: float, side: Side, radius: float | None) -> SidedSurface:
    """The surface itself, from the offset surface; radius: that of the surface if it was given."""
    match offset:
        case Plane():
            return Plane(offset.point - tip_radius * offset.normal, offset.normal)
        case Sphere() | Cylinder():
            found = offset.radius - tip_radius if side == "outer" else offset.radius + tip_radius
            return replace(offset, radius=found if radius is None else radius, side=side)


def _misfit(surface: SidedSurface, chi2: float, contacts: Contacts, dof: int) -> tuple[Reason, ...]:
    """The reason if the contacts do not lie on the surface within noise."""
    if not isinstance(surface, Plane) and surface.radius <= 0:
        message = f"a tip of radius {contacts.tip_radius:g} would have to touch a surface of radius {surface.radius:g}"
        return (Reason("fit", None, None, message),)
    limit = chi_square_limit(dof)
    if chi2 <= limit:
        return ()
    off = residuals(surface, contacts.points, contacts.tip_radius)
    worst = int(np.argmax(np.abs(off) / contacts.sigmas))
    message = (
        f"chi-square {chi2:.3g} exceeds {limit:.3g}; {contacts.label(worst)} is {off[worst]:.3g} off the surface, "
        f"{abs(off[worst]) / contacts.sigmas[worst]:.1f} sigma"
    )
    return (Reason("fit", contacts.features[worst], contacts.rows[worst], message),)


def _against_approach(
    surface: SidedSurface, known: SurfaceCovariance, contacts: Contacts
) -> tuple[tuple[Reason, ...], tuple[str, ...]]:
    """The approaches that violate eq. 11, approach . outward normal < 0, and those too close to grazing to decide."""
    normals = outward_normals(surface, contacts.points)
    cosines = np.where(contacts.has_approach, np.einsum("ij,ij->i", contacts.approaches, normals), -1.0)
    margins = np.minimum(SURE * _cosine_sigmas(surface, known, contacts), GRAZING)
    wrong = [int(i) for i in np.flatnonzero(cosines > margins)]
    reasons = tuple(
        Reason(
            "approach",
            contacts.features[i],
            contacts.rows[i],
            f"at {contacts.label(i)} the probe would have come out of the material (approach . normal = "
            f"{cosines[i]:+.3f})",
        )
        for i in wrong
    )
    doubts = tuple(
        f"the approach at {contacts.label(int(i))} grazes the surface: its sign is not certain"
        for i in np.flatnonzero(np.abs(cosines) <= margins)
    )
    return reasons, doubts


def _cosine_sigmas(surface: SidedSurface, known: SurfaceCovariance, contacts: Contacts) -> Floats:
    """One standard deviation (n,) of approach . outward normal at each contact, from the covariance of the surface."""
    if isinstance(surface, Plane):
        tilt = np.einsum("ni,ij,nj->n", contacts.approaches, known.covariance[3:, 3:], contacts.approaches)
        # For an approach along the normal this is rounding, of either sign.
        return np.asarray(np.sqrt(np.maximum(np.nan_to_num(tilt), 0.0)))
    place = known.covariance[:3, :3]
    if isinstance(surface, Cylinder):
        # At the contact, a distance t along the axis from its point, the axis also moves by t times the tilt.
        along = (contacts.points - surface.point) @ surface.direction
        tilt = known.covariance[3:6, 3:6]
        mixed = known.covariance[:3, 3:6] + known.covariance[3:6, :3]
        spread = place + along[:, None, None] * mixed + along[:, None, None] ** 2 * tilt
    else:
        spread = np.broadcast_to(place, (len(contacts), 3, 3))
    offset = offset_radius("surface", surface.radius, surface.side, contacts.tip_radius)
    across = np.where(contacts.has_approach[:, None], contacts.approaches, 0.0)
    normals = outward_normals(surface, contacts.points)
    across = across - np.sum(across * normals, axis=1, keepdims=True) * normals
    variance = np.einsum("ni,nij,nj->n", across, spread, across)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0) + contacts.sigmas**2) / offset)
