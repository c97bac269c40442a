"""Every pose of a rigid fixture at which each contact lies on its feature, within noise.

1. Contacts and fixture are centred and scaled, and a well spread subset of the contacts is chosen (`search_frame`).
2. All zeros of the equations of that subset are searched: from the rotations that features located alone leave, if
   there are enough contacts (`feature_rotations`), else from all rotations (`search`).
3. If no zero explains the subset, it may contain a wrong contact: other subsets are searched for poses that most
   contacts agree on (`subsets`).
4. Every zero is refined on all contacts by geometric least squares (`subsets`); equal ones are merged.
5. Each becomes a `PoseFit` in the user's frames and unit, with residuals, chi-square and sensitivity.

All poses that explain the contacts are returned; none is preferred.

Complex poses of six contacts in general position, at most as many are real: three planes 3-2-1: 4, 2-2-2: 8; three
spheres 3-2-1: 8, 2-2-2: 16; sphere and cylinder 3+3: 48, 2+4: 96; plane and cylinder 3+3: 24, 2+4: 48; two
cylinders 3+3: 288, 2+4: 192; six spheres: 40.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Floats, farthest_first
from tactfix.geometry.surfaces import Cylinder, Plane, SidedSurface, Sphere
from tactfix.noise import chi_square_limit
from tactfix.placement import Placement
from tactfix.poses.equations import PoseEquations
from tactfix.poses.feature_rotations import not_out_of_material, rotations_in
from tactfix.poses.pose_fit import PoseFit, fit_at
from tactfix.poses.search import find_zeros, find_zeros_near, nearest_misses
from tactfix.poses.search_frame import SearchFrame
from tactfix.poses.solution import Found
from tactfix.poses.starts import BEYOND_SHARE, domain_rotations, start_count
from tactfix.poses.subsets import PART_CONTACTS, acceptance_cost, agreed_poses, best_poses
from tactfix.poses.zeros import Zeros, together

SEARCHED = 18
"""Most contacts of the search; the refinement uses all. Three times the six unknowns leave few wrong poses to refine.
12 and 36 give the same poses of 336 problems with 8 to 30 noisy contacts, four of each kind and layout of
`tests.validation.touched_problems`."""

RELY_ON_FEATURES = 9
"""Fewest contacts for which the rotations are taken from features located alone. 7 and 18 give the same poses of the
336 problems of SEARCHED."""

FAR_OFF = 100.0
"""If the lowest cost exceeds this many times the acceptance limit, skip the geometric refinement: the algebraic cost
differs from the geometric one by a few per cent at most, so the pose would be rejected anyway."""

CLOSER_LOOK = 3
"""Coverings of the rotations that are searched if the first one led to no pose: a zero that one covering finds with
probability p is then missed with probability (1 - p)^3."""

WELL_DETERMINED_SHARE = 0.02
"""Largest sigma of a pose determined by the contacts alone, as a share of their spread (rad for rotation): a fifth of
that of a worthless pose (`localization.free_motions`), so that fits are linear there."""

CONTINUUM_SAMPLES = 8
"""Number of samples of a continuum that are kept: those that `localization.locate.SAMPLES_SHOWN` lists."""


def all_poses(
    surfaces: Mapping[str, SidedSurface],
    contacts: Contacts,
    sigmas: Floats,
    with_misses: bool = True,
    placement: Placement | None = None,
    thorough: bool = True,
    most_starts: int | None = None,
) -> Found[PoseFit]:
    """Every pose that explains the contacts; surfaces in the fixture frame, sigmas (n,) of the residuals.

    with_misses: include the nearest miss if there is no such pose. placement: prior knowledge of the pose; beyond its
    limits some poses may be missed. thorough: search until the criteria of completeness are met; else one covering of
    at most most_starts rotations.

    If contacts leave a motion free, or are fewer than the unknowns, the fits are samples of a continuum.
    Raises TipDoesNotFitError if the tip is larger than a touched bore.
    """
    index = spread_indices(contacts, SEARCHED)  # step 1
    frame = SearchFrame.of(surfaces, contacts.subset(index))
    smallest = float(sigmas.min())
    equations = frame.equations(surfaces, contacts, smallest / sigmas, placement, smallest)
    searched = equations.subset(index)
    unit = (smallest / frame.length) ** 2
    if searched.measured is not None and searched.domain.is_free:
        both = _with_measured_pose(surfaces, contacts, sigmas, frame, equations, searched, placement)
        if both is not None:
            return both
    # Constrained directions and a measured pose break the symmetry of the surfaces.
    turns = frame.half_turns(surfaces, contacts) if searched.domain.is_free and not searched.measured else []
    # Step 2.
    zeros = _zeros(surfaces, contacts, sigmas, searched, zero_limit(searched.dof, unit), turns, thorough, most_starts)
    dof, limit = equations.dof, chi_square_limit(equations.dof)
    least = zeros.costs.min(initial=np.inf) / zero_limit(searched.dof, unit)
    if zeros.continuum:
        zeros = zeros.split_off(searched, CONTINUUM_SAMPLES)
    elif least > FAR_OFF and not with_misses:
        return Found((), dof, limit, zeros.complete, continuum=False)
    elif least > 1 and len(contacts) > SEARCHED and thorough:
        # Step 3.
        part_dof = dof - len(contacts) + PART_CONTACTS
        starts, part_limit = _starts(surfaces, contacts, part_dof), zero_limit(part_dof, unit)
        zeros = together([zeros, *agreed_poses(surfaces, contacts, sigmas, equations, part_limit, starts, turns)])
    zeros = best_poses(equations, contacts, zeros, unit)  # step 4
    # Step 5.
    fits = [fit_at(surfaces, contacts, sigmas, pose, placement) for pose in frame.base_from_fixture(zeros)]
    fits.sort(key=lambda fit: fit.chi2)
    kept = [fit for fit in fits if fit.chi2 <= limit] or fits[: int(with_misses)]
    return Found(tuple(kept), dof, limit, zeros.complete, zeros.continuum)


def _with_measured_pose(
    surfaces: Mapping[str, SidedSurface],
    contacts: Contacts,
    sigmas: Floats,
    frame: SearchFrame,
    equations: PoseEquations,
    searched: PoseEquations,
    placement: Placement | None,
) -> Found[PoseFit] | None:
    """One search for the poses with and without a measured pose; None if one search is not enough.

    If the contacts alone determine the pose, a measured pose only shifts each of their poses a little, or excludes it.
    """
    bare, alone = searched.without_measured(), equations.without_measured()
    unit = (float(sigmas.min()) / frame.length) ** 2
    rotations = rotations_in(bare.domain, surfaces, contacts, sigmas) if len(bare) >= RELY_ON_FEATURES else None
    if rotations is None:
        return None
    # Poses far from the measured one are only counted, and those that the approach eliminates are not.
    is_near = bare.domain.may_lead_into(rotations.matrices)
    rotations = rotations.of(is_near | not_out_of_material(surfaces, contacts, rotations.matrices))
    turns = frame.half_turns(surfaces, contacts)
    zeros = find_zeros_near(bare, zero_limit(bare.dof, unit), rotations, turns)
    near = bare.domain.has(zeros.rotations, zeros.offsets)
    if zeros.continuum or not near.any():
        return None
    moved = best_poses(equations, contacts, zeros.subset(near), unit)
    fits = [fit_at(surfaces, contacts, sigmas, pose, placement) for pose in frame.base_from_fixture(moved)]
    limit, own_limit = chi_square_limit(equations.dof), chi_square_limit(alone.dof)
    if len(fits) < near.sum() or not all(
        fit.chi2 <= limit and _is_well_determined(fit, contacts, own_limit) for fit in fits
    ):
        return None
    aside: list[PoseFit] = []
    if not near.all():
        others = best_poses(alone, contacts, zeros.subset(~near), unit)
        aside = [fit_at(surfaces, contacts, sigmas, pose) for pose in frame.base_from_fixture(others)]
    fits.sort(key=lambda fit: fit.chi2)
    kept = tuple(fit for fit in aside if fit.chi2 <= own_limit)
    return Found(tuple(fits), equations.dof, limit, zeros.complete, continuum=False, aside=kept)


def _is_well_determined(fit: PoseFit, contacts: Contacts, limit: float) -> bool:
    """Whether the contacts alone explain the pose and determine it so well that a fit stays next to it."""
    own = fit.sensitivity.jacobian[: len(contacts)]
    chi2 = fit.chi2 - float(fit.off @ fit.off)
    least = float(np.linalg.svd(own, compute_uv=False)[-1])
    return chi2 <= limit and least * WELL_DETERMINED_SHARE * fit.sensitivity.scale > 1


def zero_limit(dof: int, unit: float) -> float:
    """The cost up to which a zero with dof degrees of freedom may be a pose; unit: the cost of chi-square 1.

    The factor of 2 allows for the second-order difference of the polynomial residual from the distance.
    """
    return acceptance_cost(dof, 2 * unit)


def _zeros(
    surfaces: Mapping[str, SidedSurface],
    contacts: Contacts,
    sigmas: Floats,
    searched: PoseEquations,
    cost_limit: float,
    turns: Sequence[Floats],
    thorough: bool,
    most_starts: int | None,
) -> Zeros:
    """All zeros, from the rotations of features located alone, or else all rotations; the nearest misses if none."""
    if len(searched) >= RELY_ON_FEATURES:
        rotations = rotations_in(searched.domain, surfaces, contacts, sigmas)
        if rotations is not None:
            zeros = find_zeros_near(searched, cost_limit, rotations, turns, thorough)
            if len(zeros):
                return zeros
    starts = _starts(surfaces, contacts, searched.dof)
    if not thorough:
        few = min(int(BEYOND_SHARE * starts), most_starts or starts)
        return find_zeros(searched, cost_limit, few, turns, thorough=False)
    zeros = find_zeros(searched, cost_limit, starts, turns)
    if len(zeros):
        return zeros
    misses = nearest_misses(searched, domain_rotations(searched.domain, start_count(searched.domain, starts)), turns)
    if misses.costs.min(initial=np.inf) <= cost_limit:
        return misses
    # Before contacts are called inconsistent, further coverings are searched.
    zeros = find_zeros(searched, cost_limit, starts, turns, coverings=CLOSER_LOOK)
    return zeros if len(zeros) else replace(misses, complete=True)


STARTS = {Plane: (400, 200, 200), Sphere: (1200, 400, 200), Cylinder: (1200, 600, 300)}
"""Start rotations by the roundest surface touched, for up to 3 contacts more than six, up to 5, and more.

Of 1200 starts so many met the rarest zero of 24 random and symmetric layouts: planes 131; spheres 1, 2, 96, 286 for 0,
2, 3, 6 contacts more than six; cylinders 1, 5, 1, 34, 115 for 0, 2, 3, 6, 12. A zero that is met once or twice lies
close to others, and is found from these."""

TWO_CYLINDERS = 2000
"""Start rotations for up to 3 contacts more than six on two cylinders or more. Of 720 problems with six contacts one
had two poses, far from all others, that one start in 1600 led to."""


def _starts(surfaces: Mapping[str, SidedSurface], contacts: Contacts, beyond: int) -> int:
    """The number of start rotations; beyond: number of equations minus number of unknowns."""
    touched = [type(surfaces[name]) for name in contacts.by_feature]
    roundest = next(kind for kind in (Cylinder, Sphere, Plane) if kind in touched)
    if beyond <= 3 and touched.count(Cylinder) > 1:
        return TWO_CYLINDERS
    return STARTS[roundest][0 if beyond <= 3 else 1 if beyond <= 5 else 2]


def spread_indices(contacts: Contacts, most: int) -> list[int]:
    """At most `most` contacts, well spread over each feature and fairly shared between the features, in file order."""
    if len(contacts) <= most:
        return list(range(len(contacts)))
    queues = [index[farthest_first(contacts.points[index], most)].tolist() for index in contacts.by_feature.values()]
    chosen: list[int] = []
    for turn in range(most):
        chosen += [queue[turn] for queue in queues if turn < len(queue)]
    return sorted(chosen[:most])
