"""Which contacts would have to go, or change their labels, for the others to be consistent.

Where the wrong ones are few of many, the pose that all others agree on is found without them, and they stand out by
their residuals there, one by one or together.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from tactfix.contacts import Contacts
from tactfix.diagnosis.deletion import CaseDeletion
from tactfix.diagnosis.hypotheses import CONTACTS_DOUBTED, Hypothesis, Solve, Stage
from tactfix.errors import TactfixError
from tactfix.fixture import Fixture
from tactfix.noise import SURE
from tactfix.poses.pose_fit import contact_residuals
from tactfix.probe import residual_sigmas
from tactfix.wording import listed

MOST_DOUBTED = 40
"""Contacts, those doubted most, that are asked whether they rule a hypothesis out, and of which each two labels are
swapped: the cost grows with the square of their number."""
MOST_SWAPS = 24
"""Swaps that are located, those first without whose two contacts chi-square would fall most."""
SEVERAL = (1, 2, 3, 5, 8, 12, 20)
"""Contacts that are left out together, those doubted most."""
SINGLE_FAULT_CONTACTS = 8
"""Of so many contacts at most one is left out."""
MUCH_EXPLAINED = 0.1
"""Share of chi-square that is not left, as far as residuals near the best pose tell, where those left out are wrong."""


def few_of_many(fixture: Fixture, contacts: Contacts, deletion: CaseDeletion, solve: Solve) -> Iterator[Stage]:
    """What explains all but a few of the contacts: a probe that scans makes thousands, and not one mistake at most."""
    if len(contacts) >= SINGLE_FAULT_CONTACTS:
        alone = [i for i in deletion.singly[:CONTACTS_DOUBTED] if deletion.is_explained_without([i])]
        yield relabelled(contacts, alone[:1])
        yield without_each(contacts, alone)
    wrong = _wrong_ones(fixture, contacts, deletion, solve)
    if len(wrong) == 2 and contacts.features[wrong[0]] != contacts.features[wrong[1]]:
        yield swapped_labels(contacts, [(wrong[0], wrong[1])])
    if len(wrong) > 1:
        yield _without_all(contacts, wrong)
    else:
        yield relabelled(contacts, wrong)
        yield without_each(contacts, wrong)


def _wrong_ones(fixture: Fixture, contacts: Contacts, deletion: CaseDeletion, solve: Solve) -> list[int]:
    """Indices of a few contacts that a pose leaves out which explains all others; empty where there is none."""
    for count in SEVERAL:
        doubtful = deletion.order[:count]
        if count > len(contacts) // SINGLE_FAULT_CONTACTS or deletion.remaining_share(doubtful) > MUCH_EXPLAINED:
            continue
        try:
            solutions = solve(_without(contacts, doubtful))
        except TactfixError:
            continue
        best = next(iter(solutions.found), None)
        if best is not None and best.chi2 <= solutions.limit:
            residuals, _ = contact_residuals(best.surfaces, contacts)
            return [int(i) for i in np.flatnonzero(np.abs(residuals) > SURE * residual_sigmas(fixture, contacts))]
    return []


def relabelled(contacts: Contacts, index: Sequence[int]) -> Stage:
    """Each of these contacts on each other feature that is touched."""
    for i in index:
        for feature in contacts.by_feature:
            if feature == contacts.features[i]:
                continue
            features = (*contacts.features[:i], feature, *contacts.features[i + 1 :])
            message = (
                f"{contacts.label(i)} is labelled {contacts.features[i]}; on {feature} it fits, and the contacts are "
                "consistent"
            )
            other = replace(contacts, features=features)
            yield Hypothesis("relabel", message, other, (contacts.rows[i],), (feature,))


def without_each(contacts: Contacts, index: Sequence[int]) -> Stage:
    """Each of these contacts alone left out."""
    for i in index if len(contacts) > 6 else ():
        label = f"{contacts.label(i)} ({contacts.features[i]})"
        message = f"without {label} the others are consistent: touch it again"
        rows, features = _told(contacts, [i])
        yield Hypothesis("outlier", message, _without(contacts, [i]), rows, features)


def _without_all(contacts: Contacts, index: Sequence[int]) -> Stage:
    labels = listed([contacts.label(i) for i in index])
    message = f"without {labels} the others are consistent: touch these again"
    yield Hypothesis("outlier", message, _without(contacts, index), *_told(contacts, index))


def _told(contacts: Contacts, index: Sequence[int]) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """The rows of these contacts, and their features."""
    return tuple(contacts.rows[i] for i in index), tuple(dict.fromkeys(contacts.features[i] for i in index))


def _without(contacts: Contacts, index: Sequence[int]) -> Contacts:
    return contacts.subset(np.delete(np.arange(len(contacts)), index))


def likely_pairs(contacts: Contacts, order: Sequence[int], deletion: CaseDeletion | None) -> list[tuple[int, int]]:
    """Pairs of contacts on different features, those first without which chi-square would fall most."""
    names = contacts.features
    pairs = [(i, k) for i, k in combinations(sorted(order[:MOST_DOUBTED]), 2) if names[i] != names[k]]
    if deletion is None:
        return pairs
    gains = np.array([deletion.gain(pair) for pair in pairs])
    return [pairs[int(p)] for p in np.argsort(-gains, kind="stable")]


def swapped_labels(contacts: Contacts, pairs: Sequence[tuple[int, int]]) -> Stage:
    """The labels of each of these pairs of contacts swapped."""
    for i, k in pairs:
        features = list(contacts.features)
        features[i], features[k] = features[k], features[i]
        message = f"with the labels of {contacts.label(i)} and {contacts.label(k)} swapped the contacts are consistent"
        swapped = replace(contacts, features=tuple(features))
        yield Hypothesis("swapped_labels", message, swapped, *_told(contacts, [i, k]))
