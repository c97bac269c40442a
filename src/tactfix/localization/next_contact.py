"""The contact that distinguishes the remaining poses best: where they disagree by the largest margin in sigma.

1. Points are spread over the touchable part of each feature at the best pose; those with a blocked path are dropped.
2. The margin of a point is the least distance, over the other poses, of the fixture's surface from it.
3. The point with the largest margin is chosen, the first of equal ones.
4. If that margin is within sigma, no contact distinguishes the poses.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.accessibility.approach_path import path_blocked
from tactfix.accessibility.touchable import extent_of, sample_touches
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import inverse, transform_points
from tactfix.geometry.surfaces import Point, Surface, moved, outward_normals, residuals, standoff
from tactfix.localization.missing_contacts import touch_in_words
from tactfix.poses.solution import Solution
from tactfix.results import NextContact

PLACES_TO_TELL_APART = 200
"""Candidate touches of each feature, evenly spread: neighbours are about a fourteenth of a face apart, so that the best
margin is nearly reached."""
_EQUAL_MARGIN = 1e-9
"""Relative difference of margins up to which they are equal, as at mirror-symmetric points: above rounding. The
first of equal ones is chosen, so that the same contacts give the same point on every machine."""
_FAR_APART = 1000
"""Sigmas beyond which it is not told how many: the number would say nothing, and take a power of ten."""


def next_contact(
    fixture: Fixture, solutions: Sequence[Solution], sigma: float, tip_radius: float
) -> NextContact | None:
    """A reachable point on a touchable surface, square approach, at which the poses disagree most.

    The point is on the fixture at the best pose, in base; sigma in fixture units. None if the poses have every
    touchable surface in the same place: then no contact distinguishes them.
    """
    first, *others = solutions
    base_from_fixture = first.base_from_fixture
    fixture_from_base = inverse(base_from_fixture)
    surfaces = {name: moved(fixture_from_base, surface) for name, surface in first.surfaces.items()}
    centre, extent = extent_of(surfaces, fixture.touch)
    best: tuple[float, str, Floats, Floats] | None = None
    for name, surface in surfaces.items():
        # Step 1.
        points, normals = sample_touches(surface, fixture.touch.get(name), PLACES_TO_TELL_APART, centre, extent)
        free = _reachable(fixture, surfaces, name, points + standoff(surface, tip_radius) * normals, -normals)
        points, normals = points[free], normals[free]
        if not len(points):
            continue
        # Steps 2 and 3.
        margins = _disagreement(fixture, name, points, normals, tip_radius, first, others)
        top = int(np.argmax(margins >= (1 - _EQUAL_MARGIN) * margins.max()))
        if best is None or margins[top] > (1 + _EQUAL_MARGIN) * best[0]:
            best = (float(margins[top]), name, points[top], normals[top])
    if best is None or best[0] <= sigma:  # step 4
        return None
    margin, name, point, normal = best
    approach = None if isinstance(surfaces[name], Point) else -normal
    touch = touch_in_words(name, point, approach, base_from_fixture, sigma)
    apart = f"{margin / sigma:.3g}" if margin < _FAR_APART * sigma else f"more than {_FAR_APART}"
    disagree = f"the poses disagree by {apart} sigma ({margin:.4g} {fixture.units})"
    return replace(touch, message=f"{touch.message}: {disagree}")


def _reachable(
    fixture: Fixture, surfaces: dict[str, Surface], name: str, points: Floats, approaches: Floats
) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    blocked = path_blocked(
        surfaces, fixture.touch, name, points, approaches, fixture.probe.approach_distance, strict=True
    )
    return np.array([obstacle is None for obstacle in blocked], dtype=bool)


def _disagreement(
    fixture: Fixture,
    name: str,
    points: Floats,
    normals: Floats,
    tip_radius: float,
    first: Solution,
    others: Sequence[Solution],
) -> Floats:
    """The distance (m,) of each contact from the surface at the nearest other pose.

    A pose at which the probe would find no surface, come out of the material, or touch outside the touch box counts as
    disagreeing by the size of the feature.
    """
    off = standoff(first.surfaces[name], tip_radius)
    tips = transform_points(first.base_from_fixture, points + off * normals)
    approaches = -normals @ first.base_from_fixture[:3, :3].T
    worst = np.full(len(points), np.inf)
    for other in others:
        surface = other.surfaces[name]
        gap = np.abs(residuals(surface, tips, tip_radius))
        from_behind = np.einsum("ij,ij->i", approaches, outward_normals(surface, tips)) > 0
        if isinstance(surface, Point):
            from_behind[:] = False
        size = float(np.linalg.norm(points.max(axis=0) - points.min(axis=0))) + tip_radius
        gap = np.where(from_behind, np.maximum(gap, size), gap)
        box = fixture.touch.get(name)
        if box is not None:
            placed = transform_points(inverse(other.base_from_fixture), tips)
            beyond = np.maximum(box.low - placed, placed - box.high).max(axis=1) - tip_radius
            gap = np.where(beyond > 0, np.maximum(gap, beyond), gap)
        worst = np.minimum(worst, gap)
    return worst
