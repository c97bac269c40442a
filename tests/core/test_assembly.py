"""Fixtures by relations: every noisy set of contacts finds the truth, exact relations hold, all shapes are found."""

import numpy as np
import pytest
from core.problems import (
    BALLS,
    BALLS_RECIPE,
    CYLINDER_SPHERE,
    CYLINDER_SPHERE_RECIPE,
    CYLINDER_SPHERE_TOUCH,
    Patch,
    angle,
    ball_distances,
    distance,
    pose_error,
    recipe,
    related,
    touch_all,
)

from tactfix.frame import FrameError
from tactfix.relations.assembly import assembled_solutions

SIX_DOF_UPPER = 38.3
"""Chi-square that six degrees of freedom exceed once in a million (tables)."""


@pytest.mark.parametrize("sigma", [1e-6, 1e-3, 0.1])
@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e3])
def test_exact_distances_hold_and_no_noise_loses_the_truth(sigma, unit):
    fixture = related(BALLS, [*ball_distances()] if unit == 1 else scaled_distances(unit), BALLS_RECIPE, scale=unit)
    rng = np.random.default_rng(5)
    for _ in range(3):
        truth = touch_all(BALLS, {"a": 4, "b": 4, "c": 4}, rng, sigma=sigma, tip=2.0, scale=unit)
        contacts = truth.contacts(rng)
        best = assembled_solutions(fixture, contacts, contacts.sigmas).found[0]
        assert best.chi2 < SIX_DOF_UPPER
        error = pose_error(best.base_from_fixture, truth.pose)
        assert error @ np.linalg.solve(best.covariance, error) < SIX_DOF_UPPER
        for relation in fixture.relations:
            a, b = (best.surfaces[name].center for name in relation.between)
            assert np.linalg.norm(a - b) == pytest.approx(relation.value, rel=1e-8)


def scaled_distances(unit):
    return [type(r)(r.kind, r.between, r.value * unit, r.sigma * unit) for r in ball_distances()]


NEXT_TO_A_DOUBLE_ROOT = [(48, 1e-4), (95, 1e-4), (71, 1e-3), (12, 5e-3), (22, 5e-3), (56, 5e-3), (92, 5e-3)]


@pytest.mark.parametrize(("seed", "sigma"), NEXT_TO_A_DOUBLE_ROOT)
def test_ball_whose_two_places_all_but_coincide_is_not_lost(seed, sigma):
    """Two contacts and the distance leave two places for the ball; noise pushes them together and beyond."""
    rng = np.random.default_rng([7, seed])
    fixture = related(CYLINDER_SPHERE, [distance("bar", "ball", 3.0)], CYLINDER_SPHERE_RECIPE, CYLINDER_SPHERE_TOUCH)
    truth = touch_all(CYLINDER_SPHERE, {"bar": 5, "ball": 2}, rng, sigma=sigma)
    contacts = truth.contacts(rng)
    found = assembled_solutions(fixture, contacts, contacts.sigmas).found
    assert min(np.linalg.norm(pose_error(s.base_from_fixture, truth.pose)[:3]) for s in found) < 0.3
    for solution in found:
        gap = np.cross(
            solution.surfaces["ball"].center - solution.surfaces["bar"].point, solution.surfaces["bar"].direction
        )
        assert np.linalg.norm(gap) == pytest.approx(3.0, abs=1e-8)


PINS = {
    "plate": Patch("plane", (100, 100, 0), (0, 0, 1), length=60.0),
    "one": Patch("cylinder", (0, 0, 0), (0, 0, 1), 10.0, length=15.0, middle=20.0),
    "two": Patch("cylinder", (200, 0, 0), (0, 0, 1), 10.0, length=15.0, middle=20.0),
}
PINS_RECIPE = recipe(("meet_of", "one", "plate"), ("z", "along", "plate"), ("x", "from_to", "one", "two"))


@pytest.mark.parametrize(
    "relations",
    [
        [],
        [angle("plate", "one", 0), angle("plate", "two", 0), distance("one", "two", 200.0)],
        [angle("plate", "one", 0, 0.01), angle("two", "plate", 0, 0.01), distance("two", "one", 200.0, 0.01)],
    ],
    ids=["no relations", "exact", "with sigma"],
)
def test_two_pins_that_noise_has_made_not_quite_parallel(relations):
    rng = np.random.default_rng(8)
    fixture = related(PINS, relations, PINS_RECIPE)
    for _ in range(3):
        truth = touch_all(PINS, {"plate": 3, "one": 6, "two": 6}, rng, sigma=0.02, tip=1.5)
        contacts = truth.contacts(rng)
        errors = [
            pose_error(s.base_from_fixture, truth.pose)
            for s in assembled_solutions(fixture, contacts, contacts.sigmas).found
        ]
        assert min(np.linalg.norm(error[:3]) for error in errors) < 0.01
        assert min(np.linalg.norm(error[3:]) for error in errors) < 1.0


def test_a_relation_that_is_less_sure_than_the_contacts_loses_no_pose():
    """The bar needs the ball, so the fixture is searched as one body, though the distance is off by a tenth."""
    fixture = related(
        CYLINDER_SPHERE, [distance("bar", "ball", 3.0, 0.05)], CYLINDER_SPHERE_RECIPE, CYLINDER_SPHERE_TOUCH
    )
    for seed in (2, 9, 10):
        rng = np.random.default_rng([3, seed])
        off = 0.05 * rng.normal()
        built = {**CYLINDER_SPHERE, "ball": Patch("sphere", (3.0 + off, 0, 0), radius=1.0)}
        truth = touch_all(built, {"bar": 3, "ball": 5}, rng, sigma=1e-4)
        contacts = truth.contacts(rng)
        found = assembled_solutions(fixture, contacts, contacts.sigmas).found
        assert min(np.linalg.norm(pose_error(s.base_from_fixture, truth.pose)[:3]) for s in found) < 0.2


def test_a_recipe_that_gives_no_frame_is_an_error_not_an_inconsistency():
    rng = np.random.default_rng(9)
    skewed = recipe(("foot_of", "two", "one"), ("z", "along", "plate"), ("x", "from_to", "one", "two"))
    contacts = touch_all(PINS, {"plate": 3, "one": 6, "two": 6}, rng, sigma=0.02).contacts(rng)
    with pytest.raises(FrameError, match="no foot"):
        assembled_solutions(related(PINS, [], skewed), contacts, contacts.sigmas)
