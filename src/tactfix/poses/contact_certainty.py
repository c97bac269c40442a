"""How surely a pose says where a contact lies on its feature and how the surface faces there.

A small motion of the fixture, rotation w and translation v about a point o, moves a point x of it by
u = v + w x (x - o). The outward normal n below a tip that stays where it is turns by

    plane      w x n
    sphere     w x n - sign (I - n n^T) u / rho
    cylinder   w x n - sign e e^T u / rho,   e = axis x n,

with rho the tip's distance from the centre or axis and sign -1 on an inner surface.
"""

from collections.abc import Mapping

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats, cross
from tactfix.geometry.rigid import skew
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Surface, offset_radius

STILL = 1e-6
"""A free motion that moves a contact less than this share of how far it moves any of them does not move it."""


def contact_certainty(
    surfaces: Mapping[str, Surface], contacts: Contacts, normals: Floats, origin: Floats, factor: Floats, free: Floats
) -> tuple[Floats, Floats]:
    """Standard deviations of each contact's place on the fixture (n,), a length, and of its normal (n,), rad.

    factor (6, m): of the covariance factor factor^T of rotation and translation about origin (3,); free (6, k): motions
    there that nothing resists. Infinite for a contact whose place or normal a free motion changes. Surfaces in base,
    normals (n, 3) the outward ones there.
    """
    places = np.concatenate(
        [-skew(contacts.points - origin), np.broadcast_to(np.eye(3), (len(contacts), 3, 3))], axis=2
    )
    turns = np.concatenate([-skew(normals), np.zeros((len(contacts), 3, 3))], axis=2)
    turns -= _curvatures(surfaces, contacts, normals) @ places
    place, normal = _spread(places @ factor), _spread(turns @ factor)
    if free.shape[1]:
        moves = _spread(places @ free)
        size = float(np.abs(contacts.points - contacts.centre).max()) or 1.0
        place = np.where(moves > STILL * moves.max(), np.inf, place)
        normal = np.where(_spread(turns @ free) > STILL * moves.max() / size, np.inf, normal)
    return place, normal


def _spread(motions: Floats) -> Floats:
    """Root sum of squares (n,) of all entries of motions (n, 3, m)."""
    return np.asarray(np.sqrt((motions**2).sum(axis=(1, 2))))


def _curvatures(surfaces: Mapping[str, Surface], contacts: Contacts, normals: Floats) -> Floats:
    """The matrices (n, 3, 3) that take a move of the surface below a tip to the turn of the normal."""
    curvatures = np.zeros((len(contacts), 3, 3))
    for name, index in contacts.by_feature.items():
        surface = surfaces[name]
        if isinstance(surface, Plane | Point):
            continue
        own = normals[index]
        rho = offset_radius(name, surface.radius, surface.side, contacts.tip_radius)
        if isinstance(surface, Cylinder):
            around = cross(surface.direction, own)
            across = around[:, :, None] * around[:, None, :]
        else:
            across = np.eye(3) - own[:, :, None] * own[:, None, :]
        curvatures[index] = across * ((1.0 if surface.side == "outer" else -1.0) / rho)
    return curvatures
