"""Which explanations are told, and which the contacts cannot tell apart."""

import math
from collections.abc import Sequence

from tactfix.diagnosis.corrections import Hypothesis, Problem
from tactfix.diagnosis.trial_search import Explanation
from tactfix.noise import chi_square_limit

INDISTINCT = 10.0
"""Difference of the criterion up to which two causes cannot be told apart. Beyond it the evidence is called very strong
(Kass and Raftery 1995), and misleads in less than one of a thousand cases, whatever the effect (Royall 2000)."""
BY_CHANCE = 0.01
"""How often numbers without meaning lower chi-square by more than is put down to chance; then both are told. With one
in a thousand a feature 0.6 mm elsewhere was passed over for coordinates that fit when exchanged by accident."""


def without_generalizations(problem: Problem, found: Sequence[Explanation]) -> list[Explanation]:
    """The explanations without those that only say less of what another one says: that a contact is bad where its label
    is wrong, that a radius is another one where it is a diameter, or where the side is the other one.

    The special one must not fit worse by more than chance, one in a hundred, allows for.
    """
    return [one for one in found if not any(says_more(problem, other, one) for other in found)]


def says_more(problem: Problem, special: Explanation, general: Explanation) -> bool:
    """Whether the special explanation makes the general one idle."""
    more = general.hypothesis.numbers(problem) - special.hypothesis.numbers(problem)
    if more < 1 or not _is_general(general.hypothesis, special.hypothesis):
        return False
    # A contact that is left out beside those concerned is the one of all without which chi-square falls most.
    beside = len(set(general.hypothesis.deleted) - set(special.hypothesis.index))
    chosen_among = math.comb(len(problem.contacts), beside)
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


def told_apart(found: Sequence[Explanation]) -> tuple[list[Explanation], list[Explanation]]:
    """The explanations, best first, that are as plausible as the best; and the others."""
    ranked = sorted(found, key=lambda one: one.score)
    alike = [one for one in ranked if one.score <= ranked[0].score + INDISTINCT]
    return alike, ranked[len(alike) :]
