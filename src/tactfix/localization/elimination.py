"""Elimination: the tests that reject poses although they fit.

1. The approach must lead into the material (eq. 11 of the paper, for planes, cylinders and inner surfaces too).
2. Each contact must lie in the touch box of its feature.
3. The pose must agree with what is known beforehand (`prior`).
4. If it passes these tests, the straight path to each contact must be free.

Fit and relations are tested before, where the poses are computed. A sign must be wrong by SURE standard deviations to
reject a pose; within them there is a warning.
"""

from collections.abc import Callable

import numpy as np

from tactfix.accessibility.approach_path import path_blocked
from tactfix.contacts import GRAZING, Contacts
from tactfix.fixture import Fixture, TouchBox
from tactfix.geometry.arrays import Bools, Floats
from tactfix.geometry.rigid import inverse, transform_points
from tactfix.geometry.surfaces import feet, moved
from tactfix.noise import SURE
from tactfix.poses.prior import contradiction
from tactfix.poses.solution import Solution
from tactfix.results import Reason, ReasonCode
from tactfix.values import frozen_value


@frozen_value
class Assessment:
    """reasons: why the pose is rejected; empty if it is not. warnings: tests that are within their uncertainty."""

    reasons: tuple[Reason, ...]
    warnings: tuple[str, ...]


def assess(fixture: Fixture, contacts: Contacts, trial: Solution, use_path: bool = True) -> Assessment:
    """The assessment of a pose that fits. The path is tested only if no other test rejects the pose."""
    reasons: list[Reason] = []
    warnings: list[str] = []
    for test in (_approach, _touch):  # steps 1 and 2
        test(fixture, contacts, trial, reasons, warnings)
    # Step 3.
    if fixture.placement is not None and (off := contradiction(fixture.placement, trial, fixture.units, fitted=True)):
        reasons.append(Reason("prior", None, None, off.message))
    if not reasons and use_path:  # step 4
        _path(fixture, contacts, trial, reasons)
    return Assessment(tuple(reasons), tuple(warnings))


def _approach(
    fixture: Fixture, contacts: Contacts, trial: Solution, reasons: list[Reason], warnings: list[str]
) -> None:
    """Eq. 11: the probe must travel into the material, approach . outward normal < 0."""
    cosine = np.where(contacts.has_approach, np.einsum("ij,ij->i", contacts.approaches, trial.normals), -1.0)
    margin = SURE * trial.normal_sigmas
    _report(
        "approach",
        contacts,
        cosine,
        margin,
        reasons,
        lambda i, more: (
            f"the probe would have come out of the material of {contacts.features[i]} at {contacts.label(i)}{more}"
        ),
    )
    for i in np.flatnonzero((np.abs(cosine) <= margin) & (cosine > -GRAZING))[:3]:
        warnings.append(
            f"the approach at {contacts.label(int(i))} grazes {contacts.features[i]}: too close to tell a side"
        )


def _touch(fixture: Fixture, contacts: Contacts, trial: Solution, reasons: list[Reason], warnings: list[str]) -> None:
    """Each contact must lie in the touch box of its feature."""
    if not fixture.touch:
        return
    outside = np.full(len(contacts), -np.inf)
    fixture_from_base = inverse(trial.base_from_fixture)
    for name, box in fixture.touch.items():
        index = contacts.by_feature.get(name)
        if index is not None:
            on_surface = feet(trial.surfaces[name], contacts.points[index])
            outside[index] = _beyond(box, transform_points(fixture_from_base, on_surface))
    margin = SURE * np.hypot(trial.place_sigmas, contacts.sigmas)
    _report(
        "touch",
        contacts,
        outside,
        margin,
        reasons,
        lambda i, more: (
            f"{contacts.label(i)} would lie {outside[i]:.4g} {fixture.units} outside the touch box of "
            f"{contacts.features[i]}{more}"
        ),
    )
    # Rounding alone puts contacts outside a box that has no thickness along the normal of its plane.
    for i in np.flatnonzero((outside > 0.01 * contacts.sigmas) & (outside <= margin))[:3]:
        warnings.append(
            f"{contacts.label(int(i))} lies {outside[i]:.4g} {fixture.units} outside the touch box of "
            f"{contacts.features[i]}, within its uncertainty"
        )


def _beyond(box: TouchBox, points: Floats) -> Floats:
    """How far (n,) points (n, 3) lie outside the box, negative inside."""
    return np.asarray(np.maximum(box.low - points, points - box.high).max(axis=1))


def _path(fixture: Fixture, contacts: Contacts, trial: Solution, reasons: list[Reason]) -> None:
    """The straight approach to a contact must not run through another feature."""
    fixture_from_base = inverse(trial.base_from_fixture)
    points = transform_points(fixture_from_base, contacts.points)
    approaches = contacts.approaches @ fixture_from_base[:3, :3].T
    surfaces = {name: moved(fixture_from_base, surface) for name, surface in trial.surfaces.items()}
    margin = SURE * np.hypot(trial.place_sigmas, contacts.sigmas)
    # A contact whose place is free cannot be tested.
    testable = contacts.has_approach & np.isfinite(margin)
    for name, on_feature in contacts.by_feature.items():
        index = on_feature[testable[on_feature]]
        distance = fixture.probe.approach_distance
        blocked = path_blocked(surfaces, fixture.touch, name, points[index], approaches[index], distance, margin[index])
        for i, obstacle in zip(index, blocked, strict=True):
            if obstacle is not None:
                message = (
                    f"the straight approach to {contacts.label(int(i))} on {name} would have run through {obstacle}"
                )
                reasons.append(Reason("path", name, contacts.rows[i], message))
                break


def _report(
    code: ReasonCode,
    contacts: Contacts,
    values: Floats,
    margins: Floats,
    reasons: list[Reason],
    message: Callable[[int, str], str],
) -> None:
    """One reason per feature for values above their margins, at its worst contact."""
    wrong: Bools = values > margins
    if not wrong.any():
        return
    for name, on_feature in contacts.by_feature.items():
        index = on_feature[wrong[on_feature]]
        if not len(index):
            continue
        worst = int(index[np.argmax(values[index])])
        more = f" and {len(index) - 1} more" if len(index) > 1 else ""
        reasons.append(Reason(code, name, contacts.rows[worst], message(worst, more)))
