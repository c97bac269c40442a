"""The frames in which poses are searched: centred on the contacts and on the fixture, with lengths of about one."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats, cross
from tactfix.geometry.nearest import foot
from tactfix.geometry.rigid import homogeneous, inverse, orthonormalized
from tactfix.geometry.scale import middle_of
from tactfix.geometry.surfaces import Cylinder, Plane, SidedSurface, Sphere, reference_point, rescaled
from tactfix.placement import Placement
from tactfix.poses.equations import PoseEquations, pose_equations
from tactfix.poses.placement_terms import with_placement
from tactfix.poses.zeros import Zeros
from tactfix.values import frozen_value

COINCIDENT_SHARE = 1e-3
"""Share of the largest radius below which the extent of contacts and surfaces is rounding or noise: lengths are then
scaled by the radius, since equations scaled by the extent would be nearly singular."""
SEARCH_ROUNDING = 1e-12
"""Share of the coordinates below which an extent is rounding: several thousand times the rounding of doubles."""

EXACT_SYMMETRY = 1e-9
"""Largest difference of unit vectors of an exact symmetry: rounding. An approximate symmetry would give twins that are
no zeros."""


@frozen_value
class SearchFrame:
    """The centred and scaled frames of the search: origins (3,) in base and fixture, one length for both."""

    base_origin: Floats
    fixture_origin: Floats
    length: float

    @staticmethod
    def of(surfaces: Mapping[str, SidedSurface], contacts: Contacts) -> "SearchFrame":
        """The frames for contacts and the surfaces that they touch, in the fixture frame."""
        touched = [surfaces[name] for name in contacts.by_feature]
        middle = middle_of(touched)
        base_origin = contacts.points.mean(axis=0)
        spread = ((contacts.points - base_origin) ** 2).sum(axis=1).mean()
        extent = np.mean([((foot(surface, middle) - middle) ** 2).sum() for surface in touched])
        return SearchFrame(base_origin, middle, _length(float(np.sqrt(max(spread, extent))), touched, contacts))

    def equations(
        self,
        surfaces: Mapping[str, SidedSurface],
        contacts: Contacts,
        weights: Floats,
        placement: Placement | None = None,
        sigma: float = 1.0,
    ) -> PoseEquations:
        """The equations of the contacts, scaled; weights (n,) of their residuals.

        placement: prior knowledge of the pose; sigma: the standard deviation of a residual of weight 1.
        """
        names = list(contacts.by_feature)
        scaled = [self._scale(surfaces[name]) for name in names]
        index: Sequence[int] = [names.index(name) for name in contacts.features]
        points = (contacts.points - self.base_origin) / self.length
        equations = pose_equations(scaled, index, points, weights, contacts.tip_radius / self.length)
        if placement is None:
            return equations
        still = homogeneous(np.eye(3), -self.fixture_origin)
        return with_placement(equations, placement, self.base_origin, still, self.length, sigma)

    def half_turns(self, surfaces: Mapping[str, SidedSurface], contacts: Contacts) -> list[Floats]:
        """Rotations (3, 3) by 180 degrees about the search's origin that map every touched surface onto itself.

        The origin is the fixture's middle. Such a rotation fixes it, the points of the surfaces nearest to it and their
        normals, and keeps or reverses axes. So its own axis is along one of those vectors, or perpendicular to two of
        the axes.
        """
        touched = [self._scale(surfaces[name]) for name in contacts.by_feature]
        kept = [reference_point(s) for s in touched]
        kept += [s.normal for s in touched if isinstance(s, Plane)]
        axes = [s.direction for s in touched if isinstance(s, Cylinder)]
        candidates = [v for v in [*kept, *axes, *(cross(a, b) for a, b in combinations(axes, 2))] if v @ v > 1e-6]
        found: list[Floats] = []
        for candidate in candidates:
            turn = 2 * np.outer(candidate, candidate) / (candidate @ candidate) - np.eye(3)
            fixes = all(np.abs(turn @ v - v).max() < EXACT_SYMMETRY for v in kept)
            turns = all(np.linalg.norm(cross(turn @ s, s)) < EXACT_SYMMETRY for s in axes)
            if fixes and turns and not any(np.abs(turn - other).max() < EXACT_SYMMETRY for other in found):
                found.append(turn)
        return found

    def _scale(self, surface: SidedSurface) -> SidedSurface:
        """The surface in the search's frame, with the reference point of a plane or axis nearest to the origin."""
        if not isinstance(surface, Sphere):
            surface = replace(surface, point=foot(surface, self.fixture_origin))
        return rescaled(surface, self.fixture_origin, self.length)

    def base_from_fixture(self, zeros: Zeros) -> Floats:
        """Poses (k, 4, 4) in the user's frames and unit."""
        rotations = orthonormalized(np.moveaxis(zeros.rotations, -1, 0))
        fixture_from_base = homogeneous(rotations, zeros.offsets.T * self.length)
        poses = inverse(fixture_from_base)
        shift = poses[:, :3, :3] @ self.fixture_origin
        poses[:, :3, 3] += self.base_origin - shift
        return poses


def _length(size: float, touched: Sequence[SidedSurface], contacts: Contacts) -> float:
    """The unit of length: size; or the largest radius, or one, if all contacts and surfaces coincide."""
    largest = max((surface.radius for surface in touched if not isinstance(surface, Plane)), default=0.0)
    rounding = SEARCH_ROUNDING * float(np.abs(contacts.points).max())
    return size if size > max(COINCIDENT_SHARE * largest, rounding) else largest or max(rounding, 1.0)
