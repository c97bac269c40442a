"""One feature alone: every plane, sphere or cylinder that explains the contacts, and the elimination of the wrong ones.

1. The localizer of the feature gives every surface that the contacts allow (`tactfix.localizers`).
2. A surface is rejected by its fit (chi-square, radius) or by the approaches (eq. 11), with the reason (`trial`).
3. The number of accepted surfaces, and how well the contacts determine a single one, give the status.
4. If none is accepted, the other side, outer or inner, is tried, and a warning says if it fits.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from types import MappingProxyType

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import DegenerateContactsError, TipDoesNotFitError, UsageError
from tactfix.fitting.result import FitCandidate, FitResult
from tactfix.fitting.trial import judged, surface_below_tip
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import (
    Cylinder,
    Plane,
    Side,
    SidedSurface,
    SidedType,
    Sphere,
    offset_radius,
    radius_of,
    residuals,
)
from tactfix.localizers.candidate import SurfaceCandidate
from tactfix.localizers.cylinder import localize_cylinder
from tactfix.localizers.plane import localize_plane
from tactfix.localizers.sphere import localize_sphere
from tactfix.localizers.surface_covariance import SurfaceCovariance, surface_covariance
from tactfix.noise import SURE, chi_square_limit
from tactfix.results import Reason

__all__ = ["FitCandidate", "FitResult", "fit"]

SURFACE_PARAMETERS: Mapping[SidedType, int] = MappingProxyType({"plane": 3, "sphere": 4, "cylinder": 5})
"""Number of parameters of a surface with free radius."""

WORTHLESS = 0.3
"""Standard deviation, in rad or as a share of the contacts' extent, beyond which a surface is not located."""


def fit(kind: SidedType, contacts: Contacts, radius: float | None = None, side: Side = "outer") -> FitResult:
    """Fit one plane, sphere or cylinder: find every surface that explains the contacts, and reject the wrong ones.

    Parameters
    ----------
    kind : {"plane", "sphere", "cylinder"}
        Type of the surface.
    contacts : Contacts
        All on that one surface, in base coordinates.
    radius : float, optional
        Of the surface itself, in the contacts' unit; fitted if None. None for a plane.
    side : {"outer", "inner"}
        Outer for a boss, inner for a bore.

    Returns
    -------
    FitResult
        status is "located" if one surface is accepted, "ambiguous" for several, "inconsistent" for none, and
        "underdetermined" if the contacts are too few or degenerate, or determine the surface too weakly; warnings say
        why.

    Raises
    ------
    UsageError
        A plane with a radius.
    TipDoesNotFitError
        A tip that is not smaller than the bore.

    Notes
    -----
    Surfaces are the minima of the sum of (d_i - r_o)^2 / sigma_i^2, with d_i the distance of contact i from the plane,
    centre or axis and r_o the offset radius, radius + tip radius outside and radius - tip radius inside. They are
    rejected by chi-square, or by an approach out of the material (eq. 11).

    References
    ----------
    .. [1] Eqs. 1-45 of the paper of the README.
    .. [2] I. G. Macdonald, J. Pach, T. Theobald, "Common tangents to four unit balls in R^3", Discrete Comput. Geom. 26
       (2001): four contacts on a cylinder of known radius.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> tactfix.fit("sphere", contacts.on("ball"), radius=19.05).surface.center.round(1)
    array([1476.8, -547.2,  476.8])
    """
    if kind == "plane" and radius is not None:
        raise UsageError("a plane has no radius")
    answer = _answer(kind, contacts, radius, side)  # steps 1 to 3
    if answer.status == "inconsistent" and kind != "plane":  # step 4
        answer = replace(answer, warnings=(*answer.warnings, *_of_other_side(kind, contacts, radius, side)))
    return replace(answer, units=contacts.units, contacts=contacts)


def _answer(kind: SidedType, contacts: Contacts, radius: float | None, side: Side) -> FitResult:
    offset = None if radius is None else offset_radius(kind, radius, side, contacts.tip_radius)
    dof = len(contacts) - SURFACE_PARAMETERS[kind] + (offset is not None)
    if dof < 0:
        return _underdetermined(kind, dof, f"{len(contacts)} contacts on a {kind}: {-dof} more needed to locate it")
    try:
        found = _localize(kind, contacts, offset)  # step 1
    except DegenerateContactsError as error:
        return _underdetermined(kind, dof, str(error))
    candidates = [judged(candidate, contacts, side, dof, radius) for candidate in found]  # step 2
    candidates = _without_twins(candidates, contacts, dof)
    if radius is not None and dof == 1:
        candidates += _of_other_radius(kind, contacts, side, radius)
    return _of_candidates(kind, contacts, candidates, dof, radius is not None)  # step 3


def _of_other_side(kind: SidedType, contacts: Contacts, radius: float | None, side: Side) -> tuple[str, ...]:
    """A warning if the contacts locate a surface of the other side."""
    other: Side = "inner" if side == "outer" else "outer"
    try:
        fits = _answer(kind, contacts, radius, other).status == "located"
    except TipDoesNotFitError:
        return ()
    touched = "from inside, a bore or socket" if other == "inner" else "from outside, a boss or ball"
    return (f"the {other} side would fit: was it touched {touched}?",) if fits else ()


def _underdetermined(kind: SidedType, dof: int, why: str) -> FitResult:
    return FitResult(kind, "underdetermined", dof, warnings=(why,))


def _localize(kind: SidedType, contacts: Contacts, offset: float | None) -> tuple[SurfaceCandidate, ...]:
    """Every candidate, with its offset radius."""
    match kind:
        case "plane":
            return localize_plane(contacts.points, contacts.sigmas)
        case "sphere":
            return localize_sphere(contacts.points, offset, contacts.sigmas)
        case "cylinder":
            return localize_cylinder(contacts.points, offset, contacts.sigmas)


def _of_other_radius(kind: SidedType, contacts: Contacts, side: Side, radius: float) -> list[FitCandidate]:
    """The surfaces of another radius through contacts that would determine the radius too (Table 1), rejected."""
    try:
        found = _localize(kind, contacts, None)
    except DegenerateContactsError:
        return []
    others = []
    for candidate in found:
        surface = surface_below_tip(candidate.surface, contacts.tip_radius, side, None)
        known = surface_covariance(candidate.surface, contacts.points, contacts.sigmas, radius_known=False)
        off = radius_of(surface) - radius
        # Within noise it is one of those found with the given radius.
        if abs(off) > SURE * np.sqrt(known.covariance[-1, -1]):
            reason = Reason("fit", None, None, f"its radius would be {radius_of(surface):.7g}, not {radius:g}")
            others.append(FitCandidate(surface, candidate.chi2, candidate.rms, candidate.poorly_determined, (reason,)))
    return others


def _without_twins(candidates: Sequence[FitCandidate], contacts: Contacts, dof: int) -> list[FitCandidate]:
    """The candidates; of two that may be one double root between them within noise, the worse one is rejected."""
    kept = list(candidates)
    for i, k in combinations(range(len(kept)), 2):
        first, second = kept[i], kept[k]
        if not (first.accepted and second.accepted and (first.poorly_determined or second.poorly_determined)):
            continue
        between = _halfway(first.surface, second.surface)
        chi2 = np.sum((residuals(between, contacts.points, contacts.tip_radius) / contacts.sigmas) ** 2)
        if chi2 <= chi_square_limit(dof):
            message = "within noise it is one double root with the candidate before it"
            kept[k] = replace(second, reasons=(Reason("fit", None, None, message),))
    return kept


def _halfway(first: SidedSurface, second: SidedSurface) -> SidedSurface:
    """The surface half-way between two of one kind."""
    if isinstance(first, Sphere) and isinstance(second, Sphere):
        return Sphere((first.center + second.center) / 2, (first.radius + second.radius) / 2, first.side)
    if isinstance(first, Cylinder) and isinstance(second, Cylinder):
        sign = 1.0 if first.direction @ second.direction >= 0 else -1.0
        direction = first.direction + sign * second.direction
        return Cylinder((first.point + second.point) / 2, direction, (first.radius + second.radius) / 2, first.side)
    # The two sides of a plane are no neighbours.
    return first


def _of_candidates(
    kind: SidedType, contacts: Contacts, candidates: Sequence[FitCandidate], dof: int, radius_known: bool
) -> FitResult:
    """The result by the number of accepted candidates."""
    limit = chi_square_limit(dof)
    left = [candidate for candidate in candidates if candidate.accepted]
    warnings = tuple(dict.fromkeys(doubt for candidate in left for doubt in candidate.doubts))
    empty = FitResult(kind, "inconsistent", dof, candidates=tuple(candidates), chi2_limit=limit, warnings=warnings)
    if not left:
        return empty if candidates else replace(empty, warnings=(f"no {kind} explains the contacts",))
    if len(left) > 1:
        return replace(empty, status="ambiguous")
    return _located(empty, left[0], contacts, radius_known)


def _located(result: FitResult, candidate: FitCandidate, contacts: Contacts, radius_known: bool) -> FitResult:
    """The result with its only accepted candidate, unless the contacts determine it too weakly."""
    offset = _surface_of_tip(candidate.surface, contacts.tip_radius)
    known = surface_covariance(offset, contacts.points, contacts.sigmas, radius_known=radius_known)
    if known.weakest > WORTHLESS:
        message = (
            f"the contacts determine the {result.kind} too weakly: one standard deviation is {known.weakest:.2g} "
            "of their extent (or rad); spread them wider"
        )
        return replace(result, status="underdetermined", warnings=(*result.warnings, message))
    warnings = result.warnings
    if candidate.poorly_determined:
        warnings += (
            f"the {result.kind} is close to a double root, which makes it poorly determined: its sigma grows with the "
            "square root of the contacts'; add a contact elsewhere",
        )
    return replace(
        result,
        status="located",
        surface=candidate.surface,
        chi2=candidate.chi2,
        rms=candidate.rms,
        residuals=residuals(candidate.surface, contacts.points, contacts.tip_radius),
        sigma=_sigma(candidate.surface, known),
        warnings=warnings,
    )


def _surface_of_tip(surface: SidedSurface, tip_radius: float) -> SidedSurface:
    """The offset surface, on which the centres of the tip lie."""
    if isinstance(surface, Plane):
        return Plane(surface.point + tip_radius * surface.normal, surface.normal)
    return replace(surface, radius=offset_radius("surface", surface.radius, surface.side, tip_radius))


def _sigma(surface: SidedSurface, known: SurfaceCovariance) -> dict[str, Floats]:
    """One standard deviation of each number of the surface, under its name in the JSON."""
    deviations = np.sqrt(np.diag(known.covariance))
    match surface:
        case Plane():
            return {"point": deviations[:3], "normal": deviations[3:]}
        case Sphere():
            return {"center": deviations[:3], "radius": deviations[3:]}
        case Cylinder():
            return {"point": deviations[:3], "direction": deviations[3:6], "radius": deviations[6:]}
