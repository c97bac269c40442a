"""Mistakes in the contact file: contacts off their surface, wrong labels, a wrong unit, a wrong tip."""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.hypotheses import Hypothesis, Problem
from tactfix.geometry.surfaces import Point

TURNED_ENTRY = 1e-3
"""Rotations of the flange count as one orientation if no entry differs by more (no unit, about rad): with a turn that
small, a displaced tip and a displaced fixture are the same to within a thousandth of the displacement."""

LEAST_SPREAD = 30.0
"""Least spread of the contacts, in sigma, after a change of their unit. Contacts that are closer together fit any
pose, and a search takes long; a fixture is thousands of sigma wide."""
LATEST = 0.01
"""Share of the contacts' spread: a probe that reports points of the surface may trigger late by this much at most.
Overtravel is a length of the probe, whatever the fixture's size, but no contact file bounds it. So the share is a
choice without a source, which holds in every unit: 1 mm on 100 mm. On a fixture of 10 mm it leaves out a trigger
0.2 mm late; on one of several metres it admits tens of millimetres."""
UNITS_MEANT = {
    25.4: "inches given as mm",
    1 / 25.4: "mm given as inches",
    1e3: "metres given as mm, or mm given as micrometres",
    1e-3: "mm given as metres, or micrometres given as mm",
    1e3 / 25.4: "metres given as inches",
    25.4e-3: "inches given as metres",
    1e6: "metres given as micrometres",
    1e-6: "micrometres given as metres",
    25.4e3: "inches given as micrometres",
    1 / 25.4e3: "micrometres given as inches",
}
"""Factors between any two units that a contact file may have (mm, m, um, inch), each with the mistake that it
undoes."""


def deleted(contacts: Contacts, index: Sequence[int], alternatives: float = 1.0) -> Hypothesis:
    """The contacts of this index (from 0) are wrong: they are deleted."""
    features = tuple(dict.fromkeys(contacts.features[i] for i in index))
    return Hypothesis("outlier", tuple(index), features, alternatives, deleted=tuple(index))


def relabelled(contacts: Contacts, i: int, feature: str, alternatives: float = 1.0) -> Hypothesis:
    """Contact i is on another feature."""
    labels = (*contacts.features[:i], feature, *contacts.features[i + 1 :])
    return Hypothesis("relabel", (i,), (feature,), alternatives, labels=labels)


def swapped(contacts: Contacts, i: int, k: int, alternatives: float = 1.0) -> Hypothesis:
    """The labels of contacts i and k, on different features, are swapped."""
    labels = list(contacts.features)
    labels[i], labels[k] = labels[k], labels[i]
    return Hypothesis("swapped_labels", (i, k), (labels[k], labels[i]), alternatives, labels=tuple(labels))


def reversed_approaches(contacts: Contacts, index: Sequence[int], alternatives: float = 1.0) -> Hypothesis:
    """The approaches of the contacts of this index are reversed."""
    features = tuple(dict.fromkeys(contacts.features[i] for i in index))
    return Hypothesis("approach", tuple(index), features, alternatives, reversed=tuple(index))


def all_reversed(contacts: Contacts) -> Hypothesis:
    """All approaches are reversed."""
    return Hypothesis("approach", reversed=tuple(np.flatnonzero(contacts.has_approach).tolist()))


def unit_changes(contacts: Contacts) -> list[Hypothesis]:
    """The coordinates alone, or all lengths, in another unit than that of the file."""
    count, tip = 2 * len(UNITS_MEANT), contacts.tip_radius
    coordinates = [Hypothesis("unit", alternatives=count, points=factor) for factor in UNITS_MEANT]
    return coordinates + [
        Hypothesis("unit", alternatives=count, points=factor, sigmas=factor, tip=tip * factor, note="whole")
        for factor in UNITS_MEANT
    ]


def is_possible_tip(contacts: Contacts, radius: float) -> bool:
    """Whether an effective tip radius is possible: below 0, by LATEST at most, for points of the surface only."""
    return radius >= 0 or (contacts.tip_radius == 0 and -radius <= LATEST * contacts.spread)


def outliers(problem: Problem, sets: Iterable[tuple[int, ...]]) -> list[Hypothesis]:
    """Each of these sets of contacts deleted, if at least six equations are left."""
    count = len(problem.contacts)
    return [
        deleted(problem.contacts, chosen, math.comb(count, len(chosen)))
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


def _relabels(problem: Problem) -> Iterator[Hypothesis]:
    pairs = [(i, f) for i, name in enumerate(problem.contacts.features) for f in problem.surfaces if f != name]
    return (relabelled(problem.contacts, i, feature, len(pairs)) for i, feature in pairs)


def swaps(problem: Problem) -> list[Hypothesis]:
    """The labels of each two contacts on different features swapped, but for points."""
    return [one for one in _swaps(problem) if not _concerns_point(problem, one)]


def swaps_with_points(problem: Problem) -> list[Hypothesis]:
    """The labels of each two contacts swapped of which one is on a point."""
    return [one for one in _swaps(problem) if _concerns_point(problem, one)]


def _swaps(problem: Problem) -> Iterator[Hypothesis]:
    names = problem.contacts.features
    pairs = [(i, k) for i, k in combinations(range(len(names)), 2) if names[i] != names[k]]
    return (swapped(problem.contacts, i, k, len(pairs)) for i, k in pairs)


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
    """Each change of unit after which the contacts' spread is LEAST_SPREAD sigma or more."""
    spread = problem.contacts.spread / float(problem.contacts.sigmas.max())
    return [one for one in unit_changes(problem.contacts) if spread * one.points / one.sigmas > LEAST_SPREAD]
