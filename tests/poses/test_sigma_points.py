"""Covariance by sigma points against independent samples, and against the linear covariance where that is valid."""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from tactfix.localization.locate import locate, solve
from tactfix.poses.sigma_points import FOLDED, MOST_MISSING, curved_spread, motions_between
from tests.support.problems import (
    BALLS,
    BALLS_RECIPE,
    CORNER,
    CYLINDER_SPHERE,
    Patch,
    ball_distances,
    placed,
    pose_error,
    pose_of,
    related,
    touch_all,
)

COVERED = chi2.ppf(0.95, 6)
NARROW = {name: Patch(p.kind, p.at, p.along, length=9.0) for name, p in CORNER.items()}
CASES = {
    "narrow corner": (NARROW, {"right": 3, "back": 2, "top": 1}, 0.02, 3),
    "bar 4 ball 2": (CYLINDER_SPHERE, {"bar": 4, "ball": 2}, 0.004, 1),
    "balls 3-2-2": (BALLS, {"a": 3, "b": 2, "c": 2}, 0.1, 2),
}


def nearest(patches, contacts, pose):
    """The solution that is nearest to a pose."""
    found = solve(placed(patches), contacts, contacts.sigmas).found
    return min(found, key=lambda s: np.linalg.norm(pose_error(s.base_from_fixture, pose)))


def samples(patches, contacts, best, count, rng):
    """Errors (count, 6) of poses whose residuals differ from those of the best pose by noise."""
    search_angle = float(np.abs(contacts.points - contacts.points.mean(axis=0)).max())
    centre, out_of_material = contacts.points.mean(axis=0), depths(patches, contacts.features)

    def moved(x):
        turn = Rotation.from_rotvec(x[:3] / search_angle).as_matrix()
        return pose_of(turn @ best[:3, :3], centre + x[3:] + turn @ (best[:3, 3] - centre))

    def residuals(x):
        pose = moved(x)
        local = (contacts.points - pose[:3, 3]) @ pose[:3, :3]
        return out_of_material(local) / contacts.sigmas

    rest = residuals(np.zeros(6))
    errors = []
    for _ in range(count):
        noise = rng.standard_normal(len(contacts))
        errors.append(pose_error(best, moved(least_squares(lambda x, n=noise: residuals(x) - rest - n, np.zeros(6)).x)))
    return np.array(errors)


def depths(patches, names):
    """The distances of points from their features, all outer, as a function of the points."""
    touched = [patches[name] for name in names]
    at, along = (np.array([getattr(patch, attribute) for patch in touched], float) for attribute in ("at", "along"))
    radii, kinds = np.array([patch.radius for patch in touched]), np.array([patch.kind for patch in touched])
    is_plane, of_bars = kinds == "plane", along * (kinds == "cylinder")[:, None]

    def out_of_material(points):
        arms = points - at
        heights = (arms * along).sum(axis=1)
        across = arms - heights[:, None] * of_bars
        return np.where(is_plane, heights, np.sqrt((across**2).sum(axis=1))) - radii

    return out_of_material


@pytest.mark.parametrize("name", CASES)
def test_the_covariance_covers_possible_poses_where_a_linear_one_does_not(name):
    patches, counts, sigma, seed = CASES[name]
    rng = np.random.default_rng(seed)
    truth = touch_all(patches, counts, rng, sigma=sigma, cone=0.0)
    contacts = truth.contacts(rng)
    solution = nearest(patches, contacts, truth.pose)
    errors = samples(patches, contacts, solution.base_from_fixture, 120, rng)
    inside = np.einsum("ni,ij,nj->n", errors, np.linalg.inv(solution.covariance), errors) < COVERED
    assert solution.trusted
    # Three standard errors of 120 samples.
    assert 0.89 < inside.mean() <= 1.0
    sure = touch_all(patches, counts, np.random.default_rng(seed), pose=truth.pose, sigma=1e-3 * sigma, cone=0.0)
    linear = nearest(patches, sure.contacts(), truth.pose).covariance * 1e6
    outside = np.einsum("ni,ij,nj->n", errors, np.linalg.inv(linear), errors) > COVERED
    assert outside.mean() > 0.11


def test_the_covariance_is_linear_for_well_distributed_contacts():
    rng = np.random.default_rng(4)
    truth = touch_all(CORNER, {"right": 3, "back": 3, "top": 3}, rng, sigma=0.002)
    contacts = truth.contacts()
    solution = nearest(CORNER, contacts, truth.pose)
    arms = contacts.points - truth.pose[:3, 3]
    rows = np.hstack([np.cross(arms, truth.normals), truth.normals]) / truth.sigma
    assert solution.covariance == pytest.approx(np.linalg.inv(rows.T @ rows), rel=1e-6, abs=1e-12)


def test_exact_relations_give_the_covariance_of_a_rigid_body():
    """Displacements of three balls with relations, and the motion of one rigid body, give the same covariance."""
    rng = np.random.default_rng(6)
    truth = touch_all(BALLS, dict.fromkeys(BALLS, 3), rng, sigma=0.4, cone=0.0)
    contacts = truth.contacts(rng)
    rigid = nearest(BALLS, contacts, truth.pose)
    found = solve(related(BALLS, ball_distances(), BALLS_RECIPE), contacts, contacts.sigmas).found
    joint = min(found, key=lambda s: np.linalg.norm(pose_error(s.base_from_fixture, truth.pose)))
    assert joint.base_from_fixture == pytest.approx(rigid.base_from_fixture, abs=1e-5)
    scale = np.sqrt(np.diag(rigid.covariance))
    assert joint.covariance / np.outer(scale, scale) == pytest.approx(
        rigid.covariance / np.outer(scale, scale), abs=0.02
    )


def test_a_pose_next_to_a_fold_is_underdetermined():
    """Three contacts on a great circle of a ball: its centre may lie on either side of their plane, or in it."""
    balls = {**BALLS, "a": Patch("sphere", (0, 0, 0), radius=12.7)}
    circle = np.array([(12.7, 0, 0), (-6.35, 10.998, 0), (-6.35, -10.998, 0)])
    rest = np.array([(192.7, 0, 0), (180, 0, 12.7), (50, 152.7, 0)])
    touched = touch_all(balls, {"a": 3, "b": 2, "c": 1}, np.random.default_rng(0), pose=np.eye(4), sigma=0.05)
    grazing = touched.contacts(points=np.vstack([circle, rest]), approaches=np.full((6, 3), np.nan))
    assert locate(placed(balls), grazing).status == "underdetermined"


def toy(second_order, missing=0.0, centre=(0.0, 0.0, 0.0)):
    """One sigma is a thousandth along each axis; a shift along z moves the fixture along x by its square."""
    searched, sigma = [], 1e-3

    def search_angle(steps):
        searched.append(steps)
        shifts = sigma * steps[3:]
        shifts[0] += sigma * second_order * steps[5] ** 2
        poses = [
            pose_of(turn, np.asarray(centre) + shift - turn @ np.asarray(centre))
            for turn, shift in zip(Rotation.from_rotvec(sigma * steps[:3].T).as_matrix(), shifts.T, strict=True)
        ]
        return np.array(poses), np.full(steps.shape[1], missing)

    linear = sigma * np.eye(6)
    linear[3:, :3] = -sigma * np.cross(np.eye(3), centre).T
    return searched, lambda bend: curved_spread(
        np.eye(4), np.asarray(centre), linear, np.eye(6), lambda steps: np.full(steps.shape[1], bend), search_angle
    )


def test_no_search_if_residuals_are_linear():
    searched, spread = toy(0.5)
    assert np.array_equal(spread(0.1).factor, 1e-3 * np.eye(6))
    assert not searched
    spread(1.0)
    assert searched


def test_the_second_moment_includes_a_quadratic_drift():
    _, spread = toy(0.2)
    found = spread(1.0)
    covariance = found.factor @ found.factor.T
    # Two of twelve points lie at sqrt 6 sigma, and each drifts by 0.2 * 6.
    assert covariance[3, 3] == pytest.approx(1e-6 * (1.0 + 2 * (0.2 * 6) ** 2 / 12))
    assert covariance[5, 5] == pytest.approx(1e-6)
    assert found.trusted


def test_an_origin_far_from_the_contacts_runs_along_an_arc():
    """Residuals are linear near the contacts, but the origin, 1000 away, moves on an arc; there is no fold."""
    centre = (1000.0, 0.0, 0.0)
    searched, spread = toy(0.0, centre=centre)
    found = spread(0.0)
    assert searched
    assert found.trusted
    covariance = found.factor @ found.factor.T
    # A rotation by t about y or z moves the origin by 1000 (1 - cos t) along x.
    arc = 1000 * (1 - np.cos(1e-3 * 6**0.5))
    assert covariance[3, 3] == pytest.approx(1e-6 + 4 * arc**2 / 12, rel=1e-6)
    assert covariance[0, 0] == pytest.approx(1e-6)


@pytest.mark.parametrize(("second_order", "missing"), [(0.2, 2 * MOST_MISSING), (2 * FOLDED / 6**0.5, 0.0)])
def test_unreachable_and_distant_sigma_points_are_not_trusted(second_order, missing):
    _, spread = toy(second_order, missing)
    assert not spread(1.0).trusted


def test_motions_between_poses():
    rng = np.random.default_rng(3)
    pose = pose_of(Rotation.random(random_state=1).as_matrix(), [1.0, 2.0, 3.0])
    wanted = np.hstack([rng.normal(scale=[[1e-9], [0.3], [1.0], [0.0]], size=(4, 3)), rng.normal(size=(4, 3))])
    others = np.array(
        [pose_of(Rotation.from_rotvec(w[:3]).as_matrix() @ pose[:3, :3], pose[:3, 3] + w[3:]) for w in wanted]
    )
    assert np.allclose(motions_between(pose, others).T, wanted, rtol=0, atol=1e-12)
