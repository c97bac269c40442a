"""Rotations that features located alone leave a rigid fixture: the paper's way, as the start for all contacts at once.

A plane located by its own contacts gives a direction, its normal, on either side; each two spheres give another, from
centre to centre. Two directions that are not parallel fix the rotation, one leaves a turn about it. A pose that
explains all contacts explains those of each feature, so it is as near to one of these rotations as the features are
known.
"""

from collections.abc import Mapping
from itertools import product
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import DegenerateContactsError
from tactfix.geometry.arrays import Floats, cross, perpendicular, unit
from tactfix.geometry.rigid import rotation_from_vector
from tactfix.geometry.surfaces import Plane, Sphere, Surface, offset_radius
from tactfix.localizers.candidate import SurfaceCandidate
from tactfix.localizers.plane import localize_plane
from tactfix.localizers.sphere import localize_sphere

SURE = 0.02
"""Share of its own contacts' extent by which a feature must be known to be relied on, one standard deviation; ..."""
NEAR = 0.25
"""... angles between directions may be off by so much (rad), a dozen times that, before they are passed over."""
TURNS = 36
"""Turns about a single direction: one every ten degrees."""
PARALLEL = 0.2
"""Sine of the angle below which a second direction is not used."""
MOST = 64
"""Combinations of candidates that are worth a start; beyond, all rotations are."""

Direction: TypeAlias = tuple[Floats, Floats]
"""A direction (3,) in the fixture frame and where it points in base."""


def feature_rotations(surfaces: Mapping[str, Surface], contacts: Contacts, sigmas: Floats) -> Floats | None:
    """Rotations (3, 3, N) of fixture_from_base near that of every pose; None where no direction is known alone.

    surfaces in the fixture frame; sigmas (n,) of the residuals.
    """
    located = _located(surfaces, contacts, sigmas)
    if np.prod([len(places) for places in located.values()]) > MOST:
        return None
    found: list[Floats] = []
    for choice in product(*located.values()):
        directions = _directions(surfaces, dict(zip(located, choice, strict=True)))
        if not directions:
            return None
        if _agree(directions):
            found.append(_rotations(directions))
    return np.moveaxis(np.concatenate(found), 0, -1) if found else None


def _located(surfaces: Mapping[str, Surface], contacts: Contacts, sigmas: Floats) -> dict[str, list[Surface]]:
    """Planes and spheres that their own contacts locate well, with every place they may have."""
    located: dict[str, list[Surface]] = {}
    for name, index in contacts.by_feature.items():
        try:
            found = _candidates(surfaces[name], contacts.points[index], sigmas[index], contacts.tip_radius)
        except DegenerateContactsError:
            continue
        extent = float(np.linalg.norm(np.ptp(contacts.points[index], axis=0)))
        sure = all(c.condition * sigmas[index].max() < SURE * extent and not c.poorly_determined for c in found)
        if found and sure:
            located[name] = [candidate.surface for candidate in found]
    # A direction takes two spheres: one alone would only double the combinations.
    spheres = [name for name in located if isinstance(surfaces[name], Sphere)]
    return {name: places for name, places in located.items() if spheres != [name]}


def _candidates(surface: Surface, points: Floats, sigmas: Floats, tip_radius: float) -> tuple[SurfaceCandidate, ...]:
    if isinstance(surface, Plane):
        return localize_plane(points, sigmas, tip_radius)
    if isinstance(surface, Sphere):
        return localize_sphere(points, offset_radius("sphere", surface.radius, surface.side, tip_radius), sigmas)
    return ()


def _directions(surfaces: Mapping[str, Surface], located: Mapping[str, Surface]) -> list[Direction]:
    """Normals of the planes, and the ways from the first sphere to the others."""
    directions: list[Direction] = []
    first: tuple[Sphere, Sphere] | None = None
    for name, place in located.items():
        surface = surfaces[name]
        if isinstance(surface, Plane) and isinstance(place, Plane):
            directions.append((surface.normal, place.normal))
        elif isinstance(surface, Sphere) and isinstance(place, Sphere):
            if first is None:
                first = surface, place
            elif np.linalg.norm(surface.center - first[0].center) > surface.radius + first[0].radius:
                directions.append((unit(surface.center - first[0].center), unit(place.center - first[1].center)))
    return directions


def _agree(directions: list[Direction]) -> bool:
    """Whether the directions make the same angles in base as in the fixture."""
    fixture, base = (np.array(side) for side in zip(*directions, strict=True))
    return bool(np.abs(np.arccos(_cosines(fixture)) - np.arccos(_cosines(base))).max() < NEAR)


def _cosines(vectors: Floats) -> Floats:
    return np.asarray(np.clip(vectors @ vectors.T, -1.0, 1.0))


def _rotations(directions: list[Direction]) -> Floats:
    """The rotations (k, 3, 3) that take base directions to those of the fixture: one, or a turn about the only one."""
    fixture, base = (np.array(side) for side in zip(*directions, strict=True))
    u, values, vt = np.linalg.svd(fixture.T @ base)
    if values[1] > PARALLEL**2:
        return np.asarray(u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt)[None]
    axis, from_axis = fixture[0], base[0]
    fixture_frame, base_frame = _frame_about(axis), _frame_about(from_axis)
    angles = np.arange(TURNS) * (2 * np.pi / TURNS)
    return np.asarray(rotation_from_vector(angles[:, None] * axis) @ fixture_frame.T @ base_frame)


def _frame_about(axis: Floats) -> Floats:
    """Rows of a right-handed frame whose third is axis."""
    across = perpendicular(axis)
    return np.array([across, cross(axis, across), axis])
