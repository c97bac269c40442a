"""Fixtures by relations: noisy contacts give the true pose, exact relations hold, all shapes are found."""

import numpy as np
import pytest

import tactfix
from tactfix.frame import FrameError
from tactfix.relations.assembly import assembled_solutions
from tests.support.problems import (
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

SIX_DOF_UPPER = 38.3
"""Chi-square that six degrees of freedom exceed once in a million (tables)."""


@pytest.mark.parametrize("sigma", [1e-6, 1e-3, 0.1])
@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e3])
def test_exact_distances_hold_and_noise_keeps_the_true_pose(sigma, unit):
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
    """Two contacts and the distance leave two places for the ball, which noise makes coincide or complex."""
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


TANGENT = """tactfix: 1
name: bar and ball
units: mm
features:
  bar: {type: cylinder, radius: 10.0PLACE_BAR}
  ball: {type: sphere, radius: 12.0PLACE_BALL}
"""
BY_RELATIONS = """distances: [{between: [bar, ball], value: 40.0}]
frame: {origin: {foot_of: ball, on: bar}, y: {along: bar}, x: {from: bar, to: ball}}
"""


def bar_and_ball(tmp_path, by_relations):
    """The same bar and ball by relations and as one rigid body."""
    at_bar, at_ball = ", point: [0.0, 0.0, 0.0], direction: [0.0, 1.0, 0.0]", ", center: [40.0, 0.0, 0.0]"
    places = ("", "") if by_relations else (at_bar, at_ball)
    file = tmp_path / f"{by_relations}.yaml"
    text = TANGENT.replace("PLACE_BAR", places[0]).replace("PLACE_BALL", places[1])
    file.write_text(text + BY_RELATIONS * by_relations)
    return tactfix.load_fixture(file)


@pytest.mark.parametrize("seed", [5, 32, 57, *(pytest.param(k, marks=pytest.mark.slow) for k in (7, 8, 42, 53, 59))])
def test_a_ball_next_to_a_double_root_has_all_the_places_of_a_rigid_fixture(tmp_path, seed):
    """Its two contacts lie nearly in the direction of the bar, and noise has merged its two places, or left none."""
    rng = np.random.default_rng(seed)
    around, height = rng.uniform(0, 2 * np.pi, 5), rng.uniform(-30, 30, 5)
    on_bar = np.column_stack([np.cos(around), np.zeros(5), np.sin(around)])
    turn, off = rng.uniform(0, 2 * np.pi), 10 ** rng.uniform(-4, -1)
    sideways = 0.8 * np.array([0, np.cos(turn), np.sin(turn)])
    on_ball = [np.array([along, 0, 0]) + sideways + off * rng.normal(size=3) for along in (0.6, -0.6)]
    normals = np.vstack([on_bar, *(n / np.linalg.norm(n) for n in on_ball)])
    middles = np.vstack([np.column_stack([np.zeros(5), height, np.zeros(5)]), np.repeat([[40.0, 0, 0]], 2, axis=0)])
    radii = np.repeat([10.0, 12.0], [5, 2]) + 0.01 * rng.normal(size=7)
    names = ["bar"] * 5 + ["ball"] * 2
    contacts = tactfix.contacts_from_arrays(names, middles + radii[:, None] * normals, sigma=0.01, tip_radius=0.0)
    one, other = (
        tactfix.locate(bar_and_ball(tmp_path, by_relations), contacts, explain=False) for by_relations in (True, False)
    )
    assert (one.status, len(one.candidates)) == (other.status, len(other.candidates))


@pytest.mark.parametrize("apart", [0.0, 1e-4, 0.02])
def test_a_ball_touched_twice_at_one_place_leaves_a_motion_free(apart):
    """One of its two contacts adds nothing, which must not make the others inconsistent or raise an error."""
    fixture = related(BALLS, ball_distances(), BALLS_RECIPE)
    rng = np.random.default_rng(3)
    truth = touch_all(BALLS, {"a": 3, "b": 2, "c": 1}, rng, sigma=0.002)
    contacts = truth.contacts(rng)
    points = contacts.points.copy()
    points[4] = points[3] + [apart, 0, 0]
    again = tactfix.contacts_from_arrays(list(contacts.features), points, sigma=0.002, tip_radius=contacts.tip_radius)
    assert tactfix.locate(fixture, again).status == "underdetermined"


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


UPRIGHT = {
    "plate": Patch("plane", (0, 0, 0), (0, 0, 1), length=60.0),
    "pin": Patch("cylinder", (80, 0, 0), (0, 0, 1), 8.0, length=40.0, middle=30.0),
    "post": Patch("cylinder", (-30, 40, 0), (0, 0, 1), 12.0, length=40.0, middle=30.0),
    "ball": Patch("sphere", (10, -70, 30), radius=15.0),
}


@pytest.mark.parametrize("sigma", [1e-4, pytest.param(0.005, marks=pytest.mark.slow), 0.05])
@pytest.mark.parametrize("said_twice", [False, True])
@pytest.mark.parametrize("seeds", [range(2), pytest.param(range(2, 6), marks=pytest.mark.slow)])
def test_redundant_relations_of_parallel_features_change_nothing(sigma, said_twice, seeds):
    """Three features are pairwise parallel: two of the angles imply the third, but only if they hold exactly."""
    spaced = [
        ("pin", "post", np.hypot(110, 40)),
        ("ball", "pin", np.hypot(70, 70)),
        ("ball", "post", np.hypot(40, 110)),
    ]
    relations = [distance(*pair) for pair in spaced] + [distance("ball", "plate", 30.0)]
    relations += [angle("pin", "plate", 0.0), angle("post", "plate", 0.0)]
    relations += [angle("pin", "post", 0.0)] if said_twice else []
    frame = recipe(("center_of", "ball"), ("z", "along", "plate"), ("x", "from_to", "ball", "pin"))
    fixture = related(UPRIGHT, relations, frame)
    for seed in seeds:
        rng = np.random.default_rng(seed)
        truth = touch_all(UPRIGHT, {"plate": 4, "pin": 6, "post": 6, "ball": 4}, rng, sigma=sigma)
        contacts = truth.contacts(rng)
        solutions = assembled_solutions(fixture, contacts, contacts.sigmas)
        assert solutions.dof == 14
        # The other solution has the plate's normal reversed relative to the ball.
        assert min(s.chi2 for s in solutions.found) < 50
        at_ball = min(
            np.linalg.norm(s.surfaces["ball"].center - truth.pose[:3] @ [10, -70, 30, 1]) for s in solutions.found
        )
        assert at_ball < 10 * sigma


def test_a_relation_less_accurate_than_the_contacts_loses_no_pose():
    """The bar is not located without the ball: the fixture is searched as one body, with a distance off by a tenth."""
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
