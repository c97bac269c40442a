"""Cylinders that stand on a plane, located by their own contacts: pins and bores of a plate are most of them.

The normal of a located plane is the direction of every axis square to it. Along that direction the contacts of such a
cylinder lie on a circle, and the linear fit of a circle gives where the axis stands.
"""

from collections.abc import Mapping

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import TINY, Floats, basis_across, cross, lengths
from tactfix.geometry.surfaces import Cylinder, Plane, SidedSurface

CIRCLE_CONTACTS = 3
"""Contacts that a circle needs."""
UPRIGHT = 1e-3
"""Sine of the angle between an axis and the normal up to which the cylinder stands on the plane."""


def upright_cylinders(
    surfaces: Mapping[str, SidedSurface], contacts: Contacts, sigmas: Floats, plane: Plane, normal: Floats, tilt: float
) -> dict[str, tuple[Cylinder, float]]:
    """The cylinders on a plane that their contacts locate, each in base, and how surely its axis stands there.

    surfaces and plane, the located one, in the fixture frame; sigmas (n,) of the residuals; normal (3,): that of the
    plane in base, on either side; tilt: one standard deviation of it (rad). Each cylinder comes with the standard
    deviation of its axis across its direction, as a share of the extent of the contacts.
    """
    found: dict[str, tuple[Cylinder, float]] = {}
    for name, index in contacts.by_feature.items():
        surface = surfaces[name]
        if len(index) >= CIRCLE_CONTACTS and isinstance(surface, Cylinder) and _stands_on(surface, plane):
            center, sigma, extent = _circle(contacts.points[index], normal, float(sigmas[index].max()), tilt)
            found[name] = (Cylinder(center, normal, surface.radius, surface.side), sigma / max(extent, TINY))
    return found


def _stands_on(cylinder: Cylinder, plane: Plane) -> bool:
    return bool(lengths(cross(cylinder.direction, plane.normal)) < UPRIGHT)


def _circle(points: Floats, normal: Floats, sigma: float, tilt: float) -> tuple[Floats, float, float]:
    """The centre (3,) of the circle on which contacts (n, 3) lie along normal, its sigma, and their extent across.

    |x|^2 - 2 c . x is made as constant as can be; its values are off by twice sigma times the radius.
    """
    middle = points.mean(axis=0)
    arms = points - middle
    across = basis_across(normal)
    flat = arms @ across.T
    squared = (flat**2).sum(axis=1)
    u, spread, vh = np.linalg.svd(flat, full_matrices=False)
    if spread[-1] <= TINY:
        return middle, np.inf, 1.0
    center = ((squared - squared.mean()) @ u / (2 * spread)) @ vh
    radius = np.sqrt(squared.mean() + center @ center)
    height = float(np.ptp(arms @ normal))
    return (
        middle + center @ across,
        float(np.hypot(sigma * radius / spread[-1], tilt * height)),
        float(np.sqrt((np.ptp(flat, axis=0) ** 2).sum())),
    )
