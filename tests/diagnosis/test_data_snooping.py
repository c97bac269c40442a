"""Data snooping: the largest normalised residual, its limit, and the rate of false alarms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from tactfix.localization.locate import locate
from tactfix.noise import least_chi_square, normal_limit
from tests.support.problems import PLATE, placed, touch_all
from tests.validation.false_alarms import RareNoise

SIGMA = 0.02


def touched(counts, seed=0):
    rng = np.random.default_rng(seed)
    truth = touch_all(PLATE, counts, rng, sigma=SIGMA, tip=2.0)
    return truth, truth.contacts(rng)


def rows_of(truth, contacts):
    """Derivatives of the residuals by a motion of the fixture, written out."""
    centre = contacts.points.mean(axis=0)
    return -np.hstack([np.cross(contacts.points - centre, truth.normals) / 100.0, truth.normals])


def pushed(truth, contacts, index, size):
    """The contacts without noise, one of them moved so that its normalised residual is about size."""
    jacobian = rows_of(truth, contacts)
    leverage = np.diag(jacobian @ np.linalg.pinv(jacobian))[index]
    clean = truth.contacts()
    points = clean.points.copy()
    points[index] += size * SIGMA / np.sqrt(1 - leverage) * truth.normals[index]
    return replace(clean, points=points)


def test_limits_are_those_of_scipy():
    for count in (1, 12, 40):
        assert normal_limit(count, 1e-6) == pytest.approx(stats.norm.isf(0.5e-6 / count), rel=1e-9)
    for dof in (1, 6, 30):
        assert least_chi_square(dof) == pytest.approx(stats.chi2.ppf(1e-3, dof), rel=1e-9)
    assert least_chi_square(0) == 0.0


@pytest.mark.parametrize("index", [8, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 14))])
def test_an_error_hidden_in_chi_square_rejects_the_pose(index):
    """Six sigma in one of eighteen contacts: chi-square 36, limit 49."""
    truth, contacts = touched({"plate": 6, "pin": 6, "ball": 6})
    result = locate(placed(PLATE), pushed(truth, contacts, index, 6.0))
    assert result.status == "inconsistent"
    assert result.chi2 < result.chi2_limit
    assert [reason.code for reason in result.candidates[0].reasons] == ["fit"]
    assert result.candidates[0].reasons[0].row == index + 1
    first = result.diagnosis[0]
    assert first.code == "outlier"
    # Other contacts may explain such a small error nearly as well: then all are named together.
    assert (first.causes[0] if first.one_of else first).rows == (index + 1,)


def test_a_smaller_error_is_named_with_its_effect_on_the_pose():
    truth, contacts = touched({"plate": 6, "pin": 6, "ball": 6})
    slipped = pushed(truth, contacts, 8, 4.6)
    result = locate(placed(PLATE), slipped)
    assert result.status == "located"
    (cause,) = result.diagnosis
    assert (cause.code, cause.rows, cause.features) == ("outlier", (9,), ("pin",))
    assert cause.message in result.warnings
    without = locate(placed(PLATE), slipped.subset(np.delete(np.arange(18), 8)))
    moves = np.linalg.inv(result.base_from_fixture) @ np.vstack([slipped.points.T, np.ones(18)])
    moved = np.linalg.norm((without.base_from_fixture @ moves - np.vstack([slipped.points.T, np.ones(18)]))[:3], axis=0)
    assert float(cause.message.split("move by ")[1].split()[0]) == pytest.approx(moved.max(), rel=0.1)


@pytest.mark.parametrize(("factor", "words"), [(1.9, "times as large as sigma"), (0.2, "improbably small")])
def test_sigma_is_questioned_if_no_contact_stands_out(factor, words):
    truth, contacts = touched({"plate": 7, "pin": 7, "ball": 7})
    clean = truth.contacts()
    noisy = replace(contacts, points=clean.points + factor * (contacts.points - clean.points))
    result = locate(placed(PLATE), noisy)
    assert result.status == "located"
    (cause,) = result.diagnosis
    assert cause.code == "sigma"
    assert cause.value == pytest.approx(factor * SIGMA, rel=0.4)
    assert words in cause.message


def test_the_factor_on_the_probes_sigma_is_reported():
    """The sigma of the probe is far below that of the features: the factor is reported for the probe's sigma."""
    _, contacts = touched({"plate": 7, "pin": 7, "ball": 7})
    features = {name: replace(feature, sigma=SIGMA / 20) for name, feature in placed(PLATE).features.items()}
    result = locate(replace(placed(PLATE), features=features), replace(contacts, sigmas=contacts.sigmas / 1e4))
    assert result.status == "inconsistent"
    assert result.diagnosis[0].code == "sigma"
    assert result.diagnosis[0].value == pytest.approx(SIGMA, rel=0.4)


def test_the_joint_false_alarm_rate_is_at_most_twice_that_of_one_test():
    """Residuals are noise projected off six directions; limits a thousand times as likely make the rate measurable."""
    truth, contacts = touched({"plate": 6, "pin": 6, "ball": 6})
    jacobian = rows_of(truth, contacts)
    left = np.eye(18) - jacobian @ np.linalg.pinv(jacobian)
    residuals = np.random.default_rng(1).standard_normal((200_000, 18)) @ left
    above = (residuals**2).sum(axis=1) > stats.chi2.isf(1e-3, 12)
    stands_out = (np.abs(residuals) / np.sqrt(np.diag(left)) > normal_limit(18, 1e-3)).any(axis=1)
    assert 0.8e-3 < stands_out.mean() < 1.1e-3
    assert 1e-3 < (above | stands_out).mean() < 2e-3


def test_the_joint_false_alarm_rate_is_at_most_two_in_a_million():
    """By importance sampling: one standard error is 0.02 in a million."""
    rng = np.random.default_rng(3)
    rare = RareNoise(touch_all(PLATE, {"plate": 6, "pin": 6, "ball": 6}, rng, sigma=0.02, tip=2.0))
    drawn, weights = rare.draw(50_000, rng)
    above, out = rare.alarms(drawn)
    assert 1.8 < 1e6 * ((above | out) * weights).mean() < 2.0
