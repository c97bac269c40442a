"""Mistakes that a whole contact file shares: its unit and its tip radius."""

import numpy as np

from tactfix.diagnosis.corrections import Hypothesis, Problem
from tactfix.diagnosis.file_faults import UNITS_MEANT

TURNED_ENTRY = 1e-3
"""Entry by which rotations of the flange differ at least where one tool orientation is not all there is."""

SPREAD = 30.0
"""Sigmas that contacts are spread at least: with coordinates in a unit that brings them closer any pose fits."""


def tips(problem: Problem) -> list[Hypothesis]:
    """Another tip radius than the file says: none, or the one that fits best."""
    free = Hypothesis("tip_radius", free="tip", alternatives=2)
    return [free] if problem.contacts.tip_radius == 0 else [free, Hypothesis("tip_radius", tip=0.0, alternatives=2)]


def tip_offsets(problem: Problem) -> list[Hypothesis]:
    """The tip's centre elsewhere in the flange, where contacts say how that stood, and it turned."""
    flanges = problem.contacts.flange_rotations
    if flanges is None or np.abs(flanges - flanges[0]).max() < TURNED_ENTRY:
        return []
    return [Hypothesis("tip_offset", free="tip_offset")]


def units(problem: Problem) -> list[Hypothesis]:
    """The coordinates alone, or all lengths, in another unit than the file says."""
    count, tip = 2 * len(UNITS_MEANT), problem.contacts.tip_radius
    spread = problem.contacts.spread / float(problem.contacts.sigmas.max())
    told = [factor for factor in UNITS_MEANT if spread * factor > SPREAD]
    coordinates = [Hypothesis("unit", alternatives=count, points=factor) for factor in told]
    # Where all lengths are scaled sigma is too, and contacts stay as close together.
    whole = UNITS_MEANT if spread > SPREAD else {}
    return coordinates + [
        Hypothesis("unit", alternatives=count, points=factor, sigmas=factor, tip=tip * factor, note="whole")
        for factor in whole
    ]
