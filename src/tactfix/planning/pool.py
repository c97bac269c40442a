"""The pool of candidate touches: those that the probe can make, spread over all features of the fixture.

1. Each feature has its share of the candidates, within limits, spread evenly over its touchable part.
2. Each touch has its row of the information, or three on a point (`information.rows_of`).
3. Two contacts on one feature keep a distance, a share of the extent of its candidates.
"""

from collections.abc import Mapping

import numpy as np

from tactfix.accessibility.access import Access
from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.geometry.surfaces import Point, feet, outward_normals
from tactfix.planning.information import rows_of
from tactfix.probe import residual_sigmas
from tactfix.values import frozen_value

_POOL_SIZE = 600
"""Candidates in all. With 300 the worst sigma of five plans of 7 to 9 contacts (three planes, sphere and cylinder,
three spheres, plate with pin and ball) is up to 2 per cent larger after the polish, with 1,200 less than 2 per
cent smaller."""
_FEWEST_ON_ONE = 40
"""Candidates on one feature at least, for fixtures of more than fifteen features. With 20 and 80 five plans of 7 to
9 contacts (three planes, sphere and cylinder, three spheres, plate with pin and ball) change by less than 2 per
cent in their worst sigma."""
_MOST_ON_ONE = 200
"""Candidates on one feature at most. With 100 the plan on the plate with pin and ball has a worst sigma 2 per cent
larger, with 400 none of those plans changes by so much."""
_APART = 0.1
"""Share of a feature's touchable size that contacts on it keep apart: two touches at one spot would average the
probe's noise but share the form error there. With half as much the worst sigma of those plans changes by less
than 2 per cent."""


@frozen_value
class Touches:
    """m touches in the fixture frame: index of the feature (m,), points and outward normals (m, 3), sigmas (m,).

    rows: (m, 6); (m, 3, 6) if the fixture has points, whose touches have three rows, others filled up with zeros.
    """

    which: Ints
    points: Floats
    normals: Floats
    sigmas: Floats
    rows: Floats

    def __len__(self) -> int:
        return len(self.which)

    def take(self, index: Ints) -> "Touches":
        """The touches with these indices, in that order."""
        which, sigmas = self.which[index], self.sigmas[index]
        return Touches(which, self.points[index], self.normals[index], sigmas, self.rows[index])


def joined(first: Touches, second: Touches) -> Touches:
    """The touches of both, first ones first."""
    return Touches(
        np.concatenate([first.which, second.which]),
        np.concatenate([first.points, second.points]),
        np.concatenate([first.normals, second.normals]),
        np.concatenate([first.sigmas, second.sigmas]),
        np.concatenate([first.rows, second.rows]),
    )


@frozen_value
class Pool:
    """All candidates: touches, the names by the index `which`, and the least distance of contacts on each feature."""

    access: Access
    names: tuple[str, ...]
    sigmas: Floats
    apart: Floats
    touches: Touches

    def touches_at(self, which: Ints, points: Floats, normals: Floats, sigmas: Floats | None = None) -> Touches:
        """Touches at points (m, 3) with unit normals (m, 3) on the features of index which (m,)."""
        return _touches(self.access, which, points, normals, self.sigmas[which] if sigmas is None else sigmas)

    def on_points(self, which: Ints) -> Bools:
        """Which of the features (m,) are points."""
        return _on_points(self.access, which)

    def crowded(self, touches: Touches, others: Touches) -> Bools:
        """Which touches (m,) are nearer than apart to one of the others on the same feature."""
        arms = touches.points[:, None] - others.points[None]
        near = np.einsum("mnk,mnk->mn", arms, arms) < self.apart[others.which] ** 2
        return np.asarray((near & (touches.which[:, None] == others.which[None])).any(axis=1))


def pool_of(access: Access, sigmas: Mapping[str, float]) -> Pool:
    """All candidates on a fixture; sigmas: of a contact on each feature, its form error included.

    Raises UsageError if no feature can be touched.
    """
    names = tuple(access.surfaces)  # step 1
    each = int(np.clip(_POOL_SIZE / len(names), _FEWEST_ON_ONE, _MOST_ON_ONE))
    found = [access.spread(name, each) for name in names]
    if not sum(len(points) for points, _ in found):
        raise UsageError(
            "no feature can be reached in a straight line inside its touch box; enlarge the boxes, "
            "or give in the fixture's probe block from how far the probe comes (approach_distance)"
        )
    which = np.concatenate([np.full(len(points), i, dtype=np.intp) for i, (points, _) in enumerate(found)])
    points = np.concatenate([points for points, _ in found])
    normals = np.concatenate([normals for _, normals in found])
    spans = [float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0 for points, _ in found]
    sigma = np.array([sigmas[name] for name in names])
    touches = _touches(access, which, points, normals, sigma[which])  # step 2
    # Step 3.
    return Pool(access, names, sigma, _APART * np.array(spans), touches)


def _on_points(access: Access, which: Ints) -> Bools:
    return np.array([isinstance(surface, Point) for surface in access.surfaces.values()])[which]


def _touches(access: Access, which: Ints, points: Floats, normals: Floats, sigmas: Floats) -> Touches:
    return Touches(which, points, normals, sigmas, _rows(access, which, points, normals, sigmas))


def _rows(access: Access, which: Ints, points: Floats, normals: Floats, sigmas: Floats) -> Floats:
    """The rows of touches about the middle of the fixture, in its radii; see Touches."""
    centre = access.centre
    if not any(isinstance(surface, Point) for surface in access.surfaces.values()):
        return rows_of(points, normals, sigmas, centre, access.radius)
    on_points = _on_points(access, which)
    rows = np.zeros((len(which), 3, 6))
    rows[:, 0] = rows_of(points, normals, sigmas, centre, access.radius)
    for axis, direction in enumerate(np.eye(3)):
        along = np.tile(direction, (int(on_points.sum()), 1))
        rows[on_points, axis] = rows_of(points[on_points], along, sigmas[on_points], centre, access.radius)
    return rows


def touches_made(pool: Pool, contacts: Contacts | None, fixture: Fixture) -> Touches:
    """Contacts already made, in the fixture frame, as touches with their own sigmas; no touches for None."""
    if contacts is None:
        return pool.touches.take(np.zeros(0, dtype=np.intp))
    surfaces = [pool.access.surfaces[name] for name in contacts.features]
    points = np.array([feet(surface, point) for surface, point in zip(surfaces, contacts.points, strict=True)])
    normals = np.array([outward_normals(surface, point) for surface, point in zip(surfaces, points, strict=True)])
    which = np.array([pool.names.index(name) for name in contacts.features], dtype=np.intp)
    sigmas = residual_sigmas(fixture, contacts)
    return pool.touches_at(which, points, normals, sigmas)


def joined_contacts(first: Contacts | None, second: Contacts) -> Contacts:
    """The contacts of both, in one frame, with rows renumbered; the tip is that of the second."""
    if first is None:
        return second
    return Contacts(
        features=first.features + second.features,
        points=np.concatenate([first.points, second.points]),
        approaches=np.concatenate([first.approaches, second.approaches]),
        sigmas=np.concatenate([first.sigmas, second.sigmas]),
        tip_radius=second.tip_radius,
        rows=tuple(range(1, len(first) + len(second) + 1)),
        ids=first.ids + second.ids,
    )
