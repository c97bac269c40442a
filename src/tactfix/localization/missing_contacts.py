"""Which contacts are missing where those made leave a motion free: the fewest, and where to make them.

To first order about one pose a contact with outward normal n at x sees the motion (w, v) by n . v + (x - c) x n . w.
One more contact takes away one free motion at most, so that as many are missing as motions are free.

1. Touches that can be made are spread over all features, each with its information of what is not held.
2. The contacts made and a measured pose give the information to begin with.
3. The touch is chosen with which the determinant of the information grows most (D-optimal, greedily: for independent
   rows the fewest are found so), until no motion is free.
4. Where one takes no free motion away, none helps.
5. The first is told, the others as its further ones.
"""

import numpy as np

from tactfix.accessibility.access import access_of
from tactfix.contacts import Contacts
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats, cross
from tactfix.geometry.rigid import inverse, transform_points
from tactfix.geometry.surfaces import Point, moved
from tactfix.localization.motion_words import vector
from tactfix.poses.placement_terms import terms_in_fixture
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.solution import Solution
from tactfix.results import NextContact
from tactfix.wording import coordinates, listed

PLACES_FOR_A_MOTION = 60
"""Places of each feature that are looked at, evenly spread, for a motion left free."""
FREE = 1e-7
"""Ratio of singular values below which a motion is free."""
UNSEEN = 1e-10
"""Share of the largest information that a motion counts for which nothing sees."""


def missing_contact(fixture: Fixture, contacts: Contacts, solution: Solution) -> NextContact | None:
    """The first of the fewest contacts that leave no motion free, the others in its further; None where none helps.

    solution: one of the poses that the contacts allow. Where a motion is free no place in base is known, only in the
    fixture; else the place is that of the solution.
    """
    try:
        candidates = _Candidates(fixture, solution, contacts.tip_radius)  # step 1
    except TactfixError:  # a tip that does not fit into a bore that nobody has touched
        return None
    information = candidates.information_of(contacts)  # step 2
    is_free = _freedom(information) > 0
    chosen: list[int] = []
    while len(candidates) and (not chosen or _freedom(information) > 0):
        number = candidates.best(information)  # step 3
        gained = information + candidates.information[number]
        if is_free and _freedom(gained) == _freedom(information):
            return None  # step 4
        chosen.append(number)
        information = gained
    sigma = float(contacts.sigmas.max())
    # Step 5.
    touches = [candidates.touch(number, sigma, known=not is_free) for number in chosen]
    return _told(touches, is_free) if touches else None


def _freedom(information: Floats) -> int:
    """How many motions nothing sees; information (u, u)."""
    values = np.linalg.eigvalsh(information)
    return int((values <= FREE**2 * max(float(values[-1]), 1.0)).sum())


def _told(touches: list[NextContact], is_free: bool) -> NextContact:
    first, *further = touches
    if not is_free:
        words = f"{first.message}: it holds best what the contacts hold weakly"
    elif not further:
        words = f"{first.message}: at least one contact is missing, and this one will do"
    else:
        also = listed([touch.message.removeprefix("touch ") for touch in further])
        words = f"{first.message}: at least {len(touches)} contacts are missing, and these will do; then {also}"
    return NextContact(
        first.feature,
        first.point,
        first.approach,
        words,
        first.point_in_fixture,
        first.approach_in_fixture,
        tuple(further),
    )


class _Candidates:
    """Touches that can be made, with what each sees; in the fixture frame, as the solution has its features."""

    def __init__(self, fixture: Fixture, solution: Solution, tip_radius: float) -> None:
        self.pose = solution.base_from_fixture
        fixture_from_base = inverse(self.pose)
        self.surfaces = {name: moved(fixture_from_base, surface) for name, surface in solution.surfaces.items()}
        self.access = access_of(fixture, self.surfaces, tip_radius)
        # A lone point has no size; all about it is a turn, which no unit of length makes more or less seen.
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
        """What touches at points (n, 3) with normals (n, 3) see of what is not held, (u, u), lengths in self.length."""
        rows = np.hstack([cross((points - self.access.centre) / self.length, normals), normals]) @ self.basis
        return np.asarray(rows.T @ rows)

    def information_of(self, contacts: Contacts) -> Floats:
        """What contacts in base and a measured pose see, (u, u)."""
        fixture_from_base = inverse(self.pose)
        in_base = {name: moved(self.pose, surface) for name, surface in self.surfaces.items()}
        single = one_equation_each(in_base, contacts, contacts.sigmas)
        _, normals = contact_residuals(single.surfaces, single.contacts)
        points = transform_points(fixture_from_base, single.contacts.points)
        known = float(contacts.sigmas.max()) * self.known @ self.basis
        return self._information(points, normals @ fixture_from_base[:3, :3].T) + known.T @ known

    def best(self, information: Floats) -> int:
        """The touch that makes the determinant of all information largest."""
        ground = UNSEEN * max(float(np.trace(information)), 1.0) * np.eye(len(information))
        return int(np.argmax(np.linalg.slogdet(information + ground + self.information)[1]))

    def touch(self, number: int, sigma: float, known: bool) -> NextContact:
        """One of them in words; known: whether the pose is, so that it has a place in base."""
        name, point, approach = self.names[number], self.points[number], -self.normals[number]
        return touch_in_words(name, point, approach, self.pose if known else None, sigma)


def touch_in_words(
    feature: str, point: Floats, approach: Floats, base_from_fixture: Floats | None, sigma: float
) -> NextContact:
    """A touch at a surface point (3,) with an approach (3,), in the fixture frame; in base where the pose is known.

    Its message says where to touch and how to come, to the digits that a contact of this sigma bears.
    """
    here, way, frame = point, approach, " of the fixture"
    if base_from_fixture is not None:
        here = transform_points(base_from_fixture, point[None])[0]
        way, frame = base_from_fixture[:3, :3] @ approach, ""
    where = coordinates(here.tolist(), sigma)
    message = f"touch {feature} at {where}{frame}, moving along {vector(np.round(way, 4))}"
    is_known = base_from_fixture is not None
    return NextContact(feature, here if is_known else None, way if is_known else None, message, point, approach)
