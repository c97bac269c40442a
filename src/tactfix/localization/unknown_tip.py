"""Locating a fixture together with the tip, if the tip's place in the flange or its radius is unknown.

1. All poses with their tips are found (`unknowns.search`).
2. Each is tested with the contacts corrected for its tip. If the path alone rejects all that are left, the test of
   the path is left out.
3. If something is known beforehand, the same is done without it.
4. The status decides what follows: the free motions, the next contact, or the pose with its covariance.
5. If the contacts are inconsistent, another place of the tip and the deletion of one contact are tried.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts, Unknown
from tactfix.diagnosis.messages import tip_offset_message
from tactfix.errors import UsageError
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.localization.common_result import candidate_of, common_result
from tactfix.localization.contacts_alone import decided_by_prior
from tactfix.localization.fit_test import too_large
from tactfix.localization.motion_words import vector
from tactfix.localization.next_contact import distinguishing_contact
from tactfix.localization.outcome import assess
from tactfix.localization.tip_advice import suspects, tip_motions, turned_contact
from tactfix.locate_result import LocateResult
from tactfix.noise import SURE
from tactfix.poses.prior import contradiction
from tactfix.poses.solution import largest_sigma
from tactfix.probe import residual_sigmas
from tactfix.relations.realization import realize
from tactfix.results import POSE_UNKNOWNS, Diagnosis, Reason, Status, TipEstimate, WithoutPrior
from tactfix.unknowns.search import TipSolutions, tip_solutions
from tactfix.unknowns.solution import TipSolution

SAME_TIP = 1e-6
"""Share of the contacts' spread up to which the tips of samples of a continuum are one: convergence leaves 1e-10
(`unknowns.descent.TIP_REACHED`), rounding of the samples more."""


def locate_with_tip(
    fixture: Fixture, contacts: Contacts, unknown: frozenset[Unknown], *, scale_sigma: bool = False
) -> LocateResult:
    """The pose and the unknown part of the tip; base frame and fixture units.

    Raises UsageError if contacts have no flange rotations, or the fixture has no known shape.
    """
    if "tip" in unknown and contacts.flange_rotations is None:
        raise UsageError("the tip is unknown, and the contacts do not give the orientation of the flange")
    shapes = realize(fixture)
    if not shapes:
        raise UsageError(f"{fixture.name}: an unknown tip needs a fixture whose features have known places")
    sigmas = residual_sigmas(fixture, contacts)
    known = fixture.placement
    # Step 1.
    solutions = tip_solutions(shapes, contacts, sigmas, unknown, fixture.probe.tip_within, known)
    # Step 2.
    reasons = [_against(fixture, solution, solutions.limit) for solution in solutions.found]
    if not any(len(against) == 0 for against in reasons):
        # If the path alone rejects every remaining pose, the probe did not take it.
        reasons = [tuple(reason for reason in against if reason.code != "path") for against in reasons]
    left = [solution for solution, against in zip(solutions.found, reasons, strict=True) if not against]
    status = _status(solutions, left)
    pairs = sorted(zip(solutions.found, reasons, strict=True), key=lambda pair: bool(pair[1]))
    candidates = tuple(candidate_of(solution.solution, against) for solution, against in pairs)
    best, fits = (left or solutions.found)[0], [each.solution for each in left or solutions.found]
    result = common_result(fixture, best.contacts, status, fits, solutions.dof, solutions.limit)
    result = replace(result, candidates=candidates)
    if known is not None and known.is_known:  # step 3
        result = _compared_without_prior(result, fixture, contacts, unknown)
    tip = _tip(contacts, left or solutions.found, solutions, unknown, fixture.probe.tip_within)
    result = replace(result, unknowns=_names(unknown), tip=tip)
    # Step 4.
    if status == "underdetermined":
        weakest = max(left or solutions.found, key=lambda s: len(s.weak))
        touch = turned_contact(fixture, weakest)
        return replace(result, free_motions=tip_motions(fixture, weakest), next_contact=touch)
    if status == "ambiguous":
        sigma, radius = float(contacts.sigmas.max()), left[0].contacts.tip_radius
        touch = distinguishing_contact(fixture, [each.solution for each in left], sigma, radius)
        return replace(result, next_contact=touch)
    if status == "located":
        factor = left[0].solution.chi2 / solutions.dof if scale_sigma and solutions.dof > 0 else 1.0
        joint = left[0].covariance * factor
        pose = left[0].solution.base_from_fixture
        return replace(result, base_from_fixture=pose, covariance=joint[:6, :6], joint_covariance=joint)
    found: tuple[Diagnosis, ...] = ()  # step 5
    if status == "inconsistent" and "tip" not in unknown and contacts.flange_rotations is not None:
        freed = tip_solutions(shapes, contacts, sigmas, unknown | {"tip"}, fixture.probe.tip_within, known)
        found = _tip_elsewhere(fixture, contacts, freed)
    if status == "inconsistent" and not found and solutions.found[0].solution.chi2 > solutions.limit:
        found = suspects(contacts, sigmas, unknown, fixture, solutions.found[0])
    return replace(result, diagnosis=found, warnings=(*result.warnings, *(cause.message for cause in found)))


def _tip_elsewhere(fixture: Fixture, contacts: Contacts, solutions: TipSolutions) -> tuple[Diagnosis, ...]:
    """Another place of the tip in the flange as the diagnosis; empty if it does not explain the contacts."""
    best = next((s for s in solutions.found if not _against(fixture, s, solutions.limit)), None)
    if best is None or not best.tip_is_known or solutions.dof < 1:
        return ()
    then = "the contacts are consistent"
    value, message = tip_offset_message(contacts, best.tip, fixture.units, then, float(np.median(contacts.sigmas)))
    return (Diagnosis("tip_offset", (), (), value, best.solution.chi2, message),)


def _against(fixture: Fixture, solution: TipSolution, limit: float) -> tuple[Reason, ...]:
    """The reasons against a solution: its fit, a tip beyond tip_within, prior, approach, touch box, path."""
    pose = solution.solution
    if pose.chi2 > limit:
        return (too_large(solution.contacts, pose, limit),)
    within, off = fixture.probe.tip_within, float(np.linalg.norm(solution.tip))
    if within is not None and off > within and off - SURE * _sigma_along(solution) > within:
        message = f"the tip would be {off:.4g} {fixture.units} from its nominal place, tip_within is {within:g}"
        return (Reason("tip", None, None, message),)
    if fixture.placement is not None:
        beyond = contradiction(fixture.placement, pose, fixture.units, fitted=True)
        if beyond is not None:
            return (Reason("prior", None, None, beyond.message),)
    return assess(replace(fixture, placement=None), solution.contacts, pose).reasons


def _compared_without_prior(
    result: LocateResult, fixture: Fixture, contacts: Contacts, unknown: frozenset[Unknown]
) -> LocateResult:
    """The result, with the one without the prior, and a warning if the prior alone decides."""
    alone = locate_with_tip(replace(fixture, placement=None), contacts, unknown)
    poses = sum(candidate.accepted for candidate in alone.candidates)
    without = WithoutPrior(alone.status, None if alone.status == "underdetermined" else poses)
    warnings: tuple[str, ...] = ()
    if result.status == "located" and alone.status != "located":
        warnings = (decided_by_prior(without),)
    if result.status == "inconsistent" and alone.status in ("located", "ambiguous"):
        beyond = next((r.message for c in result.candidates for r in c.reasons if r.code == "prior"), "")
        words = f": of the nearest pose that fits, {beyond}" if beyond else ", and agree without it"
        warnings = (f"the contacts contradict what is known beforehand{words}",)
    return replace(result, without_prior=without, warnings=(*result.warnings, *warnings))


def _sigma_along(solution: TipSolution) -> float:
    """The standard deviation of the tip along its deviation."""
    direction = solution.tip / np.linalg.norm(solution.tip)
    return float(np.linalg.norm(direction @ solution.factor[6:9]))


def _status(solutions: TipSolutions, left: Sequence[TipSolution]) -> Status:
    if solutions.dof < 0 or all(len(solution.weak) for solution in left or solutions.found):
        explained = solutions.found[0].solution.chi2 <= solutions.limit
        return "underdetermined" if left or explained or solutions.dof < 0 else "inconsistent"
    if not left:
        return "inconsistent"
    return "located" if len(left) == 1 else "ambiguous"


def _names(unknown: frozenset[Unknown]) -> tuple[str, ...]:
    tip = ("tip_x", "tip_y", "tip_z") if "tip" in unknown else ()
    return (*POSE_UNKNOWNS, *tip, *(("tip_radius",) if "tip-radius" in unknown else ()))


def _tip(
    contacts: Contacts,
    left: Sequence[TipSolution],
    solutions: TipSolutions,
    unknown: frozenset[Unknown],
    within: float | None,
) -> TipEstimate | None:
    """The tip if the contacts determine it; the pose need not be determined."""
    best = left[0]
    if not all(solution.tip_is_known for solution in left) or best.solution.chi2 > solutions.limit:
        return None
    slack = SAME_TIP * contacts.spread + _worst_sigma(best) / 2
    if any(np.abs(other.tip - best.tip).max() > slack for other in left):
        return None
    offset = best.contacts.tip_offset if "tip" in unknown else contacts.tip_offset
    covariance = best.factor[6:] @ best.factor[6:].T
    words = _in_words(best, offset, solutions, unknown, is_bounded=within is not None)
    return TipEstimate(offset, best.contacts.tip_radius, covariance, words)


def _worst_sigma(solution: TipSolution) -> float:
    return float(np.sqrt(np.linalg.eigvalsh(solution.factor[6:] @ solution.factor[6:].T)[-1]))


def _in_words(
    best: TipSolution, offset: Floats | None, solutions: TipSolutions, unknown: frozenset[Unknown], *, is_bounded: bool
) -> str:
    parts = []
    if "tip" in unknown and offset is not None:
        sigma = largest_sigma(best.factor[6:9] @ best.factor[6:9].T)
        off = float(np.linalg.norm(best.tip))
        parts.append(
            f"the tip is at {vector(offset)} in the flange frame, {off:.3g} from its nominal place, "
            f"worst sigma {sigma:.2g}"
        )
    if "tip-radius" in unknown:
        sigma = float(np.linalg.norm(best.factor[-1]))
        parts.append(f"the tip's radius is {best.contacts.tip_radius:.6g}, sigma {sigma:.2g}")
    if not solutions.complete:
        bound = "; give probe.tip_within to limit it" if "tip" in unknown and not is_bounded else ""
        parts.append(f"another pose with another tip may explain the contacts too{bound}")
    return "; ".join(parts)
