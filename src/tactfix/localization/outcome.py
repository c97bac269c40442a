"""The outcome of locating: every solution, the tests that reject it, and the status.

1. All solutions are computed (`solve`).
2. Each is assessed: its fit first (`fit_test`), then the tests that reject poses although they fit (`assess`). The
   approach must lead into the material (eq. 11 of the paper, for planes, cylinders and inner surfaces too). Each
   contact must lie in the touch box of its feature. The pose must agree with what is known beforehand (`prior`). If it
   passes these tests, the straight path to each contact must be free.
3. If only the path rejects every remaining pose, the path was not straight: the test is left out.
4. Remaining solutions by relations whose poses are the same are one if only untouched features differ, which may be
   on either side of others: the best is kept, without these features.
5. The solutions that no test rejects give the status.

A sign must be wrong by SURE standard deviations to reject a pose; within them there is a warning.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from tactfix.accessibility.approach_path import path_blocked
from tactfix.contacts import GRAZING, Contacts
from tactfix.fixture import Fixture, TouchBox
from tactfix.geometry.arrays import Bools, Floats
from tactfix.geometry.nearest import same_surface
from tactfix.geometry.rigid import inverse, rotation_vectors, transform_points
from tactfix.geometry.surfaces import feet, moved
from tactfix.localization.fit_test import misfit_of
from tactfix.localization.free_motions import is_underdetermined
from tactfix.noise import SURE
from tactfix.poses.prior import contradiction
from tactfix.poses.solution import Solution, Solutions, in_order
from tactfix.results import Reason, ReasonCode, Status
from tactfix.values import frozen_value

NO_OTHER_POSE = 0.01
"""Share of sigma up to which two solutions have one pose. Fits of the same touched features agree to 1e-4 sigma
(`relations.joint.CONVERGED`); poses that the contacts distinguish are two sigma or more apart."""


@frozen_value
class Assessment:
    """reasons: why the pose is rejected; empty if it is not. warnings: tests that are within their uncertainty."""

    reasons: tuple[Reason, ...]
    warnings: tuple[str, ...]


@frozen_value
class Outcome:
    """solutions, the assessment of each, the solutions that are left, and the status."""

    solutions: Solutions
    assessments: tuple[Assessment, ...]
    left: tuple[Solution, ...]
    status: Status


def outcome_of(
    fixture: Fixture, contacts: Contacts, sigmas: Floats, with_misses: bool = True, thorough: bool = True
) -> Outcome:
    """The outcome for contacts with sigmas (n,) of the residuals; with_misses and thorough as in `solve`."""
    return outcome_from(fixture, contacts, solve(fixture, contacts, sigmas, with_misses, thorough))


def outcome_from(fixture: Fixture, contacts: Contacts, solutions: Solutions) -> Outcome:
    """The outcome of these solutions."""
    solutions = replace(solutions, found=in_order(solutions.found))
    # Steps 2 and 3.
    assessments = [assessment_of(fixture, contacts, solution, solutions.limit) for solution in solutions.found]
    assessments = _without_impossible_path(fixture, contacts, solutions, assessments)
    if not fixture.is_placed and len(solutions.found) > 1:
        solutions, assessments = _without_doubles(contacts, solutions, assessments)  # step 4
    left = tuple(s for s, v in zip(solutions.found, assessments, strict=True) if not v.reasons)
    return Outcome(solutions, tuple(assessments), left, status_of(contacts, solutions, left))


def _without_doubles(
    contacts: Contacts, solutions: Solutions, assessments: Sequence[Assessment]
) -> tuple[Solutions, list[Assessment]]:
    """The solutions and assessments, with those merged that no test rejects and that differ in untouched features only.

    The best of them is kept, without the features whose places differ: neither contacts nor relations determine these.
    """
    kept: list[tuple[Solution, Assessment]] = []
    for solution, assessment in zip(solutions.found, assessments, strict=True):
        doubles = [i for i, (_, v) in enumerate(kept) if not v.reasons and _are_one(kept[i][0], solution, contacts)]
        if assessment.reasons or not doubles:
            kept.append((solution, assessment))
            continue
        best, its_own = kept[doubles[0]]
        agreed = {n: s for n, s in best.surfaces.items() if same_surface(s, solution.surfaces[n], _at_most(contacts))}
        kept[doubles[0]] = replace(best, surfaces=agreed), its_own
    return replace(solutions, found=tuple(solution for solution, _ in kept)), [assessment for _, assessment in kept]


def _are_one(one: Solution, other: Solution, contacts: Contacts) -> bool:
    """Whether two solutions have one pose, and all touched features at the same places."""
    turn = other.base_from_fixture[:3, :3] @ one.base_from_fixture[:3, :3].T
    shift = other.base_from_fixture[:3, 3] - one.base_from_fixture[:3, 3]
    motion = np.concatenate([rotation_vectors(turn[None])[0], shift])
    if len(one.free_twists) or (np.abs(motion) > NO_OTHER_POSE * np.sqrt(np.diag(one.covariance))).any():
        return False
    touched = contacts.by_feature
    return all(same_surface(one.surfaces[name], other.surfaces[name], _at_most(contacts)) for name in touched)


def _at_most(contacts: Contacts) -> float:
    return NO_OTHER_POSE * float(contacts.sigmas.max())


def solve(
    fixture: Fixture, contacts: Contacts, sigmas: Floats, with_misses: bool = True, thorough: bool = True
) -> Solutions:
    """Every solution, by the way that fits the fixture: rigid, or feature by feature with relations.

    If there is none, the nearest miss, unless without with_misses; samples if relations leave a motion free. Without
    thorough a rigid fixture is searched at half the cost, and a pose may be missed.

    Raises UsageError if the file's relations leave the shape open, and the pose is constrained or was measured.
    """
    # Imported only when used: for the command, the imports take longer than the location.
    if fixture.is_placed:
        from tactfix.poses.rigid import rigid_solutions

        surfaces = {name: f.surface for name, f in fixture.features.items() if f.surface is not None}
        return rigid_solutions(surfaces, contacts, sigmas, with_misses, fixture.placement, thorough)
    if fixture.placement is not None and fixture.placement.is_in_fit:
        from tactfix.relations.rigid_bodies import placed_solutions

        return placed_solutions(fixture, contacts, sigmas, with_misses)
    from tactfix.relations.assembly import assembled_solutions

    return assembled_solutions(fixture, contacts, sigmas, with_misses)


def assessment_of(
    fixture: Fixture, contacts: Contacts, solution: Solution, limit: float, use_path: bool = True
) -> Assessment:
    """The assessment of a solution: its fit first, then approach, touch box, prior and path."""
    misfit = misfit_of(fixture, contacts, solution, limit)
    return assess(fixture, contacts, solution, use_path) if misfit is None else Assessment((misfit,), ())


NO_PATH = "no pose allows a straight path of the probe; the path test is omitted"


def _without_impossible_path(
    fixture: Fixture, contacts: Contacts, solutions: Solutions, assessments: Sequence[Assessment]
) -> list[Assessment]:
    """The assessments, without the path test if it alone rejects every remaining pose (step 3).

    A probe that starts close by did not move along the whole straight line that the test assumes.
    """
    codes = [{reason.code for reason in assessment.reasons} for assessment in assessments]
    if {"path"} not in codes or set() in codes:
        return list(assessments)
    again = [assessment_of(fixture, contacts, s, solutions.limit, use_path=False) for s in solutions.found]
    blocked = next(v.reasons[0].message for v, c in zip(assessments, codes, strict=True) if c == {"path"})
    warning = (
        f"{blocked}, and likewise for every pose: {NO_PATH}. If the probe starts closer, give probe.approach_distance"
    )
    return [v if v.reasons else replace(v, warnings=(*v.warnings, warning)) for v in again]


def status_of(contacts: Contacts, solutions: Solutions, left: Sequence[Solution]) -> Status:
    """The status if these solutions are left (step 5)."""
    if not left:
        # Too few contacts to be inconsistent: no sample of the continuum, or of the many poses, passed the tests.
        is_open = solutions.continuum or solutions.partial or solutions.dof < 0
        return "underdetermined" if is_open else "inconsistent"
    if solutions.continuum or solutions.dof < 0 or all(is_underdetermined(solution, contacts) for solution in left):
        return "underdetermined"
    if len(left) == 1:
        # Of many poses that the contacts leave, only some were fitted: the one that passed need not be the right one.
        return "underdetermined" if solutions.partial else "located"
    return "ambiguous"


def assess(fixture: Fixture, contacts: Contacts, trial: Solution, use_path: bool = True) -> Assessment:
    """The assessment of a pose that fits. The path is tested only if no other test rejects the pose."""
    reasons: list[Reason] = []
    warnings: list[str] = []
    for test in (_approach, _touch):
        test(fixture, contacts, trial, reasons, warnings)
    if fixture.placement is not None and (off := contradiction(fixture.placement, trial, fixture.units, fitted=True)):
        reasons.append(Reason("prior", None, None, off.message))
    if not reasons and use_path:
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
            f"the approach at {contacts.label(int(i))} grazes {contacts.features[i]}: its sign is not certain"
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
