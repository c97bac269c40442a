"""Two contacts of different features with their labels exchanged: the pairs that the residuals show least."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from typing import Final

import numpy as np

from tactfix.contacts import Contacts
from tactfix.design.nominal_contacts import Touched, moments, most_telling, normals_of
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import outward_normals, residuals
from tactfix.values import frozen_value

# Pairs that are fitted exactly; the others leave more to first order already.
_FOLLOWED: Final = 3


@frozen_value
class Swap:
    """The contacts with two labels exchanged, and which two, in words."""

    contacts: Contacts
    message: str


def least_visible_swaps(touched: Touched) -> Iterator[Swap]:
    """The exchanges of two labels that leave the least chi-square once the pose has followed them, to first order."""
    pairs = _pairs(touched)
    if not pairs:
        return
    rows, off = _as_labelled(touched, pairs)
    followed = np.einsum("kij,kj->ki", np.linalg.pinv(rows), off)
    left = off - np.einsum("kij,kj->ki", rows, followed)
    for k in np.argsort((left**2).sum(axis=1), kind="stable")[:_FOLLOWED]:
        yield _swapped(touched.contacts, *pairs[int(k)])


def _pairs(touched: Touched) -> list[tuple[int, int]]:
    """Indices of two contacts on different features; of very many contacts those of the most leverage."""
    names = touched.contacts.features
    return [(i, j) for i, j in combinations(sorted(most_telling(touched)), 2) if names[i] != names[j]]


def _as_labelled(touched: Touched, pairs: list[tuple[int, int]]) -> tuple[Floats, Floats]:
    """For each pair rows (k, n, 6) and residuals (k, n), over sigma, that the wrong labels give at the true pose."""
    contacts, surfaces = touched.contacts, touched.surfaces
    normals = np.repeat(normals_of(touched)[None], len(pairs), axis=0)
    off = np.zeros((len(pairs), len(contacts)))
    for k, pair in enumerate(pairs):
        for here, there in (pair, pair[::-1]):
            surface = surfaces[contacts.features[there]]
            normals[k, here] = outward_normals(surface, contacts.points[here])
            off[k, here] = residuals(surface, contacts.points[here], contacts.tip_radius)
    rows = np.array([moments(touched, normal) for normal in normals])
    return rows / touched.sigmas[:, None], off / touched.sigmas


def _swapped(contacts: Contacts, i: int, j: int) -> Swap:
    names = list(contacts.features)
    names[i], names[j] = names[j], names[i]
    message = f"labels of {contacts.label(i)} on {names[j]} and {contacts.label(j)} on {names[i]} swapped"
    return Swap(replace(contacts, features=tuple(names)), message)
