"""The status of locate is correct in regular, degenerate and borderline cases."""

import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import tactfix
from tactfix.errors import TipDoesNotFitError
from tactfix.localization.free_motions import free_motions, is_underdetermined
from tactfix.localization.locate import locate
from tactfix.localization.outcome import outcome_of
from tactfix.probe import residual_sigmas
from tests.support.problems import (
    BALLS,
    CORNER,
    CYLINDER_SPHERE,
    CYLINDER_SPHERE_RECIPE,
    CYLINDER_SPHERE_TOUCH,
    PLATE,
    Patch,
    angle,
    box,
    distance,
    placed,
    pose_error,
    pose_of,
    random_pose,
    recipe,
    related,
    touch_all,
)
from tests.support.project import PLATE_FILE, ROOT

MAHALANOBIS_LIMIT = 38.3
"""Chi-square of six degrees of freedom, exceeded once in a million (tables)."""

BUSH = {
    "face": Patch("plane", (100, 0, 0), (0, 0, 1), length=25.0),
    "bush": Patch("cylinder", (0, 0, 0), (0, 0, 1), 15.0, side="inner", length=10.0, middle=-14.0),
    "ball": Patch("sphere", (200, 0, 45), radius=12.7, up=0.0),
}
PLENTY = {
    "plate": (PLATE, {"plate": 4, "pin": 5, "ball": 4}, {}),
    "corner": (CORNER, {"right": 3, "back": 3, "top": 3}, {}),
    "balls": (BALLS, {"a": 4, "b": 4, "c": 4}, {}),
    "bar": (CYLINDER_SPHERE, {"bar": 7, "ball": 4}, CYLINDER_SPHERE_TOUCH),
    "bush": (BUSH, {"face": 4, "bush": 5, "ball": 4}, {}),
}


def fixture_of(name, **more):
    patches, _, touch = PLENTY[name]
    return placed(patches, touch, approach=6.0 if name == "bush" else None, **more)


def assert_located_truly(result, truth):
    assert result.status == "located", (result.status, result.warnings, [c.reasons for c in result.candidates])
    error = pose_error(result.base_from_fixture, truth.pose)
    assert error @ np.linalg.solve(result.covariance, error) < MAHALANOBIS_LIMIT
    turn = result.base_from_fixture[:3, :3]
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) > 0


SMALL = {"bar": 1e-4}


@pytest.mark.parametrize("name", PLENTY)
@pytest.mark.parametrize("sigma", [1e-3, 0.1])
def test_plenty_of_contacts_locate(name, sigma):
    patches, counts, _ = PLENTY[name]
    sigma *= 0.03 if name == "bar" else 1.0
    rng = np.random.default_rng(1)
    for _ in range(2):
        truth = touch_all(patches, counts, rng, sigma=sigma, tip=0.0 if name == "bar" else 2.0)
        contacts = truth.contacts(rng)
        result = locate(fixture_of(name), contacts)
        assert_located_truly(result, truth)
        assert result.dof == len(contacts) - 6
        residuals = np.array([c.residual for c in result.contacts])
        assert result.rms == pytest.approx(np.sqrt(np.mean(residuals**2)))
        assert result.chi2 == pytest.approx(np.sum((residuals / sigma) ** 2))


@pytest.mark.parametrize("name", PLENTY)
def test_ten_metres_from_the_origin_with_a_micrometre(name):
    patches, counts, _ = PLENTY[name]
    rng = np.random.default_rng(2)
    pose = pose_of(random_pose(rng)[:3, :3], [1e4, -1e4, 1e4])
    truth = touch_all(patches, counts, rng, pose=pose, sigma=1e-3)
    assert_located_truly(locate(fixture_of(name), truth.contacts(rng)), truth)


@pytest.mark.parametrize("name", PLENTY)
@pytest.mark.parametrize(("units", "scale"), [("m", 1e-3), ("um", 1e3), ("in", 1 / 25.4)])
def test_the_unit_of_length_changes_nothing(name, units, scale):
    patches, counts, touch = PLENTY[name]
    results = []
    for factor, unit in ((1.0, "mm"), (scale, units)):
        rng = np.random.default_rng(3)
        truth = touch_all(patches, counts, rng, sigma=0.003, scale=factor)
        boxes = {n: box(*(factor * np.array([b.low, b.high])).T) for n, b in touch.items()}
        distance_ = 6.0 * factor if name == "bush" else None
        fixture = placed(patches, boxes, scale=factor, units=unit, approach=distance_)
        results.append(locate(fixture, truth.contacts(rng)))
        assert_located_truly(results[-1], truth)
    mm, other = results
    assert other.chi2 == pytest.approx(mm.chi2, rel=1e-5)
    np.testing.assert_allclose(other.base_from_fixture[:3, :3], mm.base_from_fixture[:3, :3], atol=1e-8)
    np.testing.assert_allclose(other.base_from_fixture[:3, 3] / scale, mm.base_from_fixture[:3, 3], atol=1e-6)
    lengths = np.array([1, 1, 1, scale, scale, scale])
    np.testing.assert_allclose(other.covariance / np.outer(lengths, lengths), mm.covariance, rtol=1e-4, atol=1e-12)


HALF_TURNS = [np.diag(signs) for signs in ([1.0, -1, -1], [-1, 1, -1], [-1, -1, 1])]
TIDY = [np.eye(3), *HALF_TURNS, np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])]


@pytest.mark.parametrize("turn", range(len(TIDY)))
def test_tidy_contacts_in_tidy_poses_without_noise(turn):
    """The corner of a cube, parallel to the axes, touched on a grid without noise, as in a drawing."""
    pose = pose_of(TIDY[turn], [100.0, 200.0, 300.0])
    grid = [(-20.0, -20.0), (-80.0, -20.0), (-50.0, -80.0)]
    touches = [("right", (0, a, b), (1, 0, 0)) for a, b in grid]
    touches += [("back", (a, 0, b), (0, 1, 0)) for a, b in grid]
    touches += [("top", (a, b, 0), (0, 0, 1)) for a, b in grid]
    truth = touch_all(CORNER, {"right": 3, "back": 3, "top": 3}, np.random.default_rng(0), pose=pose, sigma=0.01)
    points = np.array([p for _, p, _ in touches], float) @ TIDY[turn].T + pose[:3, 3]
    normals = np.array([n for _, _, n in touches], float) @ TIDY[turn].T
    result = locate(placed(CORNER), truth.contacts(points=points, approaches=-normals))
    assert_located_truly(result, truth)
    np.testing.assert_allclose(result.base_from_fixture, pose, atol=1e-9)


@pytest.mark.parametrize("angle", [np.pi, np.pi - 1e-9, np.pi - 1e-5, 1e-9])
def test_half_turns_about_any_axis(angle):
    rng = np.random.default_rng(4)
    axis = rng.normal(size=3)
    pose = pose_of(Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix(), [10.0, 20.0, 30.0])
    truth = touch_all(PLATE, {"plate": 4, "pin": 5, "ball": 4}, rng, pose=pose, sigma=1e-3, tip=2.0)
    assert_located_truly(locate(placed(PLATE), truth.contacts(rng)), truth)


def test_four_cylinders_through_a_tidy_layout_are_not_one():
    """Three evenly spaced contacts at each of two heights, length/radius sqrt 2: four cylinders of one radius.

    Two contacts on the ball do not distinguish between the four.
    """
    angles = np.radians([0, 120, 240, 60, 180, 300])
    heights = np.repeat([1.0, 1.0 + np.sqrt(2.0)], 3)
    bar = np.column_stack([np.cos(angles), heights, np.sin(angles)])
    truth = touch_all(CYLINDER_SPHERE, {"bar": 6}, np.random.default_rng(0), pose=np.eye(4), sigma=1e-4)
    contacts = truth.contacts(points=bar, approaches=-(bar * [1, 0, 1]))
    fixture = related(CYLINDER_SPHERE, [distance("bar", "ball", 3.0)], CYLINDER_SPHERE_RECIPE, CYLINDER_SPHERE_TOUCH)
    result = locate(fixture, contacts)
    assert result.status == "underdetermined"
    assert result.free_motions


def test_contacts_in_any_order_give_the_same_answer():
    rng = np.random.default_rng(5)
    truth = touch_all(PLATE, {"plate": 4, "pin": 5, "ball": 4}, rng, sigma=0.05, tip=2.0)
    contacts = truth.contacts(rng)
    first = locate(placed(PLATE), contacts)
    again = locate(placed(PLATE), contacts.subset(rng.permutation(len(contacts)).tolist()))
    np.testing.assert_allclose(again.base_from_fixture, first.base_from_fixture, atol=1e-7)
    np.testing.assert_allclose(again.covariance, first.covariance, rtol=1e-6)


def test_moving_base_moves_the_answer():
    rng = np.random.default_rng(6)
    truth = touch_all(BUSH, {"face": 4, "bush": 5, "ball": 4}, rng, sigma=0.01, tip=2.0)
    contacts = truth.contacts(rng)
    fixture = fixture_of("bush")
    first = locate(fixture, contacts)
    other = random_pose(rng, 2000)
    turn = other[:3, :3]
    moved = truth.contacts(points=contacts.points @ turn.T + other[:3, 3], approaches=contacts.approaches @ turn.T)
    again = locate(fixture, moved)
    np.testing.assert_allclose(again.base_from_fixture, other @ first.base_from_fixture, atol=1e-7)
    turned = np.kron(np.eye(2), turn)
    np.testing.assert_allclose(again.covariance, turned @ first.covariance @ turned.T, rtol=1e-5, atol=1e-12)


@pytest.mark.parametrize("name", ["plate", "balls", "bush"])
def test_ten_thousand_contacts_take_well_under_a_second(name):
    patches, counts, _ = PLENTY[name]
    rng = np.random.default_rng(7)
    few = touch_all(patches, dict.fromkeys(counts, 100), rng, sigma=0.05, tip=2.0)
    truth = few.repeated(10_000 // len(few.names))
    contacts = truth.contacts(rng)
    start = time.process_time()
    result = locate(fixture_of(name), contacts)
    assert time.process_time() - start < 1.0
    assert_located_truly(result, truth)


# Underdetermined. -------------------------------------------------------------------------------------------------


def test_an_untouched_feature_leaves_a_named_motion_free():
    rng = np.random.default_rng(8)
    truth = touch_all(PLATE, {"plate": 5, "pin": 6}, rng, sigma=0.01)
    result = locate(placed(PLATE), truth.contacts(rng))
    assert result.status == "underdetermined"
    assert result.base_from_fixture is None
    (motion,) = result.free_motions
    axis, at = truth.pose[:3, 2], truth.pose[:3, 3]
    assert abs(motion.rotation @ axis) == pytest.approx(1, abs=1e-3)
    np.testing.assert_allclose(motion.translation, np.cross(at, motion.rotation), atol=0.3)
    assert "pin" in motion.message


def test_a_bar_alone_turns_and_slides():
    rng = np.random.default_rng(9)
    truth = touch_all(CYLINDER_SPHERE, {"bar": 8}, rng, sigma=1e-3)
    result = locate(placed(CYLINDER_SPHERE), truth.contacts(rng))
    assert result.status == "underdetermined"
    axis = truth.pose[:3, 1]
    slide, turn = result.free_motions
    np.testing.assert_array_equal(slide.rotation, 0)
    assert abs(slide.translation @ axis) == pytest.approx(1, abs=1e-4)
    assert abs(turn.rotation @ axis) == pytest.approx(1, abs=1e-4)
    assert "bar" in result.surfaces
    assert np.linalg.norm(np.cross(result.surfaces["bar"].direction, axis)) < 1e-2


def test_two_balls_turn_about_their_line():
    rng = np.random.default_rng(10)
    truth = touch_all(BALLS, {"a": 5, "b": 5}, rng, sigma=0.01)
    result = locate(placed(BALLS), truth.contacts(rng))
    assert result.status == "underdetermined"
    (motion,) = result.free_motions
    assert abs(motion.rotation @ truth.pose[:3, 0]) == pytest.approx(1, abs=1e-6)
    assert {"a", "b"} <= set(result.surfaces)


@pytest.mark.parametrize("counts", [{"plate": 3, "pin": 2}, {"plate": 3, "ball": 2}, {"plate": 1}, {"ball": 1}])
def test_too_few_contacts_never_locate(counts):
    rng = np.random.default_rng(11)
    result = locate(placed(PLATE), touch_all(PLATE, counts, rng, sigma=0.05).contacts(rng))
    assert result.status == "underdetermined"
    assert result.base_from_fixture is None
    assert result.covariance is None
    assert result.free_motions


@pytest.mark.parametrize("feature", ["bar", "ball"])
@pytest.mark.parametrize("by_relations", [False, True])
def test_one_place_touched_eight_times_does_not_locate(feature, by_relations):
    """Neither the contacts nor the fixture, a single ball, have an extent that could scale the search."""
    fixture = placed(CYLINDER_SPHERE)
    if by_relations:
        fixture = related(CYLINDER_SPHERE, [distance("bar", "ball", 3.0)], CYLINDER_SPHERE_RECIPE)
    rng = np.random.default_rng(4)
    once = touch_all(CYLINDER_SPHERE, {feature: 1}, rng, sigma=0.0)
    contacts = once.contacts(rng)
    again = replace(
        contacts,
        features=(feature,) * 8,
        points=np.repeat(contacts.points, 8, axis=0),
        approaches=np.repeat(contacts.approaches, 8, axis=0),
        sigmas=np.full(8, 2e-6),
        rows=tuple(range(1, 9)),
        ids=(None,) * 8,
    )
    assert locate(fixture, again).status == "underdetermined"


def test_many_contacts_that_leave_a_motion_free_do_not_locate():
    """Ten contacts on each of three faces of a prism, which slides along its edges."""
    prism = {
        "one": Patch("plane", (50, 0, 0), (1, 0, 0), length=20.0),
        "two": Patch("plane", (0, 50, 0), (0, 1, 0), length=20.0),
        "three": Patch("plane", (-40, -40, 0), (-0.6, -0.8, 0), length=20.0),
    }
    rng = np.random.default_rng(12)
    truth = touch_all(prism, {"one": 10, "two": 10, "three": 10}, rng, sigma=0.01)
    result = locate(placed(prism), truth.contacts(rng))
    assert result.status == "underdetermined"
    (motion,) = result.free_motions
    np.testing.assert_array_equal(motion.rotation, 0)
    assert abs(motion.translation @ truth.pose[:3, 2]) == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("gap", [0.05, 0.2])
def test_a_weakly_determined_pose_is_underdetermined(gap):
    """Two contacts on the side face nearly coincide: full rank, but the turn about the top's normal is unknown."""
    rng = np.random.default_rng(13)
    truth = touch_all(CORNER, {"top": 3, "back": 2, "right": 1}, rng, pose=np.eye(4), sigma=0.05)
    points = np.array([[-10, -10, 0], [-90, -10, 0], [-50, -90, 0], [-50, 0, -50], [-50 - gap, 0, -50], [0, -50, -50]])
    normals = np.array([[0, 0, 1]] * 3 + [[0, 1, 0]] * 2 + [[1, 0, 0]])
    result = locate(placed(CORNER), truth.contacts(points=points.astype(float), approaches=-normals.astype(float)))
    assert result.status == "underdetermined"
    assert "known only to" in result.free_motions[0].message
    assert "in the linear model" not in result.free_motions[0].message


def test_the_status_near_a_fold_is_explained_despite_a_small_sigma():
    """Its linear sigma is within the limits, so the reason for underdetermined must be stated."""
    fixture = tactfix.load_fixture(PLATE_FILE)
    contacts = tactfix.load_contacts(ROOT / "samples" / "robot-cell-plate" / "contacts.csv", fixture)
    solution = outcome_of(fixture, contacts, residual_sigmas(fixture, contacts)).solutions.found[0]
    folded = replace(solution, trusted=False)
    assert is_underdetermined(folded, contacts)
    (motion,) = free_motions(fixture, contacts, folded)
    assert "in the linear model; within the noise it is not valid" in motion.message


# Ambiguous. -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["bar", "corner"])
def test_without_approaches_and_boxes_twins_stay(name):
    patches, counts, _ = PLENTY[name]
    rng = np.random.default_rng(14)
    truth = touch_all(patches, counts, rng, sigma=1e-4)
    contacts = truth.contacts(rng, approaches=np.full((sum(counts.values()), 3), np.nan))
    result = locate(placed(patches), contacts)
    assert result.base_from_fixture is None or name == "corner"
    accepted = [c for c in result.candidates if c.accepted]
    # The mirror-like pose of a cube corner fits as well; bar and ball have a half-turn.
    assert result.status == "ambiguous"
    assert len(accepted) > 1
    errors = [np.linalg.norm(pose_error(c.base_from_fixture, truth.pose)) for c in accepted]
    assert min(errors) < 0.1
    assert all(c.approach_angle_deg is None for c in result.contacts)


def test_the_half_turn_of_bar_and_ball_is_settled_by_the_box_alone():
    rng = np.random.default_rng(15)
    truth = touch_all(CYLINDER_SPHERE, {"bar": 7, "ball": 4}, rng, sigma=1e-4)
    contacts = truth.contacts(rng)
    open_ended = locate(placed(CYLINDER_SPHERE), contacts)
    assert open_ended.status == "ambiguous"
    boxed = locate(placed(CYLINDER_SPHERE, CYLINDER_SPHERE_TOUCH), contacts)
    assert_located_truly(boxed, truth)
    fallen = [c for c in boxed.candidates if not c.accepted]
    assert {reason.code for c in fallen for reason in c.reasons} == {"touch"}
    assert {reason.feature for c in fallen for reason in c.reasons} == {"bar"}


# Borderline cases are not decided. ----------------------------------------------------------------------------------


@pytest.mark.parametrize("off", [-0.04, 0.0, 0.04])
def test_a_contact_at_the_edge_of_its_box_gives_a_doubt_not_a_rejection(off):
    """One contact lies a fraction of sigma inside or outside the box: the true pose is kept."""
    rng = np.random.default_rng(16)
    truth = touch_all(PLATE, {"plate": 4, "pin": 5, "ball": 4}, rng, sigma=0.05, tip=2.0)
    local = (truth.points - truth.pose[:3, 3]) @ truth.pose[:3, :3]
    low = local[4:9, 2].min() + off
    result = locate(placed(PLATE, {"pin": box(z=(low, 100.0))}), truth.contacts(rng))
    assert_located_truly(result, truth)
    if off > 0:
        assert any("touch box" in warning for warning in result.warnings)


def test_a_contact_far_outside_its_box_rejects_the_pose():
    rng = np.random.default_rng(17)
    truth = touch_all(PLATE, {"plate": 4, "pin": 5, "ball": 4}, rng, sigma=0.05, tip=2.0)
    result = locate(placed(PLATE, {"pin": box(z=(200.0, 300.0))}), truth.contacts(rng), explain=False)
    assert result.status == "inconsistent"
    assert {reason.code for c in result.candidates for reason in c.reasons} == {"touch"}


@pytest.mark.parametrize("degrees", [89.9, 90.0, 90.1])
def test_a_grazing_approach_gives_a_doubt_not_a_rejection(degrees):
    """The approach to one contact on the pin is nearly tangential, slightly into or out of the material."""
    rng = np.random.default_rng(18)
    truth = touch_all(PLATE, {"plate": 4, "pin": 5, "ball": 4}, rng, sigma=0.05, tip=2.0, cone=0.0)
    approaches = truth.approaches.copy()
    along = truth.pose[:3, 2]
    lean = np.radians(degrees)
    approaches[5] = -np.cos(lean) * truth.normals[5] - np.sin(lean) * along
    result = locate(placed(PLATE), truth.contacts(rng, approaches=approaches))
    assert_located_truly(result, truth)
    assert any("grazes pin" in warning for warning in result.warnings)


def test_an_approach_from_within_the_material_rejects_the_pose():
    rng = np.random.default_rng(19)
    truth = touch_all(PLATE, {"plate": 4, "pin": 5, "ball": 4}, rng, sigma=0.05, tip=2.0)
    approaches = truth.approaches.copy()
    approaches[5] *= -1
    result = locate(placed(PLATE), truth.contacts(rng, approaches=approaches), explain=False)
    assert result.status == "inconsistent"
    true = [c for c in result.candidates if np.linalg.norm(pose_error(c.base_from_fixture, truth.pose)[:3]) < 0.01]
    assert [(reason.code, reason.row) for reason in true[0].reasons] == [("approach", 6)]


def test_a_path_through_another_feature_rejects_the_pose():
    """The approach to the ball passes through the bar."""
    rng = np.random.default_rng(20)
    truth = touch_all(CYLINDER_SPHERE, {"bar": 7, "ball": 4}, rng, sigma=1e-4)
    points, approaches, normals = truth.points.copy(), truth.approaches.copy(), truth.normals.copy()
    x = truth.pose[:3, 0]
    points[7] = truth.pose[:3, 3] + 2.0 * x
    approaches[7], normals[7] = x, -x
    both = {"bar": box(y=(-6.0, 6.0))}
    result = locate(placed(CYLINDER_SPHERE, both), truth.contacts(points=points, approaches=approaches), explain=False)
    true = [c for c in result.candidates if np.linalg.norm(pose_error(c.base_from_fixture, truth.pose)[:3]) < 0.01]
    if result.status == "inconsistent":
        assert [(reason.code, reason.feature, reason.row) for reason in true[0].reasons] == [("path", "ball", 8)]
    else:
        assert any("run through bar" in warning for warning in result.warnings)


# Inner surfaces and tips. -----------------------------------------------------------------------------------------


def test_a_boss_touched_where_a_bore_is_known_is_inconsistent():
    rng = np.random.default_rng(21)
    boss = {**BUSH, "bush": Patch("cylinder", (0, 0, 0), (0, 0, 1), 15.0, length=10.0, middle=-14.0)}
    truth = touch_all(boss, {"face": 4, "bush": 6, "ball": 4}, rng, sigma=0.01, tip=2.0)
    result = locate(fixture_of("bush"), truth.contacts(rng), explain=False)
    assert result.status == "inconsistent"


def test_planes_touched_from_below_are_the_other_side():
    """All contacts fit the fixture turned over as well; only the approaches distinguish the two."""
    rng = np.random.default_rng(22)
    two = {**CORNER, "top": Patch("plane", (-50, -50, 0), (0, 0, -1), length=45.0)}
    truth = touch_all(two, {"right": 3, "back": 3, "top": 3}, rng, sigma=0.01)
    assert_located_truly(locate(placed(two), truth.contacts(rng)), truth)
    assert locate(placed(CORNER), truth.contacts(rng), explain=False).status == "inconsistent"


def test_a_nearly_free_pose_is_not_rejected_by_approaches():
    """Four contacts on one bar and two on the other, next to a double root: the best fit is 20 degrees off.

    Chi-square hardly changes from there to the true pose, so an impossible approach at the best fit proves nothing.
    """
    bars = {
        "one": Patch("cylinder", (0, 0, 0), (1, 0, 0), 8.0, length=20.0, middle=30.0),
        "two": Patch("cylinder", (0, 0, 40), (0, 1, 0), 6.0, length=20.0, middle=30.0),
    }
    rng = np.random.default_rng([11, 10])
    truth = touch_all(bars, {"one": 4, "two": 2}, rng, sigma=0.01, tip=1.0)
    result = locate(placed(bars, {"one": box(x=(5, 55)), "two": box(y=(5, 55))}), truth.contacts(rng), explain=False)
    assert result.status in ("underdetermined", "ambiguous")


@pytest.mark.parametrize("seed", range(6))
def test_pins_that_are_parallel_within_a_sigma_are_one_pose(seed):
    """The spacing of nearly parallel axes depends slightly on the start of the fit, but is one pose."""
    pins = {
        "plate": Patch("plane", (100, 100, 0), (0, 0, 1), length=60.0),
        "p1": Patch("cylinder", (0, 0, 0), (0, 0, 1), 10.0, length=15.0, middle=20.0),
        "p2": Patch("cylinder", (200, 0, 0), (0, 0, 1), 10.0, length=15.0, middle=20.0),
    }
    relations = [angle("plate", "p1", 0, 0.01), angle("plate", "p2", 0, 0.01), distance("p1", "p2", 200.0, 0.01)]
    rule = recipe(("meet_of", "p1", "plate"), ("z", "along", "plate"), ("x", "from_to", "p1", "p2"))
    rng = np.random.default_rng([11, seed])
    truth = touch_all(pins, {"plate": 3, "p1": 5, "p2": 5}, rng, sigma=0.02, tip=1.5)
    assert_located_truly(locate(related(pins, relations, rule), truth.contacts(rng)), truth)


@pytest.mark.parametrize(("known", "warned"), [([], True), ([angle("a", "b", 0.0, 1.0)], False)])
def test_axes_that_only_seem_parallel_are_doubted(known, warned):
    """Axes at half a degree; the file gives their distance but not their angle."""
    askew = (np.sin(np.radians(0.5)), 0, np.cos(np.radians(0.5)))
    pins = {
        "a": Patch("cylinder", (0, 0, 0), (0, 0, 1), 5.0, length=20.0),
        "b": Patch("cylinder", (0, 40, 0), askew, 5.0, length=20.0),
        "ball": Patch("sphere", (60, 0, 0), radius=10.0),
    }
    recipe_ = recipe(("foot_of", "ball", "a"), ("z", "along", "a"), ("x", "from_to", "a", "ball"))
    touch = {"a": box(z=(-25, 25))}
    fixture = related(pins, [distance("a", "b", 40.0, 0.1), *known], recipe_, touch)
    contacts = touch_all(pins, {"a": 7, "b": 7, "ball": 5}, np.random.default_rng(1), sigma=0.01, tip=1.0).contacts()
    result = locate(fixture, contacts)
    assert result.base_from_fixture is not None or result.status == "ambiguous", result.status
    doubts = [w for w in result.warnings if "no angle is given" in w]
    assert len(doubts) == (1 if warned else 0)
    assert not warned or "a and b are 0.5 deg from parallel" in doubts[0]


def test_a_tip_that_does_not_fit_is_reported_in_the_fixtures_unit():
    """Also with many contacts, when each feature is located alone first."""
    contacts = touch_all(BUSH, {"face": 4, "bush": 6, "ball": 5}, np.random.default_rng(2), tip=2.0).contacts()
    with pytest.raises(TipDoesNotFitError, match=r"^bush: a tip of radius 16 does not fit into .* of radius 15;"):
        locate(placed(BUSH), replace(contacts, tip_radius=16.0))
