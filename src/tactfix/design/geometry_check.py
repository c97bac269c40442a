"""The exact check of a fixture's geometry: motions, symmetries, fewest contacts, and nearly special positions."""

from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Final

import numpy as np

from tactfix.design.contact_counts import ContactCounts, contact_counts
from tactfix.design.findings import (
    Finding,
    count_findings,
    motion_findings,
    same_surface_findings,
    shape_findings,
)
from tactfix.design.known_place import left_free, settled
from tactfix.design.symmetries import LAID_ON, Symmetry, symmetries
from tactfix.design.touch_regions import reach_of
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.nearest import direction_between, same_surface
from tactfix.geometry.rigid import rotation_angle
from tactfix.geometry.scale import SPECIAL_POSITION, Tolerance, middle_of, tolerance_for
from tactfix.geometry.surfaces import Cylinder, Sphere, Surface
from tactfix.localization.free_motions import tidied
from tactfix.localization.motion_words import free_motions, motion_in_words
from tactfix.placement import Placement
from tactfix.results import FreeMotion
from tactfix.values import frozen_value

_NEAR_SIGMAS: Final = 10.0
"""Distance from a special position, in sigma, within which a position is nearly special: what depends on
that distance is then ten times less accurate than the contacts, or undetermined. On the plate with pin and ball 5 and
20 give the same report."""
_NEAREST: Final = 0.05
"""Share of the fixture's size above which _NEAR_SIGMAS sigma is not tested: with such a sigma every position would be
nearly special."""


@frozen_value
class GeometryCheck:
    """The check of the unbounded surfaces and their touch boxes.

    near: symmetries to within ten sigma, near_ratio of the fixture's size, that are not exact. size: extent of surfaces
    and boxes (units). findings: without those on symmetries and touch boxes, which depend on the contacts.
    """

    surfaces: Mapping[str, Surface]
    tolerance: Tolerance
    size: float
    free_motions: tuple[FreeMotion, ...]
    symmetries: tuple[Symmetry, ...]
    near: tuple[Symmetry, ...]
    near_ratio: float
    counts: ContactCounts
    findings: tuple[Finding, ...]


def check_geometry(
    fixture: Fixture, surfaces: Mapping[str, Surface], shapes: int, sigma: float | None
) -> GeometryCheck:
    """Check a rigid fixture with its features at surfaces; sigma: of a contact, None if nothing gives it.

    shapes: how many different shapes the fixture's relations allow.
    """
    tolerance = tolerance_for(surfaces)
    known, length = fixture.placement, tolerance.length / tolerance.angle
    motions = _free(surfaces, tolerance, known)
    found = settled(symmetries(surfaces, fixture.touch), known, length)
    counts = contact_counts(fixture.features, surfaces, _distances(surfaces), tolerance, known)
    weak: tuple[FreeMotion, ...] = ()
    near: tuple[Symmetry, ...] = ()
    ratio = _near_ratio(sigma, tolerance)
    if ratio is not None:
        weak = _free(surfaces, tolerance_for(surfaces, ratio), known)
        nearly = settled(symmetries(surfaces, fixture.touch, ratio), known, length)
        near = tuple(s for s in nearly if not _is_among(s, found, ratio))
    return GeometryCheck(
        surfaces=surfaces,
        tolerance=tolerance,
        size=reach_of(surfaces, fixture.touch, middle_of(surfaces.values())),
        free_motions=motions,
        symmetries=found,
        near=near,
        near_ratio=LAID_ON if ratio is None else ratio,
        counts=counts,
        findings=(
            *shape_findings(shapes),
            *motion_findings(motions, weak, surfaces),
            *count_findings(counts, is_rigid=True),
            *same_surface_findings(list(_same(surfaces, tolerance))),
        ),
    )


def _free(surfaces: Mapping[str, Surface], tolerance: Tolerance, placement: Placement | None) -> tuple[FreeMotion, ...]:
    """The motions common to all features that the placement leaves free, in words."""
    motions = free_motions(surfaces, tolerance)
    if placement is None or not motions:
        return motions
    if placement.covariance is not None:
        return ()
    twists = np.array([np.concatenate([motion.rotation, motion.translation]) for motion in motions])
    left = left_free(twists, placement, tolerance.length / tolerance.angle)
    if len(left) == len(motions):
        return motions
    if not len(left):
        return ()
    units = (twist / (np.linalg.norm(twist[:3]) or np.linalg.norm(twist[3:])) for twist in tidied(left))
    return tuple(motion_in_words(unit, surfaces, tolerance) for unit in units)


def _near_ratio(sigma: float | None, tolerance: Tolerance) -> float | None:
    """Ten sigma over the fixture's size; None if that is too large, or not above the tolerance of exact symmetries."""
    size = tolerance.length / tolerance.angle
    if sigma is None or size == 0:
        return None
    ratio = _NEAR_SIGMAS * sigma / size
    return ratio if SPECIAL_POSITION < ratio < _NEAREST else None


def _is_among(symmetry: Symmetry, found: tuple[Symmetry, ...], ratio: float) -> bool:
    """Whether a near symmetry is an exact one."""
    turn = symmetry.image_from_fixture[:3, :3]
    turns: list[Floats] = [s.image_from_fixture[:3, :3] for s in found]
    # Different elements of one group differ by far more than the tolerance.
    return any(rotation_angle(turn.T @ other) < 100 * ratio for other in turns)


def _distances(surfaces: Mapping[str, Surface]) -> set[frozenset[str]]:
    """The pairs between which a rigid fixture has a distance."""
    pairs = combinations(surfaces, 2)
    return {frozenset(pair) for pair in pairs if direction_between(surfaces[pair[0]], surfaces[pair[1]]) is not None}


def _same(surfaces: Mapping[str, Surface], tolerance: Tolerance) -> Iterator[tuple[str, str]]:
    """Pairs of features that are the same surface with the same side."""
    for one, other in combinations(surfaces, 2):
        a, b = surfaces[one], surfaces[other]
        if not same_surface(a, b, tolerance.length, tolerance.angle):
            continue
        if _size_and_side(a) == _size_and_side(b):
            yield one, other


def _size_and_side(surface: Surface) -> tuple[float, str] | None:
    return (surface.radius, surface.side) if isinstance(surface, Sphere | Cylinder) else None
