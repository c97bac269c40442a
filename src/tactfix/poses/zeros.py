"""Sets of zeros of the pose equations: which are the same, how often each was met, and what is a free motion.

Whether one is missing, six equations tell: the signs of the Jacobian's determinant cancel. The six residuals map poses,
rotations times translations, to six numbers. Where no translation is free for all contacts together the map is proper:
a fixture far away is far from some contact. The poses that take a given value then have determinants of the Jacobian of
both signs whose sum does not depend on the value: the degree of the map (Milnor, Topology from the Differentiable
Viewpoint, section 5). A contact cannot be nearer to an axis or centre than zero, so some values are taken nowhere, and
the degree is 0. Planes have it too: with other offsets no mirror image fits. As many poses have one sign as the other,
and where the signs of those found do not cancel, some are missing. Two missing ones of opposite signs go unnoticed.

Where directions are held (`pose_domain`) the same is true of as many equations as unknowns, but for turns about two
axes, which have no orientation, and for planes alone: shifts take any values there, each once.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.geometry.arrays import TINY, Bools, Floats, Ints
from tactfix.poses.equations import PoseEquations, evaluate, translation_matrix
from tactfix.values import frozen_value

MOST_ZEROS = 600
"""More zeros than any minimal problem has (512 complex ones for six cylinders): a continuum, not a set of poses."""
SAME_POSE = 1e-5
"""Largest entry by which two meetings of one zero differ: far above what convergence leaves, far below two zeros."""
NEARBY = 0.05
"""The same for zeros that noise, or rounding at a multiple one, may have made of one."""
SINGULAR = 1e-5
"""A zero whose Jacobian has a smaller ratio of singular values is a double root or a sample of a continuum."""
SCATTER = 0.02
"""Largest entry by which the ends of descents to one multiple zero differ: at one of order four, a few thousandths."""
MOST_SINGULAR = 12
"""More such zeros than this mean a continuum: no known problem has that many double roots."""
MOST_WELL_DETERMINED = 128
"""Well determined poses beside a continuum; more of them are samples of one that is not quite free."""
EXACT_COST = 1e-20
"""Cost below which a pose is a zero of the equations, and not a minimum that noise would explain."""
SIMPLE_ZERO = 1e-4
"""Ratio of singular values below which two poses may have met in one: its sign may be either, or none."""


@frozen_value
class Zeros:
    """A set of poses fixture_from_base at which the equations hold, and what is known of the set.

    rotations (3, 3, k), offsets (3, k); costs (k,): sums of squared weighted residuals; counts (k,): how often each was
    met. complete: the last round found nothing new, every pose was met at least twice, and those of six equations
    balance. continuum: they are samples of a free motion.
    """

    rotations: Floats
    offsets: Floats
    costs: Floats
    counts: Ints
    complete: bool = False
    continuum: bool = False

    def __len__(self) -> int:
        return len(self.costs)

    @staticmethod
    def none() -> "Zeros":
        """The empty set."""
        return Zeros(np.zeros((3, 3, 0)), np.zeros((3, 0)), np.zeros(0), np.zeros(0, dtype=np.intp))

    @property
    def entries(self) -> Floats:
        """Rotation and offset of each in a row (k, 12): what zeros are compared by."""
        return np.concatenate([self.rotations.reshape(9, -1), self.offsets]).T

    def subset(self, index: Ints | Bools) -> "Zeros":
        """Those with these numbers."""
        return replace(
            self,
            rotations=self.rotations[..., index],
            offsets=self.offsets[:, index],
            costs=self.costs[index],
            counts=self.counts[index],
        )

    def best(self, most: int) -> "Zeros":
        """At most so many of them, those of the lowest costs, best first."""
        return self.subset(np.argsort(self.costs, kind="stable")[:most])

    def since(self, number: int) -> "Zeros":
        """Those from a number on."""
        return self.subset(np.arange(number, len(self)))

    def with_twins(self, turns: Sequence[Floats]) -> "Zeros":
        """The poses, and behind them those that each symmetry of the fixture, a rotation (3, 3), makes of them."""
        twins = [
            replace(self, rotations=np.einsum("ab,bcN->acN", turn, self.rotations), offsets=turn @ self.offsets)
            for turn in turns
        ]
        return together([self, *twins]) if twins else self

    def joined(self, found: "Zeros") -> "Zeros":
        """These, each met as often more as it is in found, and behind them the new ones of found."""
        counts, rest, entries = self.counts.copy(), np.arange(len(found)), found.entries
        for number, own in enumerate(self.entries):
            same = _same(entries, own)
            if same.any():
                counts[number] += int(same.sum())
                rest, entries = rest[~same], entries[~same]
        fresh: list[int] = []
        met: list[int] = []
        while len(rest) and len(self) + len(fresh) <= MOST_ZEROS:
            same = _same(entries, entries[0])
            fresh.append(int(rest[0]))
            met.append(int(same.sum()))
            rest, entries = rest[~same], entries[~same]
        new = found.subset(np.array(fresh, dtype=np.intp))
        return together([replace(self, counts=counts), replace(new, counts=np.array(met, dtype=np.intp))])

    def met_nearby(self) -> Ints:
        """How often zeros next to each were met (k,): the ends at a nearly multiple one scatter."""
        entries = self.entries
        gaps = np.abs(entries[:, None] - entries[None]).max(axis=2)
        return np.asarray((gaps < NEARBY) @ self.counts)

    def merged(self, equations: PoseEquations) -> "Zeros":
        """Those without the scatter of multiple ones; a continuum where they are samples of a free motion.

        They are where they are too many, or those with a singular Jacobian are too many and stretch on and on. Around a
        multiple zero the ends of descents scatter: those with a singular Jacobian that lie close together become one,
        the first one met.
        """
        if equations.dof < 0 or len(self) > MOST_ZEROS:
            return replace(self, continuum=True)
        singular = np.flatnonzero(self.condition(equations) < SINGULAR)
        centres: list[int] = []
        stays, counts, entries = np.ones(len(self), dtype=bool), self.counts.copy(), self.entries
        for number in singular.tolist():
            gaps = np.abs(entries[centres] - entries[number]).max(axis=1)
            if gaps.min(initial=np.inf) > SCATTER:
                centres.append(number)
            else:
                stays[number] = False
                counts[centres[int(np.argmin(gaps))]] += counts[number]
        if len(centres) > MOST_SINGULAR:
            return replace(self, continuum=True)
        return replace(self, counts=counts, continuum=False).subset(stays)

    def split_off(self, equations: PoseEquations, most: int) -> "Zeros":
        """Of a continuum at most so many, spread over the list, and before them the poses that are well determined.

        Contacts in a special position may leave a motion free in some poses and not in others: the true one is any of
        them.
        """
        condition = self.condition(equations)
        count = int((condition >= SINGULAR).sum())
        well = np.argsort(-condition, kind="stable")[: count if count <= MOST_WELL_DETERMINED else most]
        singular = np.flatnonzero(condition < SINGULAR)
        spread = np.linspace(0, len(singular) - 1, min(most, len(singular))).astype(np.intp)
        return self.subset(np.concatenate([well, singular[spread]]))

    def condition(self, equations: PoseEquations) -> Floats:
        """How well each is determined (k,): the smallest singular value of the Jacobian over the largest.

        Where directions are held it may be the only one, and the contacts' weights say how large it should be.
        """
        if equations.dof < 0:
            return np.zeros(len(self))
        _, jacobian = evaluate(equations, self.rotations, self.offsets, geometric=False)
        values = np.linalg.svd(np.moveaxis(jacobian, -1, 0), compute_uv=False)
        least = TINY if equations.domain.is_free else np.linalg.norm(equations.weights)
        return np.asarray(values[:, -1] / np.maximum(values[:, 0], least))


def together(parts: Sequence[Zeros]) -> Zeros:
    """All of them in one, none of them compared; complete and continuum as of the first."""
    rotations, offsets, costs, counts = (
        np.concatenate([getattr(part, name) for part in parts], axis=-1)
        for name in ("rotations", "offsets", "costs", "counts")
    )
    return replace(parts[0], rotations=rotations, offsets=offsets, costs=costs, counts=counts)


def _same(entries: Floats, own: Floats) -> Bools:
    return np.asarray(np.abs(entries - own).max(axis=1) < SAME_POSE)


def are_balanced(equations: PoseEquations, zeros: Zeros) -> bool:
    """Whether these may be all; true where it cannot be told.

    A pose that is no exact zero, or nearly a double one, may have either sign.
    """
    if not _signs_cancel(equations):
        return True
    _, jacobian = evaluate(equations, zeros.rotations, zeros.offsets, geometric=False)
    matrices = np.moveaxis(jacobian, -1, 0)
    values = np.linalg.svd(matrices, compute_uv=False)
    sure = (values[:, -1] > SIMPLE_ZERO * values[:, 0]) & (zeros.costs < EXACT_COST)
    signs = np.linalg.slogdet(matrices)[0][sure]
    return bool(abs(signs.sum()) <= np.count_nonzero(~sure))


def _signs_cancel(equations: PoseEquations) -> bool:
    """Whether the degree of the map is known to be zero, and all its zeros are searched for."""
    domain = equations.domain
    if equations.dof or equations.measured or domain.reach < np.pi:
        return False
    if domain.is_free:
        return True
    is_proper = np.linalg.matrix_rank(translation_matrix(equations), tol=SIMPLE_ZERO) == 3
    return bool(domain.turns.sum() != 2 and (equations.radii > 0).any() and is_proper)
