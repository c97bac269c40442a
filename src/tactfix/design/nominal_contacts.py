"""Noise-free contacts by which a design is checked: a plan, contacts already made, or well spread ones."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final, Literal, TypeAlias

import numpy as np

from tactfix.accessibility.access import Access
from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Bools, Floats, farthest_first
from tactfix.geometry.rigid import transform_points
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Surface, outward_normals
from tactfix.locate_result import LocateResult
from tactfix.noise import SURE, chi_square_limit
from tactfix.placement import Placement
from tactfix.poses.pose_fit import contact_residuals
from tactfix.values import frozen_value

ERROR_SIGMAS: Final = 10.0
"""Errors of a radius, a distance or one contact, in sigma."""

Locator: TypeAlias = Callable[[Contacts], LocateResult]


@frozen_value
class Touched:
    """Nominal contacts on a fixture at the origin: the true pose is the identity.

    sigmas (n,) of the residuals; corners (k, 3): the extreme points at which the error of a pose is measured.
    placement: what is known beforehand; the pose in base is its near.
    """

    surfaces: Mapping[str, Surface]
    contacts: Contacts
    sigmas: Floats
    corners: Floats
    placement: Placement | None = None

    @property
    def dof(self) -> int:
        """Equations minus unknowns of the pose."""
        known = -6 if self.placement is None else self.placement.dof
        return len(self.contacts) + 2 * int(self.on_points.sum()) + known

    @property
    def rms_sigma(self) -> float:
        """The root mean square of the sigmas."""
        return float(np.sqrt((self.sigmas**2).mean()))

    @property
    def on_points(self) -> Bools:
        """Which contacts (n,) are on points."""
        return np.array([isinstance(self.surfaces[name], Point) for name in self.contacts.features], dtype=bool)

    def standoffs(self, tip_radius: float) -> Floats:
        """The distance (n,) of the centre of a tip from the surface that it touches: 0 on a point."""
        return np.where(self.on_points, 0.0, tip_radius)


def normals_of(touched: Touched) -> Floats:
    """Outward normals (n, 3) at the contacts."""
    pairs = zip(touched.contacts.features, touched.contacts.points, strict=True)
    return np.array([outward_normals(touched.surfaces[name], point) for name, point in pairs])


def moments(touched: Touched, normals: Floats) -> Floats:
    """The Jacobian (n, 6) of the residuals for a motion: [x cross n, n], arms in units of the contacts' extent."""
    arms = touched.contacts.points - touched.contacts.points.mean(axis=0)
    return np.hstack([np.cross(arms, normals) / (np.abs(arms).max() or 1.0), normals])


_TAKEN_OFF_ONE_BY_ONE: Final = 40
"""Contacts that are displaced or relabelled one by one; of more, those with the most leverage, whose errors the
residuals show least. They form 780 pairs: small systems that are solved together."""


def most_influential(touched: Touched) -> list[int]:
    """Indices of the contacts, those with the most leverage first: the residuals show their errors least."""
    rows = moments(touched, normals_of(touched)) / touched.sigmas[:, None]
    leverage = (np.linalg.qr(rows)[0] ** 2).sum(axis=1)
    return [int(i) for i in np.argsort(-leverage)[:_TAKEN_OFF_ONE_BY_ONE]]


_FIT_ROUNDING: Final = 1e-12
"""Share of the largest coordinate below which the error of a pose is rounding: some thousand roundings of a double
(2e-16), from a chain of products and one least squares."""


def shift_of(base_from_fixture: Floats, corners: Floats) -> float:
    """The largest displacement of a corner (k, 3) by the error of the pose (units)."""
    off = float(np.linalg.norm(transform_points(base_from_fixture, corners) - corners, axis=1).max())
    return off if off > _FIT_ROUNDING * float(np.abs(corners).max()) else 0.0


Source: TypeAlias = Literal["plan", "contacts", "spread"]

_CHECKED_ALONE: Final[dict[type[Surface], int]] = {Plane: 4, Cylinder: 6, Point: 1}
"""Contacts by which each feature is checked if none are given: one more than it needs alone with unknown size (three on
a plane, five on a cylinder), and one on a point."""
_CHECKED_ON_A_BALL: Final = 5
"""The same on a sphere: four and one more."""
_LAYOUT_POOL: Final = 200
"""Touches of each feature, about, of which the spread ones are those farthest from each other. With 100 the worst
sigma is 2.6 times larger on the cylinder with sphere, and within 7 per cent on the four other shipped fixtures;
with 400 it is within 3 per cent on all. No finding changes with either."""


def spread_contacts(access: Access, sigma: float) -> tuple[Contacts, tuple[str, ...]]:
    """Well spread nominal contacts in the fixture frame, approached square, and the features that cannot be touched.

    On each feature the touches that lie farthest from each other, four on a plane, five on a sphere, six on a cylinder.
    """
    names: list[str] = []
    points: list[Floats] = []
    normals: list[Floats] = []
    unreachable: list[str] = []
    for name, surface in access.surfaces.items():
        choice, outward = access.spread(name, _LAYOUT_POOL)
        pick = farthest_first(choice, _CHECKED_ALONE.get(type(surface), _CHECKED_ON_A_BALL))
        if not len(pick):
            unreachable.append(name)
        names += [name] * len(pick)
        points.append(choice[pick].reshape(-1, 3))
        normals.append(outward[pick].reshape(-1, 3))
    contacts = access.nominal_contacts(names, np.concatenate(points), np.concatenate(normals), sigma)
    return contacts, tuple(unreachable)


def lies_on(surfaces: Mapping[str, Surface], contacts: Contacts, sigmas: Floats) -> bool:
    """Whether the contacts lie on the surfaces within noise: then they are given in the surfaces' frame.

    sigmas (n,) of the residuals. A plan is written with few digits, so each contact may also be SURE sigma off.
    """
    values, _ = contact_residuals(surfaces, contacts)
    scaled = values / sigmas
    return bool((scaled**2).sum() <= chi_square_limit(len(contacts)) or np.abs(scaled).max() <= SURE)


def nominal(contacts: Contacts, surfaces: Mapping[str, Surface]) -> Contacts:
    """The contacts without noise: each moved along the normal to a residual of zero."""
    values, normals = contact_residuals(surfaces, contacts)
    return replace(contacts, points=contacts.points - values[:, None] * normals)
