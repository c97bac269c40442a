"""Hypotheses: each mistake as the change of fixture and contacts that corrects it, and their ranking.

Every mistake is one of a few changes: contacts deleted, contacts on other features, features elsewhere or of another
size, lengths in another unit, or a few numbers that are fitted (a tip radius, a radius, a place).

Explanations, which are hypotheses fitted to the contacts, are ranked by the extended Bayesian information criterion:

1. An explanation is dropped if a more special one fits no worse than chance allows: the deletion of a contact whose
   label is wrong, a free radius where the radius is a diameter or the side is wrong.
2. The others are sorted by chi-square plus the penalty of the criterion.
3. Those within INDISTINCT of the best are reported as one entry.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from typing import Final, Literal, TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats, circle_axes
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere, Surface
from tactfix.mistakes import DiagnosisCode
from tactfix.noise import chi_square_limit
from tactfix.poses.points_as_planes import Equations, one_equation_each
from tactfix.values import frozen_value

Free: TypeAlias = Literal["tip", "tip_offset", "radius", "place"]

INDISTINCT = 10.0
"""Difference of the criterion (no unit) up to which two causes are reported as indistinguishable. Beyond it the
evidence is called very strong (Kass and Raftery 1995), and misleads in less than one of a thousand cases, whatever
the effect (Royall 2000)."""
BY_CHANCE = 0.01
"""Probability that free numbers without meaning lower chi-square by more: below it a general explanation is kept
next to a special one. With 0.001 a feature displaced by 0.6 mm was reported as exchanged coordinates, which fitted by
accident (`tests.validation.diagnosis`)."""


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


NO_VALUES: Final = np.zeros(0)


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
        if self.free in ("radius", "place"):
            name = self.features[0]
            surfaces[name] = self._refitted(surfaces[name], values, problem)
        sigmas = np.delete(problem.sigmas, list(self.deleted)) * self.sigmas
        return Problem(surfaces, self.corrected_contacts(problem.contacts, values), sigmas)

    def corrected_contacts(self, contacts: Contacts, values: Floats = NO_VALUES) -> Contacts:
        """The contacts with the mistake corrected, without those deleted; values as in `corrected`."""
        tip = contacts.tip_radius if self.tip is None else self.tip
        tip += float(values[0]) if self.free == "tip" else 0.0
        approaches = contacts.approaches.copy()
        approaches[list(self.reversed)] *= -1
        corrected = replace(
            contacts,
            features=contacts.features if self.labels is None else self.labels,
            points=contacts.points * self.points,
            approaches=approaches,
            sigmas=contacts.sigmas * self.sigmas,
            tip_radius=tip,
        )
        if self.free == "tip_offset":
            corrected = corrected.with_tip(values, tip)
        return corrected.subset(np.delete(np.arange(len(contacts)), list(self.deleted)))

    def _refitted(self, surface: Surface, values: Floats, problem: Problem) -> Surface:
        if self.free == "radius":
            assert isinstance(surface, Sphere | Cylinder)
            return replace(surface, radius=surface.radius + float(values[0]))
        return shifted(surface, self.directions(problem) @ values)


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


def without_generalizations(problem: Problem, found: Sequence[Explanation]) -> list[Explanation]:
    """The explanations without those that are a general form of another one (step 1).

    The special one must not fit worse than chance allows, at a probability of BY_CHANCE.
    """
    return [one for one in found if not any(says_more(problem, other, one) for other in found)]


def says_more(problem: Problem, special: Explanation, general: Explanation) -> bool:
    """Whether the special explanation makes the general one superfluous."""
    more = general.hypothesis.numbers(problem) - special.hypothesis.numbers(problem)
    if more < 1 or not _is_general(general.hypothesis, special.hypothesis):
        return False
    # A further deleted contact was chosen among all: the one whose deletion lowers chi-square most.
    further = len(set(general.hypothesis.deleted) - set(special.hypothesis.index))
    chosen_among = math.comb(len(problem.contacts), further)
    return special.chi2 - general.chi2 <= chi_square_limit(more, BY_CHANCE / chosen_among)


def _is_general(general: Hypothesis, special: Hypothesis) -> bool:
    """Whether general leaves free what special corrects."""
    if general.deleted:
        return bool(special.index) and set(special.index) <= set(general.deleted)
    match general.free:
        case "radius":
            return special.code in ("diameter", "side") and special.features == general.features
        case "place":
            return special.code in ("axes", "mirrored") and special.features == general.features
        case "tip":
            return special.tip is not None and special.code == "tip_radius"
        case _:
            return False


def split_by_plausibility(found: Sequence[Explanation]) -> tuple[list[Explanation], list[Explanation]]:
    """The explanations, best first, that are indistinct from the best (step 3); and the others."""
    ranked = sorted(found, key=lambda one: one.score)
    alike = [one for one in ranked if one.score <= ranked[0].score + INDISTINCT]
    return alike, ranked[len(alike) :]
