"""The number of cylinders on which the contacts of each cylinder lie.

Regular layouts are the worst: three evenly spaced contacts at each of two heights lie on four cylinders whatever the
stagger, four at each of two heights in line on three (the corners of a box), and a radial approach rejects none of
them. At some lengths they even have one radius. No pattern is looked for: the cylinders are computed.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import DegenerateContactsError
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Surface, offset_radius, outward_normals
from tactfix.localizers.cylinder import localize_cylinder
from tactfix.localizers.cylinder_search import CYLINDER_CONTACTS, FREE_CYLINDER_CONTACTS
from tactfix.values import frozen_value


@frozen_value(eq=True)
class CylinderLayout:
    """The number of cylinders on which the contacts of one feature lie within noise, touched from the right side.

    own_radius: those of the feature's radius; any_radius: all of them. None: infinitely many, 0: not computed.
    """

    feature: str
    contacts: int
    own_radius: int | None
    any_radius: int | None

    @property
    def is_ambiguous(self) -> bool:
        """Whether there are several of the known radius though so many contacts in general position leave one."""
        return self.contacts > CYLINDER_CONTACTS and _several(self.own_radius)

    @property
    def is_tidy(self) -> bool:
        """The same with the radius unknown."""
        return self.contacts > FREE_CYLINDER_CONTACTS and _several(self.any_radius)


def _several(count: int | None) -> bool:
    return count is None or count > 1


def cylinder_layouts(contacts: Contacts, surfaces: Mapping[str, Surface], sigmas: Floats) -> tuple[CylinderLayout, ...]:
    """The layout on each cylinder with enough contacts. sigmas (n,): of all residuals, in fixture units."""
    found = []
    for name, surface in surfaces.items():
        index = [i for i, feature in enumerate(contacts.features) if feature == name]
        if isinstance(surface, Cylinder) and len(index) >= CYLINDER_CONTACTS:
            touched, noise = contacts.subset(index), sigmas[index]
            radius = offset_radius(name, surface.radius, surface.side, contacts.tip_radius)
            any_radius = 0 if len(index) < FREE_CYLINDER_CONTACTS else _count(surface, touched, None, noise)
            found.append(CylinderLayout(name, len(index), _count(surface, touched, radius, noise), any_radius))
    return tuple(found)


def _count(surface: Cylinder, contacts: Contacts, radius: float | None, sigmas: Floats) -> int | None:
    """How many cylinders of this radius (None: any) fit the contacts and were touched from the right side."""
    try:
        candidates = localize_cylinder(contacts.points, radius, sigmas)
    except DegenerateContactsError:
        return None
    return sum(_is_touched_from_its_side(c.surface, surface, contacts) for c in candidates)


def _is_touched_from_its_side(candidate: Surface, surface: Cylinder, contacts: Contacts) -> bool:
    """Whether every known approach leads into the material."""
    assert isinstance(candidate, Cylinder)
    normals = outward_normals(replace(candidate, side=surface.side), contacts.points)
    return not bool((np.einsum("ij,ij->i", normals, contacts.approaches) >= 0).any())
