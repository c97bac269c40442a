"""The touches of a fixture that the probe can make without a collision, spread over its surfaces.

1. The box around all touchable parts gives the middle and the size of the fixture (`touchable`).
2. Open touch boxes are closed at that size.
3. A touch can be made if it lies in its box, off the edge, and its straight approach is free (`approach_path`).

Used by simulate and plan, which choose touches. Everything is in the fixture frame.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from tactfix.accessibility.approach_path import path_blocked
from tactfix.accessibility.touchable import closed_box, extreme_points, sample_touches
from tactfix.contacts import Contacts
from tactfix.fixture import Fixture, TouchBox
from tactfix.geometry.arrays import Bools, Floats, Frozen
from tactfix.geometry.surfaces import Cylinder, Point, Sphere, Surface, offset_radius, standoff
from tactfix.units import factor
from tactfix.values import frozen_value

_CLEARANCE = 0.02
"""Distance of a chosen touch from other features and from the edge of its box, as a share of the fixture's radius: the
pose of the fixture is only roughly known when a plan is carried out."""
_EDGE_SHARE = 0.15
"""Largest distance of a chosen touch from the edge of its box, as a share of its width: seven tenths of it remain."""
_UNKNOWN_SIZE = 0.1
"""Size in metres of a fixture whose file gives no length (planes without boxes)."""


@frozen_value
class Access:
    """The surfaces of a fixture with the boxes in which it can be touched.

    corners (8, 3): of the box around all touchable parts; centre (3,), radius: of the ball around that box. boxes: the
    touch boxes of the fixture; limits: the same with open sides closed, in which touches are chosen.
    """

    surfaces: Mapping[str, Surface]
    boxes: Mapping[str, TouchBox]
    limits: Mapping[str, TouchBox | None]
    tip_radius: float
    approach_distance: float | None
    corners: Frozen

    @property
    def centre(self) -> Floats:
        """The middle (3,) of the touchable parts."""
        return np.asarray(self.corners.mean(axis=0))

    @property
    def radius(self) -> float:
        """The distance of the farthest corner from the middle."""
        return float(np.linalg.norm(self.corners[0] - self.centre))

    @property
    def clearance(self) -> float:
        """The distance of a chosen touch from other features and edges."""
        return _CLEARANCE * self.radius

    def can_touch(self, feature: str, points: Floats, normals: Floats, approaches: Floats) -> Bools:
        """Which surface points (n, 3) of feature can be touched: inside the box, not near its edge, path clear."""
        # Step 3.
        inside = _far_from_edge(self.limits[feature], points, normals, self.clearance)
        tips = points + self.tip_radius * normals
        margin = -(self.tip_radius + self.clearance)
        blockers = path_blocked(
            self.surfaces, self.boxes, feature, tips, approaches, self.approach_distance, margin, strict=True
        )
        clear = np.array([blocker is None for blocker in blockers], dtype=bool)
        return np.asarray(inside & clear)

    def spread(self, feature: str, count: int, start: tuple[float, float] = (0.5, 0.5)) -> tuple[Floats, Floats]:
        """About count well spread points (m, 3) that can be touched along the normal, and their normals (m, 3)."""
        surface, limit = self.surfaces[feature], self.limits[feature]
        points, normals = sample_touches(surface, limit, count, self.centre, self.radius, start)
        if isinstance(surface, Point):
            # A point has no direction of approach.
            return points, normals
        free = self.can_touch(feature, points, normals, -normals)
        return points[free], normals[free]

    def nominal_contacts(self, names: Sequence[str], points: Floats, normals: Floats, sigma: float) -> Contacts:
        """Touches at surface points (n, 3) with outward normals (n, 3) as contacts: tip centres, square approaches.

        A contact on a point has no approach.
        """
        count, surfaces = len(names), [self.surfaces[name] for name in names]
        off = np.array([standoff(surface, self.tip_radius) for surface in surfaces])
        on_points = np.array([isinstance(surface, Point) for surface in surfaces], dtype=bool)
        return Contacts(
            features=tuple(names),
            points=points + off[:, None] * normals,
            approaches=np.where(on_points[:, None], np.nan, -normals),
            sigmas=np.full(count, sigma),
            tip_radius=self.tip_radius,
            rows=tuple(range(1, count + 1)),
            ids=(None,) * count,
        )


def access_of(fixture: Fixture, surfaces: Mapping[str, Surface], tip_radius: float) -> Access:
    """The access to a fixture with these surfaces in its frame.

    Raises TipDoesNotFitError if the tip is larger than a bore.
    """
    for name, surface in surfaces.items():
        if isinstance(surface, Sphere | Cylinder):
            offset_radius(name, surface.radius, surface.side, tip_radius)
    corners = extreme_points(surfaces, fixture.touch, least=_UNKNOWN_SIZE * factor("m", fixture.units))  # step 1
    centre, half_width = corners.mean(axis=0), float(np.ptp(corners, axis=0).max()) / 2
    limits: dict[str, TouchBox | None] = {}
    for name, surface in surfaces.items():  # step 2
        box = fixture.touch.get(name)
        limits[name] = box if isinstance(surface, Sphere | Point) else closed_box(surface, box, centre, half_width)
    return Access(surfaces, fixture.touch, limits, tip_radius, fixture.probe.approach_distance, corners)


def _far_from_edge(box: TouchBox | None, points: Floats, normals: Floats, clearance: float) -> Bools:
    """Which points (n, 3) are at least clearance, measured along the surface, from the edge of the box."""
    if box is None:
        return np.ones(len(points), dtype=bool)
    wanted = np.minimum(clearance, _EDGE_SHARE * (box.high - box.low))
    # A face of the box that is parallel to the surface, as around a plane, is no edge: the distance along the surface
    # is the distance from the face over the tangential component.
    slope = np.sqrt(np.clip(1 - normals**2, 0.0, 1.0))
    gap = np.minimum(points - box.low, box.high - points)
    return np.asarray((gap >= np.minimum(wanted * slope, wanted) - 1e-9 * clearance).all(axis=1))
