"""From the nominal robot to the estimate with the full prior: the start of every calibration.

1. Each fixture is located with given parameters. For points alone the least squares have one minimum, in closed form
   (Kabsch 1976). Else the search of `locate` gives all poses that explain the tip's places within the prior errors of
   the robot.
2. The placement is imposed on these poses, and its own pose is added.
3. If there are none, the 24 rotations of a cube start instead: the touches of a place may leave motions free, or the
   errors of the nominal robot may exceed its prior.
4. Each start descends; ends beyond the limits of the placement are dropped if others are within.
5. Of the ends of least cost the one with the fewest approaches out of the material is taken.
6. The tip and the places are fitted first, then the joint offsets, then all parameters.
"""

from itertools import permutations, product
from typing import Final

import numpy as np

from tactfix.calibration.cell import Cell
from tactfix.calibration.equations import Group, approaches_in_base, tip_places
from tactfix.calibration.estimation import State, estimated, located
from tactfix.contacts import Contacts
from tactfix.geometry.arrays import Bools, Floats, frozen
from tactfix.geometry.rigid import homogeneous
from tactfix.geometry.surfaces import Point, moved, outward_normals, reference_point
from tactfix.poses.placement_terms import onto_placement
from tactfix.poses.prior import deviation
from tactfix.poses.rigid import rigid_solutions

_CUBE_ROTATIONS: Final = tuple(
    turn
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
    if np.linalg.det(turn := np.diag(signs)[list(order)]) > 0
)
"""The 24 rotations of a cube: every rotation is within 63 degrees of one of them, near enough for a descent."""
_EQUAL_COST: Final = 1.0
"""Difference of costs (chi-square) below which two poses of a place fit equally, and the approaches decide: one
standard deviation of one touch."""


def found_place(cell: Cell, group: Group, values: Floats, robot_sigmas: Floats) -> Floats:
    """base_from_root (4, 4) that explains the touches best for parameter values (m,).

    robot_sigmas (n,): sigma of the tip's place at each touch by the errors of the robot, along any direction.
    """
    if all(isinstance(patch.surface, Point) for patch in group.patches):  # step 1
        starts = [_superposed(cell, group, values)]
    else:
        starts = _searched(cell, group, values, robot_sigmas)
    if group.placement is not None:  # step 2
        starts = [onto_placement(group.placement, start) for start in (group.placement.near, *starts)]
    if not starts:  # step 3
        tips = tip_places(cell, group, values)
        middle = np.mean([reference_point(patch.surface) for patch in group.patches], axis=0)
        starts = [homogeneous(turn, tips.mean(axis=0) - turn @ middle) for turn in _CUBE_ROTATIONS]
    # Step 4.
    tried = [located(cell, group, start, values) for start in starts]
    tried = [found for found in tried if _is_within(group, found[0])] or tried
    # Step 5.
    least = min(cost for _, cost in tried)
    alike = [pose for pose, cost in tried if cost <= least * (1 + 1e-6) + _EQUAL_COST]
    return min(alike, key=lambda pose: _wrong_approaches(cell, group, pose, values))


def _is_within(group: Group, base_from_root: Floats) -> bool:
    """Whether a pose is within the limits of its placement."""
    if group.placement is None or group.placement.within is None:
        return True
    off = deviation(group.placement, base_from_root)
    shift, turn = group.placement.within
    return bool(np.linalg.norm(off[:3]) <= turn and np.linalg.norm(off[3:]) <= shift)


def _superposed(cell: Cell, group: Group, values: Floats) -> Floats:
    """The pose that brings points nearest to the tip's places.

    W. Kabsch: A solution for the best rotation to relate two sets of vectors, 1976.
    """
    tips = tip_places(cell, group, values)
    points = np.empty_like(tips)
    for patch in group.patches:
        points[patch.index] = reference_point(patch.surface)
    weights = 1 / group.sigmas[:, None] ** 2
    middle, origin = ((weights * these).sum(axis=0) / weights.sum() for these in (tips, points))
    left, _, right = np.linalg.svd((weights * (tips - middle)).T @ (points - origin))
    turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    return homogeneous(turn, middle - turn @ origin)


def _searched(cell: Cell, group: Group, values: Floats, robot_sigmas: Floats) -> list[Floats]:
    """The poses of the search of `locate`; empty for a continuum."""
    count = len(group.touches)
    names = [""] * count
    for number, patch in enumerate(group.patches):
        for index in patch.index:
            names[index] = str(number)
    contacts = Contacts(
        features=tuple(names),
        points=tip_places(cell, group, values),
        approaches=approaches_in_base(cell, group, values),
        sigmas=group.sigmas,
        tip_radius=cell.tip_radius + float(values[-1]),
        rows=group.touches.rows,
        ids=(None,) * count,
    )
    equations = sum(len(patch.index) * (3 if isinstance(patch.surface, Point) else 1) for patch in group.patches)
    if equations < 6:
        return []
    surfaces = {str(number): patch.surface for number, patch in enumerate(group.patches)}
    if len(surfaces) < 2:
        return []
    solutions = rigid_solutions(surfaces, contacts, np.hypot(group.sigmas, robot_sigmas), with_misses=False)
    return [] if solutions.continuum else [solution.base_from_fixture for solution in solutions.found]


def _wrong_approaches(cell: Cell, group: Group, base_from_root: Floats, values: Floats) -> int:
    """The number of touches with an approach out of the material."""
    travels = approaches_in_base(cell, group, values)
    tips = tip_places(cell, group, values)
    wrong = 0
    for patch in group.patches:
        if not isinstance(patch.surface, Point):
            normals = outward_normals(moved(base_from_root, patch.surface), tips[patch.index])
            wrong += int((np.einsum("ij,ij->i", travels[patch.index], normals) > 0).sum())
    return wrong


def placed(cell: Cell, groups: tuple[Group, ...], values: Floats, spread: Floats) -> State:
    """Every place located with parameter values (m,); spread (m,): sigmas of their errors."""
    poses = {}
    for group in groups:
        motion = cell.chain.tip(group.touches.joints, values[:-1])
        sigmas = np.sqrt(((motion.jacobian * spread[:-1]) ** 2).sum(axis=(1, 2)) / 3)
        poses[group.root] = found_place(cell, group, values, sigmas)
    return State(frozen(values), poses)


def nominal(cell: Cell, groups: tuple[Group, ...], weights: Floats, free: Bools, spread: Floats) -> State:
    """The nominal robot with its tip and places fitted: the reference for a calibrated robot."""
    start = placed(cell, groups, np.zeros(len(weights)), np.where(free, spread, 0.0))
    return estimated(cell, groups, start, weights, tips(cell, free))


def full(cell: Cell, groups: tuple[Group, ...], start: State, weights: Floats, free: Bools) -> State:
    """The estimate with weights (m,), from the nominal robot: offsets first, then all that is free."""
    offsets = np.array([parameter.kind == "joint_offset" for parameter in cell.parameters])
    # Step 6.
    first = estimated(cell, groups, start, weights, (free & offsets) | tips(cell, free), 6)
    return estimated(cell, groups, first, weights, free)


def tips(cell: Cell, free: Bools) -> Bools:
    """Which of the free parameters (m,) are the tip's; these are fitted whatever the factor on the prior is.

    None if nothing else is free: then the tip is to be calibrated.
    """
    found = free & np.array([parameter.kind == "tip" for parameter in cell.parameters])
    return np.asarray(found & (free & ~found).any())
