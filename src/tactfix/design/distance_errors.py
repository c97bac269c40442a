"""The fixture with one distance wrong by a given error, for every pair of features with a distance."""

from collections.abc import Iterator, Mapping
from itertools import permutations

import numpy as np

from tactfix.geometry.arrays import Floats, unit
from tactfix.geometry.nearest import foot
from tactfix.geometry.rigid import homogeneous
from tactfix.geometry.scale import SPECIAL_POSITION
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, moved, reference_point
from tactfix.values import frozen_value


@frozen_value
class Misplaced:
    """The surfaces of the wrong file, and the mistake in words."""

    surfaces: Mapping[str, Surface]
    message: str


def misplaced(surfaces: Mapping[str, Surface], off: float) -> Iterator[Misplaced]:
    """Each feature moved by off (units) away from each other feature to which it has a distance."""
    for name, other in permutations(surfaces, 2):
        direction = separation(surfaces[other], surfaces[name])
        if direction is not None:
            motion = homogeneous(np.eye(3), off * direction)
            message = f"{name} {off:.3g} farther from {other} in the file than it is"
            yield Misplaced({**surfaces, name: moved(motion, surfaces[name])}, message)


def separation(from_surface: Surface, to_surface: Surface) -> Floats | None:
    """The unit direction (3,) along which their distance is measured; None if there is none.

    Distances as in the fixture file: between centres, axes, and parallel planes. Two axes at distance zero have their
    common perpendicular; other features at distance zero have no direction.
    """
    match from_surface, to_surface:
        case (Plane() as plane, other) | (other, Plane() as plane):
            return _off_plane(plane, other)
        case Cylinder(), Cylinder():
            return _between_axes(from_surface, to_surface)
        case ((Sphere() | Point()), _):
            return _along(foot(to_surface, reference_point(from_surface)) - reference_point(from_surface))
        case _, (Sphere() | Point()):
            return _along(reference_point(to_surface) - foot(from_surface, reference_point(to_surface)))
        case _:  # pragma: no cover - all pairs of the four types stand above
            return None


def _off_plane(plane: Plane, other: Surface) -> Floats | None:
    """The plane's normal, if the other surface has a distance from the plane."""
    match other:
        case Plane():
            has_distance = bool(np.linalg.norm(np.cross(plane.normal, other.normal)) <= SPECIAL_POSITION)
        case Cylinder():
            has_distance = bool(abs(plane.normal @ other.direction) <= SPECIAL_POSITION)
        case Sphere() | Point():
            has_distance = True
    return plane.normal if has_distance else None


def _between_axes(first: Cylinder, second: Cylinder) -> Floats | None:
    """Along the common perpendicular of two axes."""
    square = np.cross(first.direction, second.direction)
    if np.linalg.norm(square) > SPECIAL_POSITION:
        return unit(square)
    return _along(foot(second, first.point) - first.point)


def _along(vector: Floats) -> Floats | None:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0 else None
