"""Motions of tip and fixture that the contacts leave free together, in words that tell what to do."""

import numpy as np

from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.localization.free_motions import in_words, tidied
from tactfix.localization.motion_words import vector
from tactfix.poses.solution import at_base_origin
from tactfix.results import FreeMotion
from tactfix.unknowns.solution import TipSolution

NO_PART = 1e-3
"""Share of a motion below which a part of it is none."""


def tip_motions(fixture: Fixture, solution: TipSolution) -> tuple[FreeMotion, ...]:
    """What is free, or as good as free, in base: motions with the tip first, then those of the fixture alone."""
    weak = solution.weak / np.linalg.norm(solution.weak, axis=1, keepdims=True)
    u, values, _ = np.linalg.svd(weak[:, 6:])
    moving = int((values > NO_PART).sum())
    mixed = u.T @ weak
    with_tip, alone = mixed[:moving], mixed[moving:]
    if len(alone):
        basis = np.linalg.qr(alone[:, :6].T)[0]
        with_tip[:, :6] -= with_tip[:, :6] @ basis @ basis.T
    if moving == 3 and np.abs(with_tip[:, 9]).max() < NO_PART:
        with_tip = np.linalg.solve(with_tip[:, 6:9], with_tip)
    centre = solution.centre
    together = [_together(motion, centre) for motion in with_tip]
    twists = tidied(at_base_origin(alone[:, :6], centre)) if len(alone) else alone[:, :6]
    return (*together, *(in_words(fixture, solution.solution, twist, "", solution.contacts.spread) for twist in twists))


def _together(motion: Floats, centre: Floats) -> FreeMotion:
    """A motion (10,) about the contacts' centre that moves the tip in its flange, or changes its radius."""
    tip, radius = motion[6:9], float(motion[9])
    size = float(np.linalg.norm(tip))
    if size < NO_PART:
        motion = motion / np.sign(radius)
        words = "the tip's radius and the fixture change together; touch from an opposite side, or a ball or a pin"
        return _free(motion, centre, words)
    motion = motion / size
    along = vector(motion[6:9])
    if np.abs(motion[:6]).max() < NO_PART:
        words = f"the tip moves unseen along {along} of the flange frame; turn the tool about another axis"
    else:
        base = vector(motion[3:6])
        words = f"tip and fixture move together along {along} of the flange frame, {base} in base"
        words += "; turn the tool about another axis"
    return _free(motion, centre, words)


def _free(motion: Floats, centre: Floats, words: str) -> FreeMotion:
    twist = at_base_origin(motion[None, :6], centre)[0]
    return FreeMotion(twist[:3], twist[3:], words)
