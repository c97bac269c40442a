"""Mistakes in labels and in single contacts: would the residuals show them?

Labels of single contacts, one wrong or two exchanged, are those that the residuals show least:

1. Residuals over sigma and their derivatives are taken at the true pose, with the wrong labels.
2. Linear least squares give the pose that follows, and the chi-square that remains.
3. The few labellings that leave the least chi-square are fitted exactly.

Two contacts off their surfaces are also ordered by chi-square to first order, and the first few pairs fitted.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Final

import numpy as np

from tactfix.contacts import Contacts
from tactfix.design.blind_spot import BlindSpot, Case, no_pose, power_of, refined, refitted, spot_of
from tactfix.design.nominal_contacts import ERROR_SIGMAS, Touched, moments, most_influential, normals_of, shift_of
from tactfix.diagnosis.contact_mistakes import relabelled, swapped
from tactfix.diagnosis.deletion import span_of
from tactfix.diagnosis.hypotheses import Hypothesis
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import inverse
from tactfix.geometry.surfaces import Point, outward_normals, residuals
from tactfix.wording import listed

_LABELLINGS_FITTED: Final = 3
"""Labellings that are fitted exactly, those that leave the least chi-square to first order. On the plate with pin
and ball 1 and 6 of them change which labelling is reported (one contact moves the pose by 4.3 or 20.5 mm instead
of 11.5), and not whether the residuals show it: each is a search of its own."""
_PAIRS_FITTED: Final = 3
"""Pairs of contacts that are fitted exactly, those that leave the least chi-square to first order. On the plate with
pin and ball 1 and 6 of them give the same report."""


def exchanged_labels(case: Case) -> Iterator[BlindSpot]:
    """The labels of features that can nearly change places, exchanged: the fit then starts at the other pose."""
    touched = case.touched
    if len(touched.surfaces) > 1:
        yield no_pose("labels", "labels exchanged")
    for exchange in case.exchanges:
        features = tuple(exchange.images[name] for name in touched.contacts.features)
        contacts = replace(touched.contacts, features=features)
        fit = refined(touched, contacts, inverse(exchange.image_from_fixture))
        mistake = f"labels of {listed([n for n, image in exchange.images.items() if n != image])} exchanged"
        yield spot_of(
            "labels", power_of(fit.chi2, touched.dof), shift_of(fit.base_from_fixture, touched.corners), mistake
        )


def swapped_labels(case: Case) -> Iterator[BlindSpot]:
    """Two contacts on different features with their labels exchanged; of very many those with the most leverage."""
    contacts = case.touched.contacts
    pairs = combinations(sorted(most_influential(case.touched)), 2)
    wrong = [swapped(contacts, i, j) for i, j in pairs if contacts.features[i] != contacts.features[j]]
    for one in _least_visible(case.touched, wrong):
        first, second = (f"{contacts.label(i)} on {contacts.features[i]}" for i in one.index)
        mistake = f"labels of {first} and {second} swapped"
        yield refitted("swapped_contacts", case.touched, one.corrected_contacts(contacts), mistake)


def wrong_label(case: Case) -> Iterator[BlindSpot]:
    """One contact labelled as another feature that is touched, except points, whose contacts have three equations."""
    contacts = case.touched.contacts
    sided = [name for name in contacts.by_feature if not isinstance(case.touched.surfaces[name], Point)]
    wrong = [
        relabelled(contacts, i, name)
        for i in sorted(most_influential(case.touched))
        for name in sided
        if name != contacts.features[i] and contacts.features[i] in sided
    ]
    for one in _least_visible(case.touched, wrong):
        (i,) = one.index
        mistake = f"{contacts.label(i)} on {contacts.features[i]} labelled {one.features[0]}"
        yield refitted("wrong_label", case.touched, one.corrected_contacts(contacts), mistake)


def _least_visible(touched: Touched, wrong: Sequence[Hypothesis]) -> Iterator[Hypothesis]:
    """The labellings that leave the least chi-square at the pose that follows them, to first order."""
    if not wrong:
        return
    rows, off = _as_labelled(touched, wrong)  # step 1
    followed = np.einsum("kij,kj->ki", np.linalg.pinv(rows), off)  # step 2
    left = off - np.einsum("kij,kj->ki", rows, followed)
    for k in np.argsort((left**2).sum(axis=1), kind="stable")[:_LABELLINGS_FITTED]:  # step 3
        yield wrong[int(k)]


def _as_labelled(touched: Touched, wrong: Sequence[Hypothesis]) -> tuple[Floats, Floats]:
    """Jacobian rows (k, n, 6) and residuals (k, n), over sigma, of each labelling at the true pose."""
    points, tip = touched.contacts.points, touched.contacts.tip_radius
    normals = np.repeat(normals_of(touched)[None], len(wrong), axis=0)
    off = np.zeros((len(wrong), len(points)))
    for k, one in enumerate(wrong):
        assert one.labels is not None
        for i in one.index:
            surface = touched.surfaces[one.labels[i]]
            normals[k, i] = outward_normals(surface, points[i])
            off[k, i] = residuals(surface, points[i], tip)
    rows = np.array([moments(touched, normal) for normal in normals])
    return rows / touched.sigmas[:, None], off / touched.sigmas


def one_contact(case: Case) -> Iterator[BlindSpot]:
    """Each contact in turn off along its normal."""
    for i in most_influential(case.touched):
        mistake = f"{case.touched.contacts.label(i)} off by {ERROR_SIGMAS:g} sigma"
        yield refitted("contact", case.touched, _off(case.touched, {i: ERROR_SIGMAS}), mistake)


def two_contacts(case: Case) -> Iterator[BlindSpot]:
    """Two contacts off along their normals: the pairs that, to first order, leave the least chi-square."""
    touched, index = case.touched, sorted(most_influential(case.touched))
    span = span_of(moments(touched, normals_of(touched)) / touched.sigmas[:, None])[index]
    shown = np.eye(len(index)) - span @ span.T
    own = np.add.outer(np.diag(shown), np.diag(shown))
    pairs = list(combinations(range(len(index)), 2))
    either = [(float(own[p] + 2 * sign * shown[p]), *p, sign) for p in pairs for sign in (1.0, -1.0)]
    for _, i, k, sign in sorted(either)[:_PAIRS_FITTED]:
        off = {index[i]: ERROR_SIGMAS, index[k]: sign * ERROR_SIGMAS}
        rows = listed([touched.contacts.label(j) for j in off])
        mistake = f"{rows} off by {ERROR_SIGMAS:g} and {sign * ERROR_SIGMAS:g} sigma"
        yield refitted("contacts", touched, _off(touched, off), mistake)


def _off(touched: Touched, sigmas_off: Mapping[int, float]) -> Contacts:
    """The contacts with these off their surfaces by so many sigma."""
    normals, points = normals_of(touched), touched.contacts.points.copy()
    for i, size in sigmas_off.items():
        points[i] += size * touched.sigmas[i] * normals[i]
    return replace(touched.contacts, points=points)
