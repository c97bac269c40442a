"""Locating a fixture: from contacts to one pose, or to the reason why there is none or more than one.

1. Contacts that do not belong to this fixture are refused. Features by relations that nothing determines are left out
   (`relations.free_features`). If the tip is unknown, `unknown_tip` takes over.
2. All solutions are found (`poses.rigid`: all contacts at once; `relations.assembly`: feature by feature). Each is
   tested, and those that remain give the status (`outcome`).
3. The result gets what every status has: candidates, residuals, surfaces, warnings.
4. If something is known beforehand, the result without it is added (`contacts_alone`).
5. The status decides what follows: the pose, the next contact, the free motions, or a diagnosis.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts, Unknown
from tactfix.errors import UsageError
from tactfix.fixture import Fixture
from tactfix.geometry.surfaces import offset_radius
from tactfix.localization.common_result import candidate_of, common_result
from tactfix.localization.fit_test import residual_warnings
from tactfix.localization.free_motions import free_motions, is_underdetermined
from tactfix.localization.outcome import Assessment, assessment_of, outcome_from, outcome_of, solve
from tactfix.locate_result import LocatedResult, LocateResult, NotLocatedResult
from tactfix.noise import chi_square_limit
from tactfix.poses.solution import Solution, Solutions
from tactfix.probe import residual_sigmas
from tactfix.results import Diagnosis, Status, Touched
from tactfix.wording import listed

COINCIDENT_SIGMAS = 100.0
"""Extent of the contacts, in sigma, below which underdetermined contacts get a warning about their unit: fixtures are
thousands of sigma wide, and a wrong unit makes them 25 or 1000 times smaller."""

CUT = "Of the mistakes only the most plausible ones were tried."
SAMPLES_SHOWN = 8
"""Samples of a continuum that are listed: enough to show what is free, few enough to read."""


def locate(
    fixture: Fixture,
    contacts: Contacts,
    *,
    scale_sigma: bool = False,
    explain: bool = True,
    unknown: Collection[Unknown] = (),
) -> LocatedResult | NotLocatedResult:
    """Locate a fixture: find every pose that explains the contacts, and say which one is left.

    Parameters
    ----------
    fixture : Fixture
        What was touched.
    contacts : Contacts
        In base coordinates and in the fixture's units.
    scale_sigma : bool
        Scale the covariance by chi2 / dof where dof > 0, instead of trusting sigma.
    explain : bool
        False: an inconsistent result comes without the nearest miss and without a diagnosis, and an underdetermined
        one of a fixture by relations may come without the motions left free.
    unknown : collection of {"tip", "tip-radius"}
        Unknowns of the tip that are found too: its centre in the flange frame, which takes contacts with flange
        rotations, and its effective radius.

    Returns
    -------
    LocatedResult or NotLocatedResult
        status is "located" if and only if exactly one pose is left; then pose and covariance are not None.

    Raises
    ------
    UsageError
        Contacts on no or unknown features, or in another unit than the fixture's.
    TipDoesNotFitError
        A tip that is not smaller than a bore.

    Notes
    -----
    Poses are the minima over (R, t) of the sum of (f_i(R^T (x_i - t)) - r)^2 / sigma_i^2, with f_i the signed distance
    from the surface of contact i and r the tip radius. A pose is eliminated, in this order, by chi-square and by the
    largest normalised residual (one in a million), by the approach (n_i . a_i < 0, to 5 sigma; eq. 11 of [1]_,
    generalised to planes, cylinders and inner surfaces), by the touch boxes, and by the path of the probe.
    The covariance is that of (d_rot, d_t): R_true = exp([d_rot]) R, t_true = t + d_t, in base axes.

    References
    ----------
    .. [1] The paper of the README.
    .. [2] W. Baarda, "A testing procedure for use in geodetic networks", 1968: the largest normalised residual.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> contacts = tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    >>> result = tactfix.locate(fixture, contacts)
    >>> result.status, round(result.rms, 3)
    ('located', 0.067)
    """
    _refuse_foreign(fixture, contacts)  # step 1
    part, counted = fixture, contacts
    if not fixture.is_placed:
        from tactfix.relations.free_features import without_free_features

        part, counted = without_free_features(fixture, contacts)
    answer = _answer(part, counted, scale_sigma, explain, unknown)
    if len(counted) < len(contacts):
        answer = replace(answer, warnings=(*answer.warnings, *_not_counted(part, contacts)))
    return replace(answer, touched=Touched(fixture, contacts)).by_status


def _not_counted(part: Fixture, contacts: Contacts) -> Iterator[str]:
    """A warning for each touched feature that is not in part, the fixture without free features."""
    for name, index in contacts.by_feature.items():
        if name not in part.features:
            rows = listed([contacts.label(int(i)) for i in index])
            yield f"{rows} not counted: contacts and relations leave {name} free, and the pose does not depend on it"


def _answer(
    fixture: Fixture, contacts: Contacts, scale_sigma: bool, explain: bool, unknown: Collection[Unknown]
) -> LocateResult:
    contacts = _without_approach_to_points(fixture, contacts)
    if unknown:
        from tactfix.localization.unknown_tip import locate_with_tip

        return locate_with_tip(fixture, contacts, frozenset(unknown), scale_sigma=scale_sigma)
    sigmas = residual_sigmas(fixture, contacts)
    outcome = outcome_of(fixture, contacts, sigmas, with_misses=explain)  # step 2
    solutions, assessments, left, status = outcome.solutions, outcome.assessments, outcome.left, outcome.status
    result = _result(fixture, contacts, solutions, assessments, left, status)  # step 3
    if left and not fixture.is_placed and status != "underdetermined":
        from tactfix.relations.parallels import uncertain_distances

        result = replace(result, warnings=(*result.warnings, *uncertain_distances(fixture, left[0].surfaces)))
    if explain and fixture.placement is not None and fixture.placement.is_known:  # step 4
        from tactfix.localization.contacts_alone import contacts_alone

        alone = contacts_alone(fixture, contacts, sigmas, outcome)
        warnings = (*result.warnings, *alone.warnings(status))
        candidates = (*result.candidates, *alone.fallen)
        result = replace(result, candidates=candidates, warnings=warnings, without_prior=alone.without)
        if alone.contradictions:
            return result
    # Step 5.
    if status == "located":
        return _with_pose(result, fixture, left[0], scale_sigma)
    if status == "ambiguous":
        from tactfix.localization.next_contact import distinguishing_contact

        touch = distinguishing_contact(fixture, left, float(contacts.sigmas.max()), contacts.tip_radius)
        return replace(result, next_contact=touch)
    if status == "underdetermined":
        return _with_free_motions(result, fixture, contacts, solutions, left)
    return _with_diagnosis(result, fixture, contacts, solutions) if explain else result


def _refuse_foreign(fixture: Fixture, contacts: Contacts) -> None:
    foreign = sorted(set(contacts.by_feature) - set(fixture.features))
    if foreign:
        raise UsageError(f"contacts on {', '.join(foreign)}, which {fixture.name} does not have")
    if contacts.units not in (None, fixture.units):
        raise UsageError(f"contacts in {contacts.units}, and {fixture.name} in {fixture.units}; give both in one unit")
    if not len(contacts):
        raise UsageError("there are no contacts; touch the fixture at least six times")
    for name in dict.fromkeys(contacts.features):
        # Here the error can name the feature; the search knows scaled lengths only.
        feature = fixture.features[name]
        if feature.radius is not None:
            offset_radius(name, feature.radius, feature.side, contacts.tip_radius)


def _without_approach_to_points(fixture: Fixture, contacts: Contacts) -> Contacts:
    """The contacts without approaches to points, which have no side."""
    on_point = np.array([fixture.features[name].type == "point" for name in contacts.features])
    if not (on_point & contacts.has_approach).any():
        return contacts
    return replace(contacts, approaches=np.where(on_point[:, None], np.nan, contacts.approaches))


def _result(
    fixture: Fixture,
    contacts: Contacts,
    solutions: Solutions,
    assessments: Sequence[Assessment],
    left: Sequence[Solution],
    status: Status,
) -> LocateResult:
    """The part of the result that every status has."""
    shown = list(zip(solutions.found, assessments, strict=True))
    if solutions.continuum:
        samples = [pair for pair in shown if len(pair[0].free_twists)]
        shown = [pair for pair in shown if not len(pair[0].free_twists)] + samples[:SAMPLES_SHOWN]
    shown.sort(key=lambda pair: bool(pair[1].reasons))
    candidates = (candidate_of(solution, assessment.reasons) for solution, assessment in shown)
    suspicious = (
        residual_warnings(fixture, contacts, left[0], solutions.dof) if left and status != "underdetermined" else ()
    )
    is_open = status == "underdetermined" and not solutions.partial
    return replace(
        common_result(fixture, contacts, status, left or solutions.found, solutions.dof, solutions.limit),
        candidates=(*candidates, *solutions.fallen),
        warnings=() if is_open else _warnings(solutions, assessments, left, suspicious),
        diagnosis=suspicious,
    )


def _warnings(
    solutions: Solutions, assessments: Sequence[Assessment], left: Sequence[Solution], suspicious: Sequence[Diagnosis]
) -> tuple[str, ...]:
    warnings = [warning for one in assessments if not one.reasons for warning in one.warnings]
    for assessment in assessments if len(left) == 1 else []:
        if {reason.code for reason in assessment.reasons} == {"path"}:
            note = "no other test rejects another pose; if the probe starts closer, give approach_distance"
            warnings.append(f"{assessment.reasons[0].message}: {note}")
    warnings += [cause.message for cause in suspicious]
    if not solutions.complete and not solutions.continuum and solutions.dof >= 0:
        warnings.append("the search for poses did not converge: a pose may have been missed; add a contact")
    return tuple(dict.fromkeys(warnings))


def _with_pose(result: LocateResult, fixture: Fixture, solution: Solution, scale_sigma: bool) -> LocateResult:
    factor = solution.chi2 / result.dof if scale_sigma and result.dof > 0 else 1.0
    return replace(result, base_from_fixture=solution.base_from_fixture, covariance=solution.covariance * factor)


def _with_free_motions(
    result: LocateResult, fixture: Fixture, contacts: Contacts, solutions: Solutions, left: Sequence[Solution]
) -> LocateResult:
    # Contacts in special position leave a motion free in some poses and not in others.
    weakest = max(left or solutions.found, key=lambda sample: len(sample.free_twists), default=None)
    motions = free_motions(fixture, contacts, weakest) if weakest and (left or not solutions.partial) else ()
    if weakest is not None:
        from tactfix.localization.next_contact import missing_contact

        result = replace(result, next_contact=missing_contact(fixture, contacts, weakest))
    extent, sigma = float(np.linalg.norm(np.ptp(contacts.points, axis=0))), float(np.median(contacts.sigmas))
    if weakest is None or len(weakest.free_twists) or extent > COINCIDENT_SIGMAS * sigma:
        return replace(result, free_motions=motions)
    warning = (
        f"all contacts lie within {extent:.3g} {fixture.units}, {extent / sigma:.2g} times their sigma: "
        "is their unit the right one?"
    )
    return replace(result, free_motions=motions, warnings=(*result.warnings, warning))


def _with_diagnosis(result: LocateResult, fixture: Fixture, contacts: Contacts, solutions: Solutions) -> LocateResult:
    """The result with the mistakes that explain the contacts."""
    from tactfix.diagnosis.diagnose import NOTHING_EXPLAINS, diagnosed
    from tactfix.diagnosis.staged import staged_diagnosis
    from tactfix.relations.realization import few_shapes
    from tactfix.relations.trials import CorrectionTrials

    best = next(iter(solutions.found), None)
    trials = None if few_shapes(fixture) else CorrectionTrials(fixture, contacts, best.surfaces if best else None)

    def solve_again(corrected: Contacts, with_misses: bool = True) -> Solutions:
        if trials is not None:
            return trials.solutions(corrected, with_misses)
        return solve(fixture, corrected, residual_sigmas(fixture, corrected), with_misses)

    def explained(corrected: Contacts) -> tuple[float, str] | None:
        again = outcome_from(fixture, corrected, solve_again(corrected, with_misses=False))
        if not again.left:
            return None
        # A weakly determined pose counts after a deletion only: contacts in a wrong unit may shrink to a point.
        is_weak = again.status == "underdetermined"
        if is_weak and (again.solutions.dof < 1 or len(corrected) == len(contacts)):
            return None
        return again.left[0].chi2, "" if again.status == "located" else f" (the result is then {again.status})"

    def accepts(corrected: Fixture, kept: Contacts, solution: Solution) -> str | None:
        assessment = assessment_of(corrected, kept, solution, chi_square_limit(corrected.dof(kept.features)))
        if {reason.code for reason in assessment.reasons} - {"path"}:
            return None
        return " (the pose is then weakly determined)" if is_underdetermined(solution, kept) else ""

    fits = any(reason.code != "fit" for candidate in result.candidates for reason in candidate.reasons)

    def staged() -> tuple[Diagnosis, ...]:
        return staged_diagnosis(fixture, contacts, best, fits, solve_again, explained, trials)

    found = diagnosed(fixture, contacts, solutions.found, accepts, staged)
    nothing = f"{NOTHING_EXPLAINS} {CUT}" if trials and trials.is_cut else NOTHING_EXPLAINS
    messages = tuple(cause.message for cause in found) or (nothing, *_doubt_of_tip(fixture, contacts))
    return replace(result, warnings=(*result.warnings, *messages), diagnosis=found)


def _doubt_of_tip(fixture: Fixture, contacts: Contacts) -> tuple[str, ...]:
    """A tip that is larger than all that was touched: 3 (mm) read in the metres of a log."""
    extent = float(np.linalg.norm(np.ptp(contacts.points, axis=0)))
    if contacts.tip_radius <= extent:
        return ()
    return (
        f"the tip radius, {contacts.tip_radius:.4g} {fixture.units}, is larger than the extent of the contacts, "
        f"{extent:.4g} {fixture.units}: are it and sigma given in the unit of the contacts?",
    )
