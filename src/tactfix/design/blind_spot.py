"""The blind spot of one mistake: the probability that the residuals show it, and the error of the pose."""

from dataclasses import replace
from functools import cached_property
from typing import Final

import numpy as np

from tactfix.contacts import Contacts
from tactfix.design.nominal_contacts import Locator, Touched, shift_of
from tactfix.design.symmetries import Symmetry
from tactfix.diagnosis.hypotheses import Problem
from tactfix.diagnosis.trial_search import TrialSearch
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import inverse
from tactfix.mistakes import BlindSpotCode
from tactfix.noise import SUSPICIOUS, chi_square_limit
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import PoseFit, refine
from tactfix.values import frozen_value

_POWER: Final = 0.95
"""Least probability of detection of a detectable mistake, as that of the intervals that are reported."""
_SELDOM: Final = 0.01
"""Probability of detection below which no number is given: less than ten times SUSPICIOUS, that of noise alone."""
FAR_BEYOND_LIMIT: Final = 20.0
"""Ratio of noncentrality to the limit of chi-square above which the power is 1: the noncentral distribution function is
then 0 to all digits of a double, and its series takes many terms."""


@frozen_value(eq=True)
class BlindSpot:
    """One mistake. pose_shift (units): the displacement of the worst extreme point, None if no pose is found.

    power: the probability that the residuals show it.
    """

    error: BlindSpotCode
    detectable: bool
    pose_shift: float | None
    power: float
    message: str


@frozen_value
class Case:
    """Contacts and fixture whose blind spots are asked for.

    tip_radius: of the tip that is forgotten. worst_sigma: of the extreme point with the largest sigma. exchanges: the
    near symmetries that exchange features without contradicting sides and touch boxes.
    """

    touched: Touched
    tip_radius: float
    worst_sigma: float
    exchanges: tuple[Symmetry, ...]
    fixture: Fixture
    locator: Locator

    @cached_property
    def problem(self) -> Problem:
        """The contacts on the fixture of the file, in its frame."""
        return Problem(self.touched.surfaces, self.touched.contacts, self.touched.sigmas)

    @cached_property
    def trials(self) -> TrialSearch:
        """The search for wrong files: the poses that it starts from are computed once for all of them."""
        return TrialSearch(self.problem, [np.eye(4)])


def power_of(noncentrality: float, dof: int) -> float:
    """The probability that noncentral chi-square with dof degrees of freedom exceeds the limit of locate's warnings."""
    from scipy.special import chndtr

    if dof < 1:
        # Six contacts have no residuals, unless no pose fits them.
        return float(noncentrality > chi_square_limit(1))
    limit = chi_square_limit(dof, SUSPICIOUS)
    return 1.0 if noncentrality > FAR_BEYOND_LIMIT * limit else float(1 - chndtr(limit, dof, noncentrality))


def no_pose(error: BlindSpotCode, mistake: str) -> BlindSpot:
    """A mistake with which no pose is found."""
    return BlindSpot(error, True, None, 1.0, f"{mistake}: no pose is found")


def refined(touched: Touched, contacts: Contacts, start: Floats) -> PoseFit:
    """The pose that contacts on these surfaces give from start (4, 4)."""
    single = one_equation_each(touched.surfaces, contacts, touched.sigmas)
    known = touched.placement
    if known is None:
        return refine(single.surfaces, single.contacts, single.sigmas, start)
    # What is known beforehand is known in base.
    fit = refine(single.surfaces, single.contacts.moved(known.near), single.sigmas, known.near @ start, known)
    return replace(fit, base_from_fixture=inverse(known.near) @ fit.base_from_fixture)


def refitted(error: BlindSpotCode, touched: Touched, contacts: Contacts, mistake: str) -> BlindSpot:
    """A small mistake: contacts and surfaces with the mistake, fitted from the true pose."""
    fit = refined(touched, contacts, np.eye(4))
    power = power_of(fit.chi2, touched.dof)
    return spot_of(error, power, shift_of(fit.base_from_fixture, touched.corners), mistake)


def located(error: BlindSpotCode, touched: Touched, contacts: Contacts, mistake: str, locator: Locator) -> BlindSpot:
    """A mistake given to locate."""
    result = locator(contacts)
    if result.base_from_fixture is None:
        return no_pose(error, mistake)
    power = power_of(result.chi2 or 0.0, touched.dof)
    return spot_of(error, power, shift_of(result.base_from_fixture, touched.corners), mistake)


def spot_of(error: BlindSpotCode, power: float, shift: float, mistake: str) -> BlindSpot:
    """A mistake with which a pose is found, off by shift (units)."""
    seen = "the residuals show it" if power >= _POWER else f"the residuals show it in {int(100 * power)} of 100 cases"
    seen = "the residuals do not show it" if power < _SELDOM else seen
    return BlindSpot(error, power >= _POWER, shift, power, f"{mistake}: {seen}, and the pose is off by {shift:.3g}")


def worst(spots: list[BlindSpot]) -> BlindSpot:
    """The undetectable one that shifts the pose most; if all are detectable, the one with the largest shift."""
    return max(spots, key=lambda spot: (not spot.detectable, spot.pose_shift or 0.0))
