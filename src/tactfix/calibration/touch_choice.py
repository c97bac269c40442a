"""The choice of touches from a pool, to add to planned ones: the best by a criterion (`touch_plan`).

1. The rows of planned touches and of the pool are scaled by the sigmas of the priors.
2. One touch after the other is added: at a place with the fewest, the one with the best score after those before.
3. Each of them in turn is exchanged for the best one at its place, until none is better (V. V. Fedorov: Theory of
   optimal experiments, 1972).
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, Literal, TypeAlias

import numpy as np

from tactfix.calibration.cell import Cell, Touches
from tactfix.calibration.equations import block, groups_of
from tactfix.calibration.touch_pool import joined
from tactfix.geometry.arrays import Bools, Floats, Ints
from tactfix.values import frozen_value

Criterion: TypeAlias = Literal["worst", "d"]
_ANYWHERE: Final = 10.0
"""Prior sigma of the pose of a place without placement, in units of the spread of its touches: almost no knowledge.
With 24 touches of samples/robot-calibration planned, 5 and 20 change no sigma of 6 or 24 touches more by 2 per cent."""
_ROUNDS: Final = 3
"""Most rounds of exchanges. With 24 touches of samples/robot-calibration planned, 1 and 6 change no sigma of 6 or 24
touches more by 2 per cent: most exchanges pay in the first round."""
_MOST_SCORES: Final = 300
"""Most evaluations of all candidates for exchanges, to bound the time of long plans, in which each exchange gains
least. 150 and 600 change no sigma of 6 or 24 touches more by 2 per cent, on the robot as for _ROUNDS."""


@frozen_value
class _Candidates:
    """The candidates, in units of the priors' sigmas.

    rows (r, m): by all unknowns; own: the rows of each touch; tip (3 n, robot): derivatives of the tip's places by the
    robot's parameters; made (m, m): information matrix before any touch is added.
    """

    rows: Floats
    own: tuple[Ints, ...]
    tip: Floats
    made: Floats
    criterion: Criterion

    def after(self, chosen: Sequence[int]) -> Floats:
        """The score (c,), smaller is better, of the chosen touches with each touch of the pool."""
        rows = self.rows[np.concatenate([self.own[index] for index in chosen])] if chosen else self.rows[:0]
        spread = np.linalg.inv(self.made + rows.T @ rows)
        if self.criterion == "worst":
            return _worst_after(self.rows, spread, self.tip, self.own)
        return _determinant_after(self.rows, spread, self.tip.shape[1], self.own)


def chosen_touches(
    cell: Cell,
    start: Touches,
    pool: Touches,
    poses: Mapping[str, Floats],
    free: Bools,
    prior: Floats,
    moves: Floats,
    add: int,
    criterion: Criterion,
) -> list[int]:
    """The touches of the pool (indices from 0) to add: one after the other, then exchanged for better ones."""
    if not add or not len(pool):
        return []
    # Step 1.
    rows, owners, wide = _rows(cell, joined(start, pool), poses, free)
    # In units of the priors, so that lengths and angles are alike in size.
    rows = rows * np.concatenate([prior[free], wide])
    made = owners <= len(start)
    tip = (moves[:, :, free] * prior[free]).reshape(-1, int(free.sum()))
    own = tuple(np.flatnonzero(owners == row) for row in pool.rows)
    known = rows[made].T @ rows[made] + np.eye(rows.shape[1])
    # Steps 2 and 3.
    return _exchanged(_taken(_Candidates(rows, own, tip, known, criterion), start, pool, add), pool)


def _taken(candidates: _Candidates, start: Touches, pool: Touches, add: int) -> tuple[_Candidates, list[int]]:
    """The touches added one after the other (step 2)."""
    # Evenly over the places: each is left out in turn, and the others must then determine the robot.
    counts = Counter({place: start.places.count(place) for place in pool.places})
    left = set(range(len(pool)))
    chosen: list[int] = []
    while left and len(chosen) < add:
        scores = candidates.after(chosen)
        fewest = min(counts[pool.places[index]] for index in left)
        best = min((i for i in left if counts[pool.places[i]] == fewest), key=lambda index: float(scores[index]))
        left.discard(best)
        counts[pool.places[best]] += 1
        chosen.append(best)
    return candidates, chosen


def _exchanged(taken: tuple[_Candidates, list[int]], pool: Touches) -> list[int]:
    """The touches after exchanges (step 3)."""
    candidates, chosen = taken
    for _ in range(max(1, min(_ROUNDS, _MOST_SCORES // len(chosen)))):
        changed = False
        for number, old in enumerate(chosen):
            others = chosen[:number] + chosen[number + 1 :]
            scores = candidates.after(others)
            here = [i for i, place in enumerate(pool.places) if place == pool.places[old] and i not in others]
            best = min(here, key=lambda index: float(scores[index]))
            if scores[best] < scores[old]:
                chosen[number], changed = best, True
        if not changed:
            break
    return chosen


def _rows(cell: Cell, touches: Touches, poses: Mapping[str, Floats], free: Bools) -> tuple[Floats, Ints, Floats]:
    """Rows (r, m) by free parameters and places, the data row of each (0: a measured pose), sigmas of the places."""
    groups = groups_of(cell, touches)
    blocks = [block(cell, group, poses[group.root], np.zeros(len(free))) for group in groups]
    total = sum(found.place.shape[1] for found in blocks)
    parts, owners, wide, first = [], [], [], 0
    for group, found in zip(groups, blocks, strict=True):
        count = found.place.shape[1]
        places = np.zeros((len(found.robot), total))
        places[:, first : first + count] = found.place
        first += count
        parts.append(np.hstack([found.robot[:, free], places]))
        owners.append(np.array([*group.touches.rows, 0])[found.touch])
        wide.append(np.full(count, _ANYWHERE * found.scale))
    return np.concatenate(parts), np.concatenate(owners), np.concatenate(wide)


def _worst_after(rows: Floats, spread: Floats, tip: Floats, own: Sequence[Ints]) -> Floats:
    """The largest variance of the tip's place after each candidate; tip (3 n, robot): derivatives of its places."""
    robot = tip.shape[1]
    gains = rows @ spread
    now = np.einsum("ij,jk,ik->i", tip, spread[:robot, :robot], tip).reshape(-1, 3).sum(axis=1)
    seen = tip @ gains[:, :robot].T
    scores = np.empty(len(own))
    for which, index in _alike(own):
        blocks = _blocks(rows, gains, index)
        # (3 n, c, k) @ (c, k, k), the squares summed over three coordinates and k rows.
        white = np.einsum("pck,cjk->pcj", seen[:, index], np.linalg.inv(np.linalg.cholesky(blocks)))
        after = now[:, None] - (white**2).sum(axis=2).reshape(len(now), 3, -1).sum(axis=1)
        # The mean breaks ties where no touch changes the worst place.
        scores[which] = after.max(axis=0) + 1e-3 * after.mean(axis=0)
    return scores


def _determinant_after(rows: Floats, spread: Floats, robot: int, own: Sequence[Ints]) -> Floats:
    """The logarithm of the determinant of the robot's covariance after each candidate."""
    gains = rows @ spread
    now, inverse_ = np.linalg.slogdet(spread[:robot, :robot])[1], np.linalg.inv(spread[:robot, :robot])
    scores = np.empty(len(own))
    for which, index in _alike(own):
        blocks, part = _blocks(rows, gains, index), gains[index][:, :, :robot]
        rest = blocks - part @ inverse_ @ np.swapaxes(part, 1, 2)
        scores[which] = now + np.linalg.slogdet(rest)[1] - np.linalg.slogdet(blocks)[1]
    return scores


def _alike(own: Sequence[Ints]) -> Iterator[tuple[Ints, Ints]]:
    """Candidates (c,) with equally many rows, and their rows (c, k)."""
    counts = np.array([len(mine) for mine in own])
    for count in np.unique(counts):
        which = np.flatnonzero(counts == count)
        yield which, np.stack([own[index] for index in which.tolist()])


def _blocks(rows: Floats, gains: Floats, index: Ints) -> Floats:
    """S (c, k, k) of candidates with rows index (c, k)."""
    return np.asarray(np.eye(index.shape[1]) + rows[index] @ np.swapaxes(gains[index], 1, 2))
