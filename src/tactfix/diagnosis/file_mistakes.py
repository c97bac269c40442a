"""Mistakes that a whole contact file shares: its unit and its tip radius."""

from tactfix.diagnosis.corrections import Hypothesis, Problem
from tactfix.diagnosis.file_faults import UNITS_MEANT


def tips(problem: Problem) -> list[Hypothesis]:
    """Another tip radius than the file says: none, or the one that fits best."""
    free = Hypothesis("tip_radius", free="tip", alternatives=2)
    return [free] if problem.contacts.tip_radius == 0 else [free, Hypothesis("tip_radius", tip=0.0, alternatives=2)]


def units(problem: Problem) -> list[Hypothesis]:
    """The coordinates alone, or all lengths, in another unit than the file says."""
    count, tip = 2 * len(UNITS_MEANT), problem.contacts.tip_radius
    coordinates = [Hypothesis("unit", alternatives=count, points=factor) for factor in UNITS_MEANT]
    return coordinates + [
        Hypothesis("unit", alternatives=count, points=factor, sigmas=factor, tip=tip * factor, note="whole")
        for factor in UNITS_MEANT
    ]
