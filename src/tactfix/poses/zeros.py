"""Sets of zeros of the pose equations: equal zeros merged and counted, and samples of a free motion recognized.

Zeros (`Zeros.joined`, `Zeros.merged`):

1. Two zeros are one if no entry of rotation and offset differs by more than SAME_POSE; each meeting is counted.
2. Zeros with a singular Jacobian within SCATTER are one multiple zero.
3. Too many zeros, or too many distinct singular ones, are a continuum.

Balance (`are_balanced`), for six equations: the signs of the Jacobian's determinant cancel over all zeros.

1. The six residuals map poses, rotations times translations, to six numbers. If no translation is free for all contacts
   together, the map is proper: a fixture far away is far from some contact.
2. The sum of the signs over all poses with a given value then does not depend on the value: it is the degree of the map
   (Milnor, Topology from the Differentiable Viewpoint, section 5).
3. A contact cannot be nearer to an axis or centre than zero, so some values are never taken, and the degree is 0.
   Planes have degree 0 too: for other offsets no mirror image fits.
4. So if the signs of the zeros found do not cancel, some are missing. Two missing ones of opposite sign go unnoticed.

With constrained directions (`pose_domain`) the same holds for as many equations as unknowns, except for rotations about
two axes, which have no orientation, and for planes alone, where translations take every value once.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactfix.geometry.arrays import TINY, Bools, Floats, Ints
from tactfix.poses.equations import PoseEquations, evaluate, translation_matrix
from tactfix.values import frozen_value

MOST_ZEROS = 600
"""More zeros than this are a continuum, not a set of poses: no minimal problem is known with more than 512 complex
ones (six cylinders)."""
SAME_POSE = 1e-5
"""Largest difference of two entries (rad, fixture sizes) of one zero that was met twice: far above what convergence
leaves, far below the distance of two zeros. 1e-6 and 1e-4 give the same poses of the trial problems (`search`)."""
NEARBY = 0.05
"""The same for zeros that noise, or rounding at a multiple zero, may have split. 0.02 and 0.1 change none of the
trial problems (`search`)."""
SINGULAR = 1e-5
"""A zero whose Jacobian has a smaller ratio of singular values is a double root or a sample of a continuum. 1e-6 and
1e-4 change none of the trial problems (`search`)."""
SCATTER = 0.02
"""Largest difference of entries of the ends of descents to one multiple zero: at a zero of order four, the fourth
root of rounding, a few thousandths. 0.01 and 0.04 change none of the trial problems (`search`)."""
MOST_SINGULAR = 12
"""More such zeros than this mean a continuum: no known problem has that many double roots. 6 and 24 change none of
the trial problems (`search`)."""
MOST_WELL_DETERMINED = 128
"""Well determined poses that are kept next to a continuum; more are samples of a motion that is nearly free. None of
the trial problems (`search`) has more than 48 poses."""
EXACT_COST = 1e-20
"""Cost below which a pose is an exact zero and not a minimum that noise explains: residuals of 1e-10 of the
fixture's size."""
SIMPLE_ZERO = 1e-4
"""Ratio of singular values below which the sign of the determinant of a zero is not used: two zeros may have merged.
1e-5 and 1e-3 change none of the trial problems (`search`)."""


@frozen_value
class Zeros:
    """A set of k poses fixture_from_base at which the equations hold.

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
        """Those with these indices."""
        return replace(
            self,
            rotations=self.rotations[..., index],
            offsets=self.offsets[:, index],
            costs=self.costs[index],
            counts=self.counts[index],
        )

    def best(self, most: int) -> "Zeros":
        """At most so many, of the lowest costs, best first."""
        return self.subset(np.argsort(self.costs, kind="stable")[:most])

    def since(self, number: int) -> "Zeros":
        """Those from an index on."""
        return self.subset(np.arange(number, len(self)))

    def with_twins(self, turns: Sequence[Floats]) -> "Zeros":
        """The poses, then their images by each symmetry of the fixture, a rotation (3, 3)."""
        twins = [
            replace(self, rotations=np.einsum("ab,bcN->acN", turn, self.rotations), offsets=turn @ self.offsets)
            for turn in turns
        ]
        return together([self, *twins]) if twins else self

    def joined(self, found: "Zeros") -> "Zeros":
        """The union with found, in this order: counts of equal poses are added, new ones appended."""
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
        """How often zeros within NEARBY of each were met (k,): the ends at a nearly multiple zero scatter."""
        entries = self.entries
        gaps = np.abs(entries[:, None] - entries[None]).max(axis=2)
        return np.asarray((gaps < NEARBY) @ self.counts)

    def merged(self, equations: PoseEquations) -> "Zeros":
        """The zeros, those scattered about a multiple zero merged; marked as a continuum if they are samples of one.

        They are a continuum if there are too many, or too many distinct ones with a singular Jacobian. Zeros with a
        singular Jacobian that lie within SCATTER are merged into the first one met.
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
        """The well determined poses of a continuum, then at most so many of its samples, evenly chosen.

        Contacts in special position may leave a motion free in some poses and not in others, and any may be the true
        one.
        """
        condition = self.condition(equations)
        count = int((condition >= SINGULAR).sum())
        well = np.argsort(-condition, kind="stable")[: count if count <= MOST_WELL_DETERMINED else most]
        singular = np.flatnonzero(condition < SINGULAR)
        spread = np.linspace(0, len(singular) - 1, min(most, len(singular))).astype(np.intp)
        return self.subset(np.concatenate([well, singular[spread]]))

    def condition(self, equations: PoseEquations) -> Floats:
        """The smallest singular value of each Jacobian over the largest (k,).

        With constrained directions there may be only one; the largest is then at least the norm of the weights.
        """
        if equations.dof < 0:
            return np.zeros(len(self))
        _, jacobian = evaluate(equations, self.rotations, self.offsets, geometric=False)
        values = np.linalg.svd(np.moveaxis(jacobian, -1, 0), compute_uv=False)
        least = TINY if equations.domain.is_free else np.linalg.norm(equations.weights)
        return np.asarray(values[:, -1] / np.maximum(values[:, 0], least))


def together(parts: Sequence[Zeros]) -> Zeros:
    """The concatenation of all parts, without comparison; complete and continuum as of the first."""
    rotations, offsets, costs, counts = (
        np.concatenate([getattr(part, name) for part in parts], axis=-1)
        for name in ("rotations", "offsets", "costs", "counts")
    )
    return replace(parts[0], rotations=rotations, offsets=offsets, costs=costs, counts=counts)


def _same(entries: Floats, own: Floats) -> Bools:
    return np.asarray(np.abs(entries - own).max(axis=1) < SAME_POSE)


def are_balanced(equations: PoseEquations, zeros: Zeros) -> bool:
    """Whether these may be all zeros: the signs of their determinants must cancel. True if the test does not apply.

    A pose that is no exact zero, or nearly a double zero, may have either sign.
    """
    if not _signs_cancel(equations):
        return True
    _, jacobian = evaluate(equations, zeros.rotations, zeros.offsets, geometric=False)
    matrices = np.moveaxis(jacobian, -1, 0)
    values = np.linalg.svd(matrices, compute_uv=False)
    is_certain = (values[:, -1] > SIMPLE_ZERO * values[:, 0]) & (zeros.costs < EXACT_COST)
    signs = np.linalg.slogdet(matrices)[0][is_certain]
    return bool(abs(signs.sum()) <= np.count_nonzero(~is_certain))


def _signs_cancel(equations: PoseEquations) -> bool:
    """Whether the degree of the map is zero, and all its zeros are searched."""
    domain = equations.domain
    if equations.dof or equations.measured or domain.search_angle < np.pi:
        return False
    if domain.is_free:
        return True
    is_proper = np.linalg.matrix_rank(translation_matrix(equations), tol=SIMPLE_ZERO) == 3
    return bool(domain.turns.sum() != 2 and (equations.radii > 0).any() and is_proper)
