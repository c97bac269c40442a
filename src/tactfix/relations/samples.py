"""Solutions from many random placements, for features that can be located neither alone nor as one rigid body.

1. A feature that is located alone starts at one of its candidates, every other feature at random.
2. Damped least squares follow all placements side by side (`placements`), on a part of the contacts if there are many;
   indistinct ends are merged.
3. Joint fits start at the ends, those first that the approaches allow.
4. If contacts and relations leave no motion free, the fits are the solutions. They are complete if every end was met
   OFTEN_MET times, else partial: if all are rejected, another may be right.
5. Otherwise they are samples of a continuum; or, if none explains the contacts and no motion is free, the best is the
   nearest miss: of all ends, or partial.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import islice, product
from math import prod
from random import Random

import numpy as np

from tactfix.contacts import Contacts
from tactfix.feature import Feature
from tactfix.fixture import Fixture
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
"""Placements that are followed side by side. A slab with few contacts on its hole has eight solutions, of which 16
starts met two."""
PLACED_CONTACTS = 200
"""Contacts of each feature that placements see: ends are starts of fits, which see all contacts. More would say no more
of where a minimum lies, and a placement fills a row of numbers for each."""
START_COMBINATIONS = 64
"""Combinations of the candidates of features located alone at which placements start in turn: half of SAMPLE_STARTS, so
that each is used at least twice with other random places of the rest. With more the result is not complete."""
FREE_SAMPLES = 8
"""Configurations that are shown of a continuum: a choice of the report, as `localization.locate.SAMPLES_SHOWN`."""
FITTED_ENDS = 12
"""Distinct ends of placements that are fitted, those first that the approaches allow, then the best: half as many
again as the eight solutions of a slab with few contacts on its hole. They are a bound on time, not on what there is:
three contacts on each of three bars at angles leave up to 40 ends. With more ends the result is not complete."""
END_LIMIT = 2.0
"""Times the limit of chi-square up to which the end of a placement may explain the contacts. Relations count with at
least LEAST_RELATION_SIGMA and the steps are limited, so that an end is near a solution, not at it."""
ONE_END = 10.0
"""Distance in sigma, over all contacts, up to which two ends are one: ends are not converged. Distinct solutions are
more than `unresolved.BRANCHES`, two sigma, apart; nearer ends lead to one joint fit anyway, or to two that are
merged."""
OFTEN_MET = 4
"""Placements that must have led to each solution for all to count as found: a solution that is met 4 times on
average is missed with probability e^-4, once in 50 times."""


def sampled_solutions(
    fixture: Fixture, problem: JointProblem, alone: Mapping[str, Sequence[FeatureCandidate]]
) -> Solutions:
    """The solutions that placements lead to; marked as a continuum if a motion is free in all of them.

    alone: the candidates of the features that their own contacts locate.
    """
    starts = _starts(fixture, problem, alone)  # step 1
    few = _thinned(problem)
    ends = _distinct_ends(few, *settled(fixture, few, starts))  # step 2
    ends.sort(key=lambda end: _comes_out(problem.contacts, end[0]))
    fits: list[JointFit] = []
    for surfaces, _ in ends[:FITTED_ENDS]:  # step 3
        fits.append(branch_fit(problem, nearest_start(problem, surfaces)))
        if len(fits) >= FREE_SAMPLES and not any(_is_isolated(fit) for fit in fits) and not _are_misses(fits):
            break
    isolated = [fit for fit in fits if _is_isolated(fit)]
    if isolated:  # step 4
        are_started = prod(len(candidates) for candidates in alone.values()) <= START_COMBINATIONS
        complete = are_started and len(ends) <= FITTED_ENDS and all(count >= OFTEN_MET for _, count in ends)
        return replace(joint_solutions(fixture, problem, isolated), complete=complete, partial=not complete)
    best = _kept(fits)[:FREE_SAMPLES]  # step 5
    if _are_misses(fits):
        return replace(joint_solutions(fixture, problem, best[:1]), complete=False, partial=len(fits) < len(ends))
    return joint_solutions(fixture, problem, best, continuum=True)


def _thinned(problem: JointProblem) -> JointProblem:
    """The problem with at most PLACED_CONTACTS on each feature, drawn at random: rows of a scan may lie in a line."""
    rng, kept = Random(20261129), list[int]()
    for index in problem.contacts.by_feature.values():
        kept += index[rng.sample(range(len(index)), min(PLACED_CONTACTS, len(index)))].tolist()
    if len(kept) == len(problem.contacts):
        return problem
    kept.sort()
    return replace(problem, contacts=problem.contacts.subset(kept), sigmas=problem.sigmas[kept])


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
    """The feature in a random direction, near its contacts, or anywhere in the fixture if it has none."""
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
    """Distinct ends, best first, and the number of placements that led to each; a few if none is within the limit."""
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
    """Whether the probe came out of the material at some contact."""
    _, normals = contact_residuals(surfaces, contacts)
    return bool((np.einsum("ij,ij->i", contacts.approaches, normals) > 0).any())


def _is_isolated(fit: JointFit) -> bool:
    """Whether a fit explains the contacts and leaves no motion free."""
    if fit.missing >= RELATIONS_HOLD or fit.dof < 0 or fit.chi2 > chi_square_limit(fit.dof):
        return False
    return not len(fit.spread()[1])


def _kept(fits: Sequence[JointFit]) -> list[JointFit]:
    """The fits that keep the relations, best first; one that has not converged onto them tells nothing."""
    return sorted((fit for fit in fits if fit.missing < RELATIONS_HOLD), key=lambda fit: fit.chi2)


def _are_misses(fits: Sequence[JointFit]) -> bool:
    """Whether fits that keep the relations do not explain the contacts, and none leaves a motion free that might."""
    kept = _kept(fits)
    return bool(kept) and all(
        fit.dof >= 0 and fit.chi2 > chi_square_limit(fit.dof) and not len(fit.spread()[1]) for fit in kept
    )
