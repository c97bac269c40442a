"""One feature at a time: the surfaces that its own contacts allow, with its known size and its known distances."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Feature, Fixture, Relation
from tactfix.geometry.arrays import Floats
from tactfix.geometry.nearest import other_point
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, offset_radius
from tactfix.localizers.candidate import SurfaceCandidate
from tactfix.localizers.cylinder import localize_cylinder
from tactfix.localizers.plane import localize_plane
from tactfix.localizers.point import PointCandidate, localize_point
from tactfix.localizers.sphere import localize_sphere
from tactfix.localizers.sphere_distances import (
    AxisDistance,
    CenterDistance,
    Distance,
    PlaneDistance,
    localize_sphere_at_distances,
)
from tactfix.noise import SURE

FeatureCandidate: TypeAlias = SurfaceCandidate | PointCandidate

NEIGHBOUR_SIGMAS = 100.0
"""Sigmas by which a located neighbour may be off before the joint least squares sets everything right."""
WEAKLY_LOCATED = NEIGHBOUR_SIGMAS / 5
"""Sigmas by which noise may move a located feature in multiples of its own: a fifth of NEIGHBOUR_SIGMAS, to be safe."""


def candidates_alone(feature: Feature, contacts: Contacts, sigmas: Floats) -> Sequence[FeatureCandidate]:
    """Every surface of a feature that explains its contacts, of the feature's own size; sigmas (n,) of the residuals.

    Raises DegenerateContactsError where the contacts are too few or lie so that they leave infinitely many, and
    TipDoesNotFitError.
    """
    tip_radius = contacts.tip_radius
    if feature.type == "point":
        return list(localize_point(contacts.points, sigmas))
    if feature.type == "plane":
        return list(localize_plane(contacts.points, sigmas, tip_radius))
    radius = offset_radius(feature.name, feature.radius or 0.0, feature.side, tip_radius)
    localize = localize_sphere if feature.type == "sphere" else localize_cylinder
    return [_true(feature, found) for found in localize(contacts.points, radius, sigmas)]


def candidates_by_distance(
    fixture: Fixture, feature: Feature, contacts: Contacts, known: Mapping[str, FeatureCandidate]
) -> list[SurfaceCandidate]:
    """Every place of a sphere that explains its contacts and its distances to known surfaces (eqs. 48-51).

    Raises DegenerateContactsError where they leave infinitely many.
    """
    radius = offset_radius(feature.name, feature.radius or 0.0, feature.side, contacts.tip_radius)
    sigmas = np.hypot(contacts.sigmas, feature.sigma)
    distances = tuple(
        _distance(relation, candidate.surface, float(sigmas.max(initial=0.0)))
        for relation in fixture.relations
        if relation.kind == "distance" and feature.name in relation.between
        for name, candidate in known.items()
        if name in relation.between and name != feature.name
    )
    found = localize_sphere_at_distances(contacts.points, radius, distances, sigmas)
    return [_true(feature, candidate) for candidate in found]


def is_flat(feature: Feature, contacts: Contacts) -> bool:
    """Whether contacts on a round feature tell nothing of its radius, since noise hides that they are no plane."""
    if feature.radius is None or len(contacts) < 4:
        return False
    return thickness(contacts.points) < SURE * float(np.hypot(contacts.sigmas.max(), feature.sigma))


def thickness(points: Floats) -> float:
    """Root mean square distance of points (n, 3) from the plane that fits them best; 0 of three or fewer."""
    if len(points) < 4:
        return 0.0
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return float(values[2] / np.sqrt(len(points)))


def is_weak(candidate: FeatureCandidate) -> bool:
    """Whether noise may have moved a surface farther than its neighbours allow for, or merged it with another."""
    return candidate.poorly_determined or candidate.condition > WEAKLY_LOCATED


def _true(feature: Feature, candidate: SurfaceCandidate) -> SurfaceCandidate:
    """With the surface of the feature itself, instead of that on which the tip's centre lies."""
    surface = candidate.surface
    if isinstance(surface, Plane):
        return candidate
    return replace(candidate, surface=replace(surface, radius=feature.radius or 0.0, side=feature.side))


def _distance(relation: Relation, surface: Surface, sigma: float) -> Distance:
    """The relation as the localizer wants it. A located neighbour is itself only as sure as its contacts."""
    loose = float(np.hypot(relation.sigma, NEIGHBOUR_SIGMAS * sigma))
    match surface:
        case Sphere() | Point():
            return CenterDistance(other_point(surface), relation.value, loose)
        case Cylinder():
            return AxisDistance(surface.point, surface.direction, relation.value, loose)
        case Plane():
            return PlaneDistance(surface.point, surface.normal, relation.value, loose)
