"""The next contact: the one that removes a free motion, or that distinguishes the remaining poses best.

The fewest further contacts that leave no motion free (`missing_contact`). To first order about one pose, a contact with
outward normal n at x changes by n . v + (x - c) x n . w with a motion (w, v) of the fixture. One contact removes at
most one free motion, so at least as many are missing as motions are free.

1. Possible touches are spread over all features; each has an information matrix of the unconstrained motions.
2. The contacts made, and a measured pose, give the initial information.
3. The touch that increases the determinant of the information most is chosen, until no motion is free (greedy D-optimal
   choice; each removes one free motion if any touch can).
4. If a touch removes no free motion, none does.
5. The first touch is returned, the others as its further ones.

Where the remaining poses disagree by the largest margin in sigma (`distinguishing_contact`):

1. Points are spread over the touchable part of each feature at the best pose; those with a blocked path are dropped.
2. The margin of a point is the least distance, over the other poses, of the fixture's surface from it.
3. The point with the largest margin is chosen, the first of equal ones.
4. If that margin is within sigma, no contact distinguishes the poses.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.accessibility.access import access_of
from tactfix.accessibility.approach_path import path_blocked
from tactfix.accessibility.touchable import extent_of, sample_touches
from tactfix.contacts import Contacts
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Bools, Floats, cross
from tactfix.geometry.rigid import inverse, transform_points
from tactfix.geometry.surfaces import Point, moved, outward_normals, residuals, standoff
from tactfix.localization.motion_words import vector
from tactfix.poses.placement_terms import terms_in_fixture
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.solution import Solution
from tactfix.results import NextContact
from tactfix.wording import coordinates

PLACES_FOR_A_MOTION = 60
"""Candidate touches of each feature, evenly spread: neighbours are about an eighth of a face apart, near enough to the
best one to remove a free motion."""
FREE_RATIO = 1e-7
"""Ratio of singular values below which a motion is free: information is their square, whose rounding is 1e-15."""
UNSEEN_INFORMATION = 1e-10
"""Share of the trace of the information that is added to its diagonal, so that the determinant of singular
information can be compared: well above rounding, well below the information of a touch."""
PLACES_TO_TELL_APART = 200
"""Candidate touches of each feature, evenly spread: neighbours are about a fourteenth of a face apart, so that the best
margin is nearly reached."""
_EQUAL_MARGIN = 1e-9
"""Relative difference of margins up to which they are equal, as at mirror-symmetric points: above rounding. The
first of equal ones is chosen, so that the same contacts give the same point on every machine."""
_FAR_APART = 1000
"""Sigmas beyond which the margin is given as "more than": the number would add nothing, and take a power of ten."""


def missing_contact(fixture: Fixture, contacts: Contacts, solution: Solution) -> NextContact | None:
    """The first of the fewest contacts that leave no motion free, the others in its further; None if none helps.

    solution: one of the poses that the contacts allow. If a motion is free, places are known in the fixture frame only.
    """
    try:
        candidates = _Candidates(fixture, solution, contacts.tip_radius)  # step 1
    except TactfixError:  # a tip that does not fit into a bore that nobody has touched
        return None
    information = candidates.information_of(contacts)  # step 2
    is_free = _free_count(information) > 0
    chosen: list[int] = []
    while len(candidates) and (not chosen or _free_count(information) > 0):
        number = candidates.best(information)  # step 3
        gained = information + candidates.information[number]
        if is_free and _free_count(gained) == _free_count(information):
            return None  # step 4
        chosen.append(number)
        information = gained
    sigma = float(contacts.sigmas.max())
    touches = [candidates.touch(number, sigma, known=not is_free) for number in chosen]
    return _first_of(touches, is_free) if touches else None  # step 5


def _free_count(information: Floats) -> int:
    """The number of free motions; information (u, u)."""
    values = np.linalg.eigvalsh(information)
    return int((values <= FREE_RATIO**2 * max(float(values[-1]), 1.0)).sum())


def _first_of(touches: list[NextContact], is_free: bool) -> NextContact:
    first, *further = touches
    words = f"at least {len(touches)} contacts are missing"
    if not is_free:
        words = "it best determines what the contacts determine weakly"
    elif not further:
        words = "at least one contact is missing; this one is enough"
    return replace(first, message=f"{first.message}: {words}", further=tuple(further))


class _Candidates:
    """Possible touches and their information, in the fixture frame, with features as in the solution."""

    def __init__(self, fixture: Fixture, solution: Solution, tip_radius: float) -> None:
        self.pose = solution.base_from_fixture
        fixture_from_base = inverse(self.pose)
        self.surfaces = {name: moved(fixture_from_base, surface) for name, surface in solution.surfaces.items()}
        self.access = access_of(fixture, self.surfaces, tip_radius)
        # A single point has no size; only rotations remain, for which the unit of length does not matter.
        self.length = self.access.radius or 1.0
        self.basis, self.known = np.eye(6), np.zeros((0, 6))
        if fixture.placement is not None:
            terms = terms_in_fixture(fixture.placement, self.pose, self.access.centre, self.length)
            self.basis, self.known = terms
        spread = {name: self.access.spread(name, PLACES_FOR_A_MOTION) for name in self.surfaces}
        self.names = [name for name, (points, _) in spread.items() for _ in points]
        self.points = np.concatenate([points for points, _ in spread.values()])
        self.normals = np.concatenate([normals for _, normals in spread.values()])
        unknowns = self.basis.shape[1]
        self.information = np.array([self._seen(k) for k in range(len(self.names))]).reshape(-1, unknowns, unknowns)

    def __len__(self) -> int:
        return len(self.names)

    def _seen(self, number: int) -> Floats:
        if isinstance(self.surfaces[self.names[number]], Point):
            return self._information(np.repeat(self.points[number][None], 3, axis=0), np.eye(3))
        return self._information(self.points[number][None], self.normals[number][None])

    def _information(self, points: Floats, normals: Floats) -> Floats:
        """The information (u, u) of touches at points (n, 3) with normals (n, 3), lengths in self.length."""
        rows = np.hstack([cross((points - self.access.centre) / self.length, normals), normals]) @ self.basis
        return np.asarray(rows.T @ rows)

    def information_of(self, contacts: Contacts) -> Floats:
        """The information (u, u) of contacts in base and of a measured pose."""
        fixture_from_base = inverse(self.pose)
        in_base = {name: moved(self.pose, surface) for name, surface in self.surfaces.items()}
        single = one_equation_each(in_base, contacts, contacts.sigmas)
        _, normals = contact_residuals(single.surfaces, single.contacts)
        points = transform_points(fixture_from_base, single.contacts.points)
        known = float(contacts.sigmas.max()) * self.known @ self.basis
        return self._information(points, normals @ fixture_from_base[:3, :3].T) + known.T @ known

    def best(self, information: Floats) -> int:
        """The touch with the largest determinant of the information after it."""
        ground = UNSEEN_INFORMATION * max(float(np.trace(information)), 1.0) * np.eye(len(information))
        return int(np.argmax(np.linalg.slogdet(information + ground + self.information)[1]))

    def touch(self, number: int, sigma: float, known: bool) -> NextContact:
        """One of them in words; known: whether the pose is, so that it has a place in base."""
        name = self.names[number]
        approach = None if isinstance(self.surfaces[name], Point) else -self.normals[number]
        return touch_in_words(name, self.points[number], approach, self.pose if known else None, sigma)


def touch_in_words(
    feature: str, point: Floats, approach: Floats | None, base_from_fixture: Floats | None, sigma: float
) -> NextContact:
    """A touch at a surface point (3,) with an approach (3,), in the fixture frame; in base too if the pose is known.

    approach: None on a point, which holds the tip from all sides. Its message gives place and approach, with the digits
    that are significant for this sigma.
    """
    here, way, frame = point, approach, " of the fixture"
    if base_from_fixture is not None:
        here, frame = transform_points(base_from_fixture, point[None])[0], ""
        way = None if approach is None else base_from_fixture[:3, :3] @ approach
    moving = "" if way is None else f", moving along {vector(np.round(way, 4))}"
    message = f"touch {feature} at {coordinates(here.tolist(), sigma)}{frame}{moving}"
    is_known = base_from_fixture is not None
    return NextContact(feature, here if is_known else None, way if is_known else None, message, point, approach)


def distinguishing_contact(
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
        tips = points + standoff(surface, tip_radius) * normals
        start = fixture.probe.approach_distance
        blocked = path_blocked(surfaces, fixture.touch, name, tips, -normals, start, strict=True)
        free: Bools = np.array([obstacle is None for obstacle in blocked], dtype=bool)
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
