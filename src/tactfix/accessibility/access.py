"""How the probe gets at a fixture: which touches it can make without hitting anything else, and how they are spread.

Shared by simulate and plan, which choose touches; locate only judges those that were made (`path`). Everything is in
the fixture frame.
"""

from collections.abc import Mapping

import numpy as np

from tactfix.accessibility.approach_path import path_blocked
from tactfix.accessibility.touchable import closed_box, extreme_points, sample_touches
from tactfix.fixture import Fixture, TouchBox
from tactfix.geometry.arrays import Bools, Floats, Frozen
from tactfix.geometry.surfaces import Cylinder, Point, Sphere, Surface, offset_radius
from tactfix.units import factor
from tactfix.values import frozen_value

# A chosen touch keeps this share of the fixture's radius away from other features and from the edge of its box: a plan
# is made before anyone knows exactly where the fixture stands.
_CLEARANCE = 0.02
# A chosen touch keeps no more than this share of the width of a narrow box away from its edge.
_EDGE_SHARE = 0.15
# What is taken for the size of a fixture that does not say its size anywhere (planes without boxes), in metres.
_UNSAID_SIZE = 0.1


@frozen_value
class Access:
    """A fixture as the probe sees it.

    corners (8, 3): of the box around all touchable parts, centre (3,) and radius: of the ball around it. boxes are the
    fixture's own, limits the boxes in which touches are chosen: closed where the fixture's are open.
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
        """How far the touchable parts reach from there."""
        return float(np.linalg.norm(self.corners[0] - self.centre))

    @property
    def clearance(self) -> float:
        """What a chosen touch keeps away from all else."""
        return _CLEARANCE * self.radius

    def can_touch(self, feature: str, points: Floats, normals: Floats, approaches: Floats) -> Bools:
        """Which surface points (n, 3) of feature can be touched: inside the box, not near its edge, path clear."""
        inside = _far_from_edge(self.limits[feature], points, normals, self.clearance)
        tips = points + self.tip_radius * normals
        margin = -(self.tip_radius + self.clearance)
        blockers = path_blocked(
            self.surfaces, self.boxes, feature, tips, approaches, self.approach_distance, margin, strict=True
        )
        clear = np.array([blocker is None for blocker in blockers], dtype=bool)
        return np.asarray(inside & clear)

    def spread(self, feature: str, count: int, start: tuple[float, float] = (0.5, 0.5)) -> tuple[Floats, Floats]:
        """About count well spread points (m, 3) that can be touched square to the surface, and their normals."""
        surface, limit = self.surfaces[feature], self.limits[feature]
        points, normals = sample_touches(surface, limit, count, self.centre, self.radius, start)
        if isinstance(surface, Point):
            # How the tip comes into it is not known, and need not be.
            return points, normals
        free = self.can_touch(feature, points, normals, -normals)
        return points[free], normals[free]


def access_of(fixture: Fixture, surfaces: Mapping[str, Surface], tip_radius: float) -> Access:
    """The access to a fixture whose surfaces stand so in its frame.

    Raises TipDoesNotFitError where the tip is larger than a bore.
    """
    for name, surface in surfaces.items():
        if isinstance(surface, Sphere | Cylinder):
            offset_radius(name, surface.radius, surface.side, tip_radius)
    corners = extreme_points(surfaces, fixture.touch, least=_UNSAID_SIZE * factor("m", fixture.units))
    centre, reach = corners.mean(axis=0), float(np.ptp(corners, axis=0).max()) / 2
    limits: dict[str, TouchBox | None] = {}
    for name, surface in surfaces.items():
        box = fixture.touch.get(name)
        limits[name] = box if isinstance(surface, Sphere | Point) else closed_box(surface, box, centre, reach)
    return Access(surfaces, fixture.touch, limits, tip_radius, fixture.probe.approach_distance, corners)


def _far_from_edge(box: TouchBox | None, points: Floats, normals: Floats, clearance: float) -> Bools:
    """Which points (n, 3) are clearance away, along the surface, from where it leaves its box."""
    if box is None:
        return np.ones(len(points), dtype=bool)
    wanted = np.minimum(clearance, _EDGE_SHARE * (box.high - box.low))
    # Along the surface a coordinate changes by its tangential part only: a face of the box that is parallel to the
    # surface, as around a plane, is never reached.
    slope = np.sqrt(np.clip(1 - normals**2, 0.0, 1.0))
    gap = np.minimum(points - box.low, box.high - points)
    return np.asarray((gap >= np.minimum(wanted * slope, wanted) - 1e-9 * clearance).all(axis=1))
