"""Cylinders: the truth is among the candidates, every candidate fits, symmetries, rejected input, published values."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from tactfix.errors import DegenerateContactsError
from tactfix.localizers.cylinder import localize_cylinder
from tests.support.touched_surfaces import (
    AXES,
    TIDY_FIVES,
    TIDY_FIVES_WITH_MULTIPLE_ROOTS,
    axis_error,
    on_cylinder,
    random_rotation,
    ring,
    turned_to,
)

REFERENCE = json.loads((Path(__file__).parent / "data" / "cylinders.json").read_text())["sets"]


def _misses(cylinder, points):
    """Residuals of eq. 17, |(x - a) x s| - r |s|, written out."""
    return np.linalg.norm(np.cross(points - cylinder.point, cylinder.direction), axis=1) - cylinder.radius


def _found(candidates, point, direction, radius):
    return min((axis_error(c.surface, point, direction, radius) for c in candidates), default=np.inf)


@pytest.mark.parametrize("case", REFERENCE, ids=[case["name"] for case in REFERENCE])
def test_reference_sets(case):
    points = np.array(case["points"], dtype=float)
    if "axes" in case:
        assert len(localize_cylinder(points, case["radius"])) == case["axes"]
        return
    found = localize_cylinder(points)
    assert sorted(c.surface.radius for c in found) == pytest.approx(sorted(case["radii"]), abs=1e-6)
    for direction in case.get("directions", []):
        assert min(np.linalg.norm(np.cross(c.surface.direction, direction)) for c in found) < 1e-10


@pytest.mark.parametrize("axis", AXES, ids=str)
@pytest.mark.parametrize("n", [6, 40])
def test_the_direction_of_an_axis_does_not_depend_on_rounding(axis, n):
    """Other contacts of the same cylinder, in another order, change only the rounding."""
    rng = np.random.default_rng(n)
    best = []
    for _ in range(4):
        points = on_cylinder(rng, n) @ turned_to(axis, rng).T
        best.append(localize_cylinder(points, 1.0, 1e-3)[0].surface.direction)
    np.testing.assert_allclose(best, np.broadcast_to(best[0], (4, 3)), atol=1e-6)


@pytest.mark.parametrize("n", [4, 5, 6, 9, 20, 300])
@pytest.mark.parametrize("radius_known", [True, False])
def test_truth_is_among_the_candidates(n, radius_known):
    if n == 4 and not radius_known:
        pytest.skip("five contacts without a radius")
    rng = np.random.default_rng(n)
    for _ in range(15):
        rotation, place, radius = random_rotation(rng), rng.normal(size=3), 10 ** rng.uniform(-1, 1)
        points = on_cylinder(rng, n, radius, 2 * radius) @ rotation.T + place
        found = localize_cylinder(points, radius if radius_known else None)
        assert _found(found, place, rotation[:, 2], radius) < 1e-7
        for candidate in found:
            assert np.abs(_misses(candidate.surface, points)).max() < 1e-11 * radius


@pytest.mark.parametrize("layout", TIDY_FIVES)
def test_tidy_layouts_from_every_side(layout):
    counts = set()
    for k, axis in enumerate(AXES):
        rotation = turned_to(axis, None if k < 5 else np.random.default_rng(k))
        found = localize_cylinder(TIDY_FIVES[layout] @ rotation.T)
        counts.add(len(found))
        assert _found(found, np.zeros(3), axis, 1.0) < 1e-9
    assert len(counts) == 1, "the number of cylinders must not depend on the frame"


@pytest.mark.parametrize("layout", TIDY_FIVES_WITH_MULTIPLE_ROOTS)
def test_multiple_roots_are_found_once_and_marked(layout):
    counts = set()
    for axis in AXES:
        found = localize_cylinder(TIDY_FIVES_WITH_MULTIPLE_ROOTS[layout] @ turned_to(axis).T)
        counts.add(len(found))
        nearest = min(found, key=lambda c, axis=axis: axis_error(c.surface, np.zeros(3), axis, 1.0))
        # A root of order three is accurate to the cube root of the rounding only.
        assert axis_error(nearest.surface, np.zeros(3), axis, 1.0) < 1e-4
        assert nearest.poorly_determined
    assert len(counts) == 1


def test_a_double_root_that_noise_made_complex_is_kept_and_marked():
    # Contacts at the ends and the middle of one line, 5 sin(t) from the axis: noise leaves no real cylinder.
    points = np.vstack([ring([0], -1), ring([0], 0), ring([0], 1), ring([100, 220], 0.3)])
    points[1, 0] -= 1e-5
    assert not localize_cylinder(points)
    (only,) = localize_cylinder(points, sigmas=1e-5)
    assert only.poorly_determined
    assert axis_error(only.surface, np.zeros(3), [0, 0, 1], 1.0) < 0.05


@pytest.mark.parametrize("radius", [None, 2.0])
@pytest.mark.parametrize(("scale", "away"), [(1e-3, 0), (1e3, 0), (1.0, 1e4)])
def test_unit_of_length_and_place_do_not_matter(radius, scale, away):
    rng = np.random.default_rng(7)
    points = on_cylinder(rng, 5, 2.0, 5.0) @ random_rotation(rng).T
    here = localize_cylinder(points, radius)
    there = localize_cylinder(points * scale + away, None if radius is None else radius * scale, 1e-9 * scale)
    assert len(here) == len(there)
    for candidate in here:
        surface = candidate.surface
        assert _found(there, surface.point * scale + away, surface.direction, surface.radius * scale) < 1e-7 * scale


def test_order_of_contacts_does_not_matter():
    rng = np.random.default_rng(8)
    points = on_cylinder(rng, 5) @ random_rotation(rng).T
    reference = sorted(c.surface.radius for c in localize_cylinder(points))
    for _ in range(5):
        shuffled = localize_cylinder(points[rng.permutation(5)])
        assert sorted(c.surface.radius for c in shuffled) == pytest.approx(reference, abs=1e-9)


@pytest.mark.parametrize("radius", [1.0, None])
@pytest.mark.parametrize("apart", [0.0, 2e-6])
def test_several_touches_of_one_place_do_not_matter(radius, apart):
    """Four contacts, collinear to the last digit, may be chosen as the minimal subset of the search."""
    points = on_cylinder(np.random.default_rng(3), 8, 1.0)
    again = points[:1] + apart * np.outer([0.3, -0.4, 1.0, 0.7], [0.0, 0.0, 1.0])
    for order in range(12):
        mixed = np.random.default_rng(order).permutation(np.concatenate([points, again]))
        best = localize_cylinder(mixed, radius, 1e-5)[0]
        assert axis_error(best.surface, np.zeros(3), np.array([0.0, 0, 1]), 1.0) < 1e-4


def test_contacts_in_one_place_and_a_few_others_are_answered():
    """Four of seven contacts lie within two micrometres of one place."""
    points = [
        [0.2067603, -3.51430086, 3.07242884],
        [0.91386669, -4.85324607, 4.77953254],
        [1.91386703, -4.85324607, 3.77953523],
        [0.91386669, -4.85324607, 4.77953592],
        [0.20675955, -4.85324607, 4.48664237],
        [0.91386669, -4.85324607, 4.77953588],
        [0.91386669, -4.85324607, 4.77953166],
    ]
    found = localize_cylinder(np.array(points), 1.0, 1.6e-6)
    assert found
    for candidate in found:
        assert np.abs(_misses(candidate.surface, np.array(points))).max() < 1e-5


# Regular layouts: the last seeds have other cylinders next to a weakly determined one; the contacts of seed 9 have four
# distinct places.
@pytest.mark.parametrize("seed", [*range(9), *range(10, 30), 33, 57, 129, 155])
@pytest.mark.parametrize("radius", [1.0, None])
def test_an_early_end_of_the_search_misses_no_cylinder(seed, radius, monkeypatch):
    """If the search stops early because one minimal subset explains all contacts, a full search finds nothing more."""
    rng = np.random.default_rng(seed)
    sigma = 10 ** rng.uniform(-5, -2.5)
    points = on_cylinder(rng, 6 + seed % 4, length=10 ** rng.uniform(-0.3, 0.6))
    if seed % 2:
        layers = zip(rng.integers(0, 8, 6 + seed % 3), rng.choice([-0.5, 0.0, 0.5], 6 + seed % 3), strict=True)
        points = np.vstack([ring(45 * angle, z) for angle, z in layers])
    points = points + sigma * rng.normal(size=points.shape)
    found = localize_cylinder(points, radius, sigma)
    monkeypatch.setattr("tactfix.localizers.cylinder._are_all", lambda *_: False)
    every = localize_cylinder(points, radius, sigma)
    assert len(found) == len(every)
    for one, other in zip(found, every, strict=True):
        assert one.chi2 == pytest.approx(other.chi2, abs=1e-6)


def test_weights_follow_sigma():
    rng = np.random.default_rng(9)
    points = on_cylinder(rng, 12)
    points[0] *= [1.01, 1.01, 1]
    sigmas = np.full(12, 1e-4)
    sigmas[0] = 1e3
    (best, *_) = localize_cylinder(points, None, sigmas)
    assert axis_error(best.surface, np.zeros(3), [0, 0, 1], 1.0) < 1e-9


def test_ten_thousand_contacts_with_noise():
    rng = np.random.default_rng(10)
    points = on_cylinder(rng, 10_000, 5.0, 20.0) + rng.normal(scale=0.005, size=(10_000, 3))
    (only,) = localize_cylinder(points, 5.0, 0.005)
    assert axis_error(only.surface, np.zeros(3), [0, 0, 1], 5.0) < 1e-3


def test_contacts_that_no_cylinder_explains_still_give_the_least_squares_optimum():
    rng = np.random.default_rng(11)
    points = rng.normal(size=(9, 3))
    (best,) = localize_cylinder(points, None, 1e-6)
    assert best.chi2 > 1e6
    assert best.rms == pytest.approx(np.sqrt(np.mean(_misses(best.surface, points) ** 2)), rel=1e-9)


@pytest.mark.parametrize("radius", [None, 1.0])
@pytest.mark.parametrize("seed", [13, 17, 19, 33, 45, 54])
def test_every_answer_to_a_short_arc_with_much_noise_is_a_minimum(radius, seed):
    """Residuals contribute as much to the Hessian as the Jacobian does: descents must not stop early or at a saddle."""
    rng = np.random.default_rng(seed)
    n = 7 + seed % 6
    angle, height = rng.uniform(0, 2 * np.pi / 3, n), rng.uniform(-0.5, 0.5, n)
    points = np.column_stack([np.cos(angle), np.sin(angle), height]) + 0.03 * rng.standard_normal((n, 3))
    for answer in (candidate.surface for candidate in localize_cylinder(points, radius, 0.03)):
        across = np.linalg.svd(answer.direction[None])[2][1:]

        def misses(p, answer=answer, across=across):
            direction = answer.direction + p[2:4] @ across
            distance = np.linalg.norm(np.cross(points - answer.point - p[:2] @ across, direction), axis=1)
            return distance / np.linalg.norm(direction) - answer.radius - (p[4] if radius is None else 0.0)

        here = np.zeros(5 if radius is None else 4)
        best = least_squares(misses, here, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=5000)
        assert (np.sum(misses(here) ** 2) - 2 * best.cost) / 0.03**2 < 1e-6


def test_no_cylinder_is_an_empty_answer():
    hyperbola = np.array(
        [[np.cosh(t), np.sinh(t), 0.0] for t in (-1, 0.2, 1)] + [[-np.cosh(t), np.sinh(t), 0.0] for t in (0, 1.5)]
    )
    assert localize_cylinder(hyperbola) == ()
    assert localize_cylinder(on_cylinder(np.random.default_rng(1), 4, 1.0) * 50, 1.0) == ()


REFUSED = {
    "coincident": (np.vstack([ring([0, 100, 200, 300], 1), ring([0], 1)]), None, "different places"),
    "one line": (np.array([[0, 0, z] for z in range(6)], float), None, "one straight line"),
    "one line, radius known": (np.array([[0, 0, z] for z in range(4)], float), 1.0, "one straight line"),
    "four on a line": (
        np.vstack([ring([0], -1), ring([0], 0), ring([0], 1), ring([0], 2), ring([90])]),
        None,
        "two parallel",
    ),
    "two lines": (
        np.vstack([ring([0], -1), ring([0], 0), ring([0], 1), ring([90], 0), ring([90], 2)]),
        None,
        "two parallel",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
@pytest.mark.parametrize(("scale", "away"), [(1.0, 0.0), (1e-3, 0.0), (1e3, 0.0), (1.0, 1e4)])
def test_refusals_say_why_in_every_unit(name, scale, away):
    points, radius, why = REFUSED[name]
    rotation = random_rotation(np.random.default_rng(3))
    with pytest.raises(DegenerateContactsError, match=why) as refusal:
        localize_cylinder(points @ rotation.T * scale + away, None if radius is None else radius * scale)
    assert refusal.value.ratio <= refusal.value.limit


def test_two_parallel_lines_are_enough_when_the_radius_is_known():
    points = np.vstack([ring([0], -1), ring([0], 1), ring([80], -1), ring([80], 0.5)])
    found = localize_cylinder(points, 1.0)
    assert _found(found, np.zeros(3), [0, 0, 1], 1.0) < 1e-9
