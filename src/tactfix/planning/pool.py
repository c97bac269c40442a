"""What there is to choose from: touches that the probe can make, spread over all features of the fixture."""

from collections.abc import Mapping

import numpy as np

from tactfix.accessibility.access import Access
from tactfix.errors import UsageError
from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.planning.information import rows_of
from tactfix.values import frozen_value

# Candidates in all, and least and most on one feature: after the polish more of them gain less than other starts do.
_TOTAL, _FEWEST, _MOST = 600, 40, 200
# Contacts on one feature keep this share of its touchable size apart: two touches at one spot would average the
# probe's noise but share the form error there.
_APART = 0.1


@frozen_value
class Touches:
    """m touches in the fixture frame: index of the feature (m,), points and outward normals (m, 3), rows (m, 6)."""

    which: Ints
    points: Floats
    normals: Floats
    rows: Floats

    def __len__(self) -> int:
        return len(self.which)

    def take(self, index: Ints) -> "Touches":
        """The touches with these indices, in that order."""
        return Touches(self.which[index], self.points[index], self.normals[index], self.rows[index])


def joined(first: Touches, second: Touches) -> Touches:
    """The touches of both, first ones first."""
    return Touches(
        np.concatenate([first.which, second.which]),
        np.concatenate([first.points, second.points]),
        np.concatenate([first.normals, second.normals]),
        np.concatenate([first.rows, second.rows]),
    )


@frozen_value
class Pool:
    """Everything to choose from: touches, the names that which counts, and how far apart they stay per feature."""

    access: Access
    names: tuple[str, ...]
    sigmas: Floats
    apart: Floats
    touches: Touches

    def touches_at(self, which: Ints, points: Floats, normals: Floats, sigmas: Floats | None = None) -> Touches:
        """Touches at points (m, 3) with unit normals (m, 3) on the features that which (m,) counts."""
        sigmas = self.sigmas[which] if sigmas is None else sigmas
        rows = rows_of(points, normals, sigmas, self.access.centre, self.access.radius)
        return Touches(which, points, normals, rows)

    def crowded(self, touches: Touches, others: Touches) -> Bools:
        """Which touches (m,) are too near to one of the others on the same feature."""
        arms = touches.points[:, None] - others.points[None]
        near = np.einsum("mnk,mnk->mn", arms, arms) < self.apart[others.which] ** 2
        return np.asarray((near & (touches.which[:, None] == others.which[None])).any(axis=1))


def pool_of(access: Access, sigmas: Mapping[str, float]) -> Pool:
    """All candidates on a fixture. sigmas: one standard deviation of a contact on each feature, its own form included.

    Raises UsageError where no feature can be reached at all.
    """
    names = tuple(access.surfaces)
    each = int(np.clip(_TOTAL / len(names), _FEWEST, _MOST))
    found = [access.spread(name, each) for name in names]
    if not sum(len(points) for points, _ in found):
        raise UsageError(
            "no feature can be reached in a straight line inside its touch box; enlarge the boxes, "
            "or say in the fixture's probe block from how far the probe comes (approach_distance)"
        )
    which = np.concatenate([np.full(len(points), i, dtype=np.intp) for i, (points, _) in enumerate(found)])
    points = np.concatenate([points for points, _ in found])
    normals = np.concatenate([normals for _, normals in found])
    spans = [float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0 for points, _ in found]
    sigma = np.array([sigmas[name] for name in names])
    rows = rows_of(points, normals, sigma[which], access.centre, access.radius)
    return Pool(access, names, sigma, _APART * np.array(spans), Touches(which, points, normals, rows))
