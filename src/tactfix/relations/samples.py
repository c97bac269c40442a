"""Solutions from many random placements, for features that can be located neither alone nor as one rigid body.

1. A feature that is located alone starts at one of its candidates, every other feature at random. Random numbers are
   drawn in the principal axes of the contacts, so that the result does not depend on the axes of base.
   Combinations of candidates that violate the relations among themselves are left out.
2. Damped least squares follow SAMPLE_STARTS placements side by side (`placements`), on a part of the contacts if there
   are many; indistinct ends are merged.
3. Joint fits start at the ends, those first that the approaches allow, one on each branch that is near: an end may
   stand for two solutions on either side of a fold.
4. Steps 1 to 3 are repeated with new placements until OFTEN_MET of them have led to each solution, at most
   SAMPLE_ROUNDS times, and not if contacts and relations leave a motion free.
5. If some fit leaves none free, all that explain the contacts are the solutions: at a fold rounding decides whether a
   motion is free. They are complete if each was met OFTEN_MET times; else partial, and if all are rejected, the right
   one may have been missed.
6. Otherwise they are samples of a continuum; or, if none explains the contacts and no motion is free, the best is the
   nearest miss, complete or partial as in step 5.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import cycle, islice, product
from math import prod
from random import Random

import numpy as np

from tactfix.contacts import Contacts
from tactfix.feature import Feature
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats, cross
from tactfix.geometry.rigid import homogeneous
from tactfix.geometry.surfaces import Surface, moved
from tactfix.noise import chi_square_limit
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.solution import Solutions
from tactfix.relations.branch_fits import branch_fit, near_starts
from tactfix.relations.branches import COSTLY, least_cost
from tactfix.relations.features_alone import FeatureCandidate
from tactfix.relations.joint_problem import JointFit, JointProblem
from tactfix.relations.joint_solutions import RELATIONS_HOLD, grouped, joint_solutions
from tactfix.relations.placements import settled
from tactfix.relations.realization import random_surface
from tactfix.relations.unresolved import are_one

SAMPLE_STARTS = 128
"""Placements that are followed side by side. A slab with few contacts on its hole has eight solutions, two of which
were found from 16 starts."""
SAMPLE_ROUNDS = 4
"""Rounds of SAMPLE_STARTS placements at most: they bound the time, a tenth of a second each with 15 contacts. One in a
hundred placements reaches a solution of five features with three contacts each."""
PLACED_CONTACTS = 200
"""Contacts of each feature that placements see: ends are starts of fits, which see all contacts. More would not
locate a minimum better, and each adds a column to the arrays of all placements."""
START_COMBINATIONS = 64
"""Combinations of the candidates of features located alone at which placements start in turn: half of SAMPLE_STARTS, so
that each is used at least twice with different random places of the others. With more the result is not complete."""
FREE_SAMPLES = 8
"""Configurations that are shown of a continuum: a choice of the report, as `localization.locate.SAMPLES_SHOWN`."""
MOST_FITS = 24
"""Joint fits in each round at most, of those ends first that the approaches allow, then of the best. They bound the
time, not the number of ends: one round fits 24 ends of planes, or 6 of three bars near 90 deg, which have four branches
each. If ends remain, the result is not complete. With 48, three bars with three contacts take 2.3 s instead of 1.1."""
MOST_FITS_IN_ALL = 2 * MOST_FITS
"""Number of joint fits after which there are no more rounds."""
END_LIMIT = 2.0
"""Times the limit of chi-square up to which the end of a placement may explain the contacts. Relations have at least
the sigma of LEAST_RELATION_SIGMA and the steps are limited, so that an end is near a solution, not at it."""
OFTEN_MET = 4
"""Placements that must have led to each solution for the list to count as complete: a solution that is met 4 times on
average is missed with probability e^-4, once in 50 times."""


@dataclass(slots=True)
class End:
    """A distinct end of placements: its surfaces, chi-square there, the placements that led to it, its joint fits.

    fits: one for each branch near the surfaces; empty before they are made. left_out: the least cost of other branches.
    """

    surfaces: Mapping[str, Surface]
    chi2: float
    count: int = 1
    fits: tuple[JointFit, ...] = ()
    left_out: float = np.inf


def sampled_solutions(
    fixture: Fixture, problem: JointProblem, alone: Mapping[str, Sequence[FeatureCandidate]]
) -> Solutions:
    """The solutions that placements lead to; marked as a continuum if a motion is free in all of them.

    alone: the candidates of the features that their own contacts locate.
    """
    few, ends = _thinned(problem), list[End]()
    placements = _placements(fixture, problem, alone)  # step 1
    for _ in range(SAMPLE_ROUNDS):  # step 4
        ends = _with_ends(few, ends, *settled(fixture, few, list(islice(placements, SAMPLE_STARTS))))  # step 2
        _fit(problem, ends)  # step 3
        fits = [fit for end in ends for fit in end.fits]
        explaining = [fit for fit in fits if _explains(fit)]
        are_isolated = any(_is_isolated(fit) for fit in explaining)
        is_continuum = not (are_isolated or _are_misses(fits))
        if is_continuum or len(fits) >= MOST_FITS_IN_ALL or _all_met_often(problem, ends, explaining):
            break
    if are_isolated:  # step 5
        are_started = prod(len(candidates) for candidates in alone.values()) <= START_COMBINATIONS
        complete = are_started and _all_met_often(problem, ends, explaining)
        # Partial solutions are never reported as located, so that no covariance is needed.
        solutions = joint_solutions(fixture, problem, explaining, curved=complete)
        return replace(solutions, complete=complete, partial=not complete)
    best = _kept(fits)[:FREE_SAMPLES]  # step 6
    if _are_misses(fits):
        return replace(joint_solutions(fixture, problem, best[:1]), complete=False, partial=len(fits) < len(ends))
    return joint_solutions(fixture, problem, best, continuum=True)


def _fit(problem: JointProblem, ends: Sequence[End]) -> None:
    """At most MOST_FITS more joint fits, of ends without any; of a continuum only the samples shown are fitted."""
    fits = [fit for end in ends for fit in end.fits]
    new = [end for end in ends if not end.fits]
    new.sort(key=lambda end: (_comes_out(problem.contacts, end.surfaces), end.chi2))
    most = len(fits) + MOST_FITS
    for end in new:
        if len(fits) >= most:
            break
        if len(fits) >= FREE_SAMPLES and not any(_is_isolated(fit) for fit in fits) and not _are_misses(fits):
            break
        starts = near_starts(problem, end.surfaces)
        end.fits, end.left_out = tuple(branch_fit(problem, start) for start in starts.followed), starts.left_out
        fits += end.fits


def _all_met_often(problem: JointProblem, ends: Sequence[End], explaining: Sequence[JointFit]) -> bool:
    """Whether every end was fitted on every branch, and OFTEN_MET placements have led to each solution."""
    counts = {id(fit): end.count for end in ends for fit in end.fits}
    groups = grouped(explaining, problem)
    return (
        bool(groups)
        and all(end.fits and end.left_out > chi_square_limit(len(problem.contacts)) for end in ends)
        and all(sum(counts[id(fit)] for fit in (group.best, *group.others)) >= OFTEN_MET for group in groups)
    )


def _thinned(problem: JointProblem) -> JointProblem:
    """The problem with at most PLACED_CONTACTS on each feature, drawn at random: rows of a scan may lie in a line."""
    rng, kept = Random(20261129), list[int]()
    for index in problem.contacts.by_feature.values():
        kept += index[rng.sample(range(len(index)), min(PLACED_CONTACTS, len(index)))].tolist()
    if len(kept) == len(problem.contacts):
        return problem
    kept.sort()
    return replace(problem, contacts=problem.contacts.subset(kept), sigmas=problem.sigmas[kept])


def _placements(
    fixture: Fixture, problem: JointProblem, alone: Mapping[str, Sequence[FeatureCandidate]]
) -> Iterator[dict[str, Surface]]:
    """An endless iterator of placements, each combination of the candidates of located features in turn."""
    rng, axes = Random(20261122), _principal_axes(problem.contacts)
    for known in cycle(_start_combinations(problem, alone)):
        yield {
            name: known[name] if name in known else _anywhere(feature, problem.contacts, problem.scale, rng, axes)
            for name, feature in fixture.features.items()
        }


def _start_combinations(
    problem: JointProblem, alone: Mapping[str, Sequence[FeatureCandidate]]
) -> list[dict[str, Surface]]:
    """The combinations of candidates that keep the relations among them; all if none does."""
    choices = islice(product(*alone.values()), START_COMBINATIONS)
    every = [{n: c.surface for n, c in zip(alone, choice, strict=True)} for choice in choices] or [{}]
    among = tuple(relation for relation in problem.relations if set(relation.between) <= set(alone))
    if not among or len(every) == 1:
        return every
    index = np.flatnonzero([name in alone for name in problem.contacts.features])
    contacts, sigmas = problem.contacts.subset(index.tolist()), problem.sigmas[index]
    own = replace(problem, contacts=contacts, sigmas=sigmas, relations=among)
    limit = COSTLY * chi_square_limit(len(problem.contacts))
    return [surfaces for surfaces in every if least_cost(own, surfaces) <= limit] or every


def _principal_axes(contacts: Contacts) -> Floats:
    """Right-handed principal axes (3, 3) of the contacts as columns, each with the sense of the third moment."""
    points = contacts.points - contacts.centre
    axes = np.linalg.svd(points.T @ points)[0]
    axes = axes * np.where(((points @ axes) ** 3).sum(axis=0) < 0, -1.0, 1.0)
    return np.column_stack([axes[:, 0], axes[:, 1], cross(axes[:, 0], axes[:, 1])])


def _anywhere(feature: Feature, contacts: Contacts, scale: float, rng: Random, axes: Floats) -> Surface:
    """The feature in a random direction, near its contacts, or anywhere in the fixture if it has none.

    axes (3, 3): columns of the frame in which it is drawn.
    """
    index = contacts.by_feature.get(feature.name)
    near = scale if index is None else feature.radius or scale
    middle = contacts.centre if index is None else contacts.points[index].mean(axis=0)
    return moved(homogeneous(axes, middle), random_surface(feature, near, rng))


def _with_ends(
    problem: JointProblem, known: Sequence[End], surfaces: Sequence[Mapping[str, Surface]], chi2: Floats
) -> list[End]:
    """The distinct ends with new ones among them, best first; a few if none is within the limit."""
    limit = END_LIMIT * chi_square_limit(len(problem.contacts))
    order = np.argsort(chi2, kind="stable").tolist()
    explaining = [number for number in order if chi2[number] <= limit]
    found = [end for end in known if end.chi2 <= limit]
    if not found and not explaining:
        found, explaining = list(known), order[: max(FREE_SAMPLES - len(known), 0)]
    for number in explaining:
        for end in found:
            if _are_one_end(problem, end.surfaces, surfaces[number]):
                end.count += 1
                break
        else:
            found.append(End(surfaces[number], float(chi2[number])))
    return sorted(found, key=lambda end: end.chi2)


def _are_one_end(problem: JointProblem, one: Mapping[str, Surface], other: Mapping[str, Surface]) -> bool:
    # A wider limit would merge two solutions into one. Ends that have not converged may be counted more than once,
    # but their joint fits are merged.
    return are_one(one, other, problem.contacts, problem.sigmas, problem.scale)


def _comes_out(contacts: Contacts, surfaces: Mapping[str, Surface]) -> bool:
    """Whether the probe came out of the material at some contact."""
    _, normals = contact_residuals(surfaces, contacts)
    return bool((np.einsum("ij,ij->i", contacts.approaches, normals) > 0).any())


def _explains(fit: JointFit) -> bool:
    """Whether a fit explains the contacts."""
    return fit.missing < RELATIONS_HOLD and fit.dof >= 0 and fit.chi2 <= chi_square_limit(fit.dof)


def _is_isolated(fit: JointFit) -> bool:
    """Whether a fit explains the contacts and leaves no motion free."""
    return _explains(fit) and not len(fit.spread()[1])


def _kept(fits: Sequence[JointFit]) -> list[JointFit]:
    """The fits that satisfy the relations, best first; the chi-square of others is meaningless."""
    return sorted((fit for fit in fits if fit.missing < RELATIONS_HOLD), key=lambda fit: fit.chi2)


def _are_misses(fits: Sequence[JointFit]) -> bool:
    """Whether the fits that satisfy the relations do not explain the contacts, and none leaves a motion free."""
    kept = _kept(fits)
    return bool(kept) and all(
        fit.dof >= 0 and fit.chi2 > chi_square_limit(fit.dof) and not len(fit.spread()[1]) for fit in kept
    )
