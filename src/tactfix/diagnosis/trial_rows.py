"""The arrays of trials (`trial_fits`): one row for each hypothesis, in the units of the search frame.

1. The contacts, one equation each, and the touched surfaces are scaled to the frame.
2. Every row starts as the problem without a mistake: weights of one over sigma, each contact on its own surface.
3. A hypothesis changes its row: weights of deleted contacts are zero, labels select other surfaces, changed surfaces
   are appended to the table, and free numbers get their columns or directions.
"""

from collections.abc import Sequence

import numpy as np

from tactfix.diagnosis.hypotheses import Hypothesis, Problem
from tactfix.diagnosis.trial_fits import SurfaceTable
from tactfix.geometry.arrays import Bools
from tactfix.geometry.surfaces import Cylinder, Point, SidedSurface, Sphere
from tactfix.poses.search_frame import SearchFrame


class HypothesisRows:
    """The arrays of the trials, a row for each hypothesis, lengths in the unit of the frame."""

    def __init__(self, problem: Problem, frame: SearchFrame, hypotheses: Sequence[Hypothesis]) -> None:
        single = problem.single  # step 1
        self.problem, self.frame, self.of = problem, frame, single.of
        self.points = (single.contacts.points - frame.base_origin) / frame.length
        self.names = list(single.surfaces)
        self.base = np.array([self.names.index(name) for name in single.contacts.features])
        count, width = len(self.base), max([1, *(h.directions(problem).shape[1] for h in hypotheses)])
        shape = len(hypotheses), count
        # Step 2.
        self.weights = np.tile(frame.length / single.sigmas, (len(hypotheses), 1))
        self.surfaces = np.tile(self.base, (len(hypotheses), 1))
        self.tips = np.full(shape, problem.contacts.tip_radius / frame.length)
        # A point holds the tip's centre, whatever its radius: its planes stay where the reported one puts them.
        self.sized = np.array([not isinstance(problem.surfaces[n], Point) for n in problem.contacts.features])[self.of]
        self.columns, self.shifts = np.zeros((*shape, width)), np.zeros((*shape, 3, width))
        flanges = problem.contacts.flange_rotations if {h.free for h in hypotheses} == {"tip_offset"} else None
        self.flanges = None if flanges is None else flanges[single.of]
        changed: list[SidedSurface] = []
        for row, hypothesis in enumerate(hypotheses):  # step 3
            self._fill(row, hypothesis, changed)
        table = [*single.surfaces.values(), *changed]
        self.table = SurfaceTable.of(table, frame.fixture_origin, frame.length)

    def _fill(self, row: int, hypothesis: Hypothesis, changed: list[SidedSurface]) -> None:
        self.weights[row, np.isin(self.of, hypothesis.deleted)] = 0.0
        if hypothesis.tip is not None:
            self.tips[row, self.sized] = hypothesis.tip / self.frame.length
        if hypothesis.labels is not None:
            for i in hypothesis.index:
                self.surfaces[row, self.of == i] = self.names.index(hypothesis.labels[i])
        for name, surface in hypothesis.surfaces.items():
            self.surfaces[row, self._on(name)] = len(self.names) + len(changed)
            changed.append(_sided(surface))
        if hypothesis.free == "tip":
            self.columns[row, self.sized, 0] = 1.0
        elif hypothesis.free == "radius":
            surface = self.problem.surfaces[hypothesis.features[0]]
            assert isinstance(surface, Sphere | Cylinder)
            self.columns[row, self._on(hypothesis.features[0]), 0] = 1.0 if surface.side == "outer" else -1.0
        elif hypothesis.free == "place":
            directions = hypothesis.directions(self.problem)
            self.shifts[row, self._on(hypothesis.features[0]), :, : directions.shape[1]] = directions

    def _on(self, feature: str) -> Bools:
        return np.asarray(np.array(self.problem.contacts.features)[self.of] == feature)


def _sided(surface: object) -> SidedSurface:
    assert isinstance(surface, SidedSurface)
    return surface
