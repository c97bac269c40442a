"""Mistakes in the contact file: contacts off their surface, wrong labels, a wrong unit, a wrong tip."""

import math
from collections.abc import Iterable
from itertools import combinations

import numpy as np

from tactfix.diagnosis.contact_faults import UNITS_MEANT
from tactfix.diagnosis.hypotheses import Hypothesis, Problem
from tactfix.geometry.surfaces import Point

TURNED_ENTRY = 1e-3
"""Rotations of the flange count as one orientation if no entry differs by more (no unit, about rad): with a turn that
small, a displaced tip and a displaced fixture are the same to within a thousandth of the displacement."""

LEAST_SPREAD = 30.0
"""Least spread of the contacts, in sigma, after a change of their unit. Contacts that are closer together fit any
pose, and a search takes long; a fixture is thousands of sigma wide."""


def outliers(problem: Problem, sets: Iterable[tuple[int, ...]]) -> list[Hypothesis]:
    """Each of these sets of contacts (indices from 0) deleted, if at least six equations are left."""
    names, count = problem.contacts.features, len(problem.contacts)
    return [
        Hypothesis(
            "outlier",
            index=chosen,
            features=tuple(dict.fromkeys(names[i] for i in chosen)),
            alternatives=math.comb(count, len(chosen)),
            deleted=chosen,
        )
        for chosen in sets
        if sum(problem.equations[i] for i in chosen) <= problem.dof
    ]


def single_outliers(problem: Problem) -> list[Hypothesis]:
    """Each contact deleted."""
    return outliers(problem, [(i,) for i in range(len(problem.contacts))])


def relabels(problem: Problem) -> list[Hypothesis]:
    """Each contact on each other feature; no points, whose contacts have three equations."""
    return [one for one in _relabels(problem) if not _concerns_point(problem, one)]


def relabels_of_points(problem: Problem) -> list[Hypothesis]:
    """Each contact on a point moved to each other feature, and each other contact to each point."""
    return [one for one in _relabels(problem) if _concerns_point(problem, one)]


def _relabels(problem: Problem) -> list[Hypothesis]:
    names = problem.contacts.features
    pairs = [(i, f) for i, name in enumerate(names) for f in problem.surfaces if f != name]
    return [
        Hypothesis(
            "relabel",
            index=(i,),
            features=(feature,),
            alternatives=len(pairs),
            labels=(*names[:i], feature, *names[i + 1 :]),
        )
        for i, feature in pairs
    ]


def swaps(problem: Problem) -> list[Hypothesis]:
    """The labels of each two contacts on different features swapped, but for points."""
    return [one for one in _swaps(problem) if not _concerns_point(problem, one)]


def swaps_with_points(problem: Problem) -> list[Hypothesis]:
    """The labels of each two contacts swapped of which one is on a point."""
    return [one for one in _swaps(problem) if _concerns_point(problem, one)]


def _swaps(problem: Problem) -> list[Hypothesis]:
    names = problem.contacts.features
    pairs = [(i, k) for i, k in combinations(range(len(names)), 2) if names[i] != names[k]]
    found = []
    for i, k in pairs:
        labels = list(names)
        labels[i], labels[k] = labels[k], labels[i]
        features = (names[i], names[k])
        found.append(Hypothesis("swapped_labels", (i, k), features, len(pairs), labels=tuple(labels)))
    return found


def _concerns_point(problem: Problem, one: Hypothesis) -> bool:
    names = {*one.features, *(problem.contacts.features[i] for i in one.index)}
    return any(isinstance(problem.surfaces[name], Point) for name in names)


def tips(problem: Problem) -> list[Hypothesis]:
    """Another tip radius than that of the file: zero, or the one that fits best."""
    free = Hypothesis("tip_radius", free="tip", alternatives=2)
    return [free] if problem.contacts.tip_radius == 0 else [free, Hypothesis("tip_radius", tip=0.0, alternatives=2)]


def tip_offsets(problem: Problem) -> list[Hypothesis]:
    """The tip's centre elsewhere in the flange frame, if the contacts have flange rotations that differ."""
    flanges = problem.contacts.flange_rotations
    if flanges is None or np.abs(flanges - flanges[0]).max() < TURNED_ENTRY:
        return []
    return [Hypothesis("tip_offset", free="tip_offset")]


def units(problem: Problem) -> list[Hypothesis]:
    """The coordinates alone, or all lengths, in another unit than that of the file."""
    count, tip = 2 * len(UNITS_MEANT), problem.contacts.tip_radius
    spread = problem.contacts.spread / float(problem.contacts.sigmas.max())
    possible = [factor for factor in UNITS_MEANT if spread * factor > LEAST_SPREAD]
    coordinates = [Hypothesis("unit", alternatives=count, points=factor) for factor in possible]
    # If all lengths are scaled, the spread in sigma stays as it is.
    whole = UNITS_MEANT if spread > LEAST_SPREAD else {}
    return coordinates + [
        Hypothesis("unit", alternatives=count, points=factor, sigmas=factor, tip=tip * factor, note="whole")
        for factor in whole
    ]
