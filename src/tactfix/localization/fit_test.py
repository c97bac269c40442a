"""Whether a pose fits the contacts, all together and one by one, and warnings if it barely does.

Two tests, each wrong once in a million for good contacts: the chi-square of all residuals, and the normalised residual
of each contact. Between one in a million and one in a thousand the pose is kept, with a warning that names the suspect.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.noise import REJECTED_IN_ERROR, SUSPICIOUS, chi_square_limit, least_chi_square, normal_limit
from tactfix.poses.solution import Solution
from tactfix.probe import implied_probe_sigma, residual_sigmas
from tactfix.results import Diagnosis, Reason

if TYPE_CHECKING:
    from tactfix.diagnosis.data_snooping import StandsOut

NOMINAL_RESIDUAL = 1e-6
"""Share of sigma below which residuals are rounding: such contacts were computed and not measured, and get no
warning that they are too good."""


def misfit_of(fixture: Fixture, contacts: Contacts, solution: Solution, limit: float) -> Reason | None:
    """Why the pose does not fit the contacts; None if it does. limit: the largest chi-square that noise explains."""
    if solution.chi2 > limit:
        return too_large(contacts, solution, limit)
    found = _stands_out(fixture, contacts, solution, REJECTED_IN_ERROR)
    if found is None:
        return None
    label, row, feature = contacts.label(found.index), contacts.rows[found.index], contacts.features[found.index]
    message = f"{label} stands out by {found.size:.3g} sigma; noise exceeds {found.limit:.3g} once in a million"
    return Reason("fit", feature, row, message)


def too_large(contacts: Contacts, solution: Solution, limit: float) -> Reason:
    """The rejection of a pose whose chi-square is above the limit."""
    worst = int(np.argmax(np.abs(solution.residuals)))
    message = f"chi-square {solution.chi2:.4g} is above {limit:.4g}; worst at {contacts.label(worst)}"
    return Reason("fit", contacts.features[worst], contacts.rows[worst], message)


def residual_warnings(fixture: Fixture, contacts: Contacts, solution: Solution, dof: int) -> tuple[Diagnosis, ...]:
    """What is suspicious about the residuals of a pose that fits: the tip, one contact, or sigma."""
    suspect = _stands_out(fixture, contacts, solution, SUSPICIOUS)
    elsewhere = _tip_elsewhere(fixture, contacts, solution, dof)
    if elsewhere is not None:
        return (elsewhere,)
    all_alike = solution.chi2 > chi_square_limit(dof, SUSPICIOUS)
    if suspect is not None or all_alike:
        return _one_contact_or_sigma(fixture, contacts, solution, suspect, dof, all_alike=all_alike)
    if 0 < solution.chi2 < least_chi_square(dof):
        if solution.chi2 < dof * NOMINAL_RESIDUAL**2:
            return ()
        return (_sigma(fixture, contacts, solution, dof, "the residuals are improbably small, {ratio:.2g} of sigma"),)
    return ()


def _tip_elsewhere(fixture: Fixture, contacts: Contacts, solution: Solution, dof: int) -> Diagnosis | None:
    """Another place of the tip in the flange, if it explains the residuals as well as one bad contact would.

    Chi-square must fall by more than three free numbers without meaning lower it once in a thousand cases. That detects
    a wrong tip long before all residuals together are suspicious.
    """
    if contacts.flange_rotations is None or dof < 4:
        return None
    from tactfix.diagnosis.data_snooping import tip_change

    found = tip_change(contacts, residual_sigmas(fixture, contacts), solution, fixture.placement)
    if found is None or found.chi2 > chi_square_limit(dof - 3, SUSPICIOUS) or not found.is_plausible:
        return None
    if solution.chi2 - found.chi2 <= chi_square_limit(3, SUSPICIOUS):
        return None
    from tactfix.diagnosis.messages import tip_offset_message

    then = "the residuals agree with sigma"
    value, message = tip_offset_message(contacts, found.change, fixture.units, then, float(np.median(contacts.sigmas)))
    return Diagnosis("tip_offset", (), (), value, found.chi2, message)


def _one_contact_or_sigma(
    fixture: Fixture,
    contacts: Contacts,
    solution: Solution,
    suspect: "StandsOut | None",
    dof: int,
    *,
    all_alike: bool,
) -> tuple[Diagnosis, ...]:
    """The contact that stands out, and another sigma if all residuals together are suspicious; one entry if indistinct.

    In the order of the Bayesian information criterion: -2 log likelihood plus log n for each free number (each equation
    of the contact), and twice the logarithm of the number of contacts from which it was chosen (Chen and Chen 2008).
    """
    from tactfix.diagnosis.hypotheses import INDISTINCT
    from tactfix.diagnosis.messages import one_of

    count, scores = len(contacts), []
    if suspect is not None:
        score = solution.chi2 - suspect.size**2 + (suspect.directions + 2) * math.log(count)
        scores.append((score, _outlier(fixture, contacts, solution, suspect)))
    if all_alike and (suspect is None or dof > 1):
        score = dof * (1 + math.log(solution.chi2 / max(dof, 1))) + math.log(count)
        words = "the residuals are {ratio:.2g} times as large as sigma"
        scores.append((score, _sigma(fixture, contacts, solution, dof, words)))
    scores.sort(key=lambda pair: pair[0])
    causes = [cause for _, cause in scores]
    return (one_of(causes),) if scores[-1][0] - scores[0][0] <= INDISTINCT else tuple(causes)


def _stands_out(fixture: Fixture, contacts: Contacts, solution: Solution, probability: float) -> "StandsOut | None":
    # No normalised residual is larger than the root of chi-square: most poses need neither the test nor its import.
    if solution.chi2 <= normal_limit(len(contacts), probability) ** 2:
        return None
    from tactfix.diagnosis.data_snooping import contact_that_stands_out

    return contact_that_stands_out(
        contacts, residual_sigmas(fixture, contacts), solution, probability, fixture.placement
    )


def _outlier(fixture: Fixture, contacts: Contacts, solution: Solution, suspect: "StandsOut") -> Diagnosis:
    from tactfix.diagnosis.data_snooping import movement_without

    index = suspect.index
    moves = movement_without(contacts, residual_sigmas(fixture, contacts), solution, index, fixture.placement)
    message = (
        f"{contacts.label(index)} on {contacts.features[index]} stands out by {suspect.size:.3g} sigma: touch it "
        f"again; without it the pose would move by {moves:.2g} {fixture.units}"
    )
    row, feature = contacts.rows[index], contacts.features[index]
    left = solution.chi2 - suspect.size**2
    return Diagnosis("outlier", (row,), (feature,), float(solution.residuals[index]), left, message)


def _sigma(fixture: Fixture, contacts: Contacts, solution: Solution, dof: int, words: str) -> Diagnosis:
    """Another sigma of the probe; if sigmas of the features alone exceed the residuals, the question about these."""
    ratio = float(np.sqrt(solution.chi2 / max(dof, 1)))
    given, sigmas = float(np.median(contacts.sigmas)), residual_sigmas(fixture, contacts)
    right = implied_probe_sigma(contacts, sigmas, ratio)
    asked = f"is sigma {right:.2g} instead of {given:.2g}?" if right else "are the features' own sigmas too large?"
    agree = f"the contacts agree to {ratio * float(np.median(sigmas)):.2g} {fixture.units}"
    message = f"{words.format(ratio=ratio)}: {agree}; {asked}"
    return Diagnosis("sigma", (), (), right or None, float(dof), message)
