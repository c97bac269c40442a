"""A mistake as the change of fixture and contacts that corrects it, and the problem after that change.

Every mistake is one of a few changes: contacts deleted, contacts on other features, features elsewhere or of another
size, lengths in another unit, or a few numbers that are fitted (a tip radius, a radius, a place).
"""

import math
from collections.abc import Mapping
from dataclasses import field, replace
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats, circle_axes
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface
from tactfix.mistakes import DiagnosisCode
from tactfix.poses.points_as_planes import Equations, one_equation_each
from tactfix.values import frozen_value

Free: TypeAlias = Literal["tip", "tip_offset", "radius", "place"]


@frozen_value
class Problem:
    """A rigid fixture and contacts on it: surfaces in the fixture frame, sigmas (n,) of the residuals."""

    surfaces: Mapping[str, Surface]
    contacts: Contacts
    sigmas: Floats

    @cached_property
    def single(self) -> Equations:
        """The contacts with one equation each."""
        return one_equation_each(self.surfaces, self.contacts, self.sigmas)

    @cached_property
    def equations(self) -> list[int]:
        """The number of equations (n) of each contact: three on a point, else one."""
        return [int(count) for count in np.bincount(self.single.of)]

    @property
    def dof(self) -> int:
        """Equations beyond the six of a pose."""
        return len(self.single.contacts) - 6


@frozen_value
class Hypothesis:
    """One mistake, given by its correction.

    index: the contacts concerned (from 0); features: those concerned; alternatives: number of mistakes of this kind
    that are possible. deleted: contacts that are deleted. labels: the features (n names) of the contacts. surfaces: the
    features that are changed. free: the quantity that is fitted, of the one feature if it is a radius or place. tip:
    the tip radius; points, sigmas: factors on coordinates and sigmas. reversed: contacts whose approach is reversed.
    note: a detail for the message.
    """

    code: DiagnosisCode
    index: tuple[int, ...] = ()
    features: tuple[str, ...] = ()
    alternatives: float = 1.0
    deleted: tuple[int, ...] = ()
    labels: tuple[str, ...] | None = None
    surfaces: Mapping[str, Surface] = field(default_factory=dict)
    free: Free | None = None
    tip: float | None = None
    points: float = 1.0
    sigmas: float = 1.0
    reversed: tuple[int, ...] = ()
    note: str = ""

    def numbers(self, problem: Problem) -> int:
        """By how much the degrees of freedom decrease: equations deleted, and numbers fitted.

        A contact that is moved to a point gains two equations; one that is moved off a point loses two.
        """
        out = sum(problem.equations[i] for i in self.deleted)
        if self.labels is not None:
            relabelled = (_equations_on(problem.surfaces[name]) for name in self.labels)
            out += sum(problem.equations) - sum(relabelled)
        return out + (0 if self.free is None else self.directions(problem).shape[1])

    @property
    def allows_more(self) -> bool:
        """Whether residuals over sigma become smaller: a larger sigma, or coordinates in a smaller unit."""
        return self.sigmas > self.points

    def directions(self, problem: Problem) -> Floats:
        """The directions (3, k) of a free displacement: of the feature, in the fixture frame, or of the tip's centre,
        in the flange frame. For any other free number zeros (3, 1).
        """
        if self.free == "tip_offset":
            return np.eye(3)
        return place_directions(problem.surfaces[self.features[0]]) if self.free == "place" else np.zeros((3, 1))

    def penalty(self, problem: Problem) -> float:
        """The penalty of the extended Bayesian information criterion, to be added to chi-square.

        log n for each free number (Schwarz 1978), and twice the logarithm of the number of alternatives (Chen and Chen
        2008). If the ratio of sigma to the coordinates changes, so does the factor of the normal density, which is
        added.
        """
        count = len(problem.single.contacts)
        density = 2 * problem.dof * math.log(self.sigmas / self.points) if problem.dof > 0 else 0.0
        return self.numbers(problem) * math.log(count) + 2 * math.log(self.alternatives) + density

    def corrected(self, problem: Problem, values: Floats) -> Problem:
        """The problem with the mistake corrected; values (k,): changes of the fitted numbers, in fixture units."""
        surfaces = {**problem.surfaces, **self.surfaces}
        tip = problem.contacts.tip_radius if self.tip is None else self.tip
        tip += float(values[0]) if self.free == "tip" else 0.0
        if self.free in ("radius", "place"):
            name = self.features[0]
            surfaces[name] = self._refitted(surfaces[name], values, problem)
        contacts = self._contacts(problem.contacts, tip)
        if self.free == "tip_offset":
            contacts = contacts.with_tip(np.asarray(values if len(values) else np.zeros(3)), tip)
        kept = np.delete(np.arange(len(contacts)), list(self.deleted))
        return Problem(surfaces, contacts.subset(kept), problem.sigmas[kept] * self.sigmas)

    def _refitted(self, surface: Surface, values: Floats, problem: Problem) -> Surface:
        if self.free == "radius":
            assert isinstance(surface, Sphere | Cylinder)
            return replace(surface, radius=surface.radius + float(values[0]))
        return shifted(surface, self.directions(problem) @ values)

    def _contacts(self, contacts: Contacts, tip: float) -> Contacts:
        approaches = contacts.approaches.copy()
        approaches[list(self.reversed)] *= -1
        return replace(
            contacts,
            features=contacts.features if self.labels is None else self.labels,
            points=contacts.points * self.points,
            approaches=approaches,
            sigmas=contacts.sigmas * self.sigmas,
            tip_radius=tip,
        )


@frozen_value
class Explanation:
    """A hypothesis that has been fitted: values (k,), changes in fixture units; the pose (4, 4); chi2 there.

    score: chi2 and the penalty of the hypothesis, the smaller the more plausible. others: the same hypothesis at other
    poses with a similar chi-square, and at the poses that the fixture's symmetry makes of these.
    """

    hypothesis: Hypothesis
    values: Floats
    base_from_fixture: Floats
    chi2: float
    score: float
    others: tuple["Explanation", ...] = ()

    @property
    def ways(self) -> tuple["Explanation", ...]:
        """It and the others, best first."""
        return (self, *self.others)


def _equations_on(surface: Surface) -> int:
    return 3 if isinstance(surface, Point) else 1


def shifted(surface: Surface, shift: Floats) -> Surface:
    """The surface moved by a shift (3,)."""
    if isinstance(surface, Sphere):
        return replace(surface, center=surface.center + shift)
    return replace(surface, point=surface.point + shift)


def place_directions(surface: Surface) -> Floats:
    """The directions (3, k) in which a shift changes the surface: normal of a plane, across an axis, else all."""
    match surface:
        case Plane():
            return surface.normal[:, None]
        case Cylinder():
            return np.stack(circle_axes(surface.direction), axis=1)
        case _:
            return np.eye(3)
