"""Every pose at which some tip explains the contacts.

1. An upper bound w of the tip's displacement is taken: the one of the fixture file, or, if there is none or nothing is
   found with it, a few sigma and then more.
2. A tip that is displaced by at most w moves no contact farther than w from its surface, in any orientation of the
   flange. So at the true pose the contacts fit the reported tip with a noise of w. The complete search for poses
   (`poses.all_poses`) with this noise finds poses near every possible one.
3. From each of these, pose and tip descend together (`descent`), with the reported tip and with tips displaced by w / 2
   along the flange axes in either sense.
4. The ends that explain the contacts are the solutions; of those that noise does not distinguish, only the best is
   kept.

This is complete unless two poses, each with its tip, are one pose within the noise of w. Without a bound of the tip the
result is not marked as complete; nor with fewer equations than unknowns, whose solutions are samples of a continuum:
one covering of the rotations finds these.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from tactfix.contacts import Contacts, Unknown
from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.geometry.surfaces import Surface, moved
from tactfix.noise import chi_square_limit
from tactfix.placement import Placement
from tactfix.poses.all_poses import all_poses
from tactfix.poses.points_as_planes import one_equation_each
from tactfix.poses.pose_fit import contact_residuals
from tactfix.poses.rigid import UNRESOLVED
from tactfix.poses.sigma_points import Spread
from tactfix.poses.solution import solution_from
from tactfix.unknowns.descent import descend
from tactfix.unknowns.equations import PosesWithTip, TipEquations
from tactfix.unknowns.solution import Knowledge, TipSolution, about_origin
from tactfix.values import frozen_value

FIRST_TIP_SIGMAS = 10.0
"""Displacement of the tip, in sigmas of a contact, that the first search assumes without a bound: an error that a
calibrated tip may have. FIRST_TIP_SHARES follow."""
FIRST_TIP_SHARES = (0.02, 0.1, 0.4)
"""Displacements of the tip, as shares of the contacts' spread, that the further searches assume: each four to five
times the one before, up to the size of the fixture itself."""
TIP_STARTS = np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])
"""Directions (7, 3) in the flange frame of the starts' tip displacements: zero, and along each axis in either sense."""
TIP_CONTINUUM_SAMPLES = 8
"""Solutions of a continuum that are kept for each start of the tip, as `poses.all_poses.CONTINUUM_SAMPLES`."""
TIP_START_POSES = 24
"""Poses of the search with assumed noise that are starts, the best first: with much noise there may be hundreds,
most of them within noise of each other."""


@frozen_value
class TipSolutions:
    """The solutions, best first; only the nearest miss if none explains the contacts.

    dof, limit: of chi-square. complete: whether the search met its criteria of having found all.
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
    """Every pose, with its tip, that explains the contacts and the terms of the placement.

    shapes: the surfaces of the fixture in its frame, for each shape that it can have; sigmas (n,) of the residuals;
    within: largest displacement of the tip from its reported place, None without a bound. At least one is unknown.
    """
    dof, limit, misses, searched = 0, 0.0, [], False
    for assumed, complete in _levels(contacts, sigmas, unknown, within):  # step 1
        found, searched = [], searched or complete
        for surfaces in shapes:
            equations = TipEquations.build(surfaces, contacts, sigmas, unknown, placement)
            dof = len(equations) - len(equations.columns)
            limit = chi_square_limit(dof)
            off = assumed if "tip" in unknown else 0.0
            # Steps 2 to 4.
            starts = _starts(equations, surfaces, contacts, np.hypot(sigmas, assumed), off, placement, dof >= 0)
            trials, cost = descend(equations, starts)
            ok = (cost <= limit) & (trials.radii >= 0)
            misses.append((float(cost.min()), surfaces, equations, trials.subset(np.argsort(cost)[:1])))
            found += [(equations, surfaces, trials.subset(at[None])) for at in _distinct(equations, trials, cost, ok)]
        if found:
            solutions = [_solution(*each, contacts) for each in found]
            solutions.sort(key=lambda s: s.solution.chi2)
            return TipSolutions(tuple(solutions), dof, limit, complete and dof >= 0)
    _, surfaces, equations, nearest = min(misses, key=lambda miss: miss[0])
    nearest_pose = _solution(equations, surfaces, nearest, contacts)
    return TipSolutions((nearest_pose,), dof, limit, searched and dof >= 0)


def _levels(
    contacts: Contacts, sigmas: Floats, unknown: frozenset[Unknown], within: float | None
) -> Iterator[tuple[float, bool]]:
    """The assumed displacements of the tip in turn, and whether a search with each is complete."""
    levels = [FIRST_TIP_SIGMAS * float(sigmas.max()), *(share * contacts.spread for share in FIRST_TIP_SHARES)]
    if within is not None and "tip" in unknown:
        yield within, "tip-radius" not in unknown
        # With a bound as large as the spread of the contacts, noise merges their poses.
        levels = [level for level in levels if level < within]
    yield from ((level, False) for level in levels)


def _starts(
    equations: TipEquations,
    surfaces: Mapping[str, Surface],
    contacts: Contacts,
    sigmas: Floats,
    off: float,
    placement: Placement | None,
    thorough: bool,
) -> PosesWithTip:
    """Starts: every pose for contacts with these sigmas, and near, each with the reported tip and tips at off / 2.

    thorough False: the poses found from one covering of the rotations; if it finds none, those of the thorough search,
    which returns at least the nearest misses.
    """
    single = one_equation_each(surfaces, contacts, sigmas)
    search = all_poses(single.surfaces, single.contacts, single.sigmas, placement=placement, thorough=thorough)
    if not search.found and not thorough:
        search = all_poses(single.surfaces, single.contacts, single.sigmas, placement=placement)
    fits = search.found[:TIP_START_POSES]
    tips = 0.5 * off * (TIP_STARTS if off else TIP_STARTS[:1])
    near = [] if placement is None else [placement.near]
    poses = np.array([fit.base_from_fixture for fit in fits] + near)
    return equations.trials(np.repeat(poses, len(tips), axis=0), np.tile(tips, (len(poses), 1)), contacts.tip_radius)


def _distinct(equations: TipEquations, trials: PosesWithTip, cost: Floats, ok: Bools) -> list[Ints]:
    """The indices of the trials that are ok, best first; of those within noise of each other only the best."""
    kept: list[int] = []
    scaled = np.concatenate(
        [trials.rotations.reshape(-1, 9), trials.origins, trials.tips, trials.radii[:, None]], axis=1
    )
    for at in np.argsort(cost, kind="stable"):
        if not ok[at] or len(kept) >= TIP_CONTINUUM_SAMPLES * len(TIP_STARTS):
            continue
        if not any(_are_one(equations, trials, scaled, int(at), other) for other in kept):
            kept.append(int(at))
    return [np.array(at) for at in kept]


def _are_one(equations: TipEquations, trials: PosesWithTip, scaled: Floats, one: int, other: int) -> bool:
    if np.abs(scaled[one] - scaled[other]).max() < 1e-6:
        return True
    if np.einsum("ij,ij->", trials.rotations[one], trials.rotations[other]) < 2.99:
        return False
    # Both are minima: they are distinct if the residuals grow between them by more than noise.
    residuals = equations.evaluate(trials.subset(np.array([one, other])))[0]
    middle = _halfway(trials, one, other)
    between = equations.evaluate(middle)[0][0]
    rise = float((between**2).sum() - (residuals**2).sum(axis=1).max())
    changed = float(((residuals[0] - residuals[1]) ** 2).sum())
    return rise < UNRESOLVED**2 and changed < UNRESOLVED**2


def _halfway(trials: PosesWithTip, one: int, other: int) -> PosesWithTip:
    pair = np.array([one, other])
    u, _, vt = np.linalg.svd(trials.rotations[pair].sum(axis=0))
    return PosesWithTip(
        (u @ vt)[None],
        trials.origins[pair].mean(axis=0, keepdims=True),
        trials.tips[pair].mean(axis=0, keepdims=True),
        trials.radii[pair].mean(keepdims=True),
    )


def _solution(
    equations: TipEquations, surfaces: Mapping[str, Surface], trial: PosesWithTip, contacts: Contacts
) -> TipSolution:
    """The trial as a solution with its covariance, for the contacts corrected for its tip."""
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
        solution, corrected, change, factor, weak, known.sigmas(known.is_weak), equations.centre, known.determines_tip
    )
