"""A mistake as what is changed in fixture and contacts where it is undone, and the problem that is then left.

Every mistake is one of a few changes: contacts left out, contacts on other features, features elsewhere or of another
size, lengths in another unit, and one or a few numbers free to be fitted (a tip radius, a radius, a place).
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
        """How many equations (n) each contact is."""
        return [int(count) for count in np.bincount(self.single.of)]

    @property
    def dof(self) -> int:
        """Equations beyond the six of a pose."""
        return len(self.single.contacts) - 6


@frozen_value
class Hypothesis:
    """One mistake, by what undoes it.

    index: the contacts concerned (from 0); features: those concerned; alternatives: among how many such mistakes it is
    chosen. deleted: contacts left out. labels: features (n names) that contacts are on. surfaces: what stands
    otherwise. free: what is fitted, the radius or place that of the one feature. tip, points, sigmas: the tip radius,
    and factors of coordinates and of sigmas. reversed: contacts whose approach is the opposite. note: what a message
    needs to know.
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
        """By how much fewer the degrees of freedom are: equations left out, and numbers that are fitted.

        A contact that belongs on a point has two equations more than the file counts; one that does not, two fewer.
        """
        out = sum(problem.equations[i] for i in self.deleted)
        if self.labels is not None:
            told = (_equations_on(problem.surfaces[name]) for name in self.labels)
            out += sum(problem.equations) - sum(told)
        return out + (0 if self.free is None else self.directions(problem).shape[1])

    @property
    def allows_more(self) -> bool:
        """Whether residuals count for less than the file says: another sigma, or coordinates in a smaller unit."""
        return self.sigmas > self.points

    def directions(self, problem: Problem) -> Floats:
        """The directions (3, k) in which something is free to stand: the feature, in the fixture frame, or the tip's
        centre, in the flange frame; (3, 1) of no meaning.
        """
        if self.free == "tip_offset":
            return np.eye(3)
        return place_directions(problem.surfaces[self.features[0]]) if self.free == "place" else np.zeros((3, 1))

    def penalty(self, problem: Problem) -> float:
        """What chi-square must fall by for the mistake to be believed: the extended Bayesian information criterion.

        log n for each number that is free (Schwarz 1978), and twice the logarithm of the alternatives among which the
        mistake is chosen (Chen and Chen 2008). Where sigma is another one than the recorded coordinates had, the
        normal density's own factor counts too.
        """
        count = len(problem.single.contacts)
        density = 2 * problem.dof * math.log(self.sigmas / self.points) if problem.dof > 0 else 0.0
        return self.numbers(problem) * math.log(count) + 2 * math.log(self.alternatives) + density

    def corrected(self, problem: Problem, values: Floats) -> Problem:
        """The problem without the mistake; values (k,): of the numbers fitted, in fixture units (changes)."""
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


def _equations_on(surface: Surface) -> int:
    return 3 if isinstance(surface, Point) else 1


def shifted(surface: Surface, shift: Floats) -> Surface:
    """The surface moved by a shift (3,)."""
    if isinstance(surface, Sphere):
        return replace(surface, center=surface.center + shift)
    return replace(surface, point=surface.point + shift)


def place_directions(surface: Surface) -> Floats:
    """The directions (3, k) in which a shift of the surface is seen: normal of a plane, across an axis, all."""
    match surface:
        case Plane():
            return surface.normal[:, None]
        case Cylinder():
            return np.stack(circle_axes(surface.direction), axis=1)
        case _:
            return np.eye(3)
