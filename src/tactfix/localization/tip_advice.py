"""Advice if pose and tip are not both found: free motions, the next contact, or contacts that may be wrong.

Free motions of tip and fixture together (`tip_motions`):

1. Singular vectors of the tip's part separate the motions that move the tip from those of the fixture alone.
2. The motions of the fixture alone are removed from those with the tip, which then show what must be turned.
3. If all three translations of the tip are free, one motion for each axis of the flange is given.
4. Each motion is described by what would determine it: another orientation of the tool, or an opposite side.
"""

from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts, Unknown
from tactfix.diagnosis.hypotheses import INDISTINCT
from tactfix.diagnosis.messages import one_of, without_message
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import inverse
from tactfix.geometry.surfaces import moved
from tactfix.localization.free_motions import in_words, tidied
from tactfix.localization.motion_words import vector
from tactfix.localization.next_contact import missing_contact, touch_in_words
from tactfix.noise import chi_square_limit
from tactfix.poses.pose_fit import SMALLEST_RATIO, contact_residuals
from tactfix.poses.solution import at_base_origin
from tactfix.results import Diagnosis, FreeMotion, NextContact
from tactfix.unknowns.descent import descend
from tactfix.unknowns.equations import TipEquations
from tactfix.unknowns.solution import TipSolution

MOST_DELETED = 24
"""Contacts that are deleted one after the other: of more than these, those that the linear model names first. Each
deletion is a fit, which takes up to 80 steps."""
SUSPECTS_LISTED = 8
"""Suspect contacts that are listed at most: what a person reads, as `diagnosis.hypothesis_tests.MOST_ENTRIES`."""
NO_PART = 1e-3
"""Share of a motion below which a part of it counts as zero: a thousandth of a translation of the tip is below what a
message of two digits shows."""


def tip_motions(fixture: Fixture, solution: TipSolution) -> tuple[FreeMotion, ...]:
    """The free or nearly free motions, in base: motions with the tip first, then those of the fixture alone."""
    weak = solution.weak / np.linalg.norm(solution.weak, axis=1, keepdims=True)
    u, values, _ = np.linalg.svd(weak[:, 6:])
    moving = int((values > NO_PART).sum())
    mixed = u.T @ weak  # step 1
    with_tip, alone = mixed[:moving], mixed[moving:]
    if len(alone):  # step 2
        basis = np.linalg.qr(alone[:, :6].T)[0]
        with_tip[:, :6] -= with_tip[:, :6] @ basis @ basis.T
    # Step 3.
    if moving == 3 and np.abs(with_tip[:, 9]).max() < NO_PART:
        with_tip = np.linalg.solve(with_tip[:, 6:9], with_tip)
    centre = solution.centre
    together = [_together(motion, centre) for motion in with_tip]  # step 4
    twists = tidied(at_base_origin(alone[:, :6], centre)) if len(alone) else alone[:, :6]
    return (*together, *(in_words(fixture, solution.solution, twist, "", solution.contacts.spread) for twist in twists))


def _together(motion: Floats, centre: Floats) -> FreeMotion:
    """The free motion of a motion (10,) about the contacts' centre that moves the tip or changes its radius."""
    tip, radius = motion[6:9], float(motion[9])
    size = float(np.linalg.norm(tip))
    if size < NO_PART:
        motion = motion / np.sign(radius)
        words = "the tip's radius and the fixture change together; touch from an opposite side, or a ball or a pin"
        return _free_motion(motion, centre, words)
    motion = motion / size
    along = vector(motion[6:9])
    if np.abs(motion[:6]).max() < NO_PART:
        words = f"the tip is not determined along {along} of the flange frame; turn the tool about another axis"
    else:
        base = vector(motion[3:6])
        words = f"tip and fixture move together along {along} of the flange frame, {base} in base"
        words += "; turn the tool about another axis"
    return _free_motion(motion, centre, words)


def _free_motion(motion: Floats, centre: Floats, words: str) -> FreeMotion:
    twist = at_base_origin(motion[None, :6], centre)[0]
    return FreeMotion(twist[:3], twist[3:], words)


def turned_contact(fixture: Fixture, weakest: TipSolution) -> NextContact | None:
    """The next contact if a motion is free; with another tool orientation if a motion of the tip is.

    In the fixture frame only, since the pose is not known.
    """
    found = missing_contact(fixture, weakest.contacts, weakest.solution)
    if found is None or weakest.tip_is_known:
        return found
    point, approach = found.point_in_fixture, found.approach_in_fixture
    assert point is not None
    touch = touch_in_words(found.feature, point, approach, None, float(weakest.contacts.sigmas.min()))
    # A contact in an orientation that was used already adds nothing about the tip.
    words = f"{touch.message}, with the tool turned about another axis than so far, the farther the better"
    return replace(touch, message=words)


def suspects(
    contacts: Contacts,
    sigmas: Floats,
    unknown: frozenset[Unknown],
    fixture: Fixture,
    nearest: TipSolution,
) -> tuple[Diagnosis, ...]:
    """The contacts whose deletion lets pose and tip explain the others; empty if there is none.

    nearest: the best solution of all; each fit without one contact starts there, on its shape of the fixture.
    sigmas (n,) of the residuals.
    """
    found = []
    pose, radius = nearest.solution.base_from_fixture, nearest.contacts.tip_radius
    surfaces = {name: moved(inverse(pose), surface) for name, surface in nearest.solution.surfaces.items()}
    for i in _most_suspicious(TipEquations.build(surfaces, contacts, sigmas, unknown, fixture.placement), nearest):
        rest = np.delete(np.arange(len(contacts)), i)
        equations = TipEquations.build(surfaces, contacts.subset(rest), sigmas[rest], unknown, fixture.placement)
        dof = len(equations) - len(equations.columns)
        trials, cost = descend(equations, equations.trials(pose[None], nearest.tip[None], radius))
        if dof > 0 and cost[0] <= chi_square_limit(dof):
            there = equations.poses(trials)[0]
            change, tip = equations.length * trials.tips[0], float(equations.length * trials.radii[0])
            in_base = {name: moved(there, surface) for name, surface in surfaces.items()}
            off = contact_residuals(in_base, contacts.subset([i]).with_tip(change, tip))[0]
            found.append(_outlier(contacts, i, float(off[0]), float(cost[0])))
    found.sort(key=lambda cause: cause.chi2 or 0.0)
    alike = [cause for cause in found if (cause.chi2 or 0.0) <= (found[0].chi2 or 0.0) + INDISTINCT]
    return (one_of(alike[:SUSPECTS_LISTED]), *found[len(alike) : SUSPECTS_LISTED]) if found else ()


def _most_suspicious(equations: TipEquations, nearest: TipSolution) -> list[int]:
    """The contacts to delete, in order: of many those whose deletion lowers chi-square most, in the linear model.

    Deletion of a residual r with leverage h lowers it by r^2 / (1 - h) (Cook).
    """
    pose, radius = nearest.solution.base_from_fixture, nearest.contacts.tip_radius
    residuals, jacobian = (
        part[0] for part in equations.evaluate(equations.trials(pose[None], nearest.tip[None], radius))
    )
    motions, values, _ = np.linalg.svd(jacobian, full_matrices=False)
    leverage = (motions[:, values > SMALLEST_RATIO * values[0]] ** 2).sum(axis=1)
    rows = len(equations.of)
    drops = np.bincount(equations.of, (residuals**2 / np.maximum(1 - leverage, SMALLEST_RATIO))[:rows])
    return sorted(np.argsort(-drops, kind="stable")[:MOST_DELETED].tolist())


def _outlier(contacts: Contacts, i: int, off: float, chi2: float) -> Diagnosis:
    return Diagnosis("outlier", (contacts.rows[i],), (contacts.features[i],), off, chi2, without_message(contacts, i))
