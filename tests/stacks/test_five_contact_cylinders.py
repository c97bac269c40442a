"""Stacks of cylinders through five contacts, and their root finder."""

import tracemalloc

import numpy as np
import pytest

from tactfix.errors import UsageError
from tactfix.localizers.cylinder import localize_cylinder
from tactfix.stacks.five_contact_cylinders import cylinders_through_five
from tactfix.stacks.sphere_centers import sphere_centers
from tactfix.stacks.trigonometric_zeros import trigonometric_zeros
from tests.support.touched_surfaces import (
    AXES,
    TIDY_FIVES,
    TIDY_FIVES_WITH_MULTIPLE_ROOTS,
    on_cylinder,
    random_rotation,
    turned_to,
)


def _error(stack, index, direction, radius=1.0):
    tilt = np.linalg.norm(np.cross(stack.directions[index], direction / np.linalg.norm(direction)), axis=-1)
    return np.nanmin(np.maximum(tilt, np.abs(stack.radii[index] - radius)))


def test_stack_equals_one_at_a_time():
    rng = np.random.default_rng(1)
    points = np.array([on_cylinder(rng, 5) @ random_rotation(rng).T + rng.normal(size=3) for _ in range(60)])
    stack = cylinders_through_five(points.reshape(3, 20, 5, 3))
    assert stack.directions.shape == (3, 20, 6, 3)
    for k, contacts in enumerate(points):
        index = np.unravel_index(k, (3, 20))
        one = sorted(c.surface.radius for c in localize_cylinder(contacts))
        assert sorted(stack.radii[index][stack.valid[index]]) == pytest.approx(one, rel=1e-6)


def test_every_cylinder_passes_through_its_contacts():
    rng = np.random.default_rng(2)
    points = rng.normal(size=(300, 5, 3))
    stack = cylinders_through_five(points)
    assert set(stack.valid.sum(axis=1)) <= {0, 2, 4, 6}
    for k in np.flatnonzero(stack.valid.any(axis=1)):
        for a, s, r in zip(stack.points[k], stack.directions[k], stack.radii[k], strict=True):
            if np.isfinite(r):
                distance = np.linalg.norm(np.cross(points[k] - a, s), axis=1)
                assert distance == pytest.approx(np.full(5, r), rel=1e-6)


@pytest.mark.parametrize("layout", [*TIDY_FIVES, *TIDY_FIVES_WITH_MULTIPLE_ROOTS])
def test_tidy_layouts_from_every_side(layout):
    contacts = TIDY_FIVES.get(layout, TIDY_FIVES_WITH_MULTIPLE_ROOTS.get(layout))
    points = np.array([contacts @ turned_to(axis).T for axis in AXES])
    stack = cylinders_through_five(points)
    counts = stack.valid.sum(axis=1)
    assert len(set(counts)) == 1
    for k, axis in enumerate(AXES):
        assert _error(stack, k, axis) < (1e-9 if layout in TIDY_FIVES else 1e-4)


def test_a_double_root_that_noise_made_complex_is_kept_within_tolerance():
    contacts = TIDY_FIVES_WITH_MULTIPLE_ROOTS["three on one line and two"].copy()
    contacts[1, 0] -= 1e-5
    assert not cylinders_through_five(contacts).valid.any()
    stack = cylinders_through_five(contacts, 1e-5)
    assert stack.valid.sum() == 1
    assert _error(stack, (), np.array([0, 0, 1.0])) < 0.05


def test_degenerate_problems_do_not_stop_a_stack():
    rng = np.random.default_rng(3)
    sound = on_cylinder(rng, 5)
    stack = cylinders_through_five(np.array([np.zeros((5, 3)), sound, np.outer(np.arange(5), [1, 2, 3])]))
    assert stack.valid[1].any()
    assert _error(stack, 1, np.array([0, 0, 1.0])) < 1e-9


# Two of 100,000 random problems: the zeros of the cubic on the conic nearly coincide, and one Newton step is too few.
HARD = {
    "well conditioned": (
        [2.79904, 1.96714, 4.8431, 4.62268, 0.95138],
        [-0.65584, -0.55322, -0.41313, 0.54678, 0.85692],
    ),
    "and another": ([1.15532, 0.17787, 2.92489, 5.32459, 2.79508], [-0.58566, 0.29023, 0.40245, -0.90949, -0.14214]),
}


@pytest.mark.parametrize("name", HARD)
def test_crowded_zeros_are_followed_to_their_end(name):
    angle, z = np.array(HARD[name])
    contacts = np.column_stack([np.cos(angle), np.sin(angle), z])
    points = np.array([contacts @ turned_to(axis).T for axis in AXES])
    stack = cylinders_through_five(points)
    for k, axis in enumerate(AXES):
        assert _error(stack, k, axis) < 1e-12


def test_thin_tetrahedra_are_exact_too():
    rng = np.random.default_rng(5)
    # Of 4,000 at most one per cent: two per cent would give 80 with a standard deviation of 9, and be detected.
    points = on_cylinder(rng, 20_000).reshape(4_000, 5, 3) * [1.0, 1.0, 0.02]
    stack = cylinders_through_five(points)
    arms = np.cross(points[:, None] - stack.points[:, :, None], stack.directions[:, :, None])
    misses = np.nanmax(np.abs(np.linalg.norm(arms, axis=-1) - stack.radii[..., None]), axis=(1, 2))
    assert np.quantile(misses, 0.99) < 1e-12


def test_points_of_another_shape_are_refused():
    with pytest.raises(UsageError, match=r"\(\.\.\., 5, 3\)"):
        cylinders_through_five(np.zeros((7, 4, 3)))
    with pytest.raises(UsageError, match=r"\(\.\.\., 3, 3\)"):
        sphere_centers(np.zeros((3,)), 1.0)


def test_memory_beyond_the_answer_does_not_grow():
    def most(count: int) -> int:
        points = np.random.default_rng(6).normal(size=(count, 5, 3))
        tracemalloc.start()
        stack = cylinders_through_five(points)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return peak - sum(a.nbytes for a in (stack.points, stack.directions, stack.radii))

    few = most(10_000)
    # A flag and a volume for each problem, and the memory of one chunk.
    assert most(100_000) < few + 90_000 * 64


def test_trigonometric_zeros_against_companion_roots():
    rng = np.random.default_rng(4)
    harmonics = rng.normal(size=(7, 2000))
    angles = 2 * np.pi * np.arange(7) / 7
    basis = [np.ones(7), np.cos(angles), np.sin(angles), np.cos(2 * angles), np.sin(2 * angles)]
    basis += [np.cos(3 * angles), np.sin(3 * angles)]
    places, certain = trigonometric_zeros(np.array(basis).T @ harmonics)
    assert certain.mean() > 0.99
    for k in np.flatnonzero(certain):
        a0, a1, b1, a2, b2, a3, b3 = harmonics[:, k]
        powers = [a3 - 1j * b3, a2 - 1j * b2, a1 - 1j * b1, 2 * a0, a1 + 1j * b1, a2 + 1j * b2, a3 + 1j * b3]
        roots = np.roots(powers)
        # Rounding decides whether a pair of roots near the unit circle is on it; such polynomials are not certain.
        real = roots[np.abs(np.abs(roots) - 1) < 1e-9]
        found = places[0, :, k] + 1j * places[1, :, k]
        found = found[np.isfinite(found)]
        assert len(found) == len(real)
        assert all(np.abs(found - root).min() < 1e-7 for root in real)


def test_trigonometric_double_zeros_are_not_certain():
    angles = 2 * np.pi * np.arange(7) / 7
    double = np.cos(angles - 1.0) - 1.0
    near = np.cos(angles - 1.0) - 1.0 + 1e-10
    apart = np.cos(angles - 1.0) - 0.5
    _, certain = trigonometric_zeros(np.array([double, near, apart]).T)
    assert certain.tolist() == [False, False, True]
