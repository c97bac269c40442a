"""Contacts with wrong labels, one or two exchanged: those that the residuals show least.

1. Residuals over sigma and their derivatives are taken at the true pose, as the wrong labels give them.
2. Linear least squares say how the pose follows, and what is left of chi-square then.
3. Those few that leave the least are to be fitted exactly.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Final

import numpy as np

from tactfix.contacts import Contacts
from tactfix.design.nominal_contacts import Touched, moments, most_telling, normals_of
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Point, outward_normals, residuals
from tactfix.values import frozen_value

_LABELLINGS_FITTED: Final = 3
"""Labellings that are fitted exactly, those that leave the least chi-square to first order. On the plate with pin
and ball 1 and 6 of them change which labelling is reported (one contact moves the pose by 4.3 or 20.5 mm instead
of 11.5), and not whether the residuals show it: each is a search of its own."""


@frozen_value
class WrongLabels:
    """The contacts with wrong labels, those of index (from 0), and which, in words."""

    contacts: Contacts
    index: tuple[int, ...]
    message: str


def swaps(touched: Touched) -> list[WrongLabels]:
    """Two contacts on different features with their labels exchanged; of very many those of the most leverage."""
    names, contacts = touched.contacts.features, touched.contacts
    pairs = [(i, j) for i, j in combinations(sorted(most_telling(touched)), 2) if names[i] != names[j]]
    return [
        _labelled(
            contacts,
            {i: names[j], j: names[i]},
            f"labels of {contacts.label(i)} on {names[i]} and {contacts.label(j)} on {names[j]} swapped",
        )
        for i, j in pairs
    ]


def relabels(touched: Touched) -> list[WrongLabels]:
    """One contact labelled as another feature that is touched; points, whose contacts are three equations, are not."""
    contacts = touched.contacts
    sided = [name for name in contacts.by_feature if not isinstance(touched.surfaces[name], Point)]
    return [
        _labelled(contacts, {i: name}, f"{contacts.label(i)} on {contacts.features[i]} labelled {name}")
        for i in sorted(most_telling(touched))
        for name in sided
        if name != contacts.features[i] and contacts.features[i] in sided
    ]


def _labelled(contacts: Contacts, labels: dict[int, str], message: str) -> WrongLabels:
    features = tuple(labels.get(i, name) for i, name in enumerate(contacts.features))
    return WrongLabels(replace(contacts, features=features), tuple(labels), message)


def least_visible(touched: Touched, wrong: Sequence[WrongLabels]) -> Iterator[WrongLabels]:
    """Those that leave the least chi-square once the pose has followed them, to first order."""
    if not wrong:
        return
    rows, off = _as_labelled(touched, wrong)  # step 1
    followed = np.einsum("kij,kj->ki", np.linalg.pinv(rows), off)  # step 2
    left = off - np.einsum("kij,kj->ki", rows, followed)
    for k in np.argsort((left**2).sum(axis=1), kind="stable")[:_LABELLINGS_FITTED]:  # step 3
        yield wrong[int(k)]


def _as_labelled(touched: Touched, wrong: Sequence[WrongLabels]) -> tuple[Floats, Floats]:
    """For each of them rows (k, n, 6) and residuals (k, n), over sigma, that the labels give at the true pose."""
    points, tip = touched.contacts.points, touched.contacts.tip_radius
    normals = np.repeat(normals_of(touched)[None], len(wrong), axis=0)
    off = np.zeros((len(wrong), len(points)))
    for k, labels in enumerate(wrong):
        for i in labels.index:
            surface = touched.surfaces[labels.contacts.features[i]]
            normals[k, i] = outward_normals(surface, points[i])
            off[k, i] = residuals(surface, points[i], tip)
    rows = np.array([moments(touched, normal) for normal in normals])
    return rows / touched.sigmas[:, None], off / touched.sigmas
