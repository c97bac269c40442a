"""Solutions for a rigid fixture: every pose of `all_poses`, with its uncertainty."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Placement
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import axial
from tactfix.geometry.surfaces import Surface, moved
from tactfix.poses.all_poses import all_poses
from tactfix.poses.points_as_planes import Equations, one_equation_each
from tactfix.poses.pose_fit import PoseFit, contact_residuals, fit_at
from tactfix.poses.rigid_sigma_points import rigid_spread
from tactfix.poses.solution import Solution, Solutions, solution_from

UNRESOLVED = 0.5
"""Two poses whose residuals differ by less than this many sigma in all are one: no contact at hand tells them apart."""


def rigid_solutions(
    surfaces: Mapping[str, Surface],
    contacts: Contacts,
    sigmas: Floats,
    with_misses: bool = True,
    placement: Placement | None = None,
    thorough: bool = True,
) -> Solutions:
    """Every pose of a rigid fixture that explains the contacts; surfaces in its frame, sigmas (n,) of the residuals.

    Where none does, the best one alone, its chi2 above the limit; nothing without with_misses. placement, thorough: as
    in `all_poses`.
    """
    single = one_equation_each(surfaces, contacts, sigmas)
    search = all_poses(single.surfaces, single.contacts, single.sigmas, with_misses, placement, thorough)
    found = [_solution(fit, surfaces, contacts, single, placement) for fit in distinct(search.fits)]
    solutions = Solutions(tuple(found), search.dof, search.limit, search.complete, search.continuum)
    if search.aside is None:
        return solutions
    aside = [_solution(fit, surfaces, contacts, single, None) for fit in distinct(search.aside)]
    return replace(solutions, aside=tuple(aside))


def distinct(fits: Sequence[PoseFit]) -> list[PoseFit]:
    """The fits, best first, without those that noise cannot tell from a better one close by."""
    kept: list[PoseFit] = []
    for fit in sorted(fits, key=lambda fit: fit.chi2):
        if not any(_unresolved(other, fit) for other in kept):
            kept.append(fit)
    return kept


def _unresolved(one: PoseFit, other: PoseFit) -> bool:
    """Whether the small motion from one pose to the other changes no residual by a noticeable part of its sigma."""
    turn = other.base_from_fixture[:3, :3] @ one.base_from_fixture[:3, :3].T
    if np.trace(turn) < 2.99:
        return False
    centre = one.sensitivity.centre
    one_origin, other_origin = one.base_from_fixture[:3, 3], other.base_from_fixture[:3, 3]
    shift = other_origin + turn @ (centre - one_origin) - centre
    change = one.sensitivity.jacobian @ np.concatenate([axial(turn) * one.sensitivity.scale, shift])
    return bool(np.linalg.norm(change) < UNRESOLVED)


def solution_at(
    base_from_fixture: Floats, surfaces: Mapping[str, Surface], contacts: Contacts, sigmas: Floats
) -> Solution:
    """What is to be known of one pose (4, 4), known to be the best near itself; surfaces in the fixture's frame."""
    single = one_equation_each(surfaces, contacts, sigmas)
    fit = fit_at(single.surfaces, single.contacts, single.sigmas, base_from_fixture)
    return _solution(fit, surfaces, contacts, single, None)


def _solution(
    fit: PoseFit, surfaces: Mapping[str, Surface], contacts: Contacts, single: Equations, placement: Placement | None
) -> Solution:
    """The fit with its uncertainty spelled out, in terms of the contacts and surfaces as they were given."""
    spread = rigid_spread(fit, single.contacts, single.sigmas, placement)
    in_base = {name: moved(fit.base_from_fixture, surface) for name, surface in surfaces.items()}
    values, normals = contact_residuals(in_base, contacts)
    return solution_from(fit.base_from_fixture, in_base, contacts, values, normals, fit.chi2, spread)
