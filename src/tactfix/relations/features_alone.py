"""One feature at a time: the surfaces that explain its own contacts, with its radius and its known distances."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.feature import Feature
from tactfix.fixture import Fixture, Relation
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface, offset_radius, reference_point
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
"""Sigmas of a contact by which a located neighbour may be off when it locates a sphere by a distance: the joint least
squares correct it afterwards."""
WEAKLY_LOCATED = NEIGHBOUR_SIGMAS / 5
"""Condition of a candidate (displacement over the noise that causes it, no unit) above which it may be off by more than
NEIGHBOUR_SIGMAS: 5 sigma of noise, which good contacts do not exceed, times it."""


def candidates_alone(feature: Feature, contacts: Contacts, sigmas: Floats) -> Sequence[FeatureCandidate]:
    """Every surface of the feature's own size that explains its contacts; sigmas (n,) of the residuals.

    Raises DegenerateContactsError if contacts are too few or degenerate, so that infinitely many surfaces explain them,
    and TipDoesNotFitError.
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
    """Whether contacts on a round feature are coplanar within noise, so that they do not determine its curvature."""
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
    """Whether noise may have moved a surface by more than its neighbours allow for, or merged it with another one."""
    return candidate.poorly_determined or candidate.condition > WEAKLY_LOCATED


def _true(feature: Feature, candidate: SurfaceCandidate) -> SurfaceCandidate:
    """The candidate with the surface of the feature itself instead of the offset surface of the tip's centre."""
    surface = candidate.surface
    if isinstance(surface, Plane):
        return candidate
    return replace(candidate, surface=replace(surface, radius=feature.radius or 0.0, side=feature.side))


def _distance(relation: Relation, surface: Surface, sigma: float) -> Distance:
    """The relation for the localizer, its sigma widened by the uncertainty of the located neighbour."""
    widened = float(np.hypot(relation.sigma, NEIGHBOUR_SIGMAS * sigma))
    match surface:
        case Sphere() | Point():
            return CenterDistance(reference_point(surface), relation.value, widened)
        case Cylinder():
            return AxisDistance(surface.point, surface.direction, relation.value, widened)
        case Plane():
            return PlaneDistance(surface.point, surface.normal, relation.value, widened)
