"""The motions that no contact on a set of features can remove: intersections of symmetry groups, without numeric rank.

1. Each unbounded surface is mapped onto itself by a connected group of rigid motions: a sphere by the rotations about
   its centre, a plane by its planar motions, a cylinder by rotation about and translation along its axis.
2. The free motions of a set of features are the intersection of their groups, which is one of the six kinds below.
3. A basis of its Lie algebra gives the twists.

Source: the enumeration idea is that of Nederbragt and Ravani (1996, 1997); the intersection table is derived here.
"""

from collections.abc import Iterable
from typing import TypeAlias

import numpy as np

from tactfix.geometry.arrays import Floats, Frozen, basis_across
from tactfix.geometry.nearest import anchored
from tactfix.geometry.scale import Tolerance, middle_of
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface
from tactfix.values import frozen_value


@frozen_value(eq=True)
class Fixed:
    """Nothing but the identity."""


@frozen_value
class Prismatic:
    """Translations along direction (3,)."""

    direction: Frozen


@frozen_value
class Line:
    """A line: point (3,), unit direction (3,) without a sign."""

    point: Frozen
    direction: Frozen


@frozen_value
class Revolute:
    """Rotations about a line."""

    line: Line


@frozen_value
class Cylindrical:
    """Rotations about a line and translations along it."""

    line: Line


@frozen_value
class Spherical:
    """All rotations about center (3,)."""

    center: Frozen


@frozen_value
class Planar:
    """Translations perpendicular to normal (3,) and rotations about every line along it."""

    normal: Frozen


Motions: TypeAlias = Fixed | Prismatic | Revolute | Cylindrical | Spherical | Planar


def motions_of(surface: Surface) -> Motions:
    """The connected group of motions that map one unbounded surface onto itself."""
    match surface:
        case Plane():
            return Planar(surface.normal)
        case Sphere():
            return Spherical(surface.center)
        case Point():
            return Spherical(surface.point)
        case Cylinder():
            return Cylindrical(Line(surface.point, surface.direction))


def common_motions(surfaces: Iterable[Surface], tolerance: Tolerance) -> Motions:
    """The motions common to all surfaces: the intersection of their groups. Raises ValueError for none."""
    listed = list(surfaces)
    if not listed:
        raise ValueError("a fixture has at least one feature")
    # Lines are compared at their reference points: these are moved near the fixture.
    middle = middle_of(listed)
    groups = [motions_of(anchored(surface, middle)) for surface in listed]  # step 1
    common = groups[0]
    for group in groups[1:]:  # step 2
        common = intersection(common, group, tolerance)
    return common


def dimension(motions: Motions) -> int:
    """The dimension of the group, 0 to 3."""
    match motions:
        case Fixed():
            return 0
        case Prismatic() | Revolute():
            return 1
        case Cylindrical():
            return 2
        case Spherical() | Planar():
            return 3


def twists(motions: Motions) -> Floats:
    """A basis (k, 6) of the group's Lie algebra: unit rotation (3,), translation (3,) of the point at the origin.

    Translations come first, of unit length and with a rotation of exactly zero.
    """
    match motions:
        case Fixed():
            rows: list[Floats] = []
        case Prismatic():
            rows = [_translation(motions.direction)]
        case Revolute():
            rows = [_rotation(motions.line.point, motions.line.direction)]
        case Cylindrical():
            line = motions.line
            rows = [_translation(line.direction), _rotation(line.point, line.direction)]
        case Spherical():
            rows = [_rotation(motions.center, axis) for axis in np.eye(3)]
        case Planar():
            first, second = basis_across(motions.normal)
            rows = [_translation(first), _translation(second), _rotation(np.zeros(3), motions.normal)]
    return np.array(rows).reshape(-1, 6)


def _translation(direction: Floats) -> Floats:
    return np.concatenate([np.zeros(3), direction])


def _rotation(point: Floats, direction: Floats) -> Floats:
    """The twist of the rotation about a line: the origin moves by direction x (0 - point)."""
    return np.concatenate([direction, np.cross(point, direction)])


# The order in which two groups are compared, so that each pair occurs once.
_SIMPLER_FIRST = (Fixed, Prismatic, Revolute, Cylindrical, Spherical, Planar)


def intersection(a: Motions, b: Motions, tolerance: Tolerance) -> Motions:
    """The intersection of both groups."""
    first, second = sorted((a, b), key=lambda motions: _SIMPLER_FIRST.index(type(motions)))
    match first:
        case Fixed():
            return first
        case Prismatic():
            return first if _holds_translation(second, first.direction, tolerance) else Fixed()
        case Revolute():
            return first if _holds_rotation(second, first.line, tolerance) else Fixed()
        case Cylindrical():
            return _with_axis(first, second, tolerance)
        case Spherical():
            return _with_sphere(first, second, tolerance)
        case Planar():
            return _of_two_planes(first, second, tolerance)


def _with_axis(axis: Cylindrical, other: Motions, tolerance: Tolerance) -> Motions:
    """The motions of an axis that another group also contains: a screw only if it contains rotation and translation."""
    rotates = _holds_rotation(other, axis.line, tolerance)
    slides = _holds_translation(other, axis.line.direction, tolerance)
    if rotates and slides:
        return axis
    return Revolute(axis.line) if rotates else Prismatic(axis.line.direction) if slides else Fixed()


def _with_sphere(sphere: Spherical, other: Motions, tolerance: Tolerance) -> Motions:
    """The rotations about a centre that a second spherical or planar group also contains."""
    if isinstance(other, Planar):
        return Revolute(Line(sphere.center, other.normal))
    assert isinstance(other, Spherical)
    between = other.center - sphere.center
    distance = float(np.linalg.norm(between))
    return sphere if distance <= tolerance.length else Revolute(Line(sphere.center, between / distance))


def _of_two_planes(first: Planar, second: Motions, tolerance: Tolerance) -> Motions:
    """The motions of two planes: those of one if parallel, else the translations along their common line."""
    assert isinstance(second, Planar)
    edge = np.cross(first.normal, second.normal)
    sine = float(np.linalg.norm(edge))
    return first if sine <= tolerance.angle else Prismatic(edge / sine)


def _holds_translation(group: Motions, direction: Floats, tolerance: Tolerance) -> bool:
    """Whether translations along direction belong to the group."""
    match group:
        case Prismatic():
            return are_parallel(group.direction, direction, tolerance)
        case Cylindrical():
            return are_parallel(group.line.direction, direction, tolerance)
        case Planar():
            return bool(abs(group.normal @ direction) <= tolerance.angle)
        case _:
            return False


def _holds_rotation(group: Motions, line: Line, tolerance: Tolerance) -> bool:
    """Whether rotations about the line belong to the group."""
    match group:
        case Revolute() | Cylindrical():
            parallel = are_parallel(group.line.direction, line.direction, tolerance)
            return parallel and is_on(group.line.point, line, tolerance)
        case Spherical():
            return is_on(group.center, line, tolerance)
        case Planar():
            return are_parallel(group.normal, line.direction, tolerance)
        case _:
            return False


def are_parallel(a: Floats, b: Floats, tolerance: Tolerance) -> bool:
    """Whether two unit vectors (3,) are parallel, with either sign."""
    return bool(np.linalg.norm(np.cross(a, b)) <= tolerance.angle)


def is_on(point: Floats, line: Line, tolerance: Tolerance) -> bool:
    """Whether point (3,) lies on the line."""
    return bool(np.linalg.norm(np.cross(point - line.point, line.direction)) <= tolerance.length)
