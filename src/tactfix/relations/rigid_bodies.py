"""Solutions for a fixture whose relations fix its shape: every pose of each possible rigid body.

1. A few bodies are searched one by one, each for all of its poses (`poses.rigid`).
2. Of many bodies each is covered by a few starts. If a pose was met less often than `poses.search.OFTEN`, all bodies
   are covered again, by as many starts as for a single body.
3. The bodies with a pose are searched for all of their poses, unless these bodies are too many.
4. The other bodies count as searched if every pose that was met, of any body, was met often: a pose as rare as the
   rarest of these is missed once in some four hundred problems. If the touched directions allow only a few
   rotations, starts are at these, and two meetings of each pose are enough (`poses.search.find_zeros_near`). If no
   pose was met, this is unknown.
5. Poses that the contacts do not distinguish are merged, and each is given in the frames that the recipe allows.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.fixture import Fixture
from tactfix.frame import frames, recipe_of
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Surface
from tactfix.placement import Placement
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.rigid import rigid_solutions
from tactfix.poses.robust_poses import robust_poses
from tactfix.poses.search_frame import SearchFrame
from tactfix.poses.sigma_points import motions_between
from tactfix.poses.solution import Solution, Solutions
from tactfix.relations.realization import FEW_BODIES, Body, fixture_scale, realize
from tactfix.relations.unresolved import are_one, weight

MOST_THOROUGH = 4
"""Bodies that are searched thoroughly at most, of those in which a covering of the rotations has met a pose: a thorough
search takes ten times as long. With poses of more bodies the contacts are ambiguous in any case, and the poses found
are marked as not complete."""
FEW_BODY_STARTS = 250
"""Starts that cover the rotations of each body, if there are many: of 1,000, 18 to 734 meet the true pose of three
bars, so that a quarter as many meet it at least four times."""
RANKING_STARTS = 60
"""Start rotations of the robust fit that ranks bodies by how many contacts agree, if no pose fits: a tenth of
`robust_poses.ROBUST_STARTS`, since only a diagnosis follows."""


def body_solutions(
    fixture: Fixture, searched: Sequence[Body], contacts: Contacts, sigmas: Floats, with_misses: bool
) -> Solutions:
    """Every pose of the bodies searched that explains the contacts; sigmas (n,) of the residuals.

    Of more than FEW_BODIES, the bodies in which a covering of the rotations meets a pose; complete if the others can
    have none. If there is none, the pose of least chi2 alone, above the limit; with_misses False: nothing.
    """
    # Limits hold for one frame, and a search covers the neighbourhood of one pose.
    limits = fixture.placement if all(len(shapes) == 1 for shapes in searched) else None
    parts, complete = _searched([shapes[0] for shapes in searched], contacts, sigmas, with_misses, limits)
    any_part = next(iter(parts.values()))
    dof, limit = any_part.dof, any_part.limit
    complete &= all(part.complete for part in parts.values())
    continuum = any(part.continuum for part in parts.values())
    found = sorted(((s, n) for n, part in parts.items() for s in part.found), key=lambda pair: pair[0].chi2)
    explaining = [pair for pair in found if pair[0].chi2 <= limit] or found[:1]
    if continuum or dof < 0:
        return Solutions(tuple(solution for solution, _ in explaining), dof, limit, complete, continuum)
    framed = [pose for s in _distinct(fixture, contacts, sigmas, explaining) for pose in _framed(fixture, s)]
    return Solutions(tuple(framed), dof, limit, complete, continuum)


def _searched(
    shapes: Sequence[Mapping[str, Surface]],
    contacts: Contacts,
    sigmas: Floats,
    with_misses: bool,
    limits: Placement | None,
) -> tuple[dict[int, Solutions], bool]:
    """The solutions of each searched shape, by its number, and whether the others have no pose."""
    chosen, complete = list(range(len(shapes))), True
    if len(shapes) > FEW_BODIES:
        quick, complete = _covered(shapes, contacts, sigmas)  # step 2
        chosen = [number for number, part in enumerate(quick) if part.found]
        if len(chosen) > MOST_THOROUGH:
            return {number: quick[number] for number in chosen}, False
        chosen = chosen or [_nearest(shapes, contacts, sigmas)]
    # Steps 1 and 3.
    parts = {number: rigid_solutions(shapes[number], contacts, sigmas, with_misses, limits) for number in chosen}
    return parts, complete


def _covered(
    shapes: Sequence[Mapping[str, Surface]], contacts: Contacts, sigmas: Floats
) -> tuple[list[Solutions], bool]:
    """The solutions of each shape from a covering of the rotations, and whether no pose is likely to be missed."""
    for most_starts in (FEW_BODY_STARTS, None):
        quick = [
            rigid_solutions(shape, contacts, sigmas, with_misses=False, thorough=False, most_starts=most_starts)
            for shape in shapes
        ]
        if any(part.found for part in quick) and all(part.complete for part in quick):
            return quick, True  # step 4
    return quick, False


def _nearest(shapes: Sequence[Mapping[str, Surface]], contacts: Contacts, sigmas: Floats) -> int:
    """The number of the shape at which some pose agrees with the most contacts."""

    def disagreement(shape: Mapping[str, Surface]) -> float:
        single = one_equation_each(shape, contacts, sigmas)
        frame, smallest = SearchFrame.of(single.surfaces, single.contacts), float(single.sigmas.min())
        equations = frame.equations(single.surfaces, single.contacts, smallest / single.sigmas)
        return float(robust_poses(equations, smallest / frame.length, 1, RANKING_STARTS).costs[0])

    return min(range(len(shapes)), key=lambda number: disagreement(shapes[number]))


def placed_solutions(fixture: Fixture, contacts: Contacts, sigmas: Floats, with_misses: bool) -> Solutions:
    """The same for a measured pose or constrained directions: each shape in each frame is a body of its own.

    Raises UsageError if the relations leave the shape free or have a sigma: then the fixture is not one rigid body.
    """
    shapes = realize(fixture)
    if not shapes or any(relation.sigma > 0 for relation in fixture.relations):
        raise UsageError(
            "a measured pose and free directions need a fixture of one shape; give its features their places, or "
            "relations without sigma that fix it, or use limits (within)"
        )
    parts = [rigid_solutions(shape, contacts, sigmas, with_misses, fixture.placement) for shape in shapes]
    found = sorted((s for part in parts for s in part.found), key=lambda s: s.chi2)
    dof, limit = parts[0].dof, parts[0].limit
    complete, continuum = all(part.complete for part in parts), any(part.continuum for part in parts)
    kept = tuple(s for s in found if s.chi2 <= limit) or tuple(found[:1])
    return Solutions(kept, dof, limit, complete, continuum)


def _distinct(
    fixture: Fixture, contacts: Contacts, sigmas: Floats, found: Sequence[tuple[Solution, int]]
) -> list[Solution]:
    """Best first, indistinct solutions merged; found: solutions, and the number of their body.

    Several poses of a symmetric body have the same surfaces.
    """
    scale = fixture_scale(fixture)
    kept: list[tuple[Solution, int]] = []
    for solution, body in found:
        for number, (other, other_body) in enumerate(kept):
            if are_one(other.surfaces, solution.surfaces, contacts, sigmas, scale, body == other_body):
                kept[number] = _with(fixture, other, solution), other_body
                break
        else:
            kept.append((solution, body))
    return [solution for solution, _ in kept]


def _with(fixture: Fixture, best: Solution, other: Solution) -> Solution:
    """The better of two solutions, its covariance large enough for both."""
    poses = np.array(frames(recipe_of(fixture), other.surfaces))
    alike = np.einsum("mij,ij->m", poses[:, :3, :3], best.base_from_fixture[:3, :3])
    motion = motions_between(best.base_from_fixture, poses[[np.argmax(alike)]])
    return replace(best, covariance=best.covariance + weight(best.chi2, other.chi2) * motion @ motion.T)


def _framed(fixture: Fixture, solution: Solution) -> Iterator[Solution]:
    """The solution in each frame that the recipe makes of its features."""
    for pose in frames(recipe_of(fixture), solution.surfaces):
        yield replace(solution, base_from_fixture=pose)
