"""Least squares over the pose and a few more numbers, for hundreds of hypotheses at once.

A trial is a hypothesis at a pose: it assigns a surface and a weight to each contact, and has further unknowns q. In the
fixture frame, with y = A x + b of a contact x, the residual over sigma is

    plane              (n . (y - a) - t - c . q) / sigma              a = anchor + D q
    sphere, cylinder   (s (|P (y - a)| - r) - t - c . q) / sigma      s = 1 outer, -1 inner

For a tip that is displaced by q in the flange frame, x becomes x + R q, where R is the rotation of the flange at the
contact. Otherwise c = 1 for every contact makes q a change of the tip radius, c = s for the contacts of one feature a
change of its radius, and D holds the directions in which one feature may be displaced. Levenberg-Marquardt; the trials
are the first axis of all arrays, so that numpy and LAPACK work on all of them in one call:

1. Each hypothesis has a row in the arrays (`HypothesisRows`), all lengths in the unit of the search frame: weights are
   one over sigma, zero for deleted contacts; labels select surfaces, and changed surfaces are appended to the table.
2. Residuals and their derivatives are evaluated at the trials.
3. Damped normal equations give each trial a step, its turn and shift together no longer than one.
4. Where chi-square falls the trial takes it, its damping a tenth; else it stays, its damping tenfold.
5. A trial ends when its gain is below TRIAL_GAIN, or its damping above LAST_DAMPING: then no step lowers chi-square.
"""

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from tactfix.diagnosis.hypotheses import Hypothesis, Problem
from tactfix.geometry.arrays import TINY, Bools, Floats, Ints, cross
from tactfix.geometry.surfaces import Cylinder, Plane, Point, SidedSurface, Sphere
from tactfix.poses.search_frame import SearchFrame
from tactfix.values import frozen_value

TRIAL_DAMPING = 1e-4
"""Damping of the first step, as a share of the diagonal of the normal matrix: nearly a Gauss-Newton step, since a trial
starts near a minimum."""
SINGULAR_DAMPING = 1e-9
"""Least damping, as a share of the diagonal: the normal matrix of a free motion is singular without it. The root of the
rounding of doubles is 1.5e-8; below that, damping no longer changes a well determined step."""
LAST_DAMPING = 1e8
"""Damping, as a share of the diagonal, at which a trial ends: 12 steps in a row have failed, and the next one would be
1e-8 of a Gauss-Newton step."""
TRIAL_GAIN = 1e-6
"""A trial has converged when a step lowers chi-square by less than this share of 1 + chi-square: far below the
differences of 10 that decide between hypotheses (`hypotheses.INDISTINCT`)."""


@frozen_value
class SurfaceTable:
    """Surfaces (m) as rows: anchors (m, 3), projectors (m, 3, 3), normals (m, 3), signs (m,), radii (m,)."""

    anchors: Floats
    projectors: Floats
    normals: Floats
    signs: Floats
    radii: Floats

    @staticmethod
    def of(surfaces: Sequence[SidedSurface], origin: Floats, length: float) -> "SurfaceTable":
        """Those of these surfaces, from origin (3,) and in units of length."""
        rows = [_row(surface, origin, length) for surface in surfaces]
        return SurfaceTable(*(np.array(column) for column in zip(*rows, strict=True)))


def _row(surface: SidedSurface, origin: Floats, length: float) -> tuple[Floats, Floats, Floats, float, float]:
    if isinstance(surface, Plane):
        return (surface.point - origin) / length, np.zeros((3, 3)), surface.normal, 0.0, 0.0
    sign = 1.0 if surface.side == "outer" else -1.0
    if isinstance(surface, Sphere):
        return (surface.center - origin) / length, np.eye(3), np.zeros(3), sign, surface.radius / length
    across = np.eye(3) - np.outer(surface.direction, surface.direction)
    return (surface.point - origin) / length, across, np.zeros(3), sign, surface.radius / length


@frozen_value
class WeightedTrials:
    """points (n, 3) in base; flanges (n, 3, 3): rotations of the flange if the tip's place in it is fitted, else None.

    For each of T trials: weights (T, n), surfaces (T, n) by their row in the table, tip radii tips (T, n),
    columns (T, n, k): c, shifts (T, n, 3, k): D, and the unknowns: rotations (T, 3, 3), offsets (T, 3),
    numbers (T, k): q.
    """

    points: Floats
    flanges: Floats | None
    weights: Floats
    surfaces: Ints
    tips: Floats
    columns: Floats
    shifts: Floats
    rotations: Floats
    offsets: Floats
    numbers: Floats

    def take(self, index: Ints) -> "WeightedTrials":
        """Those trials."""
        names = [f.name for f in fields(self)][2:]
        return replace(self, **{name: getattr(self, name)[index] for name in names})


class HypothesisRows:
    """The arrays of the trials, a row for each hypothesis, lengths in the unit of the frame (step 1)."""

    def __init__(self, problem: Problem, frame: SearchFrame, hypotheses: Sequence[Hypothesis]) -> None:
        single = problem.single
        self.problem, self.frame, self.of = problem, frame, single.of
        self.points = (single.contacts.points - frame.base_origin) / frame.length
        self.names = list(single.surfaces)
        self.base = np.array([self.names.index(name) for name in single.contacts.features])
        count, width = len(self.base), max([1, *(h.directions(problem).shape[1] for h in hypotheses)])
        shape = len(hypotheses), count
        self.weights = np.tile(frame.length / single.sigmas, (len(hypotheses), 1))
        self.surfaces = np.tile(self.base, (len(hypotheses), 1))
        self.tips = np.full(shape, problem.contacts.tip_radius / frame.length)
        # A point determines the tip's centre, whatever its radius: its planes stay at the tip radius of the file.
        self.sized = np.array([not isinstance(problem.surfaces[n], Point) for n in problem.contacts.features])[self.of]
        self.columns, self.shifts = np.zeros((*shape, width)), np.zeros((*shape, 3, width))
        flanges = problem.contacts.flange_rotations if {h.free for h in hypotheses} == {"tip_offset"} else None
        self.flanges = None if flanges is None else flanges[single.of]
        changed: list[SidedSurface] = []
        for row, hypothesis in enumerate(hypotheses):
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


@frozen_value
class Fits:
    """Trials after some steps, with residuals (T, n) over sigma, jacobians (T, n, 6 + k) and chi2 (T,) there."""

    trials: WeightedTrials
    residuals: Floats
    jacobians: Floats
    chi2: Floats


def fitted(table: SurfaceTable, trials: WeightedTrials, steps: int) -> Fits:
    """The trials after at most so many steps; none ends with a larger chi-square than it began with."""
    trials = trials.take(np.arange(len(trials.tips)))
    residuals, jacobians = evaluate(table, trials)  # step 2
    chi2 = np.einsum("tn,tn->t", residuals, residuals)
    damping = np.full(len(chi2), TRIAL_DAMPING)
    live = np.arange(len(chi2))
    for _ in range(steps):
        if not len(live):
            break
        ahead = _stepped(trials.take(live), _step(residuals[live], jacobians[live], damping[live]))  # step 3
        new_residuals, new_jacobians = evaluate(table, ahead)
        new_chi2 = np.einsum("tn,tn->t", new_residuals, new_residuals)
        gain = chi2[live] - new_chi2
        better = gain > 0  # step 4
        damping[live] = np.maximum(damping[live] * np.where(better, 0.1, 10.0), SINGULAR_DAMPING)
        took = live[better]
        for name in ("rotations", "offsets", "numbers"):
            getattr(trials, name)[took] = getattr(ahead, name)[better]
        residuals[took], jacobians[took], chi2[took] = new_residuals[better], new_jacobians[better], new_chi2[better]
        # Step 5.
        live = live[~((better & (gain < TRIAL_GAIN * (1 + new_chi2))) | (damping[live] > LAST_DAMPING))]
    return Fits(trials, residuals, jacobians, chi2)


def evaluate(table: SurfaceTable, trials: WeightedTrials) -> tuple[Floats, Floats]:
    """Residuals (T, n) over sigma and their derivatives (T, n, 6 + k): turn and shift in the fixture frame, numbers."""
    points = trials.points
    if trials.flanges is not None:
        points = points + (trials.flanges @ trials.numbers[:, None, :, None])[..., 0]
    turned = points @ np.swapaxes(trials.rotations, 1, 2)
    rows, numbers = trials.surfaces, trials.numbers[:, None, :, None]
    arms = turned + trials.offsets[:, None] - table.anchors[rows] - (trials.shifts @ numbers)[..., 0]
    flat = (table.projectors[rows] @ arms[..., None])[..., 0]
    sizes = np.sqrt(np.einsum("tni,tni->tn", flat, flat))
    signs, normals = table.signs[rows], table.normals[rows]
    gradients = normals + (signs / np.where(sizes > 0, sizes, 1.0))[..., None] * flat
    residuals = np.einsum("tni,tni->tn", normals, arms) + signs * (sizes - table.radii[rows])
    residuals -= trials.tips + (trials.columns @ numbers[:, 0])[..., 0]
    along = (np.swapaxes(trials.shifts, 2, 3) @ gradients[..., None])[..., 0] + trials.columns
    if trials.flanges is not None:
        along = -np.einsum("tni,tij,njk->tnk", gradients, trials.rotations, trials.flanges)
    jacobians = np.concatenate([cross(turned, gradients), gradients, -along], axis=2)
    return residuals * trials.weights, jacobians * trials.weights[..., None]


def _step(residuals: Floats, jacobians: Floats, damping: Floats) -> Floats:
    """Damped steps (T, 6 + k), turn and shift together no longer than one; an unknown without any derivative stays."""
    normal = np.swapaxes(jacobians, 1, 2) @ jacobians
    gradient = np.swapaxes(jacobians, 1, 2) @ residuals[..., None]
    diagonal = np.einsum("tii->ti", normal)
    largest = diagonal.max(axis=1, keepdims=True) + TINY
    diagonal += damping[:, None] * diagonal + np.where(diagonal < 1e-12 * largest, largest, 0.0)
    step = -np.linalg.solve(normal, gradient)[..., 0]
    return np.asarray(step / np.maximum(1.0, np.linalg.norm(step[:, :6], axis=1))[:, None])


def _stepped(trials: WeightedTrials, step: Floats) -> WeightedTrials:
    return replace(
        trials,
        rotations=_turns(step[:, :3]) @ trials.rotations,
        offsets=trials.offsets + step[:, 3:6],
        numbers=trials.numbers + step[:, 6:],
    )


def _turns(vectors: Floats) -> Floats:
    """Rotations (T, 3, 3) by about the rotation vectors (T, 3): Cayley's map, a rotation for any length."""
    half = vectors / 2
    skew = np.zeros((len(half), 3, 3))
    skew[:, [2, 0, 1], [1, 2, 0]] = half
    skew[:, [1, 2, 0], [2, 0, 1]] = -half
    square = np.einsum("ti,ti->t", half, half)
    return np.asarray(np.eye(3) + 2 * (skew + skew @ skew) / (1 + square)[:, None, None])
