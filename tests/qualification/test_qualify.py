"""Qualification of probes: certified data of NIST, and simulated probes with drift, steps, outliers and lobes."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from tactfix import Contacts, NotQualifiedError, contacts_from_arrays, qualify
from tactfix.cli import main
from tests.support.nist import SETS


def readings(values: object, features: object = "place", direction: tuple[float, ...] = (1.0, 0.0, 0.0)) -> Contacts:
    """Touches with these readings along the outward normal, the opposite of direction."""
    values = np.asarray(values, float)
    points = -np.asarray(direction) * values[:, None]
    return contacts_from_arrays(features, points, np.tile(direction, (len(values), 1)), sigma=1.0, tip_radius=0.0)


@pytest.mark.parametrize("name", SETS)
def test_sigma_is_the_certified_one(name: str) -> None:
    known = SETS[name]
    assert np.mean(known.readings) == pytest.approx(known.mean, rel=10.0**-known.digits)
    found = qualify(readings(known.readings))
    count = len(known.readings)
    assert found.sigma == pytest.approx(known.sigma, rel=10.0**-known.digits)
    assert found.dof == count - 1
    low, high = (known.sigma * np.sqrt((count - 1) / chi2.ppf(q, count - 1)) for q in (0.975, 0.025))
    assert found.sigma_interval == pytest.approx((low, high), rel=1e-6)
    assert found.range == pytest.approx(max(known.readings) - min(known.readings))


def noise(seed: int, count: int = 30, sigma: float = 0.05) -> np.ndarray:
    return np.random.default_rng(seed).normal(0, sigma, count)


def test_places_are_pooled_and_targets_tell_them_apart() -> None:
    values = np.concatenate([10 + noise(1), 20 + noise(2)])
    expected = np.sqrt(sum(np.var(v, ddof=1) for v in np.split(values, 2)) / 2)
    by_feature = qualify(readings(values, ["a"] * 30 + ["b"] * 30))
    by_target = qualify(readings(values), targets=["1"] * 30 + ["2"] * 30)
    for found in (by_feature, by_target):
        assert found.sigma == pytest.approx(expected, rel=1e-9)
        assert found.places == 2
        assert found.dof == 58
        assert not found.warnings
    assert qualify(readings(values)).sigma > 4


def test_noise_alone_is_seldom_flagged_and_the_interval_covers() -> None:
    flagged, inside = 0, 0
    for seed in range(400):
        found = qualify(readings(noise(seed)))
        flagged += bool(found.outliers or found.steps or found.warnings)
        inside += found.sigma_interval[0] < 0.05 < found.sigma_interval[1]
    assert flagged <= 6
    assert 0.92 <= inside / 400 <= 0.98


def test_outliers_are_reported_by_row_even_if_two_mask_each_other() -> None:
    values = noise(3)
    values[[7, 20]] += 0.6
    found = qualify(readings(values))
    assert found.outliers == (8, 21)
    assert "row 8, row 21" in found.warnings[0]


def sigma_without_outliers(warnings: tuple[str, ...]) -> float:
    """The sigma in the warning, which has three digits and the unit mm."""
    (sigma,) = [float(found[1]) for text in warnings if (found := re.search(r"sigma is about (\S+) mm: check", text))]
    return sigma


@pytest.mark.parametrize("count", [10, 20, 40])
def test_sigma_without_an_outlier_is_about_the_mean_of_the_others(count: int) -> None:
    values = noise(8, count)
    values[5] += 1.0
    found = qualify(readings(values), units="mm")
    assert found.outliers == (6,)
    assert sigma_without_outliers(found.warnings) == pytest.approx(np.std(np.delete(values, 5), ddof=1), rel=5e-3)


def test_sigma_without_outliers_is_that_of_the_other_touches_of_two_places() -> None:
    values = np.concatenate([noise(3), 20 + noise(2)])
    values[[7, 20, 50]] += [0.8, -0.6, 0.7]
    places = np.delete(np.repeat([0, 1], 30), [7, 20, 50])
    left = [np.delete(values, [7, 20, 50])[places == k] for k in (0, 1)]
    expected = np.sqrt(sum(np.sum((of - of.mean()) ** 2) for of in left) / (57 - 2))
    found = qualify(readings(values, ["a"] * 30 + ["b"] * 30), units="mm")
    assert found.outliers == (8, 21, 51)
    assert sigma_without_outliers(found.warnings) == pytest.approx(expected, rel=5e-3)


def test_of_two_touches_of_a_place_neither_is_called_right() -> None:
    values = noise(3, 40)
    values[7] += 1.0
    found = qualify(readings(values, np.repeat([f"p{k}" for k in range(20)], 2)), units="mm")
    assert found.outliers == (7, 8)
    left = np.delete(values, [6, 7]).reshape(-1, 2)
    assert sigma_without_outliers(found.warnings) == pytest.approx(np.sqrt(left.var(axis=1, ddof=1).mean()), rel=5e-3)


def test_sigma_without_an_outlier_on_a_ball_is_that_of_the_ball_of_the_others() -> None:
    contacts = ball(4, 20, 0.002)
    off = contacts.points.copy()
    off[3] += 0.08 * (off[3] - [700.0, -300.0, 90.0])
    found = qualify(replace(contacts, points=off), radius=12.7, units="mm")
    assert found.outliers == (4,)
    rest = qualify(contacts_from_arrays("ball", np.delete(off, 3, 0), sigma=1.0, tip_radius=0.0), radius=12.7)
    assert sigma_without_outliers(found.warnings) == pytest.approx(rest.sigma, rel=5e-3)


def test_drift_and_step_are_reported_with_their_unit() -> None:
    drifts = qualify(readings(noise(4) + 0.02 * np.arange(30)), units="mm").warnings
    assert any(re.search(r"drift by [\d.]+ mm a touch", text) for text in drifts)
    steps = qualify(readings(noise(5) + 0.3 * (np.arange(30) >= 18)), units="mm").warnings
    assert any(re.search(r"are [\d.]+ mm more", text) for text in steps)


def test_a_drift_is_reported_with_its_sigma() -> None:
    found = qualify(readings(noise(4) + 0.02 * np.arange(30)))
    assert found.drift.per_touch == pytest.approx(0.02, abs=3 * found.drift.sigma)
    assert found.drift.sigma == pytest.approx(0.05 / np.sqrt(np.sum((np.arange(30) - 14.5) ** 2)), rel=0.4)
    assert any("drift" in warning for warning in found.warnings)


def test_a_step_is_reported_with_its_place() -> None:
    found = qualify(readings(noise(5) + 0.3 * (np.arange(30) >= 18)))
    (step,) = found.steps
    assert step.row == 19
    assert step.size == pytest.approx(0.3, abs=0.06)


def test_the_same_along_any_direction_in_any_unit_and_far_away() -> None:
    values = noise(6)
    base = qualify(readings(values))
    way = Rotation.from_rotvec([0.3, 1.0, -0.4]).apply([1.0, 0.0, 0.0])
    turned = readings(values, direction=tuple(way))
    away = np.array([900.0, -800.0, 70.0])
    far = contacts_from_arrays("p", turned.points + away, turned.approaches, sigma=1.0, tip_radius=0.0)
    assert qualify(far).sigma == pytest.approx(base.sigma, rel=1e-9)
    assert qualify(readings(values * 1e-3)).sigma == pytest.approx(base.sigma * 1e-3)


def test_without_approaches_sigma_is_the_scatter_in_all_directions() -> None:
    points = np.random.default_rng(7).normal(0, 0.05, (200, 3))
    found = qualify(contacts_from_arrays("p", points, sigma=1.0, tip_radius=0.0))
    assert found.sigma == pytest.approx(np.sqrt(points.var(axis=0, ddof=1).mean()), rel=1e-9)
    assert found.dof == 597


def test_touches_of_different_places_are_noticed() -> None:
    rng = np.random.default_rng(8)
    points = np.column_stack([rng.normal(0, 0.01, 20), rng.uniform(-50, 50, (20, 2))])
    contacts = contacts_from_arrays("face", points, np.tile([1.0, 0, 0], (20, 1)), sigma=1.0, tip_radius=0.0)
    assert any("column target" in warning for warning in qualify(contacts).warnings)


def test_touches_of_different_places_show_neither_drift_nor_step() -> None:
    values = noise(5) + 20.0 * np.arange(30) + 300.0 * (np.arange(30) >= 18)
    contacts = replace(readings(values), units="mm")
    result = qualify(contacts, units="mm")
    (warning,) = result.warnings
    assert "not all of one place" in warning
    assert result.drift is None
    assert result.steps == ()


@pytest.mark.parametrize("with_approaches", [True, False])
def test_touches_all_around_a_feature_are_no_repeats(with_approaches: bool) -> None:
    angles = np.linspace(0, 2 * np.pi, 9)[:-1]
    out = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    touched = contacts_from_arrays("pin", 10 * out, -out if with_approaches else None, sigma=1.0, tip_radius=0.0)
    assert any("reference ball" in warning for warning in qualify(replace(touched, units="mm")).warnings)
    assert (
        not any("reference ball" in warning for warning in qualify(replace(touched, units="um")).warnings)
        or with_approaches
    )


def test_touches_from_directions_too_different_are_no_repeats() -> None:
    for widest, warned in ((0.8, True), (0.1, False)):
        angles = np.linspace(-widest, widest, 8)
        out = np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
        # The deviations along and across the approach are equally large: only the directions show it.
        points = np.random.default_rng(4).normal(0, 0.01, (8, 3))
        touched = contacts_from_arrays("pin", points, -out, sigma=1.0, tip_radius=0.0)
        assert any("reference ball" in warning for warning in qualify(touched).warnings) == warned


def test_touches_that_do_not_qualify_a_probe_are_rejected() -> None:
    with pytest.raises(NotQualifiedError, match="no place is touched twice"):
        qualify(readings([1.0, 2.0], ["a", "b"]))
    with pytest.raises(NotQualifiedError, match="4 touches of the ball"):
        qualify(readings([1.0, 2.0, 3.0, 4.0]), radius=5.0)


def ball(seed: int, count: int, sigma: float, side: str = "outer", lobe: float = 0.0) -> Contacts:
    """Touches of a distant ball of radius 12.7 by a tip of 3.02 that triggers later in three directions."""
    rng = np.random.default_rng(seed)
    out = rng.normal(size=(count, 3))
    out /= np.linalg.norm(out, axis=1)[:, None]
    late = lobe * np.cos(3 * np.arctan2(out[:, 1], out[:, 0])) * (1 - out[:, 2] ** 2)
    reach = 12.7 + 3.02 if side == "outer" else 12.7 - 3.02
    points = [700.0, -300.0, 90.0] + (reach + late + rng.normal(0, sigma, count))[:, None] * out
    return contacts_from_arrays("ball", points, sigma=1.0, tip_radius=0.0)


@pytest.mark.parametrize("side", ["outer", "inner"])
def test_the_effective_tip_radius_is_that_of_the_least_squares_ball(side: str) -> None:
    contacts = ball(1, 20, 0.002, side)
    found = qualify(contacts, radius=12.7, side=side)
    least = least_squares(
        lambda s: np.linalg.norm(contacts.points - s[:3], axis=1) - s[3], [700.0, -300.0, 90.0, 15.0], xtol=1e-15
    )
    sigma = np.sqrt(2 * least.cost / 16)
    covariance = sigma**2 * np.linalg.inv(least.jac.T @ least.jac)
    assert found.sigma == pytest.approx(sigma, rel=1e-5)
    assert found.tip_radius == pytest.approx(abs(least.x[3] - 12.7), abs=1e-7)
    assert found.tip_radius_sigma == pytest.approx(np.sqrt(covariance[3, 3]), rel=1e-4)
    assert abs(found.tip_radius - 3.02) < 4 * found.tip_radius_sigma
    assert not found.directions


@pytest.mark.parametrize("side", ["outer", "inner"])
@pytest.mark.parametrize("across", [0.002, 0.05])
def test_touches_of_one_spot_are_no_touches_of_a_ball(side: str, across: float) -> None:
    for seed in range(40):
        points = np.random.default_rng(seed).normal([100, 50, 30], [across, across, 0.05], (20, 3))
        spot = contacts_from_arrays("ball", points, np.tile([0, 0, -1.0], (20, 1)), sigma=1.0, tip_radius=0.0)
        assert "do not spread over the ball" in qualify(spot, radius=12.7, side=side, units="mm").warnings[0]


@pytest.mark.parametrize(("half_angle", "warned"), [(25.0, True), (40.0, True), (55.0, False), (90.0, False)])
def test_a_cap_of_a_ball_has_to_be_wide_enough(half_angle: float, warned: bool) -> None:
    rng = np.random.default_rng(2)
    height = rng.uniform(np.cos(np.radians(half_angle)), 1.0, 300)
    turn = rng.uniform(0, 2 * np.pi, 300)
    across = np.sqrt(1 - height**2)
    out = np.column_stack([across * np.cos(turn), across * np.sin(turn), height])
    touched = contacts_from_arrays(
        "ball", (15.72 + rng.normal(0, 0.002, 300))[:, None] * out, sigma=1.0, tip_radius=0.0
    )
    assert any("do not spread" in text for text in qualify(touched, radius=12.7).warnings) == warned


def test_the_usual_five_touches_of_a_ball_spread_over_it() -> None:
    slope = np.sqrt(0.5)
    for low in ((1.0, 0.0), (slope, slope)):
        out = np.array(
            [[0, 0, 1.0], *([low[0] * x, low[0] * y, low[1]] for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)))]
        )
        points = (15.72 + np.random.default_rng(1).normal(0, 0.002, 5))[:, None] * out
        found = qualify(contacts_from_arrays("ball", points, sigma=1.0, tip_radius=0.0), radius=12.7)
        assert not any("do not spread" in text for text in found.warnings)


def test_the_sigma_of_the_tip_radius_is_that_of_many_draws() -> None:
    draws = [qualify(ball(seed, 12, 0.002), radius=12.7) for seed in range(300)]
    off = np.array([(found.tip_radius - 3.02) / found.tip_radius_sigma for found in draws])
    assert 0.92 < np.mean(np.abs(off) < 2.306) < 0.98  # Student's t with 8 degrees of freedom, 95 per cent


def test_lobes_show_by_direction() -> None:
    found = qualify(ball(3, 2000, 0.001, lobe=0.02), radius=12.7)
    means = {tuple(np.round(mean.direction, 3)): mean.mean for mean in found.directions}
    assert len(means) == 14
    assert sum(mean.touches for mean in found.directions) == 2000
    # cos 3a is 1 along x and -1 along -x: the map has these signs, averaged over cells.
    assert means[(1.0, 0.0, 0.0)] > 0.004
    assert means[(-1.0, 0.0, 0.0)] < -0.004
    assert abs(means[(0.0, 0.0, 1.0)]) < 0.001
    assert found.sigma > 0.005


def test_the_map_turns_with_the_flange() -> None:
    plain = ball(3, 500, 0.001, lobe=0.02)
    turn = Rotation.from_rotvec([0.0, 0.0, np.pi / 2]).as_matrix()
    points = (plain.points - plain.points.mean(axis=0)) @ turn.T
    turned = contacts_from_arrays(
        "ball", points, sigma=1.0, tip_radius=0.0, flange_rotations=np.tile(turn, (500, 1, 1))
    )
    one, other = qualify(plain, radius=12.7), qualify(turned, radius=12.7)
    assert other.direction_frame == "flange"
    np.testing.assert_allclose([m.mean for m in other.directions], [m.mean for m in one.directions], atol=1e-6)


def test_the_command_prints_and_writes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = "\n".join(f"top,{target},{0.1 * target},0,{z},0,0,-1" for target in (1, 2) for z in (0.0, 0.01, -0.01))
    file = tmp_path / "touches.csv"
    file.write_text(f"# units: mm\nfeature,target,x,y,z,ax,ay,az\n{rows}\n")
    assert main(["qualify", str(file), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["schema"] == "tactfix/qualify/1"
    assert report["touches"] == 6
    assert report["sigma"] == pytest.approx(0.01)
    assert report["tip_radius"] is None
    assert main(["qualify", str(file)]) == 0
    assert capsys.readouterr().out.startswith("sigma 0.01 mm, 95 % between")
    file.write_text("# units: mm\nfeature,x,y,z\na,0,0,0\n")
    assert main(["qualify", str(file)]) == 4
    assert "no place is touched twice" in capsys.readouterr().err


def test_a_ball_of_a_fixture_is_a_reference(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In the fixture's units, with other features touched as well; the side of the ball matters."""
    fixture = tmp_path / "f.yaml"
    fixture.write_text(
        "tactfix: 1\nname: f\nunits: mm\nfeatures:\n"
        "  face: {type: plane, point: [0, 0, 0], normal: [0, 0, 1]}\n"
        "  ball: {type: sphere, radius: 12.7, center: [90, 0, 40]}\n"
        "  socket: {type: sphere, radius: 12.7, side: inner, center: [0, 90, -40]}\n"
    )
    outer, inner = ball(1, 30, 0.002), ball(2, 30, 0.002, side="inner")
    for name, contacts in (("ball", outer), ("socket", inner)):
        rows = "".join(f"{name},{x / 1000!r},{y / 1000!r},{z / 1000!r}\n" for x, y, z in contacts.points.tolist())
        (tmp_path / f"{name}.csv").write_text(f"# units: m\nfeature,x,y,z\nface,0,0,0\n{rows}")
        side = "outer" if name == "ball" else "inner"
        assert main(["qualify", str(tmp_path / f"{name}.csv"), "--fixture", str(fixture), "--json"]) == 0
        report = json.loads(capsys.readouterr().out)
        assert report["units"] == "mm"
        assert report["touches"] == 30
        assert report["tip_radius"] == pytest.approx(qualify(contacts, radius=12.7, side=side).tip_radius, abs=1e-6)
    both = (tmp_path / "ball.csv").read_text() + "".join((tmp_path / "socket.csv").read_text().splitlines(True)[3:])
    (tmp_path / "both.csv").write_text(both)
    words = ["qualify", str(tmp_path / "both.csv"), "--fixture", str(fixture), "--json"]
    assert main(words) == 2
    assert "--feature" in capsys.readouterr().err
    assert main([*words, "--feature", "socket"]) == 0
    assert json.loads(capsys.readouterr().out)["touches"] == 30
    assert main([*words, "--feature", "face"]) == 2
    assert main([*words, "--radius", "12.7"]) == 2
    assert main(["qualify", str(tmp_path / "both.csv"), "--feature", "ball"]) == 2
