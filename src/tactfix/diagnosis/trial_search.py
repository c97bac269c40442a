"""The least chi-square of each hypothesis: fits from the poses that most contacts agree on.

1. Robust fits give the poses that most contacts agree on (`robust_poses`). With a mistake in a few contacts or in one
   feature the true pose is one of them.
2. Every hypothesis is fitted for a few steps from each of these poses that is possible for it, all side by side
   (`trial_fits`).
3. The most plausible are fitted to convergence; fits that end at one pose are merged.
4. Hypotheses that concern all contacts (a unit, features exchanged) are searched for from all rotations.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations

import numpy as np

from tactfix.diagnosis.deletion import falls_without, span_of
from tactfix.diagnosis.feasibility import least_chi_square
from tactfix.diagnosis.hypotheses import Explanation, Hypothesis, Problem
from tactfix.diagnosis.trial_fits import Fits, HypothesisRows, SurfaceTable, WeightedTrials, evaluate, fitted
from tactfix.errors import TactfixError
from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.geometry.rigid import homogeneous, inverse
from tactfix.noise import chi_square_limit
from tactfix.poses.all_poses import all_poses
from tactfix.poses.pose_fit import PoseFit
from tactfix.poses.robust_poses import BOUND, ONE_POSE, robust_poses
from tactfix.poses.search_frame import SearchFrame

ROBUST_POSES = 8
"""Robust poses that trials start from, in addition to the known ones. The true pose need not be the best of them: wrong
contacts, and the symmetry of a fixture, make others as good."""
FEW_STARTS = 120
"""Start rotations of a search for a hypothesis that concerns all contacts. With 120 all 31 such hypotheses that explain
contacts of `tests.validation.diagnosis` were found, as with more. With few contacts on four features there are dozens
of searches."""
TRIAL_STEPS, FITTING_STEPS = 3, 30
"""Levenberg-Marquardt steps of every trial, and of those that are fitted to convergence."""
HYPOTHESES_FITTED = 80
"""Hypotheses that are fitted to convergence: the most plausible after TRIAL_STEPS, by chi-square and penalty. 40
give the same diagnoses of 27 contact sets, a quarter of the draws 0 of `tests.validation.diagnosis`."""
POSES_FOLLOWED = 6
"""Poses from which each of these hypotheses is fitted to convergence, at most: nearly as many as ROBUST_POSES, those
that have met as one."""
CHI2_WINDOW = 10.0
"""Largest difference of chi-square between the best pose of a hypothesis and others that are kept for the tests by
approach and touch box: as `hypotheses.INDISTINCT`, beyond which another pose is not plausible."""
IN_PLACE_SIGMAS = 3.0
"""Residual, in sigma, up to which a contact fits its feature: a pose at which it does is no start for another label
of it. Good contacts exceed three sigma once in 370 cases."""
LEAST_AGREEING = 0.5
"""Share of the other contacts that must have residuals within BOUND sigma at a pose, for a mistake in a few contacts
to be fitted from there: if fewer than half agree, others than these are wrong. With 0.75 one of the 12 sets of
SETS_TRIED loses its diagnosis."""
SETS_TRIED = 12
"""Sets of contacts that are deleted together, for each pose, in decreasing order of the fall of chi-square. 4 and 36
name the same contacts first in all 12 sets with two or three wrong ones of draw 0 of `tests.validation.diagnosis`;
36 add less plausible entries to two of them."""


class TrialSearch:
    """One problem, and the poses from which hypotheses on it are fitted: the known ones, and robust ones."""

    def __init__(self, problem: Problem, known: Sequence[Floats] = (), *, most_robust: int = ROBUST_POSES) -> None:
        self.problem = problem
        self.single = problem.single
        self.frame = SearchFrame.of(self.single.surfaces, self.single.contacts)
        self.rotations, self.offsets = self._poses(known, most_robust)  # step 1

    def _poses(self, known: Sequence[Floats], most_robust: int) -> tuple[Floats, Floats]:
        turns = np.array([pose[:3, :3].T for pose in known]).reshape(-1, 3, 3)
        origins = np.array([self.frame.base_origin - pose[:3, 3] for pose in known]).reshape(-1, 3)
        shifts = ((turns @ origins[..., None])[..., 0] - self.frame.fixture_origin) / self.frame.length
        if not most_robust:
            return turns, shifts
        smallest = float(self.single.sigmas.min())
        equations = self.frame.equations(self.single.surfaces, self.single.contacts, smallest / self.single.sigmas)
        robust = robust_poses(equations, smallest / self.frame.length, most_robust)
        return np.concatenate([robust.rotations, turns]), np.concatenate([robust.offsets, shifts])

    def explanations(self, hypotheses: Sequence[Hypothesis]) -> list[Explanation]:
        """The most plausible hypotheses at their best poses, most plausible first.

        A displaced tip is fitted in a call of its own: it moves each contact in another direction.
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
        """The explanation from the fits of one hypothesis, best first."""
        numbers = 0 if hypothesis.free is None else hypothesis.directions(self.problem).shape[1]
        values = self.frame.length * fits.trials.numbers[:, :numbers]
        first, *others = (
            Explanation(hypothesis, values[k], self._pose(fits, k), float(fits.chi2[k]), float(fits.chi2[k]) + penalty)
            for k in ends
            if fits.chi2[k] <= fits.chi2[ends[0]] + CHI2_WINDOW
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
        """Symmetries (4, 4) of the fixture, in its frame: a pose followed by one of them fits as well."""
        centre = homogeneous(np.eye(3), self.frame.fixture_origin)
        turns = self.frame.half_turns(self.single.surfaces, self.single.contacts)
        return [centre @ homogeneous(turn, np.zeros(3)) @ inverse(centre) for turn in turns]

    def _trials(self, hypotheses: Sequence[Hypothesis]) -> tuple[SurfaceTable, WeightedTrials, Ints]:
        """Trials of the hypotheses from their promising poses, and the number (T,) of the hypothesis of each trial."""
        rows = HypothesisRows(self.problem, self.frame, hypotheses)
        promising = np.array([self._promising_poses(hypothesis) for hypothesis in hypotheses])
        of, pose = np.nonzero(promising)
        trials = WeightedTrials(
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

    def _promising_poses(self, hypothesis: Hypothesis) -> Bools:
        """Which of the poses (k,) may be near the pose of the hypothesis.

        For a mistake in a few contacts the others must mostly agree there; a label must not fit as given.
        """
        if not hypothesis.index:
            return np.ones(len(self.rotations), dtype=bool)
        concerned = np.isin(self.single.of, hypothesis.index)
        sizes = np.abs(self._at_poses.residuals)
        others = np.count_nonzero(sizes[:, ~concerned] <= BOUND, axis=1) >= LEAST_AGREEING * np.count_nonzero(
            ~concerned
        )
        if hypothesis.labels is None:
            return np.asarray(others)
        return np.asarray(others & (sizes[:, concerned] > IN_PLACE_SIGMAS).all(axis=1))

    @cached_property
    def _at_poses(self) -> Fits:
        """Residuals and Jacobians of the unchanged problem at the poses."""
        table, trials, _ = self._trials([NO_CHANGE])
        return Fits(trials, *evaluate(table, trials), np.zeros(0))

    def sets_to_leave_out(self, size: int) -> list[tuple[int, ...]]:
        """Sets of so many contacts whose deletion lowers chi-square most, to first order at each pose."""
        sets = np.array(list(combinations(range(len(self.single.contacts)), size)))
        found: dict[tuple[int, ...], None] = {}
        for residuals, jacobian in zip(self._at_poses.residuals, self._at_poses.jacobians, strict=True):
            falls = falls_without(residuals, span_of(jacobian[:, :6]), sets)
            best = np.argsort(-falls, kind="stable")[:SETS_TRIED]
            found |= dict.fromkeys(tuple(sorted(set(self.single.of[sets[k]].tolist()))) for k in best)
        # Two equations of a set may belong to one contact on a point.
        return [chosen for chosen in found if len(chosen) == size]


NO_CHANGE = Hypothesis("sigma")
"""The hypothesis that changes nothing."""


def searched_anew(problem: Problem, hypotheses: Iterable[Hypothesis]) -> list[Explanation]:
    """The feasible ones of hypotheses that concern all contacts, each at its best poses."""
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
    """The trials of the most plausible hypotheses, POSES_FOLLOWED of each, one for each pose that they have reached."""
    taken: dict[int, list[int]] = {}
    for number in np.argsort(begun.chi2 + penalties, kind="stable").tolist():
        hypothesis = int(of[number])
        if hypothesis not in taken and len(taken) == HYPOTHESES_FITTED:
            continue
        already = taken.setdefault(hypothesis, [])
        if len(already) < POSES_FOLLOWED and not _is_any(begun.trials, number, already):
            already.append(number)
    return np.array([number for numbers in taken.values() for number in numbers], dtype=np.intp)


def _is_any(trials: WeightedTrials, number: int, others: Sequence[int]) -> bool:
    """Whether a trial has the pose of one of the others."""
    return any(
        np.abs(trials.rotations[number] - trials.rotations[k]).max() < ONE_POSE
        and np.abs(trials.offsets[number] - trials.offsets[k]).max() < ONE_POSE
        for k in others
    )
