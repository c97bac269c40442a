"""The search for the optimal set of touches: an exchange algorithm from many starts, then a pattern search.

1. A start has as many touches as the plan: of features in turn, each a random one that is not crowded.
2. Each touch in turn is replaced by the touch of the pool that gives the best score with the others, until a pass over
   all touches changes nothing.
3. Each touch is moved over its surface in several directions, by steps that are halved in turn, as long as that lowers
   the score (pattern search).

V. V. Fedorov: Theory of optimal experiments, 1972.
"""

import numpy as np

from tactfix.geometry.arrays import Floats, Ints, circle_axes
from tactfix.geometry.surfaces import feet, outward_normals
from tactfix.planning.information import Objective, flat
from tactfix.planning.pool import Pool, Touches, joined
from tactfix.values import frozen_value

WORTH_A_STEP = 1e-6
"""Share by which a step must lower the objective: above rounding, so that exchanges do not cycle."""
_EXCHANGE_PASSES = 25
"""Passes over all contacts at most; the last one changes nothing."""
_POLISH_DIRECTIONS = 12
"""Directions of the pattern search, every 30 degrees."""
_POLISH_STEPS = (0.12, 0.06, 0.03, 0.015, 0.0075)
"""Steps of the pattern search in radii of the fixture, each half the one before."""


@frozen_value
class Choice:
    """A set of chosen touches and its score, smaller is better."""

    touches: Touches
    score: float


@frozen_value
class Search:
    """The objective of a search, its pool, and the touches already made, which are kept."""

    objective: Objective
    pool: Pool
    made: Touches

    def information(self, touches: Touches) -> Floats:
        """Information (6, 6) of the touches and of those already made."""
        new, made = flat(touches.rows), flat(self.made.rows)
        return np.asarray(new.T @ new + made.T @ made)

    def choice(self, touches: Touches) -> Choice:
        """The touches with their score."""
        return Choice(touches, self.objective.score(self.information(touches)))

    def best_in_place(self, chosen: Touches, at: int, offers: Touches) -> tuple[int, float]:
        """The offer that is best in place of chosen[at], and the score with it; inf if all are crowded."""
        rest = chosen.take(np.delete(np.arange(len(chosen)), at))
        scores = self.objective.scores(self.information(rest), offers.rows)
        scores = np.where(self.pool.crowded(offers, joined(self.made, rest)), np.inf, scores)
        best = int(np.argmin(scores))
        return best, float(scores[best])


def pays(new: float, old: float) -> bool:
    """Whether a score is better by more than WORTH_A_STEP."""
    return new < old - WORTH_A_STEP * abs(old)


def started(search: Search, count: int, rng: np.random.Generator) -> Touches:
    """A start of count touches (step 1): features in turn, a random touch of each, not crowded if there is one."""
    touches = search.pool.touches
    order = np.resize(rng.permutation(np.unique(touches.which)), count)
    chosen = touches.take(np.zeros(0, dtype=np.intp))
    for feature in order:
        offers = touches.take(rng.permutation(np.flatnonzero(touches.which == feature)))
        free = ~search.pool.crowded(offers, joined(search.made, chosen))
        chosen = joined(chosen, offers.take(np.array([int(np.argmax(free))])))
    return chosen


def extended(search: Search, smaller: Choice) -> Touches:
    """The touches of a choice, and the touch of the pool that is best with them."""
    offers = search.pool.touches
    scores = search.objective.scores(search.information(smaller.touches), offers.rows)
    scores = np.where(search.pool.crowded(offers, joined(search.made, smaller.touches)), np.inf, scores)
    return joined(smaller.touches, offers.take(np.array([int(np.argmin(scores))])))


def exchanged(search: Search, start: Touches) -> Choice:
    """The set, reached from start, that the exchange of no touch improves (step 2)."""
    current = search.choice(start)
    for _ in range(_EXCHANGE_PASSES):
        before = current
        for at in range(len(start)):
            best, score = search.best_in_place(current.touches, at, search.pool.touches)
            if pays(score, current.score):
                current = Choice(_replaced(current.touches, at, search.pool.touches, best), score)
        if current is before:
            break
    return current


def polished(search: Search, choice: Choice) -> Choice:
    """The choice with each touch moved over its surface as long as that pays, by pattern search (step 3)."""
    for step in _POLISH_STEPS:
        for _ in range(2):
            before = choice
            for at in np.flatnonzero(~search.pool.on_points(choice.touches.which)).tolist():
                offers = _around(search.pool, choice.touches, at, step)
                if len(offers):
                    best, score = search.best_in_place(choice.touches, at, offers)
                    if pays(score, choice.score):
                        choice = Choice(_replaced(choice.touches, at, offers, best), score)
            if choice is before:
                break
    return choice


def _around(pool: Pool, touches: Touches, at: int, step: float) -> Touches:
    """Touches near touches[at] on the same feature that the probe can make."""
    name = pool.names[touches.which[at]]
    surface = pool.access.surfaces[name]
    u, v = circle_axes(touches.normals[at])
    angles = 2 * np.pi * np.arange(_POLISH_DIRECTIONS) / _POLISH_DIRECTIONS
    moves = np.cos(angles)[:, None] * u + np.sin(angles)[:, None] * v
    points = feet(surface, touches.points[at] + step * pool.access.radius * moves)
    normals = np.array(outward_normals(surface, points))
    free = pool.access.can_touch(name, points, normals, -normals)
    return pool.touches_at(np.full(int(free.sum()), touches.which[at]), points[free], normals[free])


def _replaced(touches: Touches, at: int, offers: Touches, best: int) -> Touches:
    """The touches with offers[best] in the place of touches[at]."""
    pick: Ints = np.arange(len(touches))
    pick[at] = len(touches)
    return joined(touches, offers.take(np.array([best]))).take(pick)
