"""How the probe gets at a fixture: which touches it can make without hitting anything else, and how they are spread.

Shared by simulate and plan, which choose touches; locate only judges those that were made (`tactfix.reach`). Everything
is in the fixture frame.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tactfix.fixture import Fixture, TouchBox
from tactfix.geometry.arrays import Bools, Floats, frozen
from tactfix.geometry.surfaces import Plane, Surface, offset_radius
from tactfix.reach import path_blocked
from tactfix.touchable import extent_of, sample_touches
from tactfix.units import factor

# A chosen touch keeps this share of the fixture's radius away from other features and from the edge of its box: a plan
# is made before anyone knows exactly where the fixture stands.
_CLEARANCE = 0.02
# ... but never more than this share of the width of a narrow box.
_EDGE_SHARE = 0.15
# What is taken for the size of a fixture that does not say its size anywhere (planes without boxes), in metres.
_LEAST = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Access:
    """A fixture as the probe sees it. centre (3,) and radius: its middle and extent; clearance: kept from all else."""

    surfaces: Mapping[str, Surface]
    boxes: Mapping[str, TouchBox]
    tip_radius: float
    approach_distance: float | None
    centre: Floats
    radius: float
    clearance: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", frozen(self.centre))

    def can_touch(self, feature: str, points: Floats, normals: Floats, approaches: Floats) -> Bools:
        """Which surface points (n, 3) of feature can be touched: inside the box, not near its edge, path clear."""
        inside = _far_from_edge(self.boxes.get(feature), points, normals, self.clearance)
        tips = points + self.tip_radius * normals
        margin = -(self.tip_radius + self.clearance)
        blockers = path_blocked(
            self.surfaces, self.boxes, feature, tips, approaches, self.approach_distance, margin, strict=True
        )
        clear = np.array([blocker is None for blocker in blockers], dtype=bool)
        return np.asarray(inside & clear)

    def spread(self, feature: str, count: int, start: tuple[float, float] = (0.5, 0.5)) -> tuple[Floats, Floats]:
        """About count well spread points (m, 3) that can be touched square to the surface, and their normals."""
        surface, box = self.surfaces[feature], self.boxes.get(feature)
        points, normals = sample_touches(surface, box, count, self.centre, self.radius, start)
        free = self.can_touch(feature, points, normals, -normals)
        return points[free], normals[free]


def access_of(fixture: Fixture, surfaces: Mapping[str, Surface], tip_radius: float) -> Access:
    """The access to a fixture whose surfaces stand so in its frame.

    Raises TipDoesNotFitError where the tip is larger than a bore.
    """
    for name, surface in surfaces.items():
        if not isinstance(surface, Plane):
            offset_radius(name, surface.radius, surface.side, tip_radius)
    centre, radius = extent_of(surfaces, fixture.touch, least=_LEAST * factor("m", fixture.units))
    return Access(
        surfaces=surfaces,
        boxes=fixture.touch,
        tip_radius=tip_radius,
        approach_distance=fixture.probe.approach_distance,
        centre=centre,
        radius=radius,
        clearance=_CLEARANCE * radius,
    )


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
