"""Points: seats, cones, nests and marks that locate the tip's centre. Poses against scipy's orthogonal Procrustes
solution (`Rotation.align_vectors`) and against scipy's least squares with residuals written here.
"""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from tactfix import Contacts, LocateResult, contacts_from_arrays, locate
from tactfix.design.design_check import design_check
from tactfix.design.design_report import Wishes
from tactfix.errors import DegenerateContactsError, UsageError
from tactfix.feature import Feature
from tactfix.fixture import AxisRule, Fixture, FrameRecipe, OriginRule, Probe, Relation
from tactfix.geometry.surfaces import Plane, Point, Sphere, Surface
from tactfix.localizers.point import localize_point
from tactfix.planning.information import Criterion
from tactfix.planning.plan import plan
from tactfix.simulation.simulate import simulate

SEATS = {"a": (0.0, 0.0, 0.0), "b": (200.0, 0.0, 0.0), "c": (0.0, 150.0, 0.0)}
SIGMA = 0.05


def placed(surfaces: dict[str, Surface]) -> Fixture:
    features = {
        name: Feature(name, type(s).__name__.lower(), getattr(s, "radius", None), "outer", 0.0, s)
        for name, s in surfaces.items()
    }
    return Fixture("seats", "mm", Probe(), features, (), None, {})


def seats(scale: float = 1.0) -> Fixture:
    return placed({name: Point(np.array(at) * scale) for name, at in SEATS.items()})


def touched(
    seed: int, names: list[str], places: dict[str, tuple[float, ...]] = SEATS, sigma: float = SIGMA
) -> tuple[Contacts, np.ndarray, np.ndarray]:
    """Touches of points with noise in all directions; the rotation and the translation of the truth."""
    rng = np.random.default_rng(seed)
    turn, shift = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-2000, 2000, 3)
    points = np.array([places[name] for name in names]) @ turn.T + shift + rng.normal(0, sigma, (len(names), 3))
    return contacts_from_arrays(names, points, sigma=sigma, tip_radius=3.0), turn, shift


def procrustes(points: np.ndarray, nominal: np.ndarray) -> tuple[Rotation, np.ndarray]:
    """The rotation and the translation that map nominal (n, 3) onto points (n, 3) with the least squares."""
    turn, _ = Rotation.align_vectors(points - points.mean(axis=0), nominal - nominal.mean(axis=0))
    return turn, points.mean(axis=0) - turn.as_matrix() @ nominal.mean(axis=0)


@pytest.mark.parametrize("repeats", [1, 3, 20])
def test_three_points_are_located_as_procrustes_has_them(repeats: int) -> None:
    contacts, _, _ = touched(repeats, list(SEATS) * repeats)
    result = locate(seats(), contacts)
    nominal = np.array([SEATS[name] for name in contacts.features])
    turn, shift = procrustes(contacts.points, nominal)
    off = contacts.points - nominal @ turn.as_matrix().T - shift
    assert result.status == "located"
    assert result.dof == 9 * repeats - 6
    np.testing.assert_allclose(result.base_from_fixture[:3, :3], turn.as_matrix(), atol=1e-8)
    np.testing.assert_allclose(result.base_from_fixture[:3, 3], shift, atol=1e-6)
    assert result.chi2 == pytest.approx((off**2).sum() / SIGMA**2, rel=1e-6)
    assert [contact.residual for contact in result.contacts] == pytest.approx(np.linalg.norm(off, axis=1), rel=1e-5)
    assert all(contact.approach_angle_deg is None for contact in result.contacts)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_in_any_unit_and_with_exact_contacts(scale: float) -> None:
    contacts, turn, shift = touched(5, list(SEATS), sigma=1e-9)
    scaled = contacts_from_arrays(contacts.features, contacts.points * scale, sigma=SIGMA * scale, tip_radius=0.0)
    result = locate(seats(scale), scaled)
    assert result.status == "located"
    np.testing.assert_allclose(result.base_from_fixture[:3, :3], turn, atol=1e-9)
    np.testing.assert_allclose(result.base_from_fixture[:3, 3], shift * scale, atol=1e-7 * scale)


def test_the_covariance_is_that_of_many_draws() -> None:
    """The pose is the Procrustes solution (tested above), which is used for the many draws."""
    nominal = np.array(list(SEATS.values()))
    covariance = locate(seats(), contacts_from_arrays(list(SEATS), nominal, sigma=SIGMA, tip_radius=0.0)).covariance
    rng = np.random.default_rng(3)
    drawn = [procrustes(nominal + rng.normal(0, SIGMA, (3, 3)), nominal) for _ in range(4000)]
    poses = np.array([np.concatenate([turn.as_rotvec(), shift]) for turn, shift in drawn])
    np.testing.assert_allclose(np.std(poses, axis=0), np.sqrt(np.diag(covariance)), rtol=0.05)


def mixed(at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> tuple[Fixture, Contacts, np.ndarray]:
    """Contacts on a seat, a ball and a plate: seven equations. Also the start of an independent least squares."""
    surfaces = {
        "seat": Point(np.array(at)),
        "ball": Sphere(np.array([180.0, 40.0, 60.0]), 15.0),
        "plate": Plane(np.array([0.0, 0.0, -20.0]), np.array([0.0, 0.0, 1.0])),
    }
    rng = np.random.default_rng(8)
    turn, shift = Rotation.from_rotvec([0.4, -0.2, 0.9]), np.array([500.0, 20.0, 80.0])
    out = np.array([[0.0, 0.0, 1.0], [0.8, 0.6, 0.0]])
    ball = surfaces["ball"].center + 18.0 * out
    plate = np.array([[30.0, 90.0, -17.0], [150.0, 10.0, -17.0]])
    tips = np.vstack([[at], ball, plate])
    ways = np.vstack([[[1.0, 0, 0]], -out, [[0, 0, -1.0]] * 2])
    points = turn.apply(tips) + shift + rng.normal(0, SIGMA, tips.shape)
    names = ["seat", "ball", "ball", "plate", "plate"]
    contacts = contacts_from_arrays(names, points, turn.apply(ways), sigma=SIGMA, tip_radius=3.0)
    return placed(surfaces), contacts, np.concatenate([turn.as_rotvec(), shift])


def test_points_and_other_features_give_the_joint_least_squares() -> None:
    fixture, contacts, truth = mixed()

    def equations(pose: np.ndarray) -> np.ndarray:
        tips = (contacts.points - pose[3:]) @ Rotation.from_rotvec(pose[:3]).as_matrix()
        ball = np.linalg.norm(tips[1:3] - [180.0, 40.0, 60.0], axis=1) - 18.0
        return np.concatenate([tips[0], ball, tips[3:, 2] + 17.0]) / SIGMA

    least = least_squares(equations, truth, x_scale=[1e-3] * 3 + [1.0] * 3, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    result = locate(fixture, contacts)
    accepted = [candidate for candidate in result.candidates if candidate.accepted]
    best = min(accepted, key=lambda c: np.abs(c.base_from_fixture[:3, 3] - truth[3:]).max())
    assert result.dof == 1
    assert best.chi2 == pytest.approx(2 * least.cost, rel=1e-5, abs=1e-9)
    np.testing.assert_allclose(best.base_from_fixture[:3, 3], least.x[3:], atol=1e-5)


def test_an_approach_to_a_point_rejects_nothing() -> None:
    fixture, contacts, _ = mixed()
    back = contacts.approaches.copy()
    back[0] *= -1
    other = contacts_from_arrays(contacts.features, contacts.points, back, sigma=SIGMA, tip_radius=3.0)
    assert locate(fixture, contacts).status == locate(fixture, other).status


def words(result: LocateResult) -> list[str]:
    return [motion.message for motion in result.free_motions]


def test_motions_left_free_by_one_and_two_points_are_named() -> None:
    one, _, _ = touched(2, ["a"])
    result = locate(seats(), one)
    assert result.status == "underdetermined"
    assert len(words(result)) == 3
    assert all("rotates about" in text and "a" in text for text in words(result))
    two, _, _ = touched(2, ["a", "b", "a"])
    assert locate(seats(), two).status == "underdetermined"
    (turn,) = words(locate(seats(), two))
    assert turn.startswith("the fixture rotates about the line through a and b")


def test_a_displaced_point_is_inconsistent() -> None:
    contacts, _, _ = touched(4, list(SEATS) * 2, SEATS | {"b": (203.0, 0.0, 0.0)})
    assert locate(seats(), contacts).status == "inconsistent"


NEST = {"a": (10.0, 20.0, 0.0), "b": (200.0, 30.0, 0.0), "c": (40.0, 150.0, 10.0), "d": (150.0, 140.0, 60.0)}


@pytest.mark.parametrize(("true", "stated"), [(2.0, 0.0), (2.0, 4.0), (0.0, 2.0)])
def test_a_wrong_tip_radius_is_named_although_points_do_not_depend_on_it(true: float, stated: float) -> None:
    """A point locates the tip's centre: only contacts on other features are off, by the error of the radius."""
    rng = np.random.default_rng(4)
    plate, ball = Plane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]), Sphere([60.0, 90.0, 15.0], 10.0)
    fixture = placed({"plate": plate, "ball": ball, "seat": Point([180.0, 40.0, 5.0])})
    normals = rng.normal(size=(5, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    flat = np.column_stack([rng.uniform(0.0, 200.0, (4, 2)), np.full(4, true)])
    round_ = ball.center + (10.0 + true) * normals
    points = np.vstack([flat, round_, np.tile([180.0, 40.0, 5.0], (2, 1))])
    points = Rotation.random(random_state=rng).apply(points + SIGMA * rng.normal(size=points.shape))
    names = ["plate"] * 4 + ["ball"] * 5 + ["seat"] * 2
    result = locate(fixture, contacts_from_arrays(names, points, sigma=SIGMA, tip_radius=stated))
    assert result.status == "inconsistent"
    assert result.diagnosis[0].code == "tip_radius"
    assert result.diagnosis[0].value == pytest.approx(true, abs=0.3)


@pytest.mark.parametrize("name", NEST)
def test_exchanged_coordinates_of_a_seat_are_named(name: str) -> None:
    x, y, z = NEST[name]
    wrong = placed({n: Point(np.array(at)) for n, at in (NEST | {name: (y, x, z)}).items()})
    contacts, _, _ = touched(3, list(NEST) * 2, NEST)
    first = locate(wrong, contacts).diagnosis[0]
    assert (first.code, first.features, first.one_of) == ("axes", (name,), False)
    assert "x and y" in first.message


def test_three_seats_touched_once_list_possible_causes() -> None:
    """Nine equations: without one contact six remain, without two not even a pose."""
    wrong = placed({n: Point(np.array(at)) for n, at in (SEATS | {"b": (205.0, 0.0, 0.0)}).items()})
    contacts, _, _ = touched(3, list(SEATS))
    causes = [cause for entry in locate(wrong, contacts).diagnosis for cause in entry.causes or (entry,)]
    assert any(cause.code == "outlier" and cause.features == ("b",) for cause in causes)
    assert all(len(cause.rows) < 2 for cause in causes if cause.code == "outlier")


@pytest.mark.parametrize("way", [(1.0, 0.0, 0.0), (0.6, 0.64, 0.48), (0.0, -0.6, 0.8)])
def test_an_error_at_a_point_is_tested_by_its_length(way: tuple[float, ...]) -> None:
    """Twelve contacts of three equations each: the squared normalised length has three degrees of freedom."""
    names = list(SEATS) * 4
    clean, turn, _ = touched(9, names, sigma=1e-9)
    nominal = np.array([SEATS[name] for name in names])
    points = clean.points.copy()
    points[4] += 7.5 * SIGMA * turn @ way
    result = locate(seats(), contacts_from_arrays(names, points, sigma=SIGMA, tip_radius=3.0))
    assert result.status == "inconsistent"
    assert result.chi2 < result.chi2_limit
    (reason,) = result.candidates[0].reasons
    assert reason.row == 5
    # The largest normalised residual, from the equations written out.
    rows = np.array([[*np.cross(at, axis), *axis] for at in nominal for axis in np.eye(3)])
    left = np.eye(36) - rows @ np.linalg.pinv(rows)
    own = (left @ np.kron(np.eye(12)[4], 7.5 * np.array(way)))[12:15]
    size = np.sqrt(own @ np.linalg.inv(left[12:15, 12:15]) @ own)
    limit = np.sqrt(chi2.isf(1e-6 / 12, 3))
    assert reason.message.endswith(f"stands out by {size:.3g} sigma; noise exceeds {limit:.3g} once in a million")


def by_relations() -> Fixture:
    features = {name: Feature(name, "point", None, "outer", 0.0, None) for name in SEATS}
    lengths = {("a", "b"): 200.0, ("a", "c"): 150.0, ("b", "c"): 250.0}
    relations = tuple(Relation("distance", pair, length, 0.0) for pair, length in lengths.items())
    x, y = AxisRule("from_to", ("a", "b")), AxisRule("from_to", ("a", "c"))
    recipe = FrameRecipe(OriginRule("center_of", ("a",)), ("x", x), ("y", y))
    return Fixture("seats", "mm", Probe(), features, relations, recipe, {})


def test_points_by_relations_are_where_points_by_place_are() -> None:
    contacts, _, _ = touched(6, ["a", "b", "c", "b"])
    by_place, related = locate(seats(), contacts), locate(by_relations(), contacts)
    assert related.status == "located"
    assert related.chi2 == pytest.approx(by_place.chi2, rel=1e-6)
    np.testing.assert_allclose(related.base_from_fixture, by_place.base_from_fixture, atol=1e-6)
    np.testing.assert_allclose(np.diag(related.covariance), np.diag(by_place.covariance), rtol=1e-3)


def test_the_localizer_is_the_weighted_mean() -> None:
    points, sigmas = np.array([[0.0, 0, 0], [3.0, 0, 0]]), np.array([1.0, 2.0])
    (found,) = localize_point(points, sigmas)
    np.testing.assert_allclose(found.surface.point, [0.6, 0, 0])
    assert found.chi2 == pytest.approx(0.36 + 2.4**2 / 4)
    with pytest.raises(DegenerateContactsError):
        localize_point(points[:0], sigmas[:0])


def test_design_check_judges_three_points() -> None:
    report = design_check(seats())
    assert not report.free_motions
    assert report.counts.minimum_total == 3
    assert [dict(s) for s in report.counts.minimal_sets] == [{"a": 1, "b": 1, "c": 1}]
    mixed_counts = design_check(mixed((0.0, 0.0, 30.0))[0]).counts
    # Three equations of the seat and three more: the plate gives two at most; ball and seat leave one rotation free.
    assert mixed_counts.minimum_total == 4
    assert [dict(s) for s in mixed_counts.minimal_sets] == [
        {"seat": 1, "ball": 2, "plate": 1},
        {"seat": 1, "ball": 1, "plate": 2},
    ]


MIXED: dict[str, Surface] = {
    "a": Point(np.zeros(3)),
    "b": Point(np.array([100.0, 0.0, 0.0])),
    "top": Plane(np.array([0.0, 0.0, 30.0]), np.array([0.0, 0.0, 1.0])),
}


def pose_sigmas(points: np.ndarray, names: list[str]) -> np.ndarray:
    """Sigmas of rotation and translation from the equations written out: three for a point, one for a plane."""
    rows = []
    for point, name in zip(points, names, strict=True):
        for direction in [[0.0, 0.0, 1.0]] if name == "top" else np.eye(3):
            rows.append([*np.cross(point, direction), *direction])
    return np.sqrt(np.diag(np.linalg.inv(np.array(rows).T @ np.array(rows)))) * SIGMA


@pytest.mark.parametrize("criterion", ["worst", "d", "e"])
@pytest.mark.parametrize(("fixture", "fewest"), [(seats(), 3), (placed(MIXED), 3)])
def test_a_plan_touches_each_point_and_no_more_than_it_must(
    fixture: Fixture, fewest: int, criterion: Criterion
) -> None:
    planned = plan(fixture, contacts=fewest, criterion=criterion, sigma=SIGMA, tip_radius=2.0)
    assert planned.unique
    assert sorted(planned.contacts.features) == sorted(fixture.features)
    held = [fixture.features[name].type == "point" for name in planned.contacts.features]
    assert planned.contacts.has_approach.tolist() == [not on_point for on_point in held]
    places = planned.contacts.points - np.where(held, 0.0, 2.0)[:, None] * [0.0, 0.0, 1.0]
    for name, place in zip(planned.contacts.features, places, strict=True):
        surface = fixture.features[name].surface
        assert surface is not None
        off = (place - surface.point)[2] if isinstance(surface, Plane) else np.abs(place - surface.point).max()
        assert abs(off) < 1e-9
    expected = pose_sigmas(places, list(planned.contacts.features))
    np.testing.assert_allclose(np.sqrt(np.diag(planned.covariance)), expected, rtol=1e-6)
    result = locate(fixture, simulate(fixture, planned.contacts, sigma=SIGMA, tip_radius=2.0, seed=4).contacts)
    assert result.status == "located"


def test_fewer_contacts_than_the_points_need_are_no_plan_and_more_are_shared_out() -> None:
    with pytest.raises(UsageError, match="ask for 3 or more"):
        plan(seats(), contacts=2, sigma=SIGMA, tip_radius=2.0)
    shared = plan(seats(), contacts=6, sigma=SIGMA, tip_radius=2.0).contacts.features
    assert sorted(shared) == ["a", "a", "b", "b", "c", "c"]


def test_a_design_of_points_alone_does_not_depend_on_the_tip() -> None:
    report = design_check(seats(), wishes=Wishes(sigma=SIGMA, tip_radius=2.0))
    # Three points are their own mirror image, so mirrored coordinates cannot be detected.
    assert {finding.code for finding in report.findings if finding.status != "ok"} == {"blind_mirrored"}
    assert [(share.contacts, share.ambiguous) for share in report.study.shares] == [(3, 0.0)]
    assert {
        spot.error: spot.pose_shift for spot in report.blind_spots if spot.error in ("tip_radius", "pretravel")
    } == {
        "tip_radius": pytest.approx(0, abs=1e-9),
        "pretravel": pytest.approx(0, abs=1e-9),
    }
    mixed = design_check(placed(MIXED), wishes=Wishes(sigma=SIGMA, tip_radius=2.0))
    assert not {"no_redundancy", "approach_needed"} & {finding.code for finding in mixed.findings}


def test_simulated_contacts_on_points_have_no_approach() -> None:
    contacts = simulate(placed(MIXED), sigma=SIGMA, tip_radius=2.0).contacts
    assert [f for f, approached in zip(contacts.features, contacts.has_approach, strict=True) if approached] == [
        "top"
    ] * 4
