"""Pose and tip together: against scipy's least squares with residuals written here, real robots, and random draws."""

import json
from time import process_time

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from scipy.stats import chi2 as chi_square

from tactfix import Fixture, LocateResult, UsageError, contacts_from_arrays, locate
from tactfix.geometry.surfaces import Plane, Point, Sphere
from tactfix.unknowns.equations import TipEquations
from tactfix.unknowns.search import tip_solutions
from tests.support.flange_touches import (
    NOMINAL,
    PLATE,
    RADIUS,
    SEAT,
    SIGMA,
    Cell,
    Touched,
    fixture_of,
    orientations,
    plate_touches,
    touched,
)
from tests.support.shared_data import shared_data

SIDEWAYS = np.array([0.4, -0.3, 0.0])


def plate_problem(seed: int, count: int, tilt: float, error: np.ndarray = SIDEWAYS, **how: float) -> Touched:
    rng = np.random.default_rng(seed)
    return touched(plate_touches(rng), rng, orientations(count, tilt), error, **how)


def residuals_of(problem: Touched, unknowns: np.ndarray) -> np.ndarray:
    """Residuals in sigma; unknowns: rotation vector, translation, change of the tip offset, tip radius."""
    flanges = problem.contacts.flange_rotations
    tips = problem.contacts.points + flanges @ unknowns[6:9]
    local = Rotation.from_rotvec(unknowns[:3]).inv().apply(tips - unknowns[3:6])
    names, t = np.array(problem.contacts.features), unknowns[9]
    pin = np.linalg.norm(local[:, :2], axis=1) - 10.0 - t
    ball = np.linalg.norm(local - [300.0, 180.0, 60.0], axis=1) - 19.05 - t
    return np.where(names == "plate", local[:, 2] - t, np.where(names == "pin", pin, ball)) / SIGMA


def independent(problem: Touched, free: list[int]) -> tuple[np.ndarray, float]:
    """The solution of scipy's least squares for the unknowns with these indices, from the truth; and its chi-square."""
    truth = np.concatenate([problem.turn.as_rotvec(), problem.shift, problem.tip - NOMINAL, [RADIUS]])

    def residuals(values: np.ndarray) -> np.ndarray:
        whole = truth.copy()
        whole[free] = values
        return residuals_of(problem, whole)

    scale = np.array([1e-3] * 3 + [1.0] * 7)[free]
    found = least_squares(residuals, truth[free], x_scale=scale, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    truth[free] = found.x
    return truth, 2 * found.cost


def distance(result: LocateResult, problem: Touched) -> float:
    """The squared error of the pose by its covariance: chi-square with six degrees of freedom."""
    turn = Rotation.from_matrix(result.base_from_fixture[:3, :3]) * problem.turn.inv()
    off = -np.concatenate([turn.as_rotvec(), result.base_from_fixture[:3, 3] - problem.shift])
    return float(off @ np.linalg.solve(result.covariance, off))


@pytest.mark.parametrize(("count", "tilt"), [(3, 20.0), (4, 45.0), (6, 90.0)])
def test_it_is_the_least_squares_that_scipy_finds(count: int, tilt: float) -> None:
    problem = plate_problem(count, count, tilt)
    expected, chi2 = independent(problem, list(range(9)))
    result = locate(fixture_of(PLATE), problem.contacts, unknown=["tip"])
    assert result.status == "located"
    assert result.chi2 == pytest.approx(chi2, rel=1e-6)
    assert result.dof == 18 - 9
    np.testing.assert_allclose(result.base_from_fixture[:3, 3], expected[3:6], atol=1e-5)
    np.testing.assert_allclose(result.tip.offset, NOMINAL + expected[6:9], atol=1e-5)
    assert result.unknowns == ("rx", "ry", "rz", "tx", "ty", "tz", "tip_x", "tip_y", "tip_z")
    np.testing.assert_allclose(result.joint_covariance[6:, 6:], result.tip.covariance)
    np.testing.assert_allclose(result.joint_covariance[:6, :6], result.covariance)


def test_tip_and_radius_together_as_scipy_finds_them() -> None:
    problem = plate_problem(11, 4, 45.0, stated_radius=2.8)
    expected, chi2 = independent(problem, list(range(10)))
    result = locate(fixture_of(PLATE), problem.contacts, unknown=["tip", "tip-radius"])
    assert result.status == "located"
    assert result.chi2 == pytest.approx(chi2, rel=1e-6)
    assert result.tip.radius == pytest.approx(expected[9], abs=1e-5)
    np.testing.assert_allclose(result.tip.offset, NOMINAL + expected[6:9], atol=1e-5)
    # Predicted for eighteen contacts in four orientations at 45 deg: 0.044 and 0.026 mm.
    assert np.sqrt(result.joint_covariance[9, 9]) == pytest.approx(0.026, rel=0.3)
    assert np.sqrt(np.linalg.eigvalsh(result.tip.covariance[:3, :3])[-1]) < 0.09


def test_the_radius_alone_needs_no_flange() -> None:
    problem = plate_problem(12, 3, 20.0, np.zeros(3), stated_radius=2.0)
    bare = contacts_from_arrays(
        problem.contacts.features, problem.contacts.points, problem.contacts.approaches, sigma=SIGMA, tip_radius=2.0
    )
    expected, chi2 = independent(problem, [*range(6), 9])
    result = locate(fixture_of(PLATE), bare, unknown=["tip-radius"])
    assert result.status == "located"
    assert result.chi2 == pytest.approx(chi2, rel=1e-6)
    assert result.tip.radius == pytest.approx(expected[9], abs=1e-5)
    assert result.tip.offset is None


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_in_any_unit(scale: float) -> None:
    problem = plate_problem(2, 4, 30.0)
    scaled = plate_problem(2, 4, 30.0, scale=scale)
    plate = {
        "plate": PLATE["plate"],
        "pin": type(PLATE["pin"])(np.zeros(3), np.array([0.0, 0.0, 1.0]), 10.0 * scale),
        "ball": type(PLATE["ball"])(PLATE["ball"].center * scale, 19.05 * scale),
    }
    one = locate(fixture_of(PLATE), problem.contacts, unknown=["tip"])
    other = locate(fixture_of(plate), scaled.contacts, unknown=["tip"])
    np.testing.assert_allclose(other.tip.offset / scale, one.tip.offset, atol=1e-6)
    np.testing.assert_allclose(np.sqrt(np.diag(other.tip.covariance)) / scale, np.sqrt(np.diag(one.tip.covariance)))


def test_the_jacobian_is_that_of_differences() -> None:
    problem = plate_problem(4, 4, 30.0)
    surfaces = PLATE | SEAT
    place = problem.turn.apply([20.0, 30.0, 0.0]) + problem.shift - problem.contacts.flange_rotations[0] @ SIDEWAYS
    seat = contacts_from_arrays(
        ["seat", *problem.contacts.features],
        np.vstack([place, problem.contacts.points]),
        sigma=SIGMA,
        tip_radius=RADIUS,
        flange_rotations=np.vstack([problem.contacts.flange_rotations[:1], problem.contacts.flange_rotations]),
        tip_offset=NOMINAL,
    )
    equations = TipEquations.build(surfaces, seat, seat.sigmas, frozenset({"tip", "tip-radius"}))
    trial = equations.trials(problem.pose[None], SIDEWAYS[None], RADIUS)
    jacobian = equations.evaluate(trial)[1][0]
    for k in range(10):
        step = np.zeros((1, 10))
        step[0, k] = 1e-6
        ahead = equations.evaluate(equations.stepped(trial, step))[0][0]
        behind = equations.evaluate(equations.stepped(trial, -step))[0][0]
        difference = (ahead - behind) / 2e-6
        np.testing.assert_allclose(jacobian[:, k], difference, atol=1e-5 * np.abs(jacobian).max())


def test_one_orientation_leaves_three_motions_free_and_two_leave_one() -> None:
    for count, free in ((1, 3), (2, 1)):
        result = locate(fixture_of(PLATE), plate_problem(3, count, 20.0).contacts, unknown=["tip"])
        assert result.status == "underdetermined"
        assert result.tip is None
        assert len(result.free_motions) == free
        for motion in result.free_motions:
            assert motion.message.startswith("tip and fixture move together along")
            assert motion.message.endswith("turn the tool about another axis")
            assert np.linalg.norm(motion.translation) == pytest.approx(1.0, abs=1e-6)


def test_orientations_that_differ_by_the_noise_of_encoders_are_one() -> None:
    problem = plate_problem(3, 1, 0.0)
    jitter = Rotation.from_rotvec(np.random.default_rng(1).normal(0, 1e-6, (18, 3))).as_matrix()
    contacts = contacts_from_arrays(
        problem.contacts.features,
        problem.contacts.points,
        sigma=SIGMA,
        tip_radius=RADIUS,
        flange_rotations=jitter @ problem.contacts.flange_rotations,
        tip_offset=NOMINAL,
    )
    result = locate(fixture_of(PLATE), contacts, unknown=["tip"])
    assert result.status == "underdetermined"
    assert len(result.free_motions) == 3


def test_a_tip_half_a_millimetre_off_sideways_in_20_random_directions() -> None:
    for seed in range(20):
        angle = np.random.default_rng(seed).uniform(0, 2 * np.pi)
        problem = plate_problem(100 + seed, 3, 20.0, 0.5 * np.array([np.cos(angle), np.sin(angle), 0.0]))
        result = locate(fixture_of(PLATE), problem.contacts, unknown=["tip"])
        assert result.status == "located"
        assert distance(result, problem) < chi_square.isf(1e-4, 6)
        off = result.tip.offset - problem.tip
        assert off @ np.linalg.solve(result.tip.covariance, off) < chi_square.isf(1e-4, 3)


@pytest.mark.parametrize(
    ("count", "tilt", "draws", "named"),
    [
        (3, 20.0, 10, 9),
        (4, 45.0, 6, 6),
        pytest.param(3, 20.0, 20, 18, marks=pytest.mark.slow),
        pytest.param(4, 45.0, 20, 20, marks=pytest.mark.slow),
    ],
)
def test_a_tip_error_of_half_a_millimetre_is_named_if_the_tip_is_known(
    count: int, tilt: float, draws: int, named: int
) -> None:
    """With or without a remaining pose the tip is named, and neither good contacts nor sigma are blamed."""
    codes = []
    for seed in range(draws):
        angle = np.random.default_rng(seed).uniform(0, 2 * np.pi)
        off = 0.5 * np.array([np.cos(angle), np.sin(angle), 0.0])
        problem = plate_problem(100 + seed, count, tilt, off)
        result = locate(fixture_of(PLATE), problem.contacts)
        codes += [cause.code for cause in result.diagnosis[:1]]
        for cause in result.diagnosis:
            if cause.code == "tip_offset" and not cause.one_of:
                assert np.linalg.norm(np.array(cause.value) - problem.tip) < 0.6
                break
    assert set(codes) == {"tip_offset"}
    assert len(codes) >= named


def test_a_tip_that_is_right_is_seldom_doubted() -> None:
    doubted = 0
    for seed in range(150):
        result = locate(fixture_of(PLATE), plate_problem(300 + seed, 4, 45.0, np.zeros(3)).contacts)
        assert result.status == "located"
        doubted += any(cause.code == "tip_offset" for cause in result.diagnosis)
    # One in a thousand sets of good contacts.
    assert doubted <= 2


def test_one_orientation_gives_no_finding_on_the_tip() -> None:
    problem = plate_problem(9, 1, 0.0, np.array([3.0, 0.0, 0.0]))
    result = locate(fixture_of(PLATE), problem.contacts)
    assert result.status == "located"
    assert not any(cause.code == "tip_offset" for cause in result.diagnosis)


def test_a_tip_beyond_its_bound_is_rejected() -> None:
    problem = plate_problem(5, 4, 45.0, np.array([8.0, 0.0, 0.0]))
    near, far = (locate(fixture_of(PLATE, w), problem.contacts, unknown=["tip"]) for w in (5.0, 10.0))
    assert far.status == "located"
    assert "may explain" not in far.tip.message
    np.testing.assert_allclose(far.tip.offset, problem.tip, atol=0.5)
    assert near.status == "inconsistent"
    assert [reason.code for candidate in near.candidates for reason in candidate.reasons] == ["tip"]


def test_a_distant_tip_without_bound_is_found_but_not_located() -> None:
    problem = plate_problem(6, 4, 45.0, np.array([12.0, -5.0, 7.0]))
    result = locate(fixture_of(PLATE), problem.contacts, unknown=["tip"])
    assert result.status == "located"
    np.testing.assert_allclose(result.tip.offset, problem.tip, atol=0.5)
    assert "may explain" in result.tip.message


def test_a_bound_as_wide_as_the_distance_of_features_hides_no_pose() -> None:
    """With a tip bound of 14 mm, contacts do not separate a seat from a plate that is 25 mm away."""
    rng, tools = np.random.default_rng(3), Rotation.random(3, random_state=3)
    flat = rng.uniform([-25, -25, RADIUS], [25, 25, RADIUS], (4, 3))
    seat = np.tile([12.0, 8.0, 15.0], (4, 1))
    ways = np.vstack([np.tile([0.0, 0.0, -1.0], (4, 1)), np.full((4, 3), np.nan)])
    cell = Cell(["plate"] * 4 + ["seat"] * 4, np.vstack([flat, seat]), ways)
    problem = touched(cell, rng, tools, 0.2 * SIDEWAYS, sigma=0.0005)
    fixture = fixture_of({"plate": PLATE["plate"], "seat": Point(seat[0])}, within=14.0)
    result = locate(fixture, problem.contacts, unknown=["tip"])
    assert result.status == "underdetermined"  # the plate may rotate about its normal
    np.testing.assert_allclose(result.tip.offset, NOMINAL + 0.2 * SIDEWAYS, atol=0.01)


@pytest.mark.parametrize("scale", [1e-3, 1.0])
def test_a_radius_correlated_with_a_rotation_is_not_determined(scale: float) -> None:
    """Two contacts on a ball and one in a seat: if the ball turns about the seat, the radius changes slightly."""
    fixture = fixture_of(
        {"seat": Point(np.array([0.0, 0.0, 0.0])), "ball": Sphere(np.array([100.0, 0.0, 0.0]) * scale, 20.0 * scale)},
        units="m" if scale < 1 else "mm",
    )
    for lean in (1e-3, 0.01, 0.3):
        # If nearly collinear with the seat, the radius hardly changes with the rotation.
        up = np.array([np.sin(lean), 0.0, np.cos(lean)])
        across = np.array([0.0, 0.6, 0.0])
        ball = np.array([100.0, 0.0, 0.0]) + 23.0 * np.array([up * 0.8 + across, up * 0.8 - across])
        points = np.vstack([np.zeros(3), ball]) * scale
        contacts = contacts_from_arrays(["seat", "ball", "ball"], points, sigma=1e-3 * scale, tip_radius=2.0 * scale)
        result = locate(fixture, contacts, unknown=["tip-radius"])
        assert result.status == "underdetermined"
        assert result.tip is None


def test_a_wrong_contact_is_not_diagnosed_as_a_wrong_tip() -> None:
    problem = plate_problem(7, 4, 45.0)
    points = problem.contacts.points.copy()
    points[9] += 5.0 * problem.contacts.approaches[9]
    wrong = contacts_from_arrays(
        problem.contacts.features,
        points,
        problem.contacts.approaches,
        sigma=SIGMA,
        tip_radius=RADIUS,
        flange_rotations=problem.contacts.flange_rotations,
        tip_offset=NOMINAL,
    )
    result = locate(fixture_of(PLATE), wrong, unknown=["tip"])
    assert result.status == "inconsistent"
    assert result.tip is None


def seat_touches(count: int, error: np.ndarray, seed: int = 9) -> Touched:
    rng = np.random.default_rng(seed)
    cell = Cell(["seat"] * count, np.tile([20.0, 30.0, 0.0], (count, 1)), np.tile([0.0, 0.0, -1.0], (count, 1)))
    return touched(cell, rng, orientations(count, 40.0), error)


def linear_tip(contacts: object) -> np.ndarray:
    """The change d of the tip and the place p that minimize |x_i + Q_i d - p|^2."""
    rows = np.concatenate([contacts.flange_rotations, np.tile(-np.eye(3), (len(contacts.points), 1, 1))], axis=2)
    return np.linalg.lstsq(rows.reshape(-1, 6), -contacts.points.ravel(), rcond=None)[0][:3]


def test_a_lone_seat_calibrates_the_tool() -> None:
    problem = seat_touches(5, np.array([3.0, -2.0, 1.0]))
    result = locate(fixture_of(SEAT), problem.contacts, unknown=["tip"])
    assert result.status == "underdetermined"
    np.testing.assert_allclose(result.tip.offset, NOMINAL + linear_tip(problem.contacts), atol=1e-6)
    assert all("rotates about" in motion.message for motion in result.free_motions)
    assert len(result.free_motions) == 3
    assert result.dof == 15 - 9


def test_a_lone_plane_calibrates_the_tool() -> None:
    rng = np.random.default_rng(4)
    tips = np.column_stack([rng.uniform(-200, 200, (30, 2)), np.full(30, RADIUS)])
    cell = Cell(["plate"] * 30, tips, np.tile([0.0, 0.0, -1.0], (30, 1)))
    problem = touched(cell, rng, orientations(6, 35.0), np.array([2.0, 1.0, -3.0]))
    result = locate(fixture_of({"plate": PLATE["plate"]}), problem.contacts, unknown=["tip"])
    assert result.status == "underdetermined"
    off = result.tip.offset - problem.tip
    assert off @ np.linalg.solve(result.tip.covariance, off) < chi_square.isf(1e-4, 3)
    assert len(result.free_motions) == 3


def four_poses() -> tuple[np.ndarray, np.ndarray]:
    published = json.loads((shared_data("reference/real/tip") / "published.json").read_text())["four_poses"]
    poses = np.array(published["poses"])
    return poses[:, :3], Rotation.from_rotvec(poses[:, 3:], degrees=True).as_matrix()


def test_four_poses_of_a_real_robot_give_its_tip() -> None:
    origins, flanges = four_poses()
    for start in ([0.0, 0.0, 0.0], [5.25, 95.13, 308.52]):
        contacts = contacts_from_arrays(
            "seat", origins + flanges @ start, sigma=1.5, tip_radius=0.0, flange_rotations=flanges, tip_offset=start
        )
        result = locate(fixture_of({"seat": Point(np.zeros(3))}), contacts, unknown=["tip"])
        assert result.status == "underdetermined"
        np.testing.assert_allclose(result.tip.offset, start + linear_tip(contacts), atol=1e-5)
        np.testing.assert_allclose(result.tip.offset, [6.10, 92.53, 307.28], atol=0.01)


def test_touches_of_a_table_by_a_real_robot_give_its_tip() -> None:
    folder = shared_data("reference/real/tip")
    rows = np.vstack([np.loadtxt(folder / f"{n}_touches.csv", delimiter=",", skiprows=1) for n in ("tilted", "flat")])
    origins, flanges = rows[:, :3] * 1000, Rotation.from_rotvec(rows[:, 3:]).as_matrix()

    def heights(unknowns: np.ndarray) -> np.ndarray:
        x, y, height, *tip = unknowns
        normal = np.array([x, y, 1.0]) / np.sqrt(1 + x * x + y * y)
        return (origins + flanges @ tip) @ normal - height

    least = least_squares(heights, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0], x_scale=[1e-3, 1e-3, 1, 1, 1, 1], xtol=1e-15)
    contacts = contacts_from_arrays(
        "table", origins, sigma=0.35, tip_radius=0.0, flange_rotations=flanges, tip_offset=[0.0, 0.0, 0.0]
    )
    table = fixture_of({"table": Plane(np.zeros(3), np.array([0.0, 0.0, 1.0]))})
    result = locate(table, contacts, unknown=["tip"])
    assert len(contacts) == 269
    np.testing.assert_allclose(result.tip.offset, least.x[3:], atol=1e-4)
    # With the normal from the upright touches alone, which changes z by 0.06.
    np.testing.assert_allclose(result.tip.offset, [-0.623, -0.266, 48.981], atol=0.07)


def test_impossible_requests_are_rejected() -> None:
    bare = contacts_from_arrays("plate", np.zeros((3, 3)), sigma=1.0, tip_radius=0.0)
    with pytest.raises(UsageError, match="orientation of the flange"):
        locate(fixture_of(PLATE), bare, unknown=["tip"])


def test_the_json_comes_back() -> None:
    for count in (1, 4):
        result = locate(fixture_of(PLATE), plate_problem(8, count, 30.0).contacts, unknown=["tip", "tip-radius"])
        document = json.loads(result.to_json())
        assert document["unknowns"][6:] == ["tip_x", "tip_y", "tip_z", "tip_radius"]
        again = LocateResult.from_json(result.to_json())
        assert (again.tip is None) == (result.tip is None) == (count == 1)
        if again.tip is not None:
            np.testing.assert_array_equal(again.tip.offset, result.tip.offset)
            np.testing.assert_array_equal(again.joint_covariance, result.joint_covariance)


@pytest.mark.slow
@pytest.mark.parametrize("unknown", [["tip"], ["tip-radius"], ["tip", "tip-radius"]])
def test_the_joint_covariance_covers_at_its_level(unknown: list[str]) -> None:
    """Over 2,000 draws the ellipsoid of 95 per cent covers the truth in 93.5 to 96.5 per cent."""
    rng = np.random.default_rng(2026)
    cell, tools = plate_touches(rng), orientations(4, 45.0)
    free = [*range(6), *(range(6, 9) if "tip" in unknown else ()), *([9] if "tip-radius" in unknown else ())]
    inside, draws = 0, 2000
    for _ in range(draws):
        error = SIDEWAYS if "tip" in unknown else np.zeros(3)
        problem = touched(cell, rng, tools, error)
        result = locate(fixture_of(PLATE), problem.contacts, unknown=unknown)
        assert result.status == "located"
        turn = problem.turn * Rotation.from_matrix(result.base_from_fixture[:3, :3]).inv()
        tip = [*(problem.tip - result.tip.offset), RADIUS - result.tip.radius]
        off = np.concatenate([turn.as_rotvec(), problem.shift - result.base_from_fixture[:3, 3], tip])[free]
        inside += bool(off @ np.linalg.solve(result.joint_covariance, off) < chi_square.isf(0.05, len(off)))
    print(f"unknown {unknown}: covered {100 * inside / draws:.1f} per cent")
    assert 0.935 <= inside / draws <= 0.965


def test_fewer_equations_than_unknowns_are_reported_quickly() -> None:
    """A tip known only to a tenth of the fixture's size turns the poses of six contacts into a continuum.

    23 s of processor time with a search around each pose, 0.5 s since one covering is enough.
    """
    contacts = plate_problem(1, 4, 45.0).contacts.subset([0, 3, 6, 9, 12, 15])
    fixture = fixture_of(PLATE, within=0.1 * contacts.spread)
    start = process_time()
    result = locate(fixture, contacts, unknown=["tip", "tip-radius"])
    assert result.status == "underdetermined"
    assert process_time() - start < 2.0


def test_a_stated_bound_is_not_asked_for() -> None:
    """With the radius unknown as well no search is complete: the bound of the tip offset does not bound the radius."""
    contacts = plate_problem(11, 4, 45.0, stated_radius=2.8).contacts
    for within, is_asked in ((None, True), (20.0, False)):
        tip = locate(fixture_of(PLATE, within), contacts, unknown=["tip", "tip-radius"]).tip
        assert "another tip may explain" in tip.message
        assert ("give probe.tip_within" in tip.message) == is_asked


def test_too_few_contacts_are_reported_for_a_distant_tip() -> None:
    """One covering of the rotations finds no pose that fits if the tip is off by 26 mm."""
    rng = np.random.default_rng(3)
    error = rng.normal(size=3) * rng.choice([0.3, 2.0, 8.0])
    stated = float(rng.choice([3.0, 2.0, 5.0]))
    problem = touched(plate_touches(rng), rng, orientations(4, 45.0), error, stated_radius=stated)
    kept = sorted(rng.choice(18, int(rng.integers(6, 10)), replace=False).tolist())
    assert len(kept) == 7
    assert np.linalg.norm(error) > 26.0
    result = locate(fixture_of(PLATE), problem.contacts.subset(kept), unknown=["tip", "tip-radius"])
    assert result.status == "underdetermined"


FOUR_BALLS = """
tactfix: 1
name: four-balls
units: mm
features: {a: {type: sphere, radius: 10}, b: {type: sphere, radius: 10}, c: {type: sphere, radius: 10},
  d: {type: sphere, radius: 10}}
distances:
- {between: [a, b], value: 100}
- {between: [a, c], value: 80}
- {between: [b, c], value: 128.06248474865697}
- {between: [a, d], value: 70}
- {between: [b, d], value: 122.06555615733703}
- {between: [c, d], value: 106.30145812734649}
frame: {origin: {center_of: a}, x: {from: a, to: b}, y: {from: a, to: c}}
"""


@pytest.mark.parametrize("height", [70.0, -70.0])
def test_a_wrong_contact_is_named_on_either_mirror_shape(height: float) -> None:
    """Distances allow the fourth ball on either side; the contacts decide, and one of them is 1.5 mm off."""
    rng = np.random.default_rng(1)
    centres = {"a": (0, 0, 0), "b": (100, 0, 0), "c": (0, 80, 0), "d": (0, 0, height)}
    names = [name for name in centres for _ in range(6)]
    normals = rng.normal(size=(24, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    off = 0.01 * rng.normal(size=24)
    off[4] += 1.5
    turn = Rotation.random(random_state=rng)
    points = turn.apply(np.array([centres[name] for name in names]) + (11.0 + off)[:, None] * normals)
    contacts = contacts_from_arrays(names, points, turn.apply(-normals), sigma=0.01, tip_radius=1.0)
    result = locate(Fixture.from_text(FOUR_BALLS), contacts, unknown=["tip-radius"])
    assert result.status == "inconsistent"
    assert [(cause.code, cause.rows) for cause in result.diagnosis[:1]] == [("outlier", (5,))]


@pytest.mark.parametrize("seed", [1, 10])
def test_a_nearest_miss_of_too_few_contacts_is_not_complete(seed: int) -> None:
    """Only one covering of the rotations is searched, although probe.tip_within bounds the tip."""
    rng = np.random.default_rng(seed)
    problem = touched(plate_touches(rng), rng, orientations(4, 45.0), 3.0 * rng.normal(size=3))
    contacts = problem.contacts.subset(sorted(rng.choice(18, 8, replace=False).tolist()))
    found = tip_solutions([PLATE], contacts, contacts.sigmas, frozenset(["tip"]), 0.3)
    assert found.dof < 0
    assert found.found[0].solution.chi2 > found.limit
    assert not found.complete
