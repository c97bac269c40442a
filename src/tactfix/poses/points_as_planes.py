"""Contacts on points as contacts on planes, for the search and the fit of poses.

A point that fixes the tip's centre is replaced by three planes, perpendicular to the fixture's axes and offset from the
point by the tip's radius. The tip touches all three when its centre is at the point. So one contact on the point is one
on each plane: three equations with the same sigma, exactly those of the point.
"""

from collections.abc import Mapping

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import UNIT_AXES, Floats, Ints
from tactfix.geometry.surfaces import Plane, Point, SidedSurface, Surface
from tactfix.values import frozen_value


@frozen_value
class Equations:
    """m contacts with one equation each: surfaces in the fixture frame; sigmas (m,) of the residuals.

    of (m,): index of the given contact of each equation.
    """

    surfaces: Mapping[str, SidedSurface]
    contacts: Contacts
    sigmas: Floats
    of: Ints


def one_equation_each(surfaces: Mapping[str, Surface], contacts: Contacts, sigmas: Floats) -> Equations:
    """The contacts, each one on a point replaced by three on planes."""
    points = {name: surface for name, surface in surfaces.items() if isinstance(surface, Point)}
    sided = {name: surface for name, surface in surfaces.items() if not isinstance(surface, Point)}
    if not any(name in points for name in contacts.by_feature):
        return Equations(sided, contacts, sigmas, np.arange(len(contacts)))
    of = np.repeat(np.arange(len(contacts)), [3 if name in points else 1 for name in contacts.features])
    expanded = contacts.subset(of)
    names, axis = [], dict.fromkeys(range(len(contacts)), 0)
    for contact, name in zip(of.tolist(), expanded.features, strict=True):
        names.append(_plane_name(name, axis[contact]) if name in points else name)
        axis[contact] += 1
    planes: dict[str, SidedSurface] = {
        _plane_name(name, k): Plane(point.point - contacts.tip_radius * UNIT_AXES[k], UNIT_AXES[k])
        for name, point in points.items()
        for k in range(3)
    }
    return Equations(sided | planes, expanded.labelled(names), sigmas[of], of)


def _plane_name(point: str, axis: int) -> str:
    # A colon is in no feature's name.
    return f"{point}:{'xyz'[axis]}"
