"""The rigid bodies that a fixture by relations can be: every configuration of features that satisfies the relations.

Distances and angles fix the shape of most fixtures up to a mirror image, or up to a few shapes.

1. If the relations have fewer equations than a shape has numbers, the shape is free and there is no rigid body.
2. Newton's method with least-norm steps leads from a random configuration to one that satisfies the relations, on the
   branches (`equations`) that are nearest to the start.
3. If the relations leave more motions there than those of one rigid body, the shape is free.
4. The shape and its mirror image, which satisfies the relations too, are brought into the fixture frame by the recipe,
   once for each choice of axis signs. Known bodies are dropped.
5. Steps 2 to 4 end when a number of trials in a row find nothing new (NOTHING_NEW, PER_SHAPE): the list is complete.
   They also end, without a complete list, after SHAPE_STARTS trials, or when no trial converges (CONTRADICTORY).

A fixture whose shape is free, or has more shapes than can be searched or listed (`searchable_bodies`), must be located
feature by feature.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from random import Random
from typing import TypeAlias

import numpy as np

from tactfix.feature import Feature
from tactfix.fixture import Fixture
from tactfix.frame import FrameError, frames
from tactfix.geometry.arrays import TINY, unit
from tactfix.geometry.charts import dimension, displaced, rigid_displacements
from tactfix.geometry.nearest import foot, same_surface
from tactfix.geometry.rigid import inverse
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, moved, reference_point, signed_axis
from tactfix.relations.branches import nearest_branch
from tactfix.relations.equations import carried, chart_lengths, columns_of, stacked

Body: TypeAlias = tuple[Mapping[str, Surface], ...]
"""A rigid geometry of the fixture, in each frame that its recipe allows."""

SHAPE_STARTS = 240
"""Random starts at most for all shapes of one fixture: a bound on time. NOTHING_NEW and PER_SHAPE end the trials before
unless there are dozens of shapes."""
NOTHING_NEW, PER_SHAPE = 8, 4
"""Trials in a row without a new shape, the second number for each pair of mirror images found, after which the list is
complete. Of n pairs that are equally frequent, one is overlooked once in e^(8 / n + 4) times."""
CONTRADICTORY = 40
"""Trials, from the first one on, that fail to converge, after which the relations are taken to contradict each
other. If a trial converges with probability 0.1, none of 40 does with a probability of 1.5 per cent."""
SHAPE_STEPS = 40
"""Newton steps of one trial at most: a step is no longer than half a fixture size, or rad, so that twenty lead to any
configuration, and near one Newton's method converges quadratically."""
SHAPE_SIGHT, SIGHT_STEPS = 0.1, 15
"""A trial is abandoned if it violates a relation by more than this (rad, fixture sizes) after so many steps.
Of 166 trials that converged, on five fixtures of three to five features, 160 took at most 15 steps; trials that wander
take all of SHAPE_STEPS."""
SHAPE_RANK = 1e-7
"""Singular value, in units of the fixture's size, below which the relations leave a motion free: above the square
root of rounding, to which a motion of second order at a fold is resolved, far below that of any relation that fixes
one."""
FEW_BODIES = 2
"""Largest number of bodies searched and diagnosed one by one, which takes at least a tenth of a second each. Most
fixtures have one body or a pair of mirror images; of more, features that are located alone select which to search."""
MOST_BODIES = 16
"""Bodies that are searched at most: three bars at all distances and angles have 14. Listing and covering hundreds takes
seconds, and features that are located alone match only a few of them."""
MOST_FAILED = 60
"""Trials that do not converge after which the list counts as incomplete. They take five milliseconds each with five
features; where more than nine in ten fail, SHAPE_STARTS trials would not complete the list either."""
SHAPE_TOLERANCE = 1e-9
"""Largest violation of a relation (rad, fixture sizes) at a shape: Newton's method converges quadratically, so that one
more step would reach rounding."""


def realize(fixture: Fixture) -> tuple[Mapping[str, Surface], ...]:
    """Every rigid geometry of the fixture, in its frame; exactly one for a fixture by geometry.

    Empty if the relations leave the shape free, or contradict each other. Relations are taken at their values, whatever
    their sigma.
    """
    if fixture.is_placed:
        return ({name: f.surface for name, f in fixture.features.items() if f.surface is not None},)
    return tuple(shape for body in bodies(fixture) for shape in body)


def few_shapes(fixture: Fixture) -> tuple[Mapping[str, Surface], ...]:
    """The geometries of `realize`, the first frame of each body first; empty also for more than FEW_BODIES bodies."""
    if fixture.is_placed:
        return realize(fixture)
    found = searchable_bodies(fixture)
    if len(found) > FEW_BODIES:
        return ()
    most = max((len(body) for body in found), default=0)
    return tuple(body[number] for number in range(most) for body in found if number < len(body))


def bodies(fixture: Fixture) -> tuple[Body, ...]:
    """The rigid bodies that a fixture by relations can be, each in every frame that its recipe allows."""
    return _listed(fixture, SHAPE_STARTS, SHAPE_STARTS)[0]


def searchable_bodies(fixture: Fixture) -> tuple[Body, ...]:
    """The result of `bodies`; empty if there are more than MOST_BODIES, or if some may be missing."""
    found, complete = _listed(fixture, MOST_BODIES, MOST_FAILED)
    return found if complete else ()


@lru_cache(maxsize=32)
def _listed(fixture: Fixture, most: int, most_failed: int) -> tuple[tuple[Body, ...], bool]:
    """The bodies, and whether the list is complete: the search ends at these limits of bodies and of failed trials."""
    rng = Random(20261122)
    scale = fixture_scale(fixture)
    if not _are_enough(fixture, _random_surfaces(fixture, scale, rng), scale):  # step 1
        return (), True
    found: list[Body] = []
    idle = failed = 0
    for _ in range(SHAPE_STARTS):
        if idle >= NOTHING_NEW + PER_SHAPE * len(found) / 2:
            return tuple(found), True  # step 5
        if (not found and failed >= CONTRADICTORY) or failed >= most_failed or len(found) > most:
            break
        surfaces = _relaxed(fixture, _random_surfaces(fixture, scale, rng), scale)  # step 2
        if surfaces is None:
            failed += 1
            continue
        idle += 1
        # A known body has been tested for rigidity and listed with its mirror image.
        if _is_any(found, _in_first_frame(fixture, surfaces), scale):
            continue
        if not is_rigid(fixture, surfaces, scale):  # step 3
            return (), True
        for body in (surfaces, {name: _mirrored(surface) for name, surface in surfaces.items()}):  # step 4
            shapes = _distinct(_in_fixture_frame(fixture, body), scale)
            if shapes and not _is_any(found, shapes[0], scale):
                found.append(tuple(shapes))
                idle = 0
    return tuple(found), False


def _is_any(
    found: Sequence[Sequence[Mapping[str, Surface]]], shape: Mapping[str, Surface] | None, scale: float
) -> bool:
    """Whether a shape in the fixture frame is one of the bodies found; False for None."""
    return shape is not None and any(_known(shape, list(body), scale) for body in found)


def body_number(fixture: Fixture, surfaces: Mapping[str, Surface]) -> int | None:
    """The number of the body formed by surfaces that satisfy the relations; None if it is not a known body."""
    shapes = _in_fixture_frame(fixture, surfaces)
    scale = fixture_scale(fixture)
    known = (n for n, body in enumerate(searchable_bodies(fixture)) if shapes and _known(shapes[0], list(body), scale))
    return next(known, None)


def _mirrored(surface: Surface) -> Surface:
    """The mirror image of a surface in the plane x = 0."""
    flip = np.array([-1.0, 1.0, 1.0])
    match surface:
        case Sphere():
            return replace(surface, center=flip * surface.center)
        case Point():
            return Point(flip * surface.point)
        case Plane():
            return Plane(flip * surface.point, flip * surface.normal)
        case Cylinder():
            return replace(surface, point=flip * surface.point, direction=flip * surface.direction)


def _distinct(shapes: Sequence[Mapping[str, Surface]], scale: float) -> list[Mapping[str, Surface]]:
    kept: list[Mapping[str, Surface]] = []
    for shape in shapes:
        if not _known(shape, kept, scale):
            kept.append(shape)
    return kept


def fixture_scale(fixture: Fixture) -> float:
    """A length of the fixture: its largest distance or radius (the distances of crossing axes may all be near 0)."""
    distances = [abs(relation.value) for relation in fixture.relations if relation.kind == "distance"]
    radii = [feature.radius for feature in fixture.features.values() if feature.radius is not None]
    return max([*distances, *radii], default=0.0) or 1.0


def shape_sigma(fixture: Fixture) -> float:
    """The standard deviation (length) of the shape: the sigmas of all relations, angles times the fixture's scale."""
    scale = fixture_scale(fixture)
    return float(np.linalg.norm([r.sigma * (1.0 if r.kind == "distance" else scale) for r in fixture.relations]))


def random_surface(feature: Feature, scale: float, rng: Random) -> Surface:
    """A surface of the feature's kind and size, random within about scale of the origin and in direction."""
    # The standard library's generator: importing numpy.random takes a sixth of numpy's own import.
    numbers = np.array([rng.gauss(0.0, 1.0) for _ in range(6)])
    point, direction = scale * numbers[:3], unit(numbers[3:])
    if feature.type == "plane":
        return Plane(point, direction)
    if feature.type == "point":
        return Point(point)
    radius = feature.radius or 0.0
    if feature.type == "sphere":
        return Sphere(point, radius, feature.side)
    return Cylinder(point, direction, radius, feature.side)


def _random_surfaces(fixture: Fixture, scale: float, rng: Random) -> dict[str, Surface]:
    return {name: random_surface(feature, scale, rng) for name, feature in fixture.features.items()}


def _relaxed(fixture: Fixture, surfaces: Mapping[str, Surface], scale: float) -> Mapping[str, Surface] | None:
    """The surfaces after least-norm Newton steps onto the relations; None if these do not converge."""
    equations = nearest_branch(fixture.relations, surfaces)
    lengths = chart_lengths(surfaces, scale)
    columns, _ = columns_of(surfaces)
    for number in range(SHAPE_STEPS):
        equations = tuple(carried(equation, surfaces) for equation in equations)
        missing, jacobian = stacked(equations, surfaces, scale)
        if np.abs(missing).max(initial=0.0) < SHAPE_TOLERANCE:
            return surfaces
        if number == SIGHT_STEPS and np.abs(missing).max() > SHAPE_SIGHT:
            return None
        step = -np.linalg.pinv(jacobian, rcond=1e-10) @ missing
        step *= min(1.0, 0.5 / max(float(np.abs(step).max()), TINY)) * lengths
        surfaces = {name: displaced(s, step[columns[name]]) for name, s in surfaces.items()}
    return None


def is_rigid(fixture: Fixture, surfaces: Mapping[str, Surface], scale: float) -> bool:
    """Whether the relations leave no motions of the surfaces except those of one rigid body."""
    _, jacobian = stacked(nearest_branch(fixture.relations, surfaces), surfaces, scale)
    free = (
        jacobian.shape[1] - int(np.linalg.matrix_rank(jacobian, tol=SHAPE_RANK)) if len(jacobian) else jacobian.shape[1]
    )
    return bool(free == _rigid_motions(surfaces, scale))


def _are_enough(fixture: Fixture, surfaces: Mapping[str, Surface], scale: float) -> bool:
    """Whether the relations have as many equations as a shape has numbers, for surfaces in general position."""
    equations = nearest_branch(fixture.relations, surfaces)
    width = sum(dimension(surface) for surface in surfaces.values())
    return bool(sum(e.components for e in equations) >= width - _rigid_motions(surfaces, scale))


def _rigid_motions(surfaces: Mapping[str, Surface], scale: float) -> int:
    """How many motions of one rigid body move any of the surfaces."""
    centre = np.mean([reference_point(surface) for surface in surfaces.values()], axis=0)
    together = np.vstack([rigid_displacements(surface, centre) for surface in surfaces.values()])
    together[:, 3:] *= scale
    together /= chart_lengths(surfaces, scale)[:, None]
    return int(np.linalg.matrix_rank(together, tol=SHAPE_RANK))


def _in_fixture_frame(fixture: Fixture, surfaces: Mapping[str, Surface]) -> list[Mapping[str, Surface]]:
    """The shape in each frame that the recipe allows."""
    if fixture.frame is None:
        return []
    try:
        bases = frames(fixture.frame, surfaces)
    except FrameError:
        return []
    return [{n: _near_origin(moved(inverse(base), s)) for n, s in surfaces.items()} for base in bases]


def _in_first_frame(fixture: Fixture, surfaces: Mapping[str, Surface]) -> Mapping[str, Surface] | None:
    """The shape in the first of these frames; None if the recipe gives no frame."""
    return next(iter(_in_fixture_frame(fixture, surfaces)), None)


def _near_origin(surface: Surface) -> Surface:
    """The surface with its given point nearest to the fixture's origin, and an axis signed as by `signed_axis`."""
    match surface:
        case Sphere() | Point():
            return surface
        case Plane():
            return replace(surface, point=foot(surface, np.zeros(3)))
        case Cylinder():
            return replace(surface, point=foot(surface, np.zeros(3)), direction=signed_axis(surface.direction))


def _known(shape: Mapping[str, Surface], shapes: list[Mapping[str, Surface]], scale: float) -> bool:
    return any(all(same_surface(s, other[n], 1e-6 * scale, 1e-6) for n, s in shape.items()) for other in shapes)
