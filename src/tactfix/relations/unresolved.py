"""Solutions that the contacts do not distinguish: one minimum that was reached twice, and branches within the noise."""

from collections.abc import Mapping

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats
from tactfix.geometry.charts import displacement_between, equations_jacobian
from tactfix.geometry.nearest import anchored
from tactfix.geometry.surfaces import Cylinder, Plane, Surface

FOLD = 0.5
"""Change of all residuals, in sigma, below which two fits of one branch are one: one minimum reached twice, or two
minima on either side of a fold. As `poses.rigid.UNRESOLVED`: no test of the contacts distinguishes half a sigma."""
BRANCHES = 2.0
"""The same for fits of two branches, or two shapes: their chi-squares differ by at most 4, that is two sigma, and
either may be true."""
DISTINCT_PLACES = 0.15
"""Displacement of a feature (rad, fixture sizes) beyond which two places are distinct whatever their residuals: the
comparison by residuals is of first order, and the second-order terms are then 0.15 / 2, 8 per cent."""
UNSEEN = 100.0
"""Displacement of a feature, in sigmas at the size of the fixture, beyond which two solutions are not merged even if
contacts do not distinguish them to first order. Contacts all over a feature distinguish a few sigma. Two contacts on a
plane do not see it turn about the line through them: there a bar at 89.5 deg leaves two poses one degree apart, and two
pins at 45 deg two poses 7 deg apart on one branch. A covariance that covers both describes neither."""


def are_one(
    one: Mapping[str, Surface],
    other: Mapping[str, Surface],
    contacts: Contacts,
    sigmas: Floats,
    scale: float,
    same_branch: bool = True,
) -> bool:
    """Whether contacts do not distinguish two sets of surfaces.

    sigmas (n,) of the residuals; scale: a length of the fixture. same_branch: both are of one shape, with every
    relation on the same branch.
    """
    # Angles alone give no length, so that the scale of their fixture is 1.
    seen, furthest, size = 0.0, 0.0, max(scale, contacts.spread)
    for name, surface in one.items():
        # At the contacts and by norms, so that the result depends neither on reference points nor on the axes of base.
        own = contacts.points[contacts.by_feature[name]] if name in contacts.by_feature else contacts.points
        here = anchored(surface, own.mean(axis=0))
        step = displacement_between(here, other[name])
        if step is None:
            return False
        tilts = 2 if isinstance(surface, Plane | Cylinder) else 0
        tilt, shift = float(np.linalg.norm(step[:tilts])), float(np.linalg.norm(step[tilts:]))
        if max(tilt, shift / size) > DISTINCT_PLACES:
            return False
        furthest = max(furthest, tilt * size, shift)
        if name in contacts.by_feature:
            index = contacts.by_feature[name]
            moves = equations_jacobian(here, contacts.points[index]) @ step / sigmas[index, None]
            seen += float((moves**2).sum())
    return seen < (FOLD if same_branch else BRANCHES) ** 2 and furthest <= UNSEEN * float(sigmas.max())


def weight(chi2: float, other_chi2: float) -> float:
    """The probability of the other of two solutions, from their chi-squares."""
    return float(1 / (1 + np.exp(np.clip((other_chi2 - chi2) / 2, -700, 700))))
