"""How well each hypothesis explains the contacts: fits from the poses that most contacts agree on.

1. Mistakes in a few contacts or in one feature leave the pose that all others agree on where it is (`robust_poses`).
2. All are tried at once, a few steps (`trial_fits`) from each such pose that they can be found from.
3. The most plausible so far are fitted to the end, and ends that have met count as one.
4. What changes everything (a unit, features taken for each other) is searched for anew.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations

import numpy as np

from tactfix.diagnosis.corrections import Hypothesis, Problem
from tactfix.diagnosis.deletion import span_of
from tactfix.diagnosis.feasibility import least_chi_square
from tactfix.diagnosis.trial_fits import Fits, SurfaceTable, Trials, evaluate, fitted
from tactfix.errors import TactfixError
from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.geometry.rigid import homogeneous, inverse
from tactfix.geometry.surfaces import Cylinder, SidedSurface, Sphere
from tactfix.noise import chi_square_limit
from tactfix.poses.all_poses import all_poses
from tactfix.poses.pose_fit import PoseFit
from tactfix.poses.robust_poses import BOUND, ONE_POSE, robust_poses
from tactfix.poses.search_frame import SearchFrame
from tactfix.values import frozen_value

POSES = 8
"""Poses that trials start from, beside those known: those that most contacts agree on."""
FEW_STARTS = 120
"""Rotations from which a problem is searched that is changed as a whole: of 31 that explain contacts of the study it
found all, as more did, and with few contacts on four features dozens are to be searched."""
TRIAL_STEPS, FITTING_STEPS = 3, 30
"""Steps of every trial, and of those that are fitted to the end."""
HYPOTHESES_FITTED = 80
"""Hypotheses that are fitted to the end: the most plausible after TRIAL_STEPS, by chi-square and penalty."""
FROM = 6
"""Poses from which each of these hypotheses is."""
WORSE = 10.0
"""By so much chi-square may be larger at other poses that are looked at."""
IN_PLACE_SIGMAS = 3.0
"""Sigmas within which a contact is where it should be, at a pose from which other labels are tried for it."""
MOST_AGREE = 0.5
"""Share of the contacts not concerned that agree within BOUND sigma at poses from which a few contacts are doubted."""
SETS = 12
"""Sets of contacts that are left out, for each pose, those first without which chi-square falls most."""
CORRELATED = 1e-9
"""Is added to the diagonal where contacts left out together leave nothing to judge them by."""


@frozen_value
class Explanation:
    """A hypothesis, values (k,) that were fitted (changes in fixture units), the pose (4, 4), what is left of chi2.

    score: chi2 and the penalty of the hypothesis, the smaller the more plausible. others: the same at further poses
    that are as good or nearly so, and at twins of these by the fixture's symmetry.
    """

    hypothesis: Hypothesis
    values: Floats
    base_from_fixture: Floats
    chi2: float
    score: float
    others: tuple["Explanation", ...] = ()

    @property
    def ways(self) -> tuple["Explanation", ...]:
        """It and the others, best first."""
        return (self, *self.others)


class TrialSearch:
    """One problem and the poses that trials of hypotheses on it start from."""

    def __init__(self, problem: Problem, known: Sequence[Floats] = ()) -> None:
        self.problem = problem
        self.single = problem.single
        self.frame = SearchFrame.of(self.single.surfaces, self.single.contacts)
        self.rotations, self.offsets = self._poses(known)  # step 1

    def _poses(self, known: Sequence[Floats]) -> tuple[Floats, Floats]:
        smallest = float(self.single.sigmas.min())
        equations = self.frame.equations(self.single.surfaces, self.single.contacts, smallest / self.single.sigmas)
        robust = robust_poses(equations, smallest / self.frame.length, POSES)
        turns = np.array([pose[:3, :3].T for pose in known]).reshape(-1, 3, 3)
        origins = np.array([self.frame.base_origin - pose[:3, 3] for pose in known]).reshape(-1, 3)
        shifts = ((turns @ origins[..., None])[..., 0] - self.frame.fixture_origin) / self.frame.length
        return np.concatenate([robust.rotations, turns]), np.concatenate([robust.offsets, shifts])

    def explanations(self, hypotheses: Sequence[Hypothesis]) -> list[Explanation]:
        """Each of the most plausible hypotheses where it fits best, most plausible first.

        A tip elsewhere in the flange is looked for alone: it moves each contact in another direction.
        """
        if not hypotheses:
            return []
        table, trials, of = self._trials(hypotheses)
        if not len(of):
            return []
        begun = fitted(table, trials, TRIAL_STEPS)  # step 2
        penalties = np.array([hypothesis.penalty(self.problem) for hypothesis in hypotheses])
        followed = _most_plausible(begun, penalties[of], of)
        ended = fitted(table, begun.trials.take(followed), FITTING_STEPS)  # step 3
        ends: dict[int, list[int]] = {}
        for number in np.argsort(ended.chi2, kind="stable").tolist():
            already = ends.setdefault(int(of[followed[number]]), [])
            if not _is_any(ended.trials, number, already):
                already.append(number)
        found = [self._explanation(hypotheses[h], ended, numbers, float(penalties[h])) for h, numbers in ends.items()]
        return sorted(found, key=lambda explanation: explanation.score)

    def _explanation(self, hypothesis: Hypothesis, fits: Fits, ends: Sequence[int], penalty: float) -> Explanation:
        """The hypothesis by its trials, best first."""
        numbers = 0 if hypothesis.free is None else hypothesis.directions(self.problem).shape[1]
        values = self.frame.length * fits.trials.numbers[:, :numbers]
        first, *others = (
            Explanation(hypothesis, values[k], self._pose(fits, k), float(fits.chi2[k]), float(fits.chi2[k]) + penalty)
            for k in ends
            if fits.chi2[k] <= fits.chi2[ends[0]] + WORSE
        )
        twins = [
            replace(way, base_from_fixture=way.base_from_fixture @ turn)
            for way in (first, *others)
            for turn in self._half_turns
        ]
        return replace(first, others=(*others, *twins))

    def _pose(self, fits: Fits, number: int) -> Floats:
        turn, offset = fits.trials.rotations[number], fits.trials.offsets[number]
        origin = self.frame.length * offset + self.frame.fixture_origin - turn @ self.frame.base_origin
        return np.asarray(inverse(homogeneous(turn, origin)))

    @cached_property
    def _half_turns(self) -> list[Floats]:
        """Motions (4, 4) of the fixture frame that lay every surface on itself: at each of them a pose fits as well."""
        centre = homogeneous(np.eye(3), self.frame.fixture_origin)
        turns = self.frame.half_turns(self.single.surfaces, self.single.contacts)
        return [centre @ homogeneous(turn, np.zeros(3)) @ inverse(centre) for turn in turns]

    def _trials(self, hypotheses: Sequence[Hypothesis]) -> tuple[SurfaceTable, Trials, Ints]:
        """A trial of each hypothesis from each pose that it is worth trying from; which hypothesis (T,) each is of."""
        rows = _Rows(self.problem, self.frame, hypotheses)
        worth = np.array([self._worth_trying(hypothesis) for hypothesis in hypotheses])
        of, pose = np.nonzero(worth)
        trials = Trials(
            points=rows.points,
            flanges=rows.flanges,
            weights=rows.weights[of],
            surfaces=rows.surfaces[of],
            tips=rows.tips[of],
            columns=rows.columns[of],
            shifts=rows.shifts[of],
            rotations=self.rotations[pose],
            offsets=self.offsets[pose],
            numbers=np.zeros((len(of), rows.columns.shape[2])),
        )
        return rows.table, trials, of

    def _worth_trying(self, hypothesis: Hypothesis) -> Bools:
        """From which of the poses (k,) it can be found.

        A mistake in a few contacts only from where most others agree; other labels only where their own do not fit.
        """
        if not hypothesis.index:
            return np.ones(len(self.rotations), dtype=bool)
        concerned = np.isin(self.single.of, hypothesis.index)
        sizes = np.abs(self._there.residuals)
        others = np.count_nonzero(sizes[:, ~concerned] <= BOUND, axis=1) >= MOST_AGREE * np.count_nonzero(~concerned)
        if hypothesis.labels is None:
            return np.asarray(others)
        return np.asarray(others & (sizes[:, concerned] > IN_PLACE_SIGMAS).all(axis=1))

    @cached_property
    def _there(self) -> Fits:
        """The contacts as they are at the poses."""
        table, trials, _ = self._trials([NO_CHANGE])
        return Fits(trials, *evaluate(table, trials), np.zeros(0))

    def sets_to_leave_out(self, size: int) -> list[tuple[int, ...]]:
        """Sets of so many contacts without which chi-square falls most, to first order at each pose."""
        sets = np.array(list(combinations(range(len(self.single.contacts)), size)))
        found: dict[tuple[int, ...], None] = {}
        for residuals, jacobian in zip(self._there.residuals, self._there.jacobians, strict=True):
            span = span_of(jacobian[:, :6])
            own = residuals - span @ (span.T @ residuals)
            left = np.eye(len(own)) - span @ span.T + CORRELATED * np.eye(len(own))
            gains = np.linalg.solve(left[sets[:, :, None], sets[:, None, :]], own[sets][..., None])[..., 0]
            best = np.argsort(-np.einsum("si,si->s", own[sets], gains), kind="stable")[:SETS]
            found |= dict.fromkeys(tuple(sorted(set(self.single.of[sets[k]].tolist()))) for k in best)
        # Two equations may be of one contact on a point.
        return [chosen for chosen in found if len(chosen) == size]


NO_CHANGE = Hypothesis("sigma")
"""Nothing is changed."""


def searched_anew(problem: Problem, hypotheses: Iterable[Hypothesis]) -> list[Explanation]:
    """Those of the hypotheses, which change everything, that two contacts do not rule out, each where it fits best."""
    found = []
    for hypothesis in hypotheses:
        try:
            fits = _fits_anew(hypothesis.corrected(problem, np.zeros(0)))  # step 4
        except TactfixError:  # a tip that does not fit into a bore
            continue
        penalty = hypothesis.penalty(problem)
        ways = [
            Explanation(hypothesis, np.zeros(0), fit.base_from_fixture, fit.chi2, fit.chi2 + penalty) for fit in fits
        ]
        if ways:
            found.append(replace(ways[0], others=tuple(ways[1:])))
    return found


def _fits_anew(problem: Problem) -> Sequence[PoseFit]:
    """The poses that explain all of the problem's contacts, best first."""
    if least_chi_square(problem.surfaces, problem.contacts, problem.sigmas) > chi_square_limit(problem.dof):
        return ()
    single = problem.single
    search = all_poses(
        single.surfaces, single.contacts, single.sigmas, with_misses=False, thorough=False, most_starts=FEW_STARTS
    )
    return search.found


def _most_plausible(begun: Fits, penalties: Floats, of: Ints) -> Ints:
    """The trials of the hypotheses that are most plausible as yet, FROM each, those that have met as one."""
    taken: dict[int, list[int]] = {}
    for number in np.argsort(begun.chi2 + penalties, kind="stable").tolist():
        hypothesis = int(of[number])
        if hypothesis not in taken and len(taken) == HYPOTHESES_FITTED:
            continue
        already = taken.setdefault(hypothesis, [])
        if len(already) < FROM and not _is_any(begun.trials, number, already):
            already.append(number)
    return np.array([number for numbers in taken.values() for number in numbers], dtype=np.intp)


def _is_any(trials: Trials, number: int, others: Sequence[int]) -> bool:
    """Whether a trial stands where one of the others does."""
    return any(
        np.abs(trials.rotations[number] - trials.rotations[k]).max() < ONE_POSE
        and np.abs(trials.offsets[number] - trials.offsets[k]).max() < ONE_POSE
        for k in others
    )


class _Rows:
    """The arrays of trials, a row for each hypothesis, in the units of the frame."""

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
        self.tips = np.full(len(hypotheses), problem.contacts.tip_radius / frame.length)
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
            self.tips[row] = hypothesis.tip / self.frame.length
        if hypothesis.labels is not None:
            for i in hypothesis.index:
                self.surfaces[row, self.of == i] = self.names.index(hypothesis.labels[i])
        for name, surface in hypothesis.surfaces.items():
            self.surfaces[row, self._on(name)] = len(self.names) + len(changed)
            changed.append(_sided(surface))
        if hypothesis.free == "tip":
            self.columns[row, :, 0] = 1.0
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
