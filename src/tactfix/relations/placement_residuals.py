"""Residuals of contacts and relations for many placements of a fixture's features side by side (`placements`).

A feature is a point p and a direction d, of an axis or a normal. With q = p' - p, residuals as lengths:

    contact x   (x - p).d - t,   +-(|x - p| or |(x - p) - ((x - p).d) d| - r) - t,   x - p of a point
    angle       s (atan2(|d x d'|, +-d.d') - value),   s (d -+ d') if parallel
    distance    q.d - value of a plane,   |q| - value,   |q across an axis| - value,   |q.(d x d')| / |d x d'| - value

Here t is the radius of the tip, r that of the feature, and s the fixture's size. Each placement uses the nearest branch
of each relation.
"""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.feature import Feature
from tactfix.fixture import Fixture, Relation
from tactfix.geometry.arrays import TINY, Floats, cross, lengths
from tactfix.geometry.nearest import ALMOST_PARALLEL
from tactfix.relations.equations import off
from tactfix.relations.joint_problem import JointProblem
from tactfix.relations.parallels import parallel_pairs
from tactfix.values import frozen_value

Places: TypeAlias = tuple[Floats, Floats]
"""Points and directions (..., 3) of one feature, one for each placement."""


@frozen_value
class Term:
    """Residuals (..., count) over sigma of the features named, from the places of each."""

    names: tuple[str, ...]
    values: Callable[..., Floats]
    count: int


def terms_of(fixture: Fixture, problem: JointProblem, length: float, slack: float) -> tuple[Term, ...]:
    """The terms of all contacts and relations.

    length: s, the size of the fixture. slack: least sigma of a relation, as a share of the contacts' smallest sigma.
    """
    contacts, smallest = problem.contacts, float(problem.sigmas.min())
    terms = [
        _contact_term(fixture.features[name], contacts.on(name), problem.sigmas[index])
        for name, index in contacts.by_feature.items()
    ]
    parallel = parallel_pairs(problem.relations)
    for relation in problem.relations:
        one, other = (fixture.features[name] for name in relation.between)
        if relation.kind == "angle":
            sigma = max(length * relation.sigma, slack * smallest)
            terms.append(_angle_term(relation, one, other, length / sigma))
        else:
            sigma = max(relation.sigma, slack * smallest)
            terms.append(_distance_term(relation, one, other, frozenset(relation.between) in parallel, 1 / sigma))
    return tuple(term for term in terms if term.count)


def _contact_term(feature: Feature, contacts: Contacts, sigmas: Floats) -> Term:
    points, tip, radius = contacts.points, contacts.tip_radius, feature.radius or 0.0
    sign = -1.0 if feature.side == "inner" else 1.0

    def values(place: Places) -> Floats:
        arms, along = points - place[0][..., None, :], place[1][..., None]
        if feature.type == "point":
            return (arms / sigmas[:, None]).reshape(*arms.shape[:-2], -1)
        heights = arms @ along
        if feature.type == "plane":
            return np.asarray((heights[..., 0] - tip) / sigmas)
        if feature.type == "cylinder":
            arms = arms - heights * place[1][..., None, :]
        return np.asarray((sign * (lengths(arms) - radius) - tip) / sigmas)

    return Term((feature.name,), values, feature.equations * len(points))


def _angle_term(relation: Relation, one: Feature, other: Feature, weight: float) -> Term:
    is_signed, is_parallel = one.type == other.type == "plane", off(relation) == 0
    has_directions = {one.type, other.type} <= {"plane", "cylinder"}

    def values(first: Places, second: Places) -> Floats:
        a, b = first[1], second[1]
        cosine = np.einsum("...i,...i->...", a, b)[..., None]
        sense = np.where(cosine < 0, -1.0, 1.0)
        if is_parallel:
            return weight * (a - (np.sign(np.cos(relation.value)) if is_signed else sense) * b)
        angle = np.arctan2(lengths(cross(a, b))[..., None], cosine if is_signed else sense * cosine)
        return np.asarray(weight * (angle - relation.value))

    return Term(relation.between, values, (3 if is_parallel else 1) if has_directions else 0)


def _distance_term(relation: Relation, one: Feature, other: Feature, parallel: bool, weight: float) -> Term:
    kinds, value = (one.type, other.type), relation.value

    def from_plane(first: Places, second: Places) -> Floats:
        (p, normal), (q, _) = (first, second) if kinds[0] == "plane" else (second, first)
        height = np.einsum("...i,...i->...", q - p, normal)[..., None]
        is_signed = {"sphere", "point"} & set(kinds)
        return np.asarray(weight * (height - value if is_signed else np.abs(height) - value))

    def values(first: Places, second: Places) -> Floats:
        gap, a, b = second[0] - first[0], first[1], second[1]
        flat = gap - np.einsum("...i,...i->...", gap, a)[..., None] * a
        if kinds != ("cylinder", "cylinder"):
            flat = flat - np.einsum("...i,...i->...", gap, b)[..., None] * b
            return np.asarray(weight * (lengths(flat)[..., None] - value))
        normal = cross(a, b)
        sine = lengths(normal)[..., None]
        askew = np.abs(np.einsum("...i,...i->...", gap, normal))[..., None] / np.maximum(sine, TINY)
        spacing = lengths(flat)[..., None]
        return np.asarray(weight * (np.where(parallel | (sine < ALMOST_PARALLEL), spacing, askew) - value))

    return Term(relation.between, from_plane if "plane" in kinds else values, 1)
