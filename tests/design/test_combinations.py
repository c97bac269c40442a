"""Free motions, symmetries and minimal sets against results derived by hand, numeric ranks and brute force.

The expected values do not use tactfix.design: ranks come from random contacts, symmetries from a multi-start search
over all rigid motions, and Rado's condition is implemented here. All rows of the project's reference table
data/combinations.json are tested.
"""

import json
from functools import cache
from itertools import combinations, permutations, product
from pathlib import Path

import numpy as np
import pytest

from tactfix.design.contact_counts import contact_counts, minimal_sets
from tactfix.design.symmetries import symmetries
from tactfix.feature import Feature
from tactfix.geometry.scale import tolerance_for
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere, moved
from tactfix.localization.motion_words import free_motions
from tests.support.special_positions import POSITIONS, REFERENCE, Position

ROWS = json.loads((Path(__file__).parent / "data" / "combinations.json").read_text())["rows"]


def reference_position(row: dict) -> Position:
    features = REFERENCE[" ".join(row["features"]), row["position"]]
    name = f"{' '.join(row['features'])}: {row['position']}"
    return Position(name, features, row["free"], row["symmetry_order_unsided"], row["symmetry_order_sided"])


REFERENCES = [reference_position(row) for row in ROWS]
EVERY = REFERENCES + POSITIONS
each = pytest.mark.parametrize("position", EVERY, ids=lambda p: p.name)


def random_rotation(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def random_pose(rng, reach=0.0):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = random_rotation(rng), reach * rng.normal(size=3)
    return pose


def random_points(surface, count, rng):
    """Random points and normals of a surface, by formulas that are independent of the package."""
    v = rng.normal(size=(count, 3))
    if isinstance(surface, Sphere):
        n = v / np.linalg.norm(v, axis=1)[:, None]
        return surface.center + surface.radius * n, n
    if isinstance(surface, Plane):
        n = np.tile(surface.normal, (count, 1))
        return surface.point + 5 * np.cross(n, v), n
    n = np.cross(v, surface.direction)
    n /= np.linalg.norm(n, axis=1)[:, None]
    return surface.point + surface.radius * n + 5 * v[:, :1] * surface.direction, n


def numeric_rank(surfaces, counts, rng):
    """Rank of the constraint rows of random contacts."""
    rows = []
    for name, count in counts.items():
        p, n = random_points(surfaces[name], count, rng)
        rows.append(np.hstack([n, np.cross(p, n)]))
    s = np.linalg.svd(np.vstack(rows), compute_uv=False)
    return int((s > 1e-9 * s[0]).sum())


def in_letters(motions):
    rotations = sum(bool(np.linalg.norm(m.rotation) > 0) for m in motions)
    return f"{rotations}R{len(motions) - rotations}T" if motions else "none"


def test_the_table_is_as_long_as_promised():
    assert len(EVERY) >= 60 + 21
    assert len({p.name for p in EVERY}) == len(EVERY)


@each
def test_free_motions_are_those_of_the_table(position):
    surfaces = position.surfaces
    motions = free_motions(surfaces, tolerance_for(surfaces))
    assert in_letters(motions) == position.free
    translations = [not m.rotation.any() for m in motions]
    assert translations == sorted(translations, reverse=True), "translations come first"


@each
def test_free_motions_are_the_null_space_of_random_contacts(position):
    rng = np.random.default_rng(1)
    surfaces = position.surfaces
    motions = free_motions(surfaces, tolerance_for(surfaces))
    assert numeric_rank(surfaces, dict.fromkeys(surfaces, 12), rng) == 6 - len(motions)
    for name, surface in surfaces.items():
        p, n = random_points(surface, 20, rng)
        for m in motions:
            velocity = m.translation + np.cross(m.rotation, p)
            assert np.abs((n * velocity).sum(axis=1)).max() < 1e-12 * (1 + np.abs(velocity).max()), name
    basis = np.array([np.concatenate([m.rotation, m.translation]) for m in motions]).reshape(-1, 6)
    assert not len(motions) or np.linalg.matrix_rank(basis) == len(motions)  # older numpy has no rank of nothing


@each
def test_minimal_sets_are_those_with_full_numeric_rank(position):
    rng = np.random.default_rng(2)
    surfaces = position.surfaces
    full = numeric_rank(surfaces, dict.fromkeys(surfaces, 12), rng)
    found = {tuple(s.values()) for s in minimal_sets(surfaces, tolerance_for(surfaces), 10_000)}
    most = [4 if isinstance(s, Cylinder) else 3 for s in surfaces.values()]
    shares = [c for c in product(*(range(m + 1) for m in most)) if sum(c) == full]
    assert found == {c for c in shares if numeric_rank(surfaces, dict(zip(surfaces, c, strict=True)), rng) == full}


@pytest.mark.parametrize(
    ("row", "position"), list(zip(ROWS, REFERENCES, strict=True)), ids=[p.name for p in REFERENCES]
)
def test_minimal_sets_are_those_of_the_reference(row, position):
    found = minimal_sets(position.surfaces, tolerance_for(position.surfaces), 10_000)
    assert sorted(list(s.values()) for s in found) == row["minimal_distributions"]


@pytest.mark.parametrize("position", POSITIONS, ids=lambda p: p.name)
def test_minimal_sets_follow_from_the_ranks_in_the_table(position):
    """Rado's condition with the ranks derived by hand; subsets that are not in the table have rank 6."""
    surfaces = position.surfaces
    single = {name: 4 if isinstance(s, Cylinder) else 3 for name, s in surfaces.items()}

    def rank(subset):
        return single[subset] if len(subset) == 1 else position.ranks.get(subset, 6)

    names = "".join(surfaces)
    subsets = ["".join(c) for k in range(1, len(names) + 1) for c in combinations(names, k)]
    expected = {
        counts
        for counts in product(*(range(single[n] + 1) for n in names))
        if sum(counts) == rank(names)
        and all(sum(counts[names.index(n)] for n in subset) <= rank(subset) for subset in subsets)
    }
    assert {tuple(s.values()) for s in minimal_sets(surfaces, tolerance_for(surfaces), 10_000)} == expected


@each
def test_additional_contacts_complete_the_rank(position):
    rng = np.random.default_rng(6)
    surfaces = position.surfaces
    features = {n: Feature(n, type(s).__name__.lower(), None, "outer", 0.0, s) for n, s in surfaces.items()}
    found = contact_counts(features, surfaces, set(), tolerance_for(surfaces)).each.others_located
    total = numeric_rank(surfaces, dict.fromkeys(surfaces, 12), rng)
    for name in surfaces:
        others = {other: 12 for other in surfaces if other != name}
        assert found[name] == total - (numeric_rank(surfaces, others, rng) if others else 0)


@each
def test_orders_of_the_symmetry_group(position):
    found = symmetries(position.surfaces, {})
    if position.unsided is None:
        assert found == ()
        return
    assert 1 + sum(s.broken_by != "labels" for s in found) == position.unsided
    assert 1 + sum(s.broken_by is None for s in found) == position.sided
    if position.everything is not None:
        assert 1 + len(found) == position.everything


def shape(surface):
    """Coordinates of a surface that do not depend on its representation, such as the choice of a point on an axis."""
    if isinstance(surface, Sphere):
        return np.concatenate([surface.center, [surface.radius]])
    if isinstance(surface, Plane):
        return np.concatenate(
            [np.outer(surface.normal, surface.normal).ravel(), surface.normal * (surface.normal @ surface.point)]
        )
    d = surface.direction
    return np.concatenate([np.outer(d, d).ravel(), surface.point - d * (d @ surface.point), [surface.radius]])


def shapes(surfaces):
    return np.concatenate([shape(surface) for surface in surfaces])


def misfit(pose, surfaces, target):
    """The difference between the moved surfaces and their images."""
    return shapes([moved(pose, surface) for surface in surfaces]) - target


def shapes_at(poses, surfaces):
    """The shapes (..., n) of surfaces moved to many poses (..., 4, 4) at once."""
    turns, parts = poses[..., :3, :3], []
    for surface in surfaces:
        at = turns @ (surface.center if isinstance(surface, Sphere) else surface.point) + poses[..., :3, 3]
        if isinstance(surface, Sphere):
            parts.append(at)
        else:
            d = turns @ (surface.normal if isinstance(surface, Plane) else surface.direction)
            foot = d * np.sum(d * at, axis=-1, keepdims=True)
            square = (d[..., :, None] * d[..., None, :]).reshape(*d.shape[:-1], 9)
            parts += [square, foot if isinstance(surface, Plane) else at - foot]
        if not isinstance(surface, Plane):
            parts.append(np.full((*at.shape[:-1], 1), surface.radius))
    return np.concatenate(parts, axis=-1)


def descend(surfaces, poses, targets):
    """Levenberg-Marquardt on the misfit from poses (n, 4, 4); returns those that map each surface onto its image."""
    poses, damping = poses.copy(), np.full(len(poses), 1e-2)
    r = shapes_at(poses, surfaces) - targets
    small = steps(1e-6 * np.eye(6))
    for _ in range(60):
        (left,) = np.nonzero((np.sum(r * r, axis=1) >= 1e-22) & (damping <= 1e8))
        if not len(left):
            break
        ahead = shapes_at(small @ poses[left, None], surfaces) - targets[left, None]
        jac = (ahead - r[left, None]) / 1e-6  # transposed: (n, 6, misfits)
        normal = jac @ jac.swapaxes(1, 2) + damping[left, None, None] * np.eye(6)
        h = np.linalg.solve(normal, -jac @ r[left, :, None])[..., 0]
        new = steps(h) @ poses[left]
        new_r = shapes_at(new, surfaces) - targets[left]
        better = np.sum(new_r**2, axis=1) < np.sum(r[left] ** 2, axis=1)
        poses[left[better]], r[left[better]] = new[better], new_r[better]
        damping[left] *= np.where(better, 0.1, 10.0)
    return poses[np.sum(r * r, axis=1) < 1e-16]


def steps(h):
    """The rigid motions (n, 4, 4) of steps (n, 6)."""
    angle = np.maximum(np.linalg.norm(h[:, :3], axis=1), 1e-100)[:, None, None]
    k = np.cross(np.eye(3), -h[:, None, :3])
    poses = np.tile(np.eye(4), (len(h), 1, 1))
    poses[:, :3, :3] += np.sin(angle) / angle * k + (1 - np.cos(angle)) / angle**2 * (k @ k)
    poses[:, :3, 3] = h[:, 3:]
    return poses


def brute_force_group(surfaces, rng, starts):
    """Distinct rigid motions that map the set of surfaces onto itself, from random starts for each permutation."""
    poses, targets = [], []
    for images in permutations(surfaces):
        alike = [
            type(a) is type(b) and getattr(a, "radius", 0) == getattr(b, "radius", 0)
            for a, b in zip(surfaces, images, strict=True)
        ]
        if all(alike):
            poses += [random_pose(rng, 1.0) for _ in range(starts)]
            targets += [shapes(images)] * starts
    found = []
    for pose in descend(surfaces, np.array(poses), np.array(targets)):
        if not any(np.abs(pose - f).max() < 1e-5 for f in found):
            found.append(pose)
    return found


@pytest.mark.parametrize(
    "position", [p for p in EVERY if p.unsided is not None and len(p.features) <= 3], ids=lambda p: p.name
)
def test_symmetries_are_all_that_brute_force_finds(position):
    found = [np.eye(4), *(s.image_from_fixture for s in symmetries(position.surfaces, {}))]
    brute = brute_force_group(list(position.features), np.random.default_rng(3), starts=4)
    for pose in brute:
        assert min(np.abs(pose - f).max() for f in found) < 1e-5, "brute force finds one more"
    for pose in found:
        surfaces = position.features
        assert any(
            np.abs(misfit(pose, surfaces, shapes(images))).max() < 1e-9
            for images in permutations(surfaces)
            if all(type(a) is type(b) for a, b in zip(surfaces, images, strict=True))
        ), "not a symmetry"


@each
@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_verdicts_do_not_depend_on_unit_pose_or_order(position, unit):
    rng = np.random.default_rng(4)
    pose = random_pose(rng)
    pose[:3, 3] = 1e4 * unit * rng.normal(size=3)
    symmetric, here = verdicts(position.name)
    surfaces = {name: moved(pose, scaled(s, unit)) for name, s in reversed(position.surfaces.items())}
    tolerance = tolerance_for(surfaces)
    assert in_letters(free_motions(surfaces, tolerance)) == position.free
    assert len(symmetries(surfaces, {})) == symmetric
    assert {tuple(s[n] for n in position.surfaces) for s in minimal_sets(surfaces, tolerance, 10_000)} == here


@cache
def verdicts(name):
    """The number of symmetries of a position and its minimal sets, in the form of the table."""
    (surfaces,) = [p.surfaces for p in EVERY if p.name == name]
    sets = minimal_sets(surfaces, tolerance_for(surfaces), 10_000)
    return len(symmetries(surfaces, {})), {tuple(s.values()) for s in sets}


def scaled(surface, unit):
    match surface:
        case Plane():
            return Plane(unit * surface.point, surface.normal)
        case Sphere():
            return Sphere(unit * surface.center, unit * surface.radius)
        case Cylinder():
            return Cylinder(unit * surface.point, surface.direction, unit * surface.radius)


@pytest.mark.parametrize("unit", [1e-7, 1.0, 1e7])
@pytest.mark.parametrize(("shift", "is_special"), [(1e-3, False), (1e-5, False), (1e-8, True)])
def test_special_positions_are_relative_to_the_size(unit, shift, is_special):
    """Whether a position is special is decided exactly from the file; how well it holds a pose depends on sigma."""
    surfaces = {
        "ball": Sphere(unit * np.array([shift, 0, 2.0]), unit),
        "bar": Cylinder(np.zeros(3), np.array([0, 0, 1.0]), unit),
    }
    assert bool(free_motions(surfaces, tolerance_for(surfaces))) == is_special
