"""Nominal contacts on a fixture that stands at the origin: what margins and blind spots are judged by."""

from collections.abc import Callable, Mapping
from typing import Final, TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Bools, Floats
from tactfix.geometry.rigid import transform_points
from tactfix.geometry.surfaces import Point, Surface, outward_normals
from tactfix.locate_result import LocateResult
from tactfix.placement import Placement
from tactfix.values import frozen_value

ERROR_SIGMAS: Final = 10.0
"""Errors of a radius, a distance or one contact, in sigma."""

Locator: TypeAlias = Callable[[Contacts], LocateResult]


@frozen_value
class Touched:
    """Nominal contacts on a fixture that stands at the origin: the true pose is the identity.

    sigmas (n,) of the residuals; corners (k, 3): the extreme points at which a wrong pose is measured. placement: what
    is known beforehand; the fixture stands at its near in base.
    """

    surfaces: Mapping[str, Surface]
    contacts: Contacts
    sigmas: Floats
    corners: Floats
    placement: Placement | None = None

    @property
    def dof(self) -> int:
        """Equations beyond those that a pose takes."""
        known = -6 if self.placement is None else self.placement.dof
        return len(self.contacts) + 2 * int(self.on_points.sum()) + known

    @property
    def on_points(self) -> Bools:
        """Which contacts (n,) are on points."""
        return np.array([isinstance(self.surfaces[name], Point) for name in self.contacts.features], dtype=bool)

    def standoffs(self, tip_radius: float) -> Floats:
        """How far (n,) the centre of a tip stands off where it touches: nothing on a point."""
        return np.where(self.on_points, 0.0, tip_radius)


def normals_of(touched: Touched) -> Floats:
    """Outward normals (n, 3) at the contacts."""
    pairs = zip(touched.contacts.features, touched.contacts.points, strict=True)
    return np.array([outward_normals(touched.surfaces[name], point) for name, point in pairs])


def moments(touched: Touched, normals: Floats) -> Floats:
    """Rows (n, 6) of the residuals' change by a motion: [x cross n, n], arms in units of the contacts' extent."""
    arms = touched.contacts.points - touched.contacts.points.mean(axis=0)
    return np.hstack([np.cross(arms, normals) / (np.abs(arms).max() or 1.0), normals])


# Contacts that are taken off one by one; of more, those with the most leverage are the least visible.
_TAKEN_OFF_ONE_BY_ONE: Final = 40


def most_telling(touched: Touched) -> list[int]:
    """Indices of the contacts, the most leverage first: what one sees that no other does, the residuals cannot show."""
    rows = moments(touched, normals_of(touched)) / touched.sigmas[:, None]
    leverage = (np.linalg.qr(rows)[0] ** 2).sum(axis=1)
    return [int(i) for i in np.argsort(-leverage)[:_TAKEN_OFF_ONE_BY_ONE]]


# Share of the largest coordinate by which a fit is off by rounding alone.
_FIT_ROUNDING: Final = 1e-12


def shift_of(base_from_fixture: Floats, corners: Floats) -> float:
    """How far the worst of the corners (k, 3) is from where it should be (units)."""
    off = float(np.linalg.norm(transform_points(base_from_fixture, corners) - corners, axis=1).max())
    return off if off > _FIT_ROUNDING * float(np.abs(corners).max()) else 0.0
