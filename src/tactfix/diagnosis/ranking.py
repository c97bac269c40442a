"""Ranking of explanations by the extended Bayesian information criterion, and which of them are indistinct.

1. An explanation is dropped if a more special one fits no worse than chance allows: the deletion of a contact whose
   label is wrong, a free radius where the radius is a diameter or the side is wrong.
2. The others are sorted by chi-square plus penalty (`hypotheses`).
3. Those within INDISTINCT of the best are reported as one entry.
"""

import math
from collections.abc import Sequence

from tactfix.diagnosis.hypotheses import Explanation, Hypothesis, Problem
from tactfix.noise import chi_square_limit

INDISTINCT = 10.0
"""Difference of the criterion (no unit) up to which two causes are reported as indistinguishable. Beyond it the
evidence is called very strong (Kass and Raftery 1995), and misleads in less than one of a thousand cases, whatever
the effect (Royall 2000)."""
BY_CHANCE = 0.01
"""Probability that free numbers without meaning lower chi-square by more: below it a general explanation is kept beside
a special one. With 0.001 a feature displaced by 0.6 mm was reported as exchanged coordinates, which fitted by accident
(`tests.validation.diagnosis`)."""


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


def split_by_plausibility(found: Sequence[Explanation]) -> tuple[list[Explanation], list[Explanation]]:
    """The explanations, best first, that are indistinct from the best (step 3); and the others."""
    ranked = sorted(found, key=lambda one: one.score)
    alike = [one for one in ranked if one.score <= ranked[0].score + INDISTINCT]
    return alike, ranked[len(alike) :]
