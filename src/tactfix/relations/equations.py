"""Known distances and angles as equations between surfaces.

Each relation gives one or more residuals that vanish where it holds and are smooth there. A distance of zero
(concentric, coaxial, axis through a centre) and an angle of zero or 180 degrees hold more than one number: all of them
are residuals, where the plain difference would have no derivative.
"""

from collections.abc import Mapping
from functools import lru_cache
from itertools import combinations

import numpy as np

from tactfix.fixture import Fixture, Relation
from tactfix.geometry.arrays import TINY, Floats
from tactfix.geometry.charts import across, dimension, displaced, material_displacement
from tactfix.geometry.nearest import (
    ALMOST_PARALLEL,
    PARALLEL,
    direction_of,
    distance_between,
    foot,
    nearest_points,
    other_point,
)
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface

STEP = 1e-6
"""Relative step of the central differences: their error, its square, stays below 1e-11."""


@lru_cache(maxsize=64)
def parallel_pairs(relations: tuple[Relation, ...]) -> frozenset[frozenset[str]]:
    """The pairs of features that angles of 0 and 180 degrees make parallel, also by way of others."""
    groups: list[set[str]] = []
    for relation in relations:
        if relation.kind == "angle" and np.sin(relation.value) < PARALLEL:
            joined = [group for group in groups if group & set(relation.between)]
            groups = [group for group in groups if group not in joined]
            groups.append(set(relation.between).union(*joined))
    return frozenset(frozenset(pair) for group in groups for pair in combinations(sorted(group), 2))


def doubtful_distances(fixture: Fixture, surfaces: Mapping[str, Surface]) -> tuple[str, ...]:
    """In words, the distances of axes that were taken for parallel ones because they nearly are: nothing else says so.

    `geometry.nearest` takes the spacing of such axes for their distance, which the common perpendicular would be of
    axes that are askew on purpose.
    """
    known = parallel_pairs(fixture.relations)
    doubts = []
    for relation in fixture.relations:
        axes = [surface for name in relation.between if isinstance(surface := surfaces[name], Cylinder)]
        if relation.kind == "distance" and len(axes) == 2 and frozenset(relation.between) not in known:
            sine = float(np.linalg.norm(np.cross(axes[0].direction, axes[1].direction)))
            if sine < ALMOST_PARALLEL:
                one, other = relation.between
                doubts.append(
                    f"{one} and {other} are {np.degrees(np.arcsin(sine)):.2g} deg from parallel and no angle is given: "
                    "their distance was taken for the spacing of parallel axes; give their angle, 0 if they are"
                )
    return tuple(doubts)


def relation_residuals(relation: Relation, one: Surface, other: Surface, parallel: bool = False) -> Floats:
    """What is missing (k,) for the relation to hold: lengths for a distance, rad for an angle.

    parallel: whether other relations make the two parallel; then the distance of axes is their spacing, however far
    from parallel they still are.
    """
    if relation.kind == "angle":
        return _angle_residuals(relation, one, other)
    if not _has_gap(relation, one, other):
        return _coincidence(one, other, parallel)
    return np.array([_side(relation, one, other) * distance_between(one, other, parallel) - relation.value])


def _side(relation: Relation, one: Surface, other: Surface) -> float:
    """1 or -1: on which side of a plane an axis or another plane lies; only spheres have the side in their distance."""
    if relation.value == 0 or isinstance(one, Sphere | Point) or isinstance(other, Sphere | Point):
        return 1.0
    return 1.0 if distance_between(one, other) >= 0 else -1.0


def _angle_residuals(relation: Relation, one: Surface, other: Surface) -> Floats:
    """The difference of the angles; for parallel directions the two components of the turn between them."""
    if isinstance(one, Sphere | Point) or isinstance(other, Sphere | Point):
        return np.zeros(0)
    a, b = direction_of(one), direction_of(other)
    if np.sin(relation.value) > PARALLEL:
        cosine = _sense(relation, one, other) * float(a @ b)
        return np.array([np.arctan2(np.linalg.norm(np.cross(a, b)), cosine) - relation.value])
    signed = isinstance(one, Plane) and isinstance(other, Plane)
    b = b * ((1.0 if relation.value < 1 else -1.0) if signed else np.copysign(1.0, a @ b))
    sines = across(one) @ b
    sine = float(np.linalg.norm(sines))
    # Opposite normals are as far from parallel as can be, whichever way they turn.
    turn = sines / sine if sine > PARALLEL else np.array([1.0, 0.0])
    return np.asarray(sines if sine <= PARALLEL and a @ b > 0 else np.arctan2(sine, a @ b) * turn)


def _sense(relation: Relation, one: Plane | Cylinder, other: Plane | Cylinder) -> float:
    """1 or -1: which sense of an unsigned axis the angle is measured in; at 90 degrees either, so always the same."""
    if isinstance(one, Plane) and isinstance(other, Plane):
        return 1.0
    facing = float(direction_of(one) @ direction_of(other))
    return 1.0 if facing >= 0 or abs(np.cos(relation.value)) < PARALLEL else -1.0


def _coincidence(one: Surface, other: Surface, parallel: bool) -> Floats:
    """The components of the gap between centres and axes that coincide."""
    a, b = nearest_points(one, other, parallel)
    match one, other:
        case ((Sphere() | Point()), (Sphere() | Point())):
            return np.asarray(b - a)
        case Cylinder(), Cylinder():
            normal = np.cross(one.direction, other.direction)
            size = float(np.linalg.norm(normal))
            if size > ALMOST_PARALLEL and not parallel:
                return np.array([(other.point - one.point) @ normal / size])
            return np.asarray(across(one) @ (b - a))
        case (Cylinder() as axis, (Sphere() | Point())) | ((Sphere() | Point()), Cylinder() as axis):
            return np.asarray(across(axis) @ (b - a))
    return np.zeros(0)


def relation_with_jacobian(
    relation: Relation,
    surfaces: Mapping[str, Surface],
    columns: Mapping[str, slice],
    scale: float,
    width: int,
    parallel: bool = False,
) -> tuple[Floats, Floats]:
    """The residuals (k,) and their derivative (k, width) with respect to displacements of the surfaces.

    columns: where each feature's displacement stands; scale: a length of the fixture, for the size of differences.
    """
    one, other = relation.between
    pair = surfaces[one], surfaces[other]
    here = relation_residuals(relation, *pair, parallel)
    jacobian = np.zeros((len(here), width))
    if len(here) == 1 and relation.kind == "distance" and _has_gap(relation, *pair):
        side = _side(relation, *pair)
        gradients = _distance_gradients(*pair, parallel)
        jacobian[0, columns[one]], jacobian[0, columns[other]] = (side * gradient for gradient in gradients)
    elif len(here) == 1 and relation.kind == "angle":
        jacobian[0, columns[one]], jacobian[0, columns[other]] = _angle_gradients(relation, *pair)
    else:
        for name in relation.between:
            jacobian[:, columns[name]] = _differences(relation, surfaces, name, scale, parallel)
    return here, jacobian


def _has_gap(relation: Relation, one: Surface, other: Surface) -> bool:
    return relation.value != 0 or isinstance(one, Plane) or isinstance(other, Plane)


def _distance_gradients(one: Surface, other: Surface, parallel: bool) -> tuple[Floats, Floats]:
    """How a distance changes with the displacement of each: what the feet of the perpendicular move apart along it."""
    if isinstance(other, Plane) and not isinstance(one, Plane):
        second, first = _distance_gradients(other, one, parallel)
        return first, second
    if isinstance(one, Plane):
        far = other_point(other)
        near, along = foot(one, far), one.normal
    else:
        near, far = nearest_points(one, other, parallel)
        gap = far - near
        along = gap / max(float(np.linalg.norm(gap)), TINY)
    return -along @ material_displacement(one, near), along @ material_displacement(other, far)


def _angle_gradients(relation: Relation, one: Surface, other: Surface) -> tuple[Floats, Floats]:
    """How arccos(+-a . b) changes with the tilts of each direction."""
    if isinstance(one, Sphere | Point) or isinstance(other, Sphere | Point):
        return np.zeros(dimension(one)), np.zeros(dimension(other))
    a, b = direction_of(one), direction_of(other)
    rate = -_sense(relation, one, other) / max(float(np.linalg.norm(np.cross(a, b))), PARALLEL)
    first, second = np.zeros(dimension(one)), np.zeros(dimension(other))
    first[:2], second[:2] = rate * (across(one) @ b), rate * (across(other) @ a)
    return first, second


def _differences(
    relation: Relation, surfaces: Mapping[str, Surface], name: str, scale: float, parallel: bool
) -> Floats:
    """Central differences (k, dimension), for residuals that hold more than one number."""
    surface = surfaces[name]
    columns = []
    for k in range(dimension(surface)):
        step = np.zeros(dimension(surface))
        step[k] = STEP if not isinstance(surface, Sphere | Point) and k < 2 else STEP * scale
        ahead = relation_residuals(relation, *_pair(surfaces, relation, name, displaced(surface, step)), parallel)
        behind = relation_residuals(relation, *_pair(surfaces, relation, name, displaced(surface, -step)), parallel)
        columns.append((ahead - behind) / (2 * step[k]))
    return np.array(columns).T


def _pair(surfaces: Mapping[str, Surface], relation: Relation, name: str, changed: Surface) -> tuple[Surface, Surface]:
    one, other = relation.between
    return (changed, surfaces[other]) if name == one else (surfaces[one], changed)


def columns_of(surfaces: Mapping[str, Surface]) -> tuple[dict[str, slice], int]:
    """Where each feature's displacement stands in the vector of all, and how long that is."""
    columns, width = {}, 0
    for name, surface in surfaces.items():
        columns[name] = slice(width, width + dimension(surface))
        width += dimension(surface)
    return columns, width


def all_relations(
    relations: tuple[Relation, ...], surfaces: Mapping[str, Surface], scale: float
) -> list[tuple[Floats, Floats]]:
    """Residuals and Jacobian of each relation."""
    columns, width = columns_of(surfaces)
    known = parallel_pairs(relations)
    return [
        relation_with_jacobian(relation, surfaces, columns, scale, width, frozenset(relation.between) in known)
        for relation in relations
    ]
