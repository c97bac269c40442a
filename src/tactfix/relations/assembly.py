"""Solutions for a fixture by relations, the paper's way: feature by feature, then everything at once.

Each feature is located from its own contacts; a sphere with too few of them from its known distances to features that
already are (eqs. 48-51). Every combination of candidates is a start for the joint least squares over all contacts and
relations (`joint`), and those whose chi-square stays within its limit are solutions, once per choice of axis signs that
the frame recipe leaves open. Where that way does not reach a feature, or knows one so badly that others may be lost
beside it, but the relations make the fixture rigid, its shapes (`realization`) are searched as rigid bodies instead.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture, FrameRecipe, Relation
from tactfix.frame import FrameError, frame, frames, recipe_of, sign_choices
from tactfix.geometry.arrays import Floats
from tactfix.geometry.charts import displaced
from tactfix.geometry.nearest import foot
from tactfix.geometry.sameness import same_surface
from tactfix.geometry.surfaces import Point, Sphere, Surface
from tactfix.noise import chi_square_limit
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.sigma_points import motions_between
from tactfix.poses.solution import Solution, Solutions, solution_from
from tactfix.relations.combinations import combinations
from tactfix.relations.equations import relation_residuals
from tactfix.relations.joint import JointFit, JointProblem, joint_fit
from tactfix.relations.joint_sigma_points import JointSpread
from tactfix.relations.realization import fixture_scale, random_surface, realize
from tactfix.results import Candidate, Reason

FEW_COMBINATIONS = 64
"""Beyond so many combinations a rigid fixture is searched as one body, which costs the same however many there are."""
MOST_COMBINATIONS = 4096
MOST_FALLEN = 32
"""Combinations that fell because of a relation and are listed."""
LOOSE = 3.0
"""Times the slack of the relations, added to the contacts' sigma while a fixture is searched as if it were rigid."""
UNSEEN = 0.05
"""Surfaces nearer to each other than this share of sigma are one: where axes are only almost parallel, their spacing
depends a little on where it is taken, and so does the fit on where it started."""
SAMPLES = 8
"""Configurations that show what contacts and relations leave free."""
KEPT = 1e-9
"""Share of the fixture's size to which exact relations must hold in the end."""
DIFFERENCE = 1e-7
"""Step of the differences of the frame (rad, and fixture sizes): their error is of this size, rounding far below."""


def assembled_solutions(fixture: Fixture, contacts: Contacts, sigmas: Floats, with_misses: bool = True) -> Solutions:
    """Every pose of a fixture by relations that explains contacts and relations; sigmas (n,) of the residuals.

    Where none does, the best one alone, its chi2 above the limit. Where contacts and relations leave something free,
    samples, marked as a continuum. Without with_misses neither the one nor the others.
    """
    problem = JointProblem(contacts, sigmas, fixture.relations, fixture_scale(fixture))
    located = combinations(fixture, contacts, sigmas, MOST_COMBINATIONS + 1)
    if located is None or ((located.weak or len(located.surfaces) > FEW_COMBINATIONS) and realize(fixture)):
        return _unlocated(fixture, contacts, sigmas, problem, with_misses)
    starts = [_anchored(surfaces, contacts) for surfaces in located.surfaces[:MOST_COMBINATIONS]]
    fits = [joint_fit(problem, surfaces) for surfaces in starts]
    solutions = _solutions(fixture, problem, _distinct(fits, problem), continuum=False)
    return replace(
        solutions,
        complete=len(located.surfaces) <= MOST_COMBINATIONS,
        fallen=tuple(_fallen(fixture, problem, starts, fits, solutions)),
    )


def _fallen(
    fixture: Fixture,
    problem: JointProblem,
    starts: Sequence[Mapping[str, Surface]],
    fits: Sequence[JointFit],
    solutions: Solutions,
) -> Iterator[Candidate]:
    """Combinations of surfaces that explain the contacts of each feature, but not the relations between them."""
    broken = [(s, f) for s, f in zip(starts, fits, strict=True) if f.chi2 > solutions.limit]
    for surfaces, fit in broken[:MOST_FALLEN] if len(broken) < len(starts) else []:
        values, _ = contact_residuals(surfaces, problem.contacts)
        try:
            pose = frames(recipe_of(fixture), surfaces)[0]
        except FrameError:
            continue
        rms = float(np.sqrt((values**2).mean()))
        yield Candidate(pose, surfaces, fit.chi2, rms, (_broken_relation(fixture, problem, surfaces),))


def _broken_relation(fixture: Fixture, problem: JointProblem, surfaces: Mapping[str, Surface]) -> Reason:
    """The relation that the surfaces break worst, in words."""

    def missing(relation: Relation) -> float:
        one, other = relation.between
        size = problem.scale if relation.kind == "distance" else 1.0
        return float(np.abs(relation_residuals(relation, surfaces[one], surfaces[other])).max(initial=0.0)) / size

    worst = max(fixture.relations, key=missing)
    one, other = worst.between
    off = missing(worst) * (problem.scale if worst.kind == "distance" else 180 / np.pi)
    unit = fixture.units if worst.kind == "distance" else "deg"
    message = f"the {worst.kind} between {one} and {other} would be {off:.4g} {unit} off"
    return Reason("relation", other, None, message)


def _anchored(surfaces: Mapping[str, Surface], contacts: Contacts) -> dict[str, Surface]:
    """The surfaces with their given points next to their contacts, so that tilts and shifts are independent."""
    return {
        name: _anchor(s, contacts.points[contacts.by_feature[name]] if name in contacts.by_feature else contacts.points)
        for name, s in surfaces.items()
    }


def _anchor(surface: Surface, points: Floats) -> Surface:
    return (
        surface if isinstance(surface, Sphere | Point) else replace(surface, point=foot(surface, points.mean(axis=0)))
    )


def _distinct(fits: Sequence[JointFit], problem: JointProblem) -> list[JointFit]:
    """Best first, those with the same surfaces once."""
    kept: list[JointFit] = []
    for fit in sorted(fits, key=lambda fit: fit.chi2 + (0.0 if fit.missing < KEPT else np.inf)):
        if fit.missing < KEPT and not any(_alike(fit, other, problem) for other in kept):
            kept.append(fit)
    return kept


def _alike(one: JointFit, other: JointFit, problem: JointProblem) -> bool:
    """Whether two fits have the same surfaces, but for what neither rounding nor noise lets anyone see."""
    length = max(1e-7 * problem.scale, UNSEEN * float(problem.sigmas.min()))
    return all(same_surface(s, other.surfaces[n], length, length / problem.scale) for n, s in one.surfaces.items())


def _unlocated(
    fixture: Fixture, contacts: Contacts, sigmas: Floats, problem: JointProblem, with_misses: bool
) -> Solutions:
    """The rigid shapes where the relations fix one, and otherwise samples of what is free."""
    from tactfix.poses.rigid import rigid_solutions  # most fixtures by relations go without

    shapes = realize(fixture)
    if not shapes:
        return _samples(fixture, contacts, problem, SAMPLES if with_misses else 0)
    loose = np.hypot(sigmas, LOOSE * _slack(fixture, problem.scale))
    parts = [rigid_solutions(shape, contacts, loose, with_misses) for shape in shapes]
    if all(r.sigma == 0 for r in fixture.relations) or any(part.continuum or part.dof < 0 for part in parts):
        return _merged(parts)
    fits = [joint_fit(problem, _anchored(solution.surfaces, contacts)) for part in parts for solution in part.found]
    return _solutions(fixture, problem, _distinct(fits, problem), continuum=False)


def _slack(fixture: Fixture, scale: float) -> float:
    """How far (length) the relations let the features be from where their values put them, one standard deviation."""
    return float(np.linalg.norm([r.sigma * (1.0 if r.kind == "distance" else scale) for r in fixture.relations]))


def _merged(parts: Sequence[Solutions]) -> Solutions:
    """The solutions of all shapes as one, best first; of those above the limit only the best."""
    found = sorted((s for part in parts for s in part.found), key=lambda s: s.chi2)
    kept = [s for s in found if s.chi2 <= parts[0].limit] or found[:1]
    distinct: list[Solution] = []
    for solution in kept:
        if not any(
            np.abs(solution.base_from_fixture - o.base_from_fixture).max() < 1e-9 and _same_places(solution, o)
            for o in distinct
        ):
            distinct.append(solution)
    return Solutions(
        tuple(distinct), parts[0].dof, parts[0].limit, all(p.complete for p in parts), any(p.continuum for p in parts)
    )


def _same_places(one: Solution, other: Solution) -> bool:
    return all(same_surface(s, other.surfaces[n], 1e-9, 1e-9) for n, s in one.surfaces.items())


def _samples(fixture: Fixture, contacts: Contacts, problem: JointProblem, most: int) -> Solutions:
    """At most so many configurations that contacts and relations allow, from three times as many random starts."""
    rng = np.random.default_rng(20261122)
    starts = [
        {n: _moved_to(random_surface(f, problem.scale, rng), contacts.centre) for n, f in fixture.features.items()}
        for _ in range(3 * most)
    ]
    fits = _distinct([joint_fit(problem, start) for start in starts], problem)
    return _solutions(fixture, problem, fits[:most], continuum=True)


def _moved_to(surface: Surface, middle: Floats) -> Surface:
    if isinstance(surface, Sphere):
        return replace(surface, center=surface.center + middle)
    return replace(surface, point=surface.point + middle)


def _solutions(fixture: Fixture, problem: JointProblem, fits: Sequence[JointFit], continuum: bool) -> Solutions:
    """The frames of each fit that is within its limit; of the best one where none is.

    Raises FrameError where the recipe gives a frame for none of those that explain the contacts.
    """
    dof = fits[0].dof if fits else fixture.equations(problem.contacts.features) - 6
    limit = chi_square_limit(dof)
    explaining = [fit for fit in fits if fit.chi2 <= limit]
    found: list[Solution] = []
    refusal: FrameError | None = None
    for fit in explaining or fits[:1]:
        try:
            found += _framed(fixture, problem, fit)
        except FrameError as error:
            refusal = error
    if refusal is not None and explaining and not found and not continuum:
        raise refusal
    return Solutions(tuple(found), dof, limit, complete=True, continuum=continuum)


def _framed(fixture: Fixture, problem: JointProblem, fit: JointFit) -> list[Solution]:
    """One solution per frame that the recipe allows; turning an axis round turns the frame, not how it moves."""
    pose, *others = frames(recipe_of(fixture), fit.surfaces)
    values, normals = contact_residuals(fit.surfaces, problem.contacts)
    spread = JointSpread(problem, recipe_of(fixture), fit, _frame_jacobian(recipe_of(fixture), fit)).at(pose)
    solution = solution_from(pose, fit.surfaces, problem.contacts, values, normals, fit.chi2, spread)
    return [solution, *(replace(solution, base_from_fixture=other) for other in others)]


def _frame_jacobian(recipe: FrameRecipe, fit: JointFit) -> Floats:
    """How the frame moves (6, width), rotation and origin, with each displacement, by differences."""
    steps = DIFFERENCE * np.diag(fit.lengths)
    steps = np.vstack([np.zeros(len(steps)), steps])
    moved = {name: displaced(surface, steps[:, fit.columns[name]]) for name, surface in fit.surfaces.items()}
    still, *others = frame(recipe, moved, sign_choices(recipe, fit.surfaces)[0])
    return motions_between(still, np.array(others)) / DIFFERENCE
