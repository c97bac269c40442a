"""Mistakes in a few contacts: off their surface, on another feature, or with labels swapped."""

import math
from collections.abc import Iterable
from itertools import combinations

from tactfix.diagnosis.corrections import Hypothesis, Problem
from tactfix.geometry.surfaces import Point


def outliers(problem: Problem, sets: Iterable[tuple[int, ...]]) -> list[Hypothesis]:
    """Each of these sets of contacts (from 0) left out."""
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
    ]


def single_outliers(problem: Problem) -> list[Hypothesis]:
    """Each contact left out, where one more than a pose takes is left."""
    return outliers(problem, [(i,) for i in range(len(problem.contacts))]) if problem.dof > 0 else []


def relabels(problem: Problem) -> list[Hypothesis]:
    """Each contact on each other feature, but for points, whose contacts are three equations."""
    return [one for one in _relabels(problem) if not _concerns_point(problem, one)]


def relabels_of_points(problem: Problem) -> list[Hypothesis]:
    """Each contact on a point on each other feature, and each other contact on each point."""
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
    """The same where a point is among the two."""
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
