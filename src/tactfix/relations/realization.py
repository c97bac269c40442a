"""The rigid geometries that a fixture by relations can be.

Distances and angles fix the shape of most fixtures up to a mirror image, or a few shapes. Newton's method from many
random configurations finds them; each is laid into the fixture frame by the recipe, once per choice of axis signs,
and alike ones are kept once. Where the relations leave the shape free there is none: such a fixture must be located
feature by feature.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np

from tactfix.fixture import Feature, Fixture
from tactfix.frame import FrameError, frames
from tactfix.geometry.arrays import TINY, Floats, unit
from tactfix.geometry.charts import displaced, rigid_displacements
from tactfix.geometry.nearest import foot
from tactfix.geometry.rigid import inverse
from tactfix.geometry.sameness import same_surface
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, moved, signed_axis
from tactfix.relations.equations import all_relations, columns_of

TRIALS = 60
SETTLED = 12
"""Trials in a row that bring nothing new, after which the list of shapes is complete: two mirror images turn up alike
often, so that one is overlooked once in 4,000 fixtures with one pair."""
NEWTON_STEPS = 40
RANK = 1e-7
HOLDS = 1e-9
"""Share of the fixture's size (rad for angles) to which relations must hold."""


@lru_cache(maxsize=32)
def realize(fixture: Fixture) -> tuple[Mapping[str, Surface], ...]:
    """Every rigid geometry of the fixture, in its frame; exactly one for a fixture by geometry.

    Empty where the relations leave the shape of the fixture free, or contradict each other. Relations are taken at
    their values, whatever their sigma.
    """
    if fixture.is_placed:
        return ({name: f.surface for name, f in fixture.features.items() if f.surface is not None},)
    rng = np.random.default_rng(20261122)
    scale = fixture_scale(fixture)
    shapes: list[Mapping[str, Surface]] = []
    idle = 0
    for _ in range(TRIALS):
        if idle >= SETTLED:
            break
        surfaces = _relaxed(fixture, {n: random_surface(f, scale, rng) for n, f in fixture.features.items()}, scale)
        if surfaces is None:
            continue
        if not is_rigid(fixture, surfaces, scale):
            return ()
        idle += 1
        for shape in _in_fixture_frame(fixture, surfaces):
            if not _known(shape, shapes, scale):
                shapes.append(shape)
                idle = 0
    return tuple(shapes)


def fixture_scale(fixture: Fixture) -> float:
    """A length of the fixture: its largest distance, or else radius."""
    lengths = [abs(r.value) for r in fixture.relations if r.kind == "distance"]
    radii = [f.radius for f in fixture.features.values() if f.radius is not None]
    return max(lengths, default=0.0) or max(radii, default=1.0)


# The annotation is a text because looking the name up would import numpy.random, a sixth of numpy's own import.
def random_surface(feature: Feature, scale: float, rng: "np.random.Generator") -> Surface:
    """A surface of the feature's kind and size, anywhere within about scale of the origin, in any direction."""
    point, direction = scale * rng.normal(size=3), unit(rng.normal(size=3))
    if feature.type == "plane":
        return Plane(point, direction)
    if feature.type == "point":
        return Point(point)
    radius = feature.radius or 0.0
    if feature.type == "sphere":
        return Sphere(point, radius, feature.side)
    return Cylinder(point, direction, radius, feature.side)


def _relaxed(fixture: Fixture, surfaces: Mapping[str, Surface], scale: float) -> Mapping[str, Surface] | None:
    """The surfaces moved as little as the relations ask for, by Newton's method; None where it does not arrive."""
    columns, _ = columns_of(surfaces)
    for _ in range(NEWTON_STEPS):
        missing, jacobian = _stacked(fixture, surfaces, scale)
        if not len(missing) or np.abs(missing).max() < HOLDS:
            return surfaces
        step = -np.linalg.pinv(jacobian, rcond=1e-10) @ missing
        step *= min(1.0, 0.5 / max(float(np.abs(step).max()), TINY))
        surfaces = {name: displaced(s, _unscaled(s, step[columns[name]], scale)) for name, s in surfaces.items()}
    return None


def _stacked(fixture: Fixture, surfaces: Mapping[str, Surface], scale: float) -> tuple[Floats, Floats]:
    """All residuals (k,) and Jacobian (k, width), lengths in units of scale on both sides."""
    linear = all_relations(fixture.relations, surfaces, scale)
    columns, width = columns_of(surfaces)
    lengths = np.ones(width)
    for name, surface in surfaces.items():
        lengths[columns[name]] = _unscaled(surface, np.ones(columns[name].stop - columns[name].start), scale)
    if not linear:
        return np.zeros(0), np.zeros((0, width))
    values, jacobians = zip(*linear, strict=True)
    units = [scale if relation.kind == "distance" else 1.0 for relation in fixture.relations]
    unit_of_row = np.repeat(units, [len(value) for value in values])
    return np.concatenate(values) / unit_of_row, np.vstack(jacobians) * lengths / unit_of_row[:, None]


def _unscaled(surface: Surface, step: Floats, scale: float) -> Floats:
    """A displacement with its lengths in fixture units from one with lengths in units of scale."""
    tilts = 0 if isinstance(surface, Sphere | Point) else 2
    return np.concatenate([step[:tilts], step[tilts:] * scale])


def is_rigid(fixture: Fixture, surfaces: Mapping[str, Surface], scale: float) -> bool:
    """Whether the relations leave the surfaces no motion but those of one rigid body."""
    _, jacobian = _stacked(fixture, surfaces, scale)
    centre = np.mean([s.center if isinstance(s, Sphere) else s.point for s in surfaces.values()], axis=0)
    together = []
    for surface in surfaces.values():
        rows = rigid_displacements(surface, centre)
        rows[:, 3:] *= scale
        tilts = 0 if isinstance(surface, Sphere | Point) else 2
        rows[tilts:] /= scale
        together.append(rows)
    free = jacobian.shape[1] - int(np.linalg.matrix_rank(jacobian, tol=RANK)) if len(jacobian) else jacobian.shape[1]
    return bool(free == np.linalg.matrix_rank(np.vstack(together), tol=RANK))


def _in_fixture_frame(fixture: Fixture, surfaces: Mapping[str, Surface]) -> list[Mapping[str, Surface]]:
    """The shape in each frame that the recipe allows."""
    if fixture.frame is None:
        return []
    try:
        bases = frames(fixture.frame, surfaces)
    except FrameError:
        return []
    return [{n: _near_origin(moved(inverse(base), s)) for n, s in surfaces.items()} for base in bases]


def _near_origin(surface: Surface) -> Surface:
    """The surface with its given point where it is nearest to the fixture's origin, an axis as `signed_axis` has it."""
    match surface:
        case Sphere() | Point():
            return surface
        case Plane():
            return replace(surface, point=foot(surface, np.zeros(3)))
        case Cylinder():
            return replace(surface, point=foot(surface, np.zeros(3)), direction=signed_axis(surface.direction))


def _known(shape: Mapping[str, Surface], shapes: list[Mapping[str, Surface]], scale: float) -> bool:
    return any(all(same_surface(s, other[n], 1e-6 * scale, 1e-6) for n, s in shape.items()) for other in shapes)
