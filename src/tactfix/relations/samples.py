"""Where features can be located neither alone nor as one rigid body: fits from where many placements lead.

1. Features that are located alone begin at one of the places they may have, all others at random.
2. Damped least squares follow all placements side by side (`placements`); ends that are alike count as one.
3. Joint fits start at the ends, at those first that the approaches allow.
4. Where contacts and relations leave nothing free, these are the solutions: all there are, if each was met OFTEN_MET.
5. Else they are samples of what is free.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice, product
from math import prod
from random import Random

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Feature, Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Sphere, Surface
from tactfix.noise import chi_square_limit
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.solution import Solutions
from tactfix.relations.branch_fits import branch_fit, nearest_start
from tactfix.relations.features_alone import FeatureCandidate
from tactfix.relations.joint_problem import JointFit, JointProblem
from tactfix.relations.joint_solutions import RELATIONS_HOLD, joint_solutions
from tactfix.relations.placements import settled
from tactfix.relations.realization import random_surface
from tactfix.relations.unresolved import seen_difference

SAMPLE_STARTS = 128
"""Placements that are followed side by side: a slab with few contacts on its hole has eight solutions, of which sixteen
starts met two."""
START_COMBINATIONS = 64
"""Combinations of places of the features located alone, that the placements begin at in turn."""
FREE_SAMPLES = 8
"""Configurations that show what contacts and relations leave free."""
FITTED_ENDS = 12
"""Ends of placements that differ and are fitted: those first that the approaches allow, and of these the best."""
END_LIMIT = 2.0
"""Times the limit of chi-square that is left where a placement that explains the contacts ends: a few steps from it."""
ONE_END = 10.0
"""Sigmas, in all, within which two placements have ended at one solution."""
OFTEN_MET = 4
"""Placements that must have led to each solution for all of them to count as found: one as rare as the rarest is then
missed once in fifty times."""


def sampled_solutions(
    fixture: Fixture, problem: JointProblem, alone: Mapping[str, Sequence[FeatureCandidate]]
) -> Solutions:
    """The least chi-squares where placements lead; marked as a continuum unless all motions are held.

    alone: the features that their own contacts locate, and where.
    """
    starts = _starts(fixture, problem, alone)  # step 1
    ends = _distinct_ends(problem, *settled(fixture, problem, starts))  # step 2
    ends.sort(key=lambda end: _comes_out(problem.contacts, end[0]))
    fits: list[JointFit] = []
    for surfaces, _ in ends[:FITTED_ENDS]:  # step 3
        fits.append(branch_fit(problem, nearest_start(problem, surfaces)))
        if len(fits) >= FREE_SAMPLES and not any(_is_held(fit) for fit in fits):
            break
    held = [fit for fit in fits if _is_held(fit)]
    if held:  # step 4
        are_started = prod(len(candidates) for candidates in alone.values()) <= START_COMBINATIONS
        complete = are_started and len(ends) <= FITTED_ENDS and all(count >= OFTEN_MET for _, count in ends)
        return replace(joint_solutions(fixture, problem, held), complete=complete)
    best = sorted(fits, key=lambda fit: fit.chi2)[:FREE_SAMPLES]  # step 5
    return joint_solutions(fixture, problem, best, continuum=True)


def _starts(
    fixture: Fixture, problem: JointProblem, alone: Mapping[str, Sequence[FeatureCandidate]]
) -> list[dict[str, Surface]]:
    rng, contacts = Random(20261122), problem.contacts
    combinations = list(islice(product(*alone.values()), START_COMBINATIONS)) or [()]
    starts = []
    for number in range(SAMPLE_STARTS):
        chosen = combinations[number % len(combinations)]
        known = {name: candidate.surface for name, candidate in zip(alone, chosen, strict=False)}
        starts.append(
            {
                name: known[name] if name in known else _anywhere(feature, contacts, problem.scale, rng)
                for name, feature in fixture.features.items()
            }
        )
    return starts


def _anywhere(feature: Feature, contacts: Contacts, scale: float, rng: Random) -> Surface:
    """The feature in any direction, somewhere at its contacts, or anywhere in the fixture where it has none."""
    index = contacts.by_feature.get(feature.name)
    near = scale if index is None else feature.radius or scale
    middle = contacts.centre if index is None else contacts.points[index].mean(axis=0)
    return _shifted(random_surface(feature, near, rng), middle)


def _shifted(surface: Surface, shift: Floats) -> Surface:
    if isinstance(surface, Sphere):
        return replace(surface, center=surface.center + shift)
    return replace(surface, point=surface.point + shift)


def _distinct_ends(
    problem: JointProblem, ends: Sequence[Mapping[str, Surface]], chi2: Floats
) -> list[tuple[Mapping[str, Surface], int]]:
    """Ends that differ, best first, and how many placements led to each; a few where none is within the limit."""
    order = np.argsort(chi2, kind="stable").tolist()
    explaining = [n for n in order if chi2[n] <= END_LIMIT * chi_square_limit(len(problem.contacts))]
    found: list[tuple[Mapping[str, Surface], int]] = []
    for number in explaining or order[:FREE_SAMPLES]:
        for k, (surfaces, count) in enumerate(found):
            if seen_difference(surfaces, ends[number], problem.contacts, problem.sigmas, problem.scale) < ONE_END:
                found[k] = surfaces, count + 1
                break
        else:
            found.append((ends[number], 1))
    return found


def _comes_out(contacts: Contacts, surfaces: Mapping[str, Surface]) -> bool:
    """Whether the probe would have come out of the material at some contact."""
    _, normals = contact_residuals(surfaces, contacts)
    return bool((np.einsum("ij,ij->i", contacts.approaches, normals) > 0).any())


def _is_held(fit: JointFit) -> bool:
    """Whether a fit explains the contacts and nothing moves on it."""
    if fit.missing >= RELATIONS_HOLD or fit.dof < 0 or fit.chi2 > chi_square_limit(fit.dof):
        return False
    return not len(fit.spread()[1])
