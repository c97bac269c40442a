"""The branches of a fixture's relations: the signs that they may have, and which of these the contacts do not exclude.

Near located features the linear model gives the cost of a choice of signs. With residuals c of the relations, their
gradients G, the covariance S of the features from their own contacts, and R of the relations, chi-square rises by

    c^T (G S G^T + R)^-1 c.

1. The branches of each relation are listed, the one nearest to the surfaces first.
2. S is computed from the contacts alone; a displacement that they leave free gets a sigma of one fixture size, or rad.
3. A branch whose own cost exceeds COSTLY times the limit of chi-square is dropped.
4. Choices of signs are extended by one relation after another. A further relation never lowers the cost, so a choice
   that costs too much is dropped with all of its extensions. If none remains, this combination of features is dropped.
   Of more than BRANCH_FITS the cheapest are kept, and the least cost of the others is returned.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from tactfix.fixture import Relation
from tactfix.geometry.arrays import Floats
from tactfix.geometry.nearest import ALMOST_PARALLEL, direction_of, distance_between
from tactfix.geometry.surfaces import Cylinder, Plane, Surface
from tactfix.noise import chi_square_limit
from tactfix.relations import distances
from tactfix.relations.equations import Equation, chart_lengths, equation, form_of, has_branches, off, stacked
from tactfix.relations.joint_problem import JointProblem, contact_observations
from tactfix.relations.parallels import parallel_pairs
from tactfix.values import frozen_value

NEAR_COINCIDENCE = ALMOST_PARALLEL
"""Difference from coincidence (rad, fixture sizes) below which a relation is widened at first. Where directions or
places differ by so little, contacts rarely resolve the circle; `branch_fits.RESOLVED` decides afterwards."""
COSTLY = 10.0
"""Multiple of the limit of chi-square above which the linear cost excludes a branch: that cost is exact only near the
surfaces. 1 and 20 change none of every fifth of the 200 contact sets of `tests.benchmarks.bench_relations`."""
CURVED = 0.02
"""Sigma that is added to the linear model, as a share of its residual: its error is of second order, so never more than
the square of the residual, and 2 per cent of a residual as large as the fixture."""
KEPT_SIGMA = 1e-12
"""Sigma (rad, fixture sizes) of an exact relation between surfaces that are known exactly: rounding, so that its
covariance is not singular."""
BRANCH_FITS = 96
"""Branches that are followed, of one combination of features and of all of them, in order of cost: 2^6 = 64 are all
branches of six relations with an open sign. If one that is left out may explain the contacts, the result is not
complete."""


@frozen_value
class Branches:
    """The predicted chi-square and the equations of each branch kept, lowest first.

    left_out: the least chi-square of a branch, complete or partial, dropped by the limit on their number; infinite if
    there was none.
    """

    found: tuple[tuple[float, tuple[Equation, ...]], ...]
    left_out: float


def nearest_branch(
    relations: Sequence[Relation], surfaces: Mapping[str, Surface], scale: float | None = None
) -> tuple[Equation, ...]:
    """The equations of the relations on their nearest branches; with a scale, widened near coincidence."""
    choices = _choices(tuple(relations), surfaces, scale)
    return tuple(equations[0] for equations in choices)


def branches(problem: JointProblem, surfaces: Mapping[str, Surface]) -> Branches:
    """The branches that may explain the contacts, with surfaces near these."""
    choices = _choices(problem.relations, surfaces, problem.scale)  # step 1
    covariance = _covariance(problem, surfaces)  # step 2
    limit = COSTLY * chi_square_limit(len(problem.contacts))

    def cost(equations: Sequence[Equation]) -> float:
        return _cost(equations, surfaces, covariance, problem.scale)

    viable = [[e for e in equations if cost([e]) <= limit] for equations in choices]  # step 3
    if not all(viable):
        return Branches((), np.inf)
    # Step 4: those without a choice first, and all of them at once.
    order = sorted(range(len(viable)), key=lambda number: len(viable[number]) > 1)
    settled = [viable[number][0] for number in order if len(viable[number]) == 1]
    found, left_out = [(cost(settled), settled)], np.inf
    for number in order[len(settled) :]:
        longer = [[*begun, e] for _, begun in found for e in viable[number]]
        ranked = sorted(((cost(one), one) for one in longer), key=lambda pair: pair[0])
        found = [pair for pair in ranked if pair[0] <= limit]
        left_out = min([left_out, *(chi2 for chi2, _ in found[BRANCH_FITS:])])
        found = found[:BRANCH_FITS]
    place = np.argsort(order)
    return Branches(tuple((chi2, tuple(one[i] for i in place)) for chi2, one in found if chi2 <= limit), left_out)


def least_cost(problem: JointProblem, surfaces: Mapping[str, Surface]) -> float:
    """The predicted chi-square of the relations on the nearest branch."""
    equations = nearest_branch(problem.relations, surfaces, problem.scale)
    return _cost(equations, surfaces, _covariance(problem, surfaces), problem.scale)


def _choices(
    relations: tuple[Relation, ...], surfaces: Mapping[str, Surface], scale: float | None
) -> list[list[Equation]]:
    """The branches of each relation, first that nearest to the surfaces."""
    known = parallel_pairs(relations)
    found = []
    for relation in relations:
        parallel = frozenset(relation.between) in known
        widened = scale is not None and _may_widen(relation, scale)
        signs = _signs(relation, surfaces, parallel, widened)
        found.append([equation(relation, surfaces, sign, parallel, widened) for sign in signs])
    return found


def _may_widen(relation: Relation, scale: float) -> bool:
    """Whether a relation is so near coincidence that contacts may not resolve the difference; scale: a length."""
    if relation.kind == "angle":
        return 0 < off(relation) < NEAR_COINCIDENCE
    return 0 < relation.value < NEAR_COINCIDENCE * scale


def _signs(relation: Relation, surfaces: Mapping[str, Surface], parallel: bool, widened: bool) -> tuple[float, ...]:
    """The signs of a relation's branches, first that of the branch nearest to the surfaces."""
    one, other = (surfaces[name] for name in relation.between)
    form = form_of(relation, one, other, parallel, widened)
    match form, one, other:
        case "turn" | "aligned", Plane(), Plane():
            return (1.0,)
        case "turn" | "aligned", Plane() | Cylinder(), Plane() | Cylinder():
            nearest = _facing(one, other)
        case "side", Plane() | Cylinder(), Plane() | Cylinder():
            nearest = _sign(distance_between(one, other))
        case "askew", Cylinder(), Cylinder():
            nearest = _sign(float(distances.askew(one, other, 0.0, 1.0)[0][0]))
        case _:
            return (1.0,)
    if has_branches(relation, form):
        return (nearest, -nearest)
    return (nearest,) if form == "aligned" else (1.0,)


def are_same_branches(
    ones: Sequence[Equation], others: Sequence[Equation], of_one: Mapping[str, Surface], of_other: Mapping[str, Surface]
) -> bool:
    """Whether every relation is on the same branch for two sets of surfaces, though axes may be opposite."""
    flipped = {name for name, surface in of_one.items() if _are_opposite(surface, of_other[name])}
    for one, other in zip(ones, others, strict=True):
        turns = one.form != "side" and len(flipped & set(one.relation.between)) == 1
        if has_branches(one.relation, one.form) and one.sign != (-other.sign if turns else other.sign):
            return False
    return True


def _are_opposite(one: Surface, other: Surface) -> bool:
    return isinstance(one, Cylinder) and isinstance(other, Cylinder) and bool(one.direction @ other.direction < 0)


def _facing(one: Plane | Cylinder, other: Plane | Cylinder) -> float:
    """1 or -1: the sense of the second direction that is within 90 degrees of the first."""
    return _sign(float(direction_of(one) @ direction_of(other)))


def _sign(number: float) -> float:
    return 1.0 if number >= 0 else -1.0


def _covariance(problem: JointProblem, surfaces: Mapping[str, Surface]) -> Floats:
    """Covariance (width, width) of the displacements from contacts alone, in scaled units; sigma 1 of free ones."""
    _, rows = contact_observations(problem.contacts, problem.sigmas, surfaces)
    scaled = rows * chart_lengths(surfaces, problem.scale)
    # By QR factorization: in the normal matrix, rounding would swamp the ones if contacts' rows are 1e8 times larger.
    still = np.eye(scaled.shape[1])
    inverse = np.linalg.solve(np.linalg.qr(np.vstack([scaled, still]), mode="r"), still)
    return np.asarray(inverse @ inverse.T)


def _cost(equations: Sequence[Equation], surfaces: Mapping[str, Surface], covariance: Floats, scale: float) -> float:
    """The cost of the relations by the linear model."""
    missing, gradient = stacked(equations, surfaces, scale)
    if not len(missing):
        return 0.0
    own = np.concatenate([np.full(e.components, e.spread / e.unit(scale)) for e in equations])
    curved = np.minimum(missing**2, CURVED * np.abs(missing))
    covariance = gradient @ covariance @ gradient.T + np.diag(own**2 + curved**2 + KEPT_SIGMA**2)
    size = np.sqrt(np.diag(covariance))
    reduced = missing / size
    return float(reduced @ np.linalg.pinv(covariance / np.outer(size, size), rcond=1e-9, hermitian=True) @ reduced)
