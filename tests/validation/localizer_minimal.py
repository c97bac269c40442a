"""Minimal problems in large numbers: presence of the true surface among the candidates, accuracy and time.

    pytest -m slow -s tests/validation/localizer_minimal.py

INSTANCES in the environment sets the number of random problems (default 100000), ROTATIONS the number of rotations of
every regular layout (200). Errors are divided by machine epsilon times a condition number, computed here from the
Jacobian of the distances at the true surface.
"""

import os
import time

import numpy as np
import pytest

from tactfix.localizers.axis_directions import direction_zeros
from tactfix.localizers.cylinder import localize_cylinder
from tactfix.stacks.five_contact_cylinders import cylinders_through_five
from tactfix.stacks.sphere_centers import sphere_centers
from tests.support.common_tangents import tangent_lines
from tests.support.touched_surfaces import AXES, TIDY_FIVES, TIDY_FIVES_WITH_MULTIPLE_ROOTS, ring, turned_to

INSTANCES = int(os.environ.get("INSTANCES", "100000"))
ROTATIONS = int(os.environ.get("ROTATIONS", "200"))
EPS = np.finfo(float).eps
QUANTILES = [0.5, 0.9, 0.99, 0.999, 1.0]


def _unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def _report(name, errors, condition, seconds, lost):
    figures = ", ".join(f"{q:.1e}" for q in np.quantile(errors, QUANTILES))
    relative = ", ".join(f"{q:.2g}" for q in np.quantile(errors / (EPS * condition), QUANTILES))
    print(f"\n{name}: {len(errors)} random problems, {lost} without the true surface")
    print(f"  error, quantiles {QUANTILES}: {figures}")
    print(f"  error / (epsilon * condition):                {relative}")
    print(f"  {seconds / len(errors) * 1e6:.2f} us each")


@pytest.mark.slow
def test_three_contacts_on_a_sphere():
    rng = np.random.default_rng(1)
    center = rng.normal(size=(INSTANCES, 3))
    normals = _unit(rng.normal(size=(INSTANCES, 3, 3)))
    points = center[:, None] + normals
    began = time.process_time()
    found = sphere_centers(points, 1.0)
    seconds = time.process_time() - began
    errors = np.nanmin(np.linalg.norm(found.centers - center[:, None], axis=-1), axis=-1)
    condition = 1 / np.linalg.svd(normals, compute_uv=False)[:, -1]
    size = np.abs(points).max(axis=(1, 2)) + 1
    # Near a great circle the centre is accurate only to the square root of the rounding.
    bound = np.minimum(EPS * condition**2 * size, np.sqrt(EPS * size * condition))
    lost = np.count_nonzero(~(errors < 1e3 * bound))
    _report("sphere from three contacts", errors, condition * size, seconds, lost)
    assert lost == 0


@pytest.mark.slow
def test_five_contacts_on_a_cylinder():
    rng = np.random.default_rng(2)
    angle = rng.uniform(0, 2 * np.pi, (INSTANCES, 5))
    z = rng.uniform(-1, 1, (INSTANCES, 5))
    q, _ = np.linalg.qr(rng.normal(size=(INSTANCES, 3, 3)))
    points = np.stack([np.cos(angle), np.sin(angle), z], axis=-1) @ np.swapaxes(q, -1, -2)
    began = time.process_time()
    found = cylinders_through_five(points)
    seconds = time.process_time() - began
    tilt = np.linalg.norm(np.cross(found.directions, q[:, None, :, 2]), axis=-1)
    errors = np.nanmin(np.maximum(tilt, np.abs(found.radii - 1)), axis=1)
    n = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    jacobian = np.concatenate([n, z[..., None] * n, np.ones((*z.shape, 1))], axis=-1)
    condition = 1 / np.linalg.svd(jacobian, compute_uv=False)[:, -1]
    lost = np.count_nonzero(~(errors < np.minimum(1e4 * EPS * condition**2, 1e-3)))
    _report("cylinder from five contacts", errors, condition, seconds, lost)
    counts = np.bincount(found.valid.sum(axis=1), minlength=7) / INSTANCES
    print(f"  real cylinders 0..6: {np.round(counts, 4).tolist()}")
    assert lost == 0
    assert counts[[1, 3, 5]].sum() < 1e-3


@pytest.mark.slow
def test_two_methods_count_the_same_real_cylinders():
    # Any five points, on a real cylinder or not: the method of the package against the null space of a Macaulay matrix.
    rng = np.random.default_rng(9)
    count = max(INSTANCES // 4, 1)
    points = rng.normal(size=(count, 5, 3))
    found = cylinders_through_five(points).valid.sum(axis=1)
    centred = points - points.mean(axis=1, keepdims=True)
    size = np.sqrt(np.mean(np.sum(centred**2, axis=2), axis=1))
    zeros, _ = direction_zeros(centred / size[:, None, None])
    real = np.count_nonzero(np.abs(zeros.imag).max(axis=-1) < 1e-6, axis=1)
    print(f"\n{count} sets of five random points: {np.count_nonzero(found != real)} disagreements")
    print(f"  real cylinders 0..6: {np.round(np.bincount(found, minlength=7) / count, 4).tolist()}")
    # Rounding decides whether pairs of nearly double roots are real, so they may be counted either way.
    assert np.count_nonzero(found != real) <= 1e-4 * count


def _rotations(rng):
    axes = np.vstack([AXES, _unit(rng.normal(size=(max(ROTATIONS - len(AXES), 0), 3)))])
    return [(turned_to(a, None if k < len(AXES) else rng), _unit(a)) for k, a in enumerate(axes)]


@pytest.mark.slow
@pytest.mark.parametrize("layout", [*TIDY_FIVES, *TIDY_FIVES_WITH_MULTIPLE_ROOTS])
def test_tidy_layouts_of_five_at_every_rotation(layout):
    rng = np.random.default_rng(3)
    contacts = TIDY_FIVES.get(layout, TIDY_FIVES_WITH_MULTIPLE_ROOTS.get(layout))
    rotations = _rotations(rng)
    found = cylinders_through_five(np.array([contacts @ rotation.T for rotation, _ in rotations]))
    axes = np.array([axis for _, axis in rotations])
    tilt = np.linalg.norm(np.cross(found.directions, axes[:, None]), axis=-1)
    errors = np.nanmin(np.maximum(tilt, np.abs(found.radii - 1)), axis=1)
    counts = sorted(set(found.valid.sum(axis=1).tolist()))
    print(f"\n{layout}: {len(axes)} rotations, {counts} cylinders, worst error {errors.max():.1e}")
    assert len(counts) == 1
    assert errors.max() < (1e-9 if layout in TIDY_FIVES else 1e-3)


ROWS = {
    "two rows of three, staggered": (np.vstack([ring([0, 120, 240], -0.8), ring([60, 180, 300], 0.8)]), 4),
    "two rows of three, aligned": (np.vstack([ring([0, 120, 240], -0.8), ring([0, 120, 240], 0.8)]), 4),
    "two rows of four, staggered": (np.vstack([ring([0, 90, 180, 270], -0.8), ring([45, 135, 225, 315], 0.8)]), 1),
    "two rows of four, aligned": (np.vstack([ring([0, 90, 180, 270], -0.8), ring([0, 90, 180, 270], 0.8)]), 3),
    "four at right angles and two at 45 and 135": (np.vstack([ring([0, 90, 180, 270], -0.8), ring([45, 135], 0.8)]), 1),
}


@pytest.mark.slow
@pytest.mark.parametrize("layout", ROWS)
def test_rows_at_every_rotation(layout):
    contacts, expected = ROWS[layout]
    worst = 0.0
    for rotation, axis in _rotations(np.random.default_rng(4))[: ROTATIONS // 4]:
        found = [c.surface for c in localize_cylinder(contacts @ rotation.T)]
        assert len(found) == expected
        worst = max(worst, min(np.linalg.norm(np.cross(s.direction, axis)) + abs(s.radius - 1) for s in found))
    print(f"\n{layout}: {expected} cylinders, worst error {worst:.1e}")
    assert worst < 1e-7


@pytest.mark.slow
def test_four_contacts_of_known_radius():
    rng = np.random.default_rng(5)
    count = max(INSTANCES // 100, 1)
    lost, numbers, seconds = 0, np.zeros(13, int), 0.0
    for _ in range(count):
        angle = rng.uniform(0, 2 * np.pi, 4)
        rotation = turned_to(_unit(rng.normal(size=3)))
        points = np.column_stack([np.cos(angle), np.sin(angle), rng.uniform(-1, 1, 4)]) @ rotation.T
        began = time.process_time()
        _, directions = tangent_lines(points, np.ones(4))
        seconds += time.process_time() - began
        numbers[len(directions)] += 1
        lost += not np.any(np.linalg.norm(np.cross(directions, rotation[:, 2]), axis=1) < 1e-5)
    print(f"\naxes of known radius through four contacts: {count} random problems, {lost} without the true one")
    print(f"  real axes 0..12: {np.round(numbers / count, 3).tolist()}, {seconds / count * 1e3:.1f} ms each")
    assert lost == 0
