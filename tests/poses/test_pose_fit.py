"""Geometric least squares on SE(3): Jacobian by differences, optimum against scipy, covariance by random draws."""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tactfix.poses.pose_fit import covariance_at, fit_at, refine
from tests.support.plain_surfaces import depth
from tests.support.problems import pose_error, pose_of, touch_all
from tests.support.touched_fixtures import CASES, problem


def stepped(pose, twist, centre):
    """The pose turned about a point of base and shifted."""
    turn = Rotation.from_rotvec(twist[:3]).as_matrix()
    return pose_of(turn @ pose[:3, :3], centre + turn @ (pose[:3, 3] - centre) + twist[3:])


def by_depth(surfaces, contacts, pose):
    """Residuals from plain distances, in the fixture frame."""
    local = (contacts.points - pose[:3, 3]) @ pose[:3, :3]
    off = [depth(surfaces[name], p) for name, p in zip(contacts.features, local, strict=True)]
    return np.array(off) - contacts.tip_radius


@pytest.mark.parametrize("name", CASES)
def test_jacobian_against_differences(name):
    surfaces, truth, contacts = problem(name)
    fit = fit_at(surfaces, contacts, contacts.sigmas, truth.pose)
    np.testing.assert_allclose(fit.residuals, by_depth(surfaces, contacts, truth.pose), atol=1e-10)
    centre, scale = fit.sensitivity.centre, fit.sensitivity.scale
    for k in range(6):
        step = np.zeros(6)
        step[k] = 1e-5
        ahead, behind = (by_depth(surfaces, contacts, stepped(truth.pose, s, centre)) for s in (step, -step))
        numeric = (ahead - behind) / 2e-5 / contacts.sigmas / (scale if k < 3 else 1.0)
        largest = np.abs(fit.sensitivity.jacobian).max()
        np.testing.assert_allclose(fit.sensitivity.jacobian[:, k], numeric, atol=1e-6 * largest)


@pytest.mark.parametrize("name", CASES)
def test_refined_is_the_optimum_that_scipy_finds(name):
    surfaces, truth, contacts = problem(name, 1)
    rng = np.random.default_rng(2)
    start = stepped(
        truth.pose, np.concatenate([0.05 * rng.normal(size=3), rng.normal(size=3) * 0.3]), truth.pose[:3, 3]
    )
    fit = refine(surfaces, contacts, contacts.sigmas, start)
    centre = contacts.points.mean(axis=0)
    best = least_squares(
        lambda x: by_depth(surfaces, contacts, stepped(fit.base_from_fixture, x, centre)) / contacts.sigmas,
        np.zeros(6),
        x_scale=[1e-3] * 3 + [0.1] * 3,
        xtol=1e-14,
        ftol=1e-14,
        gtol=1e-14,
    )
    assert fit.chi2 <= 2 * best.cost * (1 + 1e-9) + 1e-9
    assert np.linalg.norm(pose_error(fit.base_from_fixture, truth.pose)[:3]) < 0.1
    assert fit.chi2 == pytest.approx(np.sum((fit.residuals / contacts.sigmas) ** 2))


@pytest.mark.parametrize("name", ["minimal", "bush", "bar"])
def test_covariance_is_what_a_sigma_of_each_contact_does(name):
    """One contact at a time is moved by a thousandth of a sigma to either side: the scatter gives the covariance."""
    surfaces, truth, _ = problem(name)
    exact = truth.contacts()
    covariance = fit_at(surfaces, exact, exact.sigmas, truth.pose).sensitivity.covariance(truth.pose[:3, 3])
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))
    effects = []
    for step in 1e-3 * truth.sigma * np.eye(len(exact.points))[:, :, None] * truth.normals:
        disturbed = (truth.contacts(points=exact.points + off) for off in (step, -step))
        fits = [refine(surfaces, contacts, exact.sigmas, truth.pose).base_from_fixture for contacts in disturbed]
        effects.append(whiten @ (pose_error(fits[0], truth.pose) - pose_error(fits[1], truth.pose)) / 2e-3)
    np.testing.assert_allclose(np.transpose(effects) @ effects, np.eye(6), atol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["minimal", "bush", "bar"])
def test_covariance_against_monte_carlo(name):
    """150 repetitions: every entry of the normalised scatter within five of its own standard errors."""
    surfaces, truth, _ = problem(name)
    rng = np.random.default_rng(3)
    exact = truth.contacts()
    start = fit_at(surfaces, exact, exact.sigmas, truth.pose)
    covariance = start.sensitivity.covariance(truth.pose[:3, 3])
    whiten = np.linalg.inv(np.linalg.cholesky(covariance))
    count = 150
    fits = (refine(surfaces, truth.contacts(rng), exact.sigmas, truth.pose) for _ in range(count))
    errors = np.array([whiten @ pose_error(fit.base_from_fixture, truth.pose) for fit in fits])
    np.testing.assert_allclose(errors.T @ errors / count, np.eye(6), atol=5 * np.sqrt(2 / count))


def test_covariance_of_another_point_against_its_definition():
    surfaces, truth, contacts = problem("plate")
    fit = fit_at(surfaces, contacts, contacts.sigmas, truth.pose)
    one, other = np.array([1.0, 2.0, 3.0]), np.array([-50.0, 70.0, 900.0])
    expected = fit.sensitivity.covariance(other)
    np.testing.assert_allclose(covariance_at(fit.sensitivity.covariance(one), other - one), expected, rtol=1e-6)


@pytest.mark.parametrize("far", [0.0, 1e6])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_singular_values_know_neither_unit_nor_origin(far, scale):
    patches, counts = CASES["plate"]
    surfaces = {n: p.surface(scale) for n, p in patches.items()}
    rng = np.random.default_rng(4)
    truth = touch_all(patches, counts, rng, pose=pose_of(np.eye(3), [far, far, -far]), sigma=0.01, scale=scale)
    contacts = truth.contacts()
    values, _ = fit_at(surfaces, contacts, contacts.sigmas, truth.pose).sensitivity.svd()
    rng = np.random.default_rng(4)
    near = touch_all(patches, counts, rng, pose=np.eye(4), sigma=0.01).contacts()
    expected, _ = fit_at({n: p.surface() for n, p in patches.items()}, near, near.sigmas, np.eye(4)).sensitivity.svd()
    np.testing.assert_allclose(values * scale, expected, rtol=1e-6)
