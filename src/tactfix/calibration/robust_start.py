"""From the nominal robot to the estimate with the full prior: the tip and the places first, then offsets, then all."""

import numpy as np

from tactfix.calibration.cell import Cell
from tactfix.calibration.equations import Group
from tactfix.calibration.estimation import State, estimated
from tactfix.calibration.place_search import found_place
from tactfix.geometry.arrays import Bools, Floats, frozen


def placed(cell: Cell, groups: tuple[Group, ...], values: Floats, spread: Floats) -> State:
    """Every place found with the parameters at values (m,); spread (m,): the sigma of what they may be off by."""
    poses = {}
    for group in groups:
        motion = cell.chain.tip(group.touches.joints, values[:-1])
        sigmas = np.sqrt(((motion.jacobian * spread[:-1]) ** 2).sum(axis=(1, 2)) / 3)
        poses[group.root] = found_place(cell, group, values, sigmas)
    return State(frozen(values), poses)


def nominal(cell: Cell, groups: tuple[Group, ...], weights: Floats, free: Bools, spread: Floats) -> State:
    """The nominal robot with its tip and places fitted: what a calibrated robot is held against."""
    start = placed(cell, groups, np.zeros(len(weights)), np.where(free, spread, 0.0))
    return estimated(cell, groups, start, weights, tips(cell, free))


def full(cell: Cell, groups: tuple[Group, ...], start: State, weights: Floats, free: Bools) -> State:
    """The estimate with weights (m,), from the nominal robot: offsets first, then all that is free."""
    offsets = np.array([parameter.kind == "joint_offset" for parameter in cell.parameters])
    first = estimated(cell, groups, start, weights, (free & offsets) | tips(cell, free), 6)
    return estimated(cell, groups, first, weights, free)


def tips(cell: Cell, free: Bools) -> Bools:
    """Which of the free parameters (m,) are the tip's: mounted anew, it is fitted whatever is believed of the robot.

    None where nothing else is free: then the tip is what is to be calibrated.
    """
    found = free & np.array([parameter.kind == "tip" for parameter in cell.parameters])
    return np.asarray(found & (free & ~found).any())
