"""The fixture frame from its features, by the recipe of the fixture file.

The first axis in the file is exact, the second is made perpendicular to it, the third completes a right-handed
frame. The axis of a cylinder has no sign: each choice gives a frame, and approaches and touch boxes later decide.
"""

from collections.abc import Mapping
from itertools import product

import numpy as np

from tactfix.errors import TactfixError
from tactfix.fixture import AxisRule, Fixture, FrameRecipe, OriginRule
from tactfix.geometry.arrays import Floats, cross, dot, lengths, unit
from tactfix.geometry.nearest import ALMOST_PARALLEL, direction_of, foot, nearest_points
from tactfix.geometry.rigid import homogeneous
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, radius_of, reference_point

NO_DIRECTION = 1e-6
"""Sine of the angle, and share of the features' distance, below which a direction cannot be built."""
ONE_PLACE_ROUNDING = 1e-6
"""Times NO_DIRECTION: distance of two points, relative to their coordinates, that rounding may cause."""


class FrameError(TactfixError):
    """The features are arranged so that the recipe gives no frame."""


def recipe_of(fixture: Fixture) -> FrameRecipe:
    """The frame recipe of a fixture by relations; raises FrameError if it has none."""
    if fixture.frame is None:
        raise FrameError(f"frame: {fixture.name} is given by relations and has no frame recipe; write one")
    return fixture.frame


def frames(recipe: FrameRecipe, surfaces: Mapping[str, Surface]) -> list[Floats]:
    """Every frame (4, 4), from fixture to the frame of surfaces, that the recipe allows: one per choice of axis signs.

    Raises FrameError if an axis or the origin is undefined: features coincide, or directions are parallel.
    """
    return [frame(recipe, surfaces, signs) for signs in sign_choices(recipe, surfaces)]


def sign_choices(recipe: FrameRecipe, surfaces: Mapping[str, Surface]) -> list[tuple[float, float]]:
    """The sign choices of the two given axes: both signs for an axis along a cylinder."""
    rules = (recipe.first[1], recipe.second[1])
    free = [rule.kind == "along" and isinstance(surfaces[rule.features[0]], Cylinder) for rule in rules]
    return [(one, two) for one, two in product((1.0, -1.0), repeat=2) if (one > 0 or free[0]) and (two > 0 or free[1])]


def frame(recipe: FrameRecipe, surfaces: Mapping[str, Surface], signs: tuple[float, float]) -> Floats:
    """The frame (4, 4) for one choice of signs, (k, 4, 4) for stacks of surfaces; raises FrameError like `frames`."""
    first = signs[0] * _direction(recipe.first[1], surfaces)
    second = signs[1] * _direction(recipe.second[1], surfaces)
    return homogeneous(_rotation(recipe, first, second), _origin(recipe.origin, surfaces))


def _rotation(recipe: FrameRecipe, first: Floats, second: Floats) -> Floats:
    """The rotation matrix (..., 3, 3) with the first axis exact and the second perpendicular to it."""
    names = "xyz"
    i, j = names.index(recipe.first[0]), names.index(recipe.second[0])
    # A surface keeps a direction that is a unit vector to a few roundings; a frame's axes must be orthonormal to one.
    first = unit(first)
    across = second - dot(second, first) * first
    if lengths(across).min() < NO_DIRECTION:
        raise FrameError(
            f"frame: {recipe.first[0]} and {recipe.second[0]} are parallel; choose another feature for one"
        )
    axes = {i: first, j: unit(across)}
    # x, y, z in cyclic order are right-handed: the third axis is i x j, or j x i against the cycle.
    axes[3 - i - j] = cross(axes[i], axes[j]) if (j - i) % 3 == 1 else cross(axes[j], axes[i])
    return np.stack([axes[0], axes[1], axes[2]], axis=-1)


def _direction(rule: AxisRule, surfaces: Mapping[str, Surface]) -> Floats:
    """The unit direction (..., 3) of an axis rule; for a cylinder with the arbitrary sign of its direction."""
    sign = -1.0 if rule.opposite else 1.0
    one = surfaces[rule.features[0]]
    if rule.kind == "along":
        if isinstance(one, Sphere | Point):
            kind = type(one).__name__.lower()
            raise FrameError(f"frame: {rule.features[0]} is a {kind} and has no direction; use from and to")
        return sign * direction_of(one)
    other = surfaces[rule.features[1]]
    a, b = nearest_points(one, other)
    gap = b - a
    # Two points have no radius as a length scale: the rounding of their coordinates is the limit.
    scale = max(radius_of(one), radius_of(other), float(np.abs([a, b]).max()) * ONE_PLACE_ROUNDING)
    if lengths(gap).min() < NO_DIRECTION * scale:
        raise FrameError(f"frame: {' and '.join(rule.features)} coincide, so that no axis leads from one to the other")
    return np.asarray(sign * unit(gap))


def _origin(rule: OriginRule, surfaces: Mapping[str, Surface]) -> Floats:
    """The origin (..., 3)."""
    chosen = [surfaces[name] for name in rule.features]
    match rule.kind, chosen:
        case "center_of", [(Sphere() | Point()) as sphere]:
            return reference_point(sphere)
        case "foot_of", [(Sphere() | Point()) as sphere, surface]:
            return foot(surface, reference_point(sphere))
        case "foot_of", [Cylinder() as one, Cylinder() as axis]:
            if lengths(cross(one.direction, axis.direction)).min() < ALMOST_PARALLEL:
                names = " and ".join(rule.features)
                raise FrameError(
                    f"frame: {names} are parallel and have no foot; use meet_of with a plane for the origin"
                )
            return nearest_points(one, axis)[1]
        case "meet_of", [Cylinder() as axis, Plane() as plane]:
            return _meet(axis, plane, rule)
        case "meet_of", [Plane() as a, Plane() as b, Plane() as c]:
            normals = np.stack([a.normal, b.normal, c.normal], axis=-2)
            if np.abs(np.linalg.det(normals)).min() < NO_DIRECTION:
                raise FrameError(f"frame: the planes {', '.join(rule.features)} do not meet in one point")
            heights = np.stack([dot(p.point - a.point, p.normal) for p in (a, b, c)], axis=-1)
            return np.asarray(a.point + np.linalg.solve(normals, heights.reshape(*normals.shape[:-1], 1))[..., 0])
    raise FrameError(f"frame: no origin {rule.kind} for {', '.join(rule.features)}")


def _meet(axis: Cylinder, plane: Plane, rule: OriginRule) -> Floats:
    rate = dot(axis.direction, plane.normal)
    if np.abs(rate).min() < NO_DIRECTION:
        raise FrameError(f"frame: {rule.features[0]} is parallel to {rule.features[1]} and does not meet it")
    return np.asarray(axis.point + dot(plane.point - axis.point, plane.normal) / rate * axis.direction)
