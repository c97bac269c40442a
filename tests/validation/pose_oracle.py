"""All poses of a rigid fixture that six contacts allow, by parameter homotopy: the independent method of the tests.

The complex poses of one solved problem of the same kind (monodromy.py, data/) are tracked while that problem is
deformed into the given one. The number of complex poses is the same for almost all problems of a kind, so each path
ends at a pose of the given problem, at a multiple one, or at infinity, and every isolated complex pose is reached with
probability one. Numerical failures are counted: a lost path (it passed too near infinity), two paths that end at the
same regular pose (one has jumped), a root without its complex conjugate, which a real problem must have. Then the
roots are completed by their conjugates and the run is repeated from another start, until all paths are accounted for
or the number of tries is reached.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np

from tests.validation import monodromy
from tests.validation.kinds import TYPE_ORDER, kind_of
from tests.validation.monodromy import Follow, Start, distinct, follow, random_complex_problem
from tests.validation.path_tracking import Steps
from tests.validation.real_poses import Gauge, is_multiple, polished, pose_gap, pose_of_root
from tests.validation.study_forms import PLANE, SPHERE, ContactSystem, Problem

Feature = tuple[str, Sequence[float]] | tuple[str, Sequence[float], Sequence[float]]

CAREFUL_STEPS = (Steps(), Steps(), Steps(prediction=3e-5, contraction=0.03), Steps(prediction=3e-6, contraction=0.01))
NEARLY_THERE = 0.98
# A path that completes this part of the last piece and no more is at its end, a multiple root or infinity.
CLOSE = 0.99
LAST_STEPS = Steps(first=0.5, most=150)
# |q . q| / |q|^2 is 1 for a real pose and 0 at infinity; a path that ends below this is not at a real pose.
INFINITE_ROTATION = 1e-4
# The same for a path that has not quite reached its end.
FAR_ROTATION = 3e-2
# A root with a smaller row-scaled reciprocal condition counts as multiple: about the square root of the rounding.
SINGULAR = 1e-8
# Largest distance of a contact from its feature at an accepted pose, in units of the contacts' spread.
ON_SURFACE = 1e-10
# Largest imaginary part of a regular root, and of an end near a multiple root, from which a real pose is computed.
WIDEST_IMAGINARY = (1e-3, 0.1)


@dataclass(frozen=True)
class Method:
    """The loops that take most of the time: paths (start, target, roots, begin, end, steps), gradients, polishing,
    is_multiple.

    Here in numpy; compiled_poses has compiled versions, which take a tenth of the time.
    """

    track: Follow
    gradients: Callable[[Problem, np.ndarray], np.ndarray]
    polished: Callable[[Problem, np.ndarray], tuple[np.ndarray, float]]
    is_multiple: Callable[[Problem, np.ndarray], bool]


def _gradients(problem: Problem, roots: np.ndarray) -> np.ndarray:
    return ContactSystem(problem, problem).equations(roots, np.ones(len(roots)))[1]


NUMPY = Method(follow, _gradients, polished, is_multiple)


@dataclass(frozen=True)
class OracleAnswer:
    """The numbers of paths by their ends, and the real poses (k, 4, 4), base_from_fixture.

    paths = finite + singular + diverged + suspicious. finite: distinct regular complex poses; singular: multiple poses;
    diverged: paths that end at infinity; suspicious: unaccounted paths, a pose may be missing. multiple (k,): which of
    the real poses are multiple (tangent or not isolated). runs: number of starts used.
    """

    kind: str
    poses: np.ndarray
    multiple: np.ndarray
    paths: int
    finite: int
    singular: int
    diverged: int
    suspicious: int
    runs: int


def all_real_poses(
    features: Sequence[Feature],
    feature_of_contact: Sequence[int] | np.ndarray,
    points: np.ndarray,
    rho: np.ndarray,
    method: Method = NUMPY,
) -> OracleAnswer:
    """All real poses x = R y + t at which point i is at distance rho[i] from the plane, centre or axis of its feature.

    features: ("plane", point, outward normal), ("sphere", center) or ("cylinder", point, direction) in the fixture
    frame; points (6, 3) in base; rho (6,), the same for all contacts of a feature, signed for planes.
    Raises ValueError if the kind is unknown, or rho differs within a feature.
    """
    target = _ordered_problem(features, np.asarray(feature_of_contact), np.asarray(points, float), np.asarray(rho))
    kind = kind_of([(t, target.feature_of_contact.count(i)) for i, t in enumerate(target.types)])
    stored = start_of(kind, 0)
    gauge, turned = _toward_start(target, stored.problem)
    roots, counts, runs = _all_roots(kind, turned, method)
    poses, multiple = _real_ones(turned, roots, method)
    final = np.array([gauge.pose(pose) for pose in poses]).reshape(-1, 4, 4)
    return OracleAnswer(kind, final, multiple, len(stored.roots), *counts, runs)


def _ordered_problem(
    features: Sequence[Feature], feature_of_contact: np.ndarray, points: np.ndarray, rho: np.ndarray
) -> Problem:
    """The real problem with features and contacts in the order of the kind's name; planes are shifted by their rho."""
    counts = [int(np.sum(feature_of_contact == i)) for i in range(len(features))]
    touched = [i for i in range(len(features)) if counts[i]]
    order = sorted(touched, key=lambda i: (TYPE_ORDER.index(features[i][0]), -counts[i]))
    contacts = np.concatenate([np.flatnonzero(feature_of_contact == i) for i in order])
    first_rho = np.array([rho[feature_of_contact == i][0] for i in order], dtype=float)
    if not np.allclose(rho[contacts], np.repeat(first_rho, [counts[i] for i in order]), rtol=1e-12, atol=0):
        raise ValueError("rho must be the same for all contacts of a feature")
    types = tuple(features[i][0] for i in order)
    place = np.array([features[i][1] for i in order], dtype=float)
    direction = np.array(
        [features[i][2] if types[k] != SPHERE else (0, 0, 0) for k, i in enumerate(order)], dtype=float
    )
    place[np.array(types) == PLANE] += (first_rho[:, None] * direction)[np.array(types) == PLANE]
    index = tuple(int(k) for k in np.repeat(np.arange(len(order)), [counts[i] for i in order]))
    return Problem(types, index, place, direction, first_rho**2, points[contacts])


def _toward_start(problem: Problem, start: Problem) -> tuple[Gauge, Problem]:
    """The problem centred, of unit size and rotated towards the start, so that paths are short."""
    base_center = problem.contacts.mean(axis=0)
    unit = float(np.sqrt(((problem.contacts - base_center) ** 2).sum(axis=1).mean()))
    contacts = (problem.contacts - base_center) / unit
    fixture_center = _center_of(problem)
    place = (problem.place - fixture_center) / unit
    along = np.sum(place * problem.direction, axis=1, keepdims=True) * problem.direction
    is_plane, is_sphere = (np.array([t == wanted for t in problem.types])[:, None] for wanted in (PLANE, SPHERE))
    place = np.where(is_plane, along, np.where(is_sphere, place, place - along))
    fixture_turn, direction = _turn_and_signs(place, problem.direction, start)
    base_turn = _turn_onto(contacts, start.contacts.real)
    turned = Problem(
        problem.types,
        problem.feature_of_contact,
        place @ fixture_turn.T,
        direction @ fixture_turn.T,
        problem.squared_radius / unit**2,
        contacts @ base_turn.T,
    )
    return Gauge(base_turn, base_center, fixture_turn, fixture_center, unit), turned


def _center_of(problem: Problem) -> np.ndarray:
    """The point (3,) nearest to all planes, centres and axes; if not unique, nearest to the mean of the places."""
    squares = []
    for kind, s in zip(problem.types, problem.direction, strict=True):
        squares.append(np.outer(s, s) if kind == PLANE else np.eye(3) - np.outer(s, s))
    mean = problem.place.mean(axis=0)
    right = sum(m @ (p - mean) for m, p in zip(squares, problem.place, strict=True))
    return np.asarray(mean + np.linalg.lstsq(sum(squares), right, rcond=1e-3)[0])


def _turn_and_signs(place: np.ndarray, direction: np.ndarray, start: Problem) -> tuple[np.ndarray, np.ndarray]:
    """The rotation of the fixture, and signs of axes and normals, that bring all directions near the start's."""
    count, best = len(direction), (np.inf, np.eye(3), direction)
    has_sign = direction.any(axis=1)
    goals = np.vstack([np.where(has_sign[:, None], start.direction.real, 0), 0.3 * start.place.real])
    for signs in product(*((1.0, -1.0) if open_sign else (1.0,) for open_sign in has_sign)):
        signed = direction * np.array(signs)[:, None]
        turn = _turn_onto(np.vstack([signed, 0.3 * place]), goals)
        gap = float(((signed @ turn.T - goals[:count]) ** 2).sum())
        best = min(best, (gap, turn, signed), key=lambda item: item[0])
    return best[1], best[2]


def _turn_onto(vectors: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """The rotation G for which G v is nearest to the goals (k, 3) in the least-squares sense."""
    u, _, vt = np.linalg.svd(goals.T @ vectors)
    return np.asarray(u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt)


@lru_cache(maxsize=64)
def start_of(kind: str, number: int) -> Start:
    """The stored start of a kind (number 0), or a random problem solved from it. ValueError for an unknown kind."""
    if number == 0:
        try:
            return monodromy.load(kind)
        except FileNotFoundError:
            raise ValueError(f"no solved problem of kind {kind!r} is stored; make one with monodromy.py") from None
    first = start_of(kind, 0)
    for seed in range(20):
        other = random_complex_problem(kind, np.random.default_rng([number, seed]))
        roots, part = follow(first.problem, other, first.roots, 0.0, 1.0, CAREFUL_STEPS[2])
        if (part == 1).all() and len(distinct(roots)) == len(roots):
            return Start(other, roots, 0)
    raise ValueError(f"no second start found for kind {kind!r}")


@dataclass(frozen=True)
class _Ends:
    """Ends of one run: regular roots, ends near multiple roots, and the numbers of paths with other ends.

    diverged: at infinity. stalled: near infinity, where tracking stopped. repeated: at a regular root that another path
    has reached. lost: all others.
    """

    regular: np.ndarray
    multiple: np.ndarray
    diverged: int
    stalled: int
    repeated: int
    lost: int


def _all_roots(
    kind: str, target: Problem, method: Method
) -> tuple[tuple[np.ndarray, np.ndarray], tuple[int, int, int, int], int]:
    """Regular and multiple roots of the target; finite, singular, diverged, suspicious; and the number of runs."""
    regular, multiple = np.zeros((0, 8), complex), np.zeros((0, 8), complex)
    diverged, run, paths, alone = 0, 0, len(start_of(kind, 0).roots), 0
    for run, steps in enumerate(CAREFUL_STEPS):
        start, known = start_of(kind, run), len(regular)
        ends = _run(start, target, steps, method)
        regular = _united(regular, ends.regular)
        multiple = max(multiple, ends.multiple, key=len)
        alone = _without_conjugate(regular)
        if ends.lost == ends.repeated == alone == 0 and (ends.stalled == 0 or len(regular) == known):
            # If paths from two starts stall near infinity and both runs found the same roots, they go to infinity.
            diverged = max(diverged, ends.diverged + ends.stalled)
            break
        diverged = max(diverged, ends.diverged)
        regular = _united(regular, regular.conj())
        if len(regular) == paths or len(regular) + len(multiple) + diverged == paths:
            break
    # A path that stopped before a multiple root or infinity in one run may have reached a regular root in another.
    singular = max(0, min(len(multiple), paths - len(regular)))
    diverged = max(0, min(diverged, paths - len(regular) - singular))
    missing = abs(paths - len(regular) - singular - diverged)
    return (regular, multiple), (len(regular), singular, diverged, missing), run + 1


def _without_conjugate(roots: np.ndarray) -> int:
    """The number of roots (k, 8) of a real problem whose complex conjugate is missing."""
    unit = roots / np.linalg.norm(roots, axis=1, keepdims=True)
    return int(np.sum(np.abs(unit @ unit.T).max(axis=1, initial=0.0) < 1 - 1e-9))


def _united(some: np.ndarray, more: np.ndarray) -> np.ndarray:
    both = np.concatenate([some, more])
    return both[distinct(both)]


def _run(start: Start, target: Problem, steps: Steps, method: Method) -> _Ends:
    """All paths from one start to the target, sorted by how they end."""
    roots, part = method.track(start.problem, target, start.roots, 0.0, NEARLY_THERE, steps)
    far_on_the_way = (part < 1) & (_rotation_size(roots) < FAR_ROTATION)
    ends, last_part = method.track(start.problem, target, roots[part == 1], NEARLY_THERE, 1.0, LAST_STEPS)
    rotation = _rotation_size(ends)
    far, at_target, close = rotation < FAR_ROTATION, last_part == 1, last_part > CLOSE
    diverged = (close & ~at_target & far) | (rotation < INFINITE_ROTATION)
    regular = at_target & ~diverged
    regular[regular] = far[regular] | (_condition(method.gradients(target, ends[regular])) > SINGULAR)
    multiple = close & ~regular & ~diverged
    kept = distinct(ends[regular])
    stalled = int(np.sum(far_on_the_way) + np.sum(far & ~close & ~diverged))
    known = int(regular.sum() + multiple.sum() + diverged.sum())
    return _Ends(
        regular=ends[regular][kept],
        multiple=ends[multiple],
        diverged=int(diverged.sum()),
        stalled=stalled,
        repeated=int(regular.sum()) - len(kept),
        lost=len(start.roots) - known - stalled,
    )


def _rotation_size(roots: np.ndarray) -> np.ndarray:
    """|q . q| / |q|^2 (k,): 1 for real poses, less for complex ones, 0 at infinity."""
    return np.asarray(np.abs(np.sum(roots[:, :4] ** 2, axis=1)) / np.sum(np.abs(roots[:, :4]) ** 2, axis=1))


def _imaginary_rotation(roots: np.ndarray) -> np.ndarray:
    """Largest imaginary part (k,) of the quaternions of roots (k, 8), normalized to q . q = 1."""
    quaternions = roots[:, :4] / np.sqrt(np.sum(roots[:, :4] ** 2, axis=1, keepdims=True))
    return np.asarray(np.abs(quaternions.imag).max(axis=1, initial=0.0))


def _condition(gradients: np.ndarray) -> np.ndarray:
    """Smallest over largest singular value (k,) of the equations' gradients (k, 7, 8), normalized to unit length."""
    gradients = gradients / np.linalg.norm(gradients, axis=2, keepdims=True)
    values = np.linalg.svd(gradients, compute_uv=False)
    return np.asarray(values[:, -1] / values[:, 0])


def _real_ones(target: Problem, roots: tuple[np.ndarray, np.ndarray], method: Method) -> tuple[np.ndarray, np.ndarray]:
    """Distinct real poses (k, 4, 4) in the frames of the target, and which (k,) are multiple."""
    poses: list[np.ndarray] = []
    multiple: list[bool] = []
    for group, widest in zip(roots, WIDEST_IMAGINARY, strict=True):
        for root in group[_imaginary_rotation(group) <= widest]:
            pose, imaginary = pose_of_root(root)
            if imaginary > widest:
                continue
            pose, off = method.polished(target, pose)
            flat = method.is_multiple(target, pose)
            # A multiple pose is accurate to the square or cube root of rounding, and found by every path to it.
            if off <= ON_SURFACE and all(pose_gap(pose, known) > (1e-3 if flat else 1e-7) for known in poses):
                poses.append(pose)
                multiple.append(flat)
    return np.array(poses).reshape(-1, 4, 4), np.array(multiple, dtype=bool)
