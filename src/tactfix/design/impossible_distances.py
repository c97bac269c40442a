"""Contacts that no pose explains, told by two of them alone: too far apart for a sphere, or too near for two features.

Wherever a fixture stands, the tip's centres at two touches are no farther apart than the spheres that they lie on
allow, and no nearer than the gap between the two features. A pose that leaves the residuals a and b on them would have
to make up for what is missing, |a| + |b| >= excess, so chi-square is at least excess^2 / (sigma_a^2 + sigma_b^2).
"""

from collections.abc import Mapping
from itertools import combinations_with_replacement

import numpy as np

from tactfix.contacts import Contacts
from tactfix.design.touched import Touched
from tactfix.geometry.arrays import Floats
from tactfix.geometry.nearest import distance_between
from tactfix.geometry.surfaces import Plane, Sphere, Surface, offset_radius


def least_chi_square(touched: Touched, contacts: Contacts) -> float:
    """What no pose of the fixture falls below; 0 where two contacts alone contradict nothing."""
    apart = np.linalg.norm(contacts.points[:, None] - contacts.points[None], axis=2)
    variance = touched.sigmas[:, None] ** 2 + touched.sigmas[None] ** 2
    names = np.array(contacts.features)
    least = 0.0
    for one, other in combinations_with_replacement(touched.surfaces, 2):
        low, high = _limits(touched.surfaces, one, other, contacts.tip_radius)
        pairs = (names == one)[:, None] & (names == other)[None]
        excess: Floats = np.maximum(np.maximum(apart - high, low - apart), 0.0)
        least = max(least, float((excess**2 / variance)[pairs].max(initial=0.0)))
    return least


def _limits(surfaces: Mapping[str, Surface], one: str, other: str, tip_radius: float) -> tuple[float, float]:
    """How near and how far apart the tip's centres can be at touches of two features, or twice of one."""
    a, b = surfaces[one], surfaces[other]
    if one == other:
        return 0.0, 2 * _reach(one, a, tip_radius) if isinstance(a, Sphere) else np.inf
    if not (isinstance(a, Sphere) or isinstance(b, Sphere)):
        return 0.0, np.inf
    distance, reaches = distance_between(a, b), _reach(one, a, tip_radius) + _reach(other, b, tip_radius)
    # A plane's distance is signed, and the tip's centre runs a tip radius above it.
    near = abs(distance - tip_radius) if isinstance(a, Plane) or isinstance(b, Plane) else distance
    both = isinstance(a, Sphere) and isinstance(b, Sphere)
    return max(near - reaches, 0.0), distance + reaches if both else np.inf


def _reach(name: str, surface: Surface, tip_radius: float) -> float:
    """How far from its centre or axis a feature holds the tip's centre; 0 for a plane."""
    if isinstance(surface, Plane):
        return 0.0
    return offset_radius(name, surface.radius, surface.side, tip_radius)
