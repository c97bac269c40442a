"""Solutions that no contact tells apart: one minimum reached twice, and branches that lie within the noise."""

from collections.abc import Mapping

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats
from tactfix.geometry.charts import displacement_between, equations_jacobian
from tactfix.geometry.surfaces import Cylinder, Plane, Surface

FOLD = 0.5
"""Sigmas, in all, below which two fits of one branch are one: they have met, or stand on either side of a fold."""
BRANCHES = 2.0
"""The same for fits of two branches, or shapes: chi-square differs by four at most, and either may be true."""
DISTINCT_PLACES = 0.15
"""Rad, and share of the fixture's size, beyond which two places of a feature are two, whatever contacts see of them."""


def seen_difference(
    one: Mapping[str, Surface], other: Mapping[str, Surface], contacts: Contacts, sigmas: Floats, scale: float
) -> float:
    """By how many sigma in all the contacts see surfaces move from one to other; infinite where these are not close.

    sigmas (n,) of the residuals; scale: a length of the fixture.
    """
    seen = 0.0
    for name, surface in one.items():
        step = displacement_between(surface, other[name])
        if step is None:
            return np.inf
        tilts = 2 if isinstance(surface, Plane | Cylinder) else 0
        if max(np.abs(step[:tilts]).max(initial=0.0), np.abs(step[tilts:]).max() / scale) > DISTINCT_PLACES:
            return np.inf
        if name in contacts.by_feature:
            index = contacts.by_feature[name]
            moves = equations_jacobian(surface, contacts.points[index]) @ step / sigmas[index, None]
            seen += float((moves**2).sum())
    return float(np.sqrt(seen))


def weight(chi2: float, other_chi2: float) -> float:
    """The probability of the other of two solutions, from their chi-squares."""
    return float(1 / (1 + np.exp(np.clip((other_chi2 - chi2) / 2, -700, 700))))
