"""The result of the contacts alone, without what is known of the pose beforehand, and contradictions between the two.

1. If the prior takes part in the fit, the poses of the contacts alone come from the same search, or from one without
   it.
2. If it only limits the poses, they are the same, and rejections by the prior are not counted.
3. Poses that contradict the prior are added as candidates.
4. If no pose is left, the messages name a constrained direction whose release explains the contacts, else the deviation
   of the nearest pose from the prior.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Final, TypeAlias

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.localization.common_result import candidate_of
from tactfix.localization.outcome import Outcome, outcome_from, outcome_of, status_of
from tactfix.placement import Direction, Placement
from tactfix.poses.prior import Contradiction, component, contradiction, deviation
from tactfix.poses.solution import Solution
from tactfix.results import Candidate, Reason, Status, WithoutPrior
from tactfix.values import frozen_value

POSES_AGREE = 1e-6
"""Largest difference (rad, distances from the contacts) of one pose in two searches: both converge to about 1e-8
(`descent.SMALLEST_STEP`)."""
COMPONENTS: Final[tuple[Direction, ...]] = ("rx", "ry", "rz", "x", "y", "z")
"""The components of a motion, in the order of a covariance."""


@frozen_value
class ContactsAlone:
    """The result without the prior.

    without: status and number of poses. fallen: poses that explain the contacts and contradict the prior, as
    candidates. contradictions: if no pose is left, messages why the prior cannot be right; empty if it is not the
    cause.
    """

    without: WithoutPrior
    fallen: tuple[Candidate, ...]
    contradictions: tuple[str, ...]

    def warnings(self, status: str) -> tuple[str, ...]:
        """The warnings for the status of the result with the prior."""
        if status == "inconsistent":
            return self.contradictions
        if status != "located" or self.without.status == "located":
            return ()
        return (decided_by_prior(self.without),)


def decided_by_prior(without: WithoutPrior) -> str:
    """The warning that the contacts alone, with this result, would not locate the fixture."""
    left = (
        f"at least {without.poses} poses would be left" if without.poses else "the contacts would leave a motion free"
    )
    return f"the result depends on what is known beforehand: without it {left}"


def contacts_alone(fixture: Fixture, contacts: Contacts, sigmas: Floats, outcome: Outcome) -> ContactsAlone:
    """The same contacts without placement; outcome: the one with it. sigmas (n,) of the residuals."""
    placement = fixture.placement
    assert placement is not None
    off: Contradicting = []
    if placement.is_in_fit:  # step 1
        without, left = _from_the_same_search(fixture, contacts, outcome) or _searched_again(fixture, contacts, sigmas)
        off = _contradicting(fixture, left, fitted=False)
    else:
        without = _counted(contacts, outcome)  # step 2
    fallen = tuple(  # step 3
        candidate_of(s, (Reason("prior", None, None, o.message),))
        for s, o in off
        if not any(_is_same(s, other, contacts) for other in outcome.solutions.found)
    )
    # Step 4.
    messages = _contradictions(fixture, contacts, sigmas, outcome, off) if outcome.status == "inconsistent" else ()
    return ContactsAlone(without, fallen, tuple(messages))


def _counted(contacts: Contacts, outcome: Outcome, further: Sequence[Solution] = ()) -> WithoutPrior:
    """The result if rejections by the prior are not counted; further: more solutions."""
    pairs = zip(outcome.solutions.found, outcome.assessments, strict=True)
    left = [*(s for s, v in pairs if {reason.code for reason in v.reasons} <= {"prior"}), *further]
    is_same = len(left) == len(outcome.left)
    return _without(outcome.status if is_same else status_of(contacts, outcome.solutions, left), left)


Left: TypeAlias = tuple[WithoutPrior, Sequence[Solution]]
"""The result without the prior, and those of its poses that may contradict it."""


def _from_the_same_search(fixture: Fixture, contacts: Contacts, outcome: Outcome) -> Left | None:
    """The poses of the contacts alone from the search with a measured pose; None if it did not look for them."""
    if outcome.solutions.aside is None:
        return None
    alone = replace(outcome.solutions, found=outcome.solutions.aside)
    further = outcome_from(_without_placement(fixture), contacts, alone).left
    return _counted(contacts, outcome, further), further


def _searched_again(fixture: Fixture, contacts: Contacts, sigmas: Floats) -> Left:
    """The result of a search for all six unknowns at half the cost."""
    if fixture.equations(contacts.features) < 6:
        return WithoutPrior("underdetermined", None), ()
    alone = outcome_of(_without_placement(fixture), contacts, sigmas, with_misses=False, thorough=False)
    return _without(alone.status, alone.left), () if alone.solutions.continuum else alone.left


def _without(status: Status, left: Sequence[Solution]) -> WithoutPrior:
    return WithoutPrior(status, None if status == "underdetermined" else len(left))


@lru_cache(maxsize=32)
def _without_placement(fixture: Fixture) -> Fixture:
    """The fixture without placement: the same object each time, so that its cached shapes are found again."""
    return replace(fixture, placement=None)


Contradicting: TypeAlias = list[tuple[Solution, Contradiction]]


def _contradicting(fixture: Fixture, solutions: Iterable[Solution], fitted: bool) -> Contradicting:
    """The solutions that contradict the prior, each with its contradiction."""
    assert fixture.placement is not None
    pairs = ((s, contradiction(fixture.placement, s, fixture.units, fitted)) for s in solutions)
    return [(solution, how) for solution, how in pairs if how is not None]


def _is_same(one: Solution, other: Solution, contacts: Contacts) -> bool:
    off = deviation(Placement(one.base_from_fixture), other.base_from_fixture)
    arm = float(np.linalg.norm(one.base_from_fixture[:3, 3] - contacts.centre))
    return bool(
        np.linalg.norm(off[:3]) < POSES_AGREE and np.linalg.norm(off[3:]) < POSES_AGREE * (contacts.spread + arm)
    )


def _contradictions(
    fixture: Fixture, contacts: Contacts, sigmas: Floats, outcome: Outcome, off: Contradicting
) -> Iterator[str]:
    """Messages why the prior cannot be right: constrained directions to release, else the nearest pose (step 4)."""
    ways = list(_ways(fixture, contacts, sigmas))
    if ways:
        components = ", or ".join(ways)
        yield f"the contacts contradict the fixed directions: they fit if this too may differ from near: {components}"
        return
    pairs = zip(outcome.solutions.found, outcome.assessments, strict=True)
    only = [s for s, v in pairs if {reason.code for reason in v.reasons} == {"prior"}]
    off = off + _contradicting(fixture, only, fitted=True)
    if off:
        nearest = min((how for _, how in off), key=lambda how: how.ratio)
        yield f"the contacts contradict what is known beforehand: of the nearest pose that fits, {nearest.message}"


def _ways(fixture: Fixture, contacts: Contacts, sigmas: Floats) -> Iterator[str]:
    """The constrained directions whose release explains the contacts, best first, each with its deviation."""
    placement = fixture.placement
    if placement is None or placement.free is None:
        return
    found = []
    for number, name in enumerate(COMPONENTS):
        if name in placement.free:
            continue
        wider = replace(fixture, placement=replace(placement, free=placement.free | {name}))
        outcome = outcome_of(wider, contacts, sigmas, with_misses=False)
        if outcome.left and outcome.status != "underdetermined":
            best = outcome.left[0]
            value = deviation(placement, best.base_from_fixture)[number]
            found.append((best.chi2, f"{name}, {component(number, value, fixture.units)}"))
    for _, words in sorted(found):
        yield words
