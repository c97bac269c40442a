"""From what the file says to what a fixture is: plain values, angles in rad."""

import math
from collections.abc import Mapping

import numpy as np

from tactfix.fixture import (
    AxisRule,
    Feature,
    Fixture,
    FrameRecipe,
    OriginRule,
    Probe,
    Relation,
    TouchBox,
)
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, Surface
from tactfix.models.document import FixtureDocument, Interval, TouchModel
from tactfix.models.features import CylinderModel, FeatureModel, PlaneModel, SphereModel
from tactfix.models.frame import Along, CenterOf, FootOf, FrameModel, FromTo, MeetOf, Opposite


def build_fixture(document: FixtureDocument, name: str) -> Fixture:
    """The fixture of a document in which `tactfix.models.parse` found nothing wrong; name: if it gives none itself."""
    probe = document.probe
    return Fixture(
        name=document.name or name,
        units=document.units,
        probe=Probe(probe.tip_radius, probe.sigma, probe.approach_distance),
        features={name: build_feature(name, model) for name, model in document.features.items()},
        relations=relations_of(document),
        frame=None if document.frame is None else recipe_of(document.frame, document.features),
        touch={name: box_of(model) for name, model in document.touch.items()},
    )


def build_feature(name: str, model: FeatureModel) -> Feature:
    """One feature."""
    if isinstance(model, PlaneModel):
        return Feature(name, "plane", None, "outer", model.sigma, surface_of(model))
    return Feature(name, model.type, model.radius, model.side, model.sigma, surface_of(model))


def surface_of(model: FeatureModel) -> Surface | None:
    """Where a feature is in the fixture frame, None where the file does not say."""
    match model:
        case PlaneModel(point=list(point), normal=list(normal)):
            return Plane(_vector(point), _direction(normal))
        case SphereModel(center=list(center)):
            return Sphere(_vector(center), model.radius, model.side)
        case CylinderModel(point=list(point), direction=list(direction)):
            return Cylinder(_vector(point), _direction(direction), model.radius, model.side)
        case _:
            return None


def relations_of(document: FixtureDocument) -> tuple[Relation, ...]:
    """The distances, then the angles, angles in rad."""
    distances = [Relation("distance", (d.between[0], d.between[1]), d.value, d.sigma) for d in document.distances]
    angles = [
        Relation("angle", (a.between[0], a.between[1]), math.radians(a.value), math.radians(a.sigma))
        for a in document.angles
    ]
    return (*distances, *angles)


def recipe_of(frame: FrameModel, features: Mapping[str, FeatureModel]) -> FrameRecipe:
    """The frame recipe; [plane, cylinder] is turned into [cylinder, plane]."""
    match frame.origin:
        case CenterOf(center_of=sphere):
            origin = OriginRule("center_of", (sphere,))
        case FootOf(foot_of=above, on=below):
            origin = OriginRule("foot_of", (above, below))
        case MeetOf(meet_of=names):
            origin = OriginRule("meet_of", tuple(sorted(names, key=lambda name: features[name].type == "plane")))
    (first, first_rule), (second, second_rule) = frame.axes
    return FrameRecipe(origin, (first, _axis_rule(first_rule)), (second, _axis_rule(second_rule)))


def _axis_rule(model: Along | FromTo | Opposite) -> AxisRule:
    opposite = isinstance(model, Opposite)
    direction = model.opposite if isinstance(model, Opposite) else model
    if isinstance(direction, Along):
        return AxisRule("along", (direction.along,), opposite)
    return AxisRule("from_to", (direction.from_, direction.to), opposite)


def box_of(model: TouchModel) -> TouchBox:
    """The touch box, infinite where the file leaves it open."""

    def ends(interval: Interval | None) -> tuple[float, float]:
        low, high = interval or (None, None)
        return -math.inf if low is None else low, math.inf if high is None else high

    low, high = zip(ends(model.x), ends(model.y), ends(model.z), strict=True)
    return TouchBox(np.array(low), np.array(high))


def _vector(values: list[float]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array(values, dtype=np.float64)


def _direction(values: list[float]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Scaled to a largest component of one, so that no square under- or overflows."""
    vector = _vector(values)
    return np.asarray(vector / np.abs(vector).max())
