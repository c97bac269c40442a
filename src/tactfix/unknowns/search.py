"""Every pose at which some tip explains the contacts.

1. Take the tip to be off by no more than w: what bounds it; where that finds nothing, or nothing bounds it, a few sigma
   and then more.
2. A tip that is off by no more than w, wherever its flange points, moves no contact farther from its surface than w:
   the true pose, with the tip as it was reported, explains the contacts if each is given w for its noise. So the
   complete search for poses (`poses.all_poses`) with that noise finds the surroundings of every pose that may be right.
3. From each of them pose and tip descend together (`descent`), with the tip where it was reported and at half of w to
   all sides.
4. Ends that explain the contacts and that noise can tell apart are the solutions.

That is complete as far as two poses with their tips are not hidden behind one with much noise. Where nothing bounds the
tip, nothing is claimed.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from tactfix.contacts import Contacts, Unknown
from tactfix.fixture import Placement
from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.geometry.surfaces import Surface, moved
from tactfix.noise import chi_square_limit
from tactfix.poses.all_poses import all_poses
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.rigid import UNRESOLVED
from tactfix.poses.sigma_points import Spread
from tactfix.poses.solution import solution_from
from tactfix.unknowns.descent import descend
from tactfix.unknowns.equations import TipEquations, Trials
from tactfix.unknowns.solution import Knowledge, TipSolution, about_origin
from tactfix.values import frozen_value

FIRST_TIP_SIGMAS = 10.0
"""Sigmas of a contact that the tip is first taken to be off, where nothing bounds it; then, as shares of the problem's
length, FIRST_TIP_SHARES."""
FIRST_TIP_SHARES = (0.02, 0.1, 0.4)
"""Shares of the contacts' spread by which the tip may be off in the first searches."""
TIP_STARTS = np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])
SAMPLES = 8
"""Solutions of a continuum that are kept."""
MOST_POSES = 24
"""Poses of much noise that are followed, the best first."""


@frozen_value
class TipSolutions:
    """All found, best first; the nearest miss alone where none explains the contacts.

    dof, limit: the chi-square up to which one explains them. complete: whether the search claims to have found all.
    """

    found: tuple[TipSolution, ...]
    dof: int
    limit: float
    complete: bool


def tip_solutions(
    shapes: Sequence[Mapping[str, Surface]],
    contacts: Contacts,
    sigmas: Floats,
    unknown: frozenset[Unknown],
    within: float | None,
    placement: Placement | None = None,
) -> TipSolutions:
    """Every pose, with its tip, at which the contacts, and what placement says for the fit, are explained.

    shapes: the surfaces of the fixture in its frame, each way that it can be; sigmas (n,) of the residuals; within: how
    far the tip can be from where it was reported, None where nothing bounds it. At least one is unknown.
    """
    dof, limit, misses = 0, 0.0, []
    for assumed, complete in _levels(contacts, sigmas, unknown, within):  # step 1
        found = []
        for surfaces in shapes:
            equations = TipEquations.build(surfaces, contacts, sigmas, unknown, placement)
            dof = len(equations) - len(equations.columns)
            limit = chi_square_limit(dof)
            off = assumed if "tip" in unknown else 0.0
            # Steps 2 to 4.
            starts = _starts(equations, surfaces, contacts, np.hypot(sigmas, assumed), off, placement)
            trials, cost = descend(equations, starts)
            ok = (cost <= limit) & (trials.radii >= 0)
            misses.append((float(cost.min()), surfaces, equations, trials.subset(np.argsort(cost)[:1])))
            found += [(equations, surfaces, trials.subset(at[None])) for at in _distinct(equations, trials, cost, ok)]
        if found:
            solutions = [_solution(*each, contacts) for each in found]
            solutions.sort(key=lambda s: s.solution.chi2)
            return TipSolutions(tuple(solutions), dof, limit, complete)
    _, surfaces, equations, nearest = min(misses, key=lambda miss: miss[0])
    return TipSolutions((_solution(equations, surfaces, nearest, contacts),), dof, limit, complete=within is not None)


def _levels(
    contacts: Contacts, sigmas: Floats, unknown: frozenset[Unknown], within: float | None
) -> Iterator[tuple[float, bool]]:
    """How far the tip is taken to be off, level by level, and whether a search with that is complete."""
    levels = [FIRST_TIP_SIGMAS * float(sigmas.max()), *(share * contacts.spread for share in FIRST_TIP_SHARES)]
    if within is not None and "tip" in unknown:
        yield within, "tip-radius" not in unknown
        # A bound as wide as the contacts lie apart blurs their poses into one.
        levels = [level for level in levels if level < within]
    yield from ((level, False) for level in levels)


def _starts(
    equations: TipEquations,
    surfaces: Mapping[str, Surface],
    contacts: Contacts,
    sigmas: Floats,
    off: float,
    placement: Placement | None,
) -> Trials:
    """Every pose for contacts with these sigmas, with the tip as reported and at half of off to all sides; and near."""
    single = one_equation_each(surfaces, contacts, sigmas)
    fits = all_poses(single.surfaces, single.contacts, single.sigmas, placement=placement).found[:MOST_POSES]
    tips = 0.5 * off * (TIP_STARTS if off else TIP_STARTS[:1])
    near = [] if placement is None else [placement.near]
    poses = np.array([fit.base_from_fixture for fit in fits] + near)
    return equations.trials(np.repeat(poses, len(tips), axis=0), np.tile(tips, (len(poses), 1)), contacts.tip_radius)


def _distinct(equations: TipEquations, trials: Trials, cost: Floats, ok: Bools) -> list[Ints]:
    """The numbers of the trials that are ok, best first, without those that noise cannot tell from a better one."""
    kept: list[int] = []
    scaled = np.concatenate(
        [trials.rotations.reshape(-1, 9), trials.origins, trials.tips, trials.radii[:, None]], axis=1
    )
    for at in np.argsort(cost, kind="stable"):
        if not ok[at] or len(kept) >= SAMPLES * len(TIP_STARTS):
            continue
        if not any(_are_one(equations, trials, scaled, int(at), other) for other in kept):
            kept.append(int(at))
    return [np.array(at) for at in kept]


def _are_one(equations: TipEquations, trials: Trials, scaled: Floats, one: int, other: int) -> bool:
    if np.abs(scaled[one] - scaled[other]).max() < 1e-6:
        return True
    if np.einsum("ij,ij->", trials.rotations[one], trials.rotations[other]) < 2.99:
        return False
    # Both are minima: between them the residuals would have to grow, unless noise is all that separates them.
    residuals = equations.evaluate(trials.subset(np.array([one, other])))[0]
    middle = _halfway(trials, one, other)
    between = equations.evaluate(middle)[0][0]
    rise = float((between**2).sum() - (residuals**2).sum(axis=1).max())
    changed = float(((residuals[0] - residuals[1]) ** 2).sum())
    return rise < UNRESOLVED**2 and changed < UNRESOLVED**2


def _halfway(trials: Trials, one: int, other: int) -> Trials:
    pair = np.array([one, other])
    u, _, vt = np.linalg.svd(trials.rotations[pair].sum(axis=0))
    return Trials(
        (u @ vt)[None],
        trials.origins[pair].mean(axis=0, keepdims=True),
        trials.tips[pair].mean(axis=0, keepdims=True),
        trials.radii[pair].mean(keepdims=True),
    )


def _solution(
    equations: TipEquations, surfaces: Mapping[str, Surface], trial: Trials, contacts: Contacts
) -> TipSolution:
    """The trial with its uncertainty spelled out, in terms of the contacts as its tip makes them."""
    known = Knowledge.at(equations, trial)
    pose, change = equations.poses(trial)[0], equations.length * trial.tips[0]
    corrected = contacts.with_tip(change, float(equations.length * trial.radii[0]))
    in_base = {name: moved(pose, surface) for name, surface in surfaces.items()}
    residuals, normals = contact_residuals(in_base, corrected)
    chi2 = float((equations.evaluate(trial)[0] ** 2).sum())
    factor = known.factor()
    arm = equations.length * trial.origins[0]
    weak = known.motions(known.is_weak)
    free = weak @ about_origin(arm).T
    solution = solution_from(
        pose, in_base, corrected, residuals, normals, chi2, Spread(factor[:6], free[:, :6].T, trusted=True)
    )
    return TipSolution(
        solution, corrected, change, factor, weak, known.sigmas(known.is_weak), equations.centre, known.tells_tip
    )
