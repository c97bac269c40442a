"""All poses of a rigid fixture: the true pose is among them, every pose fits, and rigid motions change nothing."""

import numpy as np
import pytest

from tactfix.errors import TipDoesNotFitError
from tactfix.poses.all_poses import all_poses, spread_indices
from tests.support.plain_surfaces import depth
from tests.support.problems import BALLS, CORNER, CYLINDER_SPHERE, PLATE, Patch, pose_error, random_pose, touch_all
from tests.validation.poses_of_package import poses_of

SKEW = {
    "one": Patch("cylinder", (0, 0, 0), (1, 0, 0), 8.0, length=20.0, middle=30.0),
    "two": Patch("cylinder", (0, 0, 40), (0, 1, 0), 6.0, length=20.0, middle=30.0),
}
MINIMAL = {
    "planes 3-2-1": (CORNER, {"right": 3, "back": 2, "top": 1}, 4),
    "planes 2-2-2": (CORNER, {"right": 2, "back": 2, "top": 2}, 8),
    "balls 3-2-1": (BALLS, {"a": 3, "b": 2, "c": 1}, 8),
    "balls 2-2-2": (BALLS, {"a": 2, "b": 2, "c": 2}, 16),
    "bar 4 ball 2": (CYLINDER_SPHERE, {"bar": 4, "ball": 2}, 96),
    "bar 3 ball 3": (CYLINDER_SPHERE, {"bar": 3, "ball": 3}, 48),
    "bars 4-2": (SKEW, {"one": 4, "two": 2}, 192),
    "three kinds": (PLATE, {"plate": 3, "pin": 2, "ball": 1}, None),
}


def surfaces_of(patches):
    return {name: patch.surface() for name, patch in patches.items()}


def off_by(surfaces, contacts, pose):
    local = (contacts.points - pose[:3, 3]) @ pose[:3, :3]
    return max(
        abs(depth(surfaces[name], p) - contacts.tip_radius) for name, p in zip(contacts.features, local, strict=True)
    )


@pytest.mark.parametrize("name", MINIMAL)
def test_truth_is_among_them_and_all_of_them_fit(name):
    patches, counts, most = MINIMAL[name]
    surfaces = surfaces_of(patches)
    for seed in range(2):
        rng = np.random.default_rng([1, seed])
        truth = touch_all(patches, counts, rng, sigma=1e-6, tip=0.5)
        contacts = truth.contacts()
        poses = poses_of(all_poses(surfaces, contacts, contacts.sigmas))
        assert len(poses) >= 1
        assert most is None or len(poses) <= most
        assert min(np.linalg.norm(pose_error(pose, truth.pose)) for pose in poses) < 1e-4
        for pose in poses:
            assert off_by(surfaces, contacts, pose) < 1e-6
            np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
            assert np.linalg.det(pose[:3, :3]) > 0


@pytest.mark.parametrize("name", ["planes 2-2-2", "bar 3 ball 3"])
def test_moving_everything_moves_every_pose(name):
    patches, counts, _ = MINIMAL[name]
    surfaces = surfaces_of(patches)
    rng = np.random.default_rng(2)
    truth = touch_all(patches, counts, rng, sigma=1e-6)
    contacts = truth.contacts()
    other = random_pose(rng, 3000.0)
    moved_contacts = truth.contacts(points=contacts.points @ other[:3, :3].T + other[:3, 3])
    here_poses = poses_of(all_poses(surfaces, contacts, contacts.sigmas))
    moved_poses = poses_of(all_poses(surfaces, moved_contacts, moved_contacts.sigmas))
    assert len(here_poses) == len(moved_poses)
    for pose in here_poses:
        assert min(np.abs(other @ pose - moved).max() for moved in moved_poses) < 1e-4


def test_a_double_root_that_noise_has_made_complex_is_still_found():
    """Three contacts on a great circle of a ball: the centre is a double root, or complex."""
    surfaces = surfaces_of(BALLS)
    angles = np.radians([10, 130, 250])
    circle = 12.7 * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(3)])
    for outwards in (1e-3,):
        places = [circle * (1 + outwards / 12.7)]
        places += [
            np.asarray(BALLS[n].at) + 12.7 * np.array(d)
            for n, d in (("b", (0, 0, 1)), ("b", (1, 0, 0)), ("c", (0, 1, 0)))
            for d in (np.array(d, float),)
        ]
        points = np.vstack(places)
        truth = touch_all(BALLS, {"a": 3, "b": 2, "c": 1}, np.random.default_rng(0), pose=np.eye(4), sigma=1e-3)
        contacts = truth.contacts(points=points)
        poses = poses_of(all_poses(surfaces, contacts, contacts.sigmas))
        assert len(poses) >= 1, outwards
        assert min(np.linalg.norm(pose_error(pose, np.eye(4))[:3]) for pose in poses) < 0.05


def test_a_tip_that_does_not_fit_the_bore_is_refused():
    bore = {**PLATE, "pin": Patch("cylinder", (0, 0, 0), (0, 0, 1), 2.0, side="inner", length=10.0)}
    truth = touch_all(bore, {"plate": 3, "pin": 3, "ball": 3}, np.random.default_rng(0), tip=0.5)
    contacts = truth.contacts(tip_radius=2.5)
    with pytest.raises(TipDoesNotFitError, match="2"):
        all_poses(surfaces_of(bore), contacts, contacts.sigmas)


def test_the_contacts_that_are_searched_are_spread_and_fair():
    rng = np.random.default_rng(3)
    truth = touch_all(PLATE, {"plate": 500, "pin": 40, "ball": 3}, rng)
    contacts = truth.contacts()
    index = spread_indices(contacts, 18)
    assert len(index) == len(set(index)) == 18
    names = [contacts.features[i] for i in index]
    assert names.count("ball") == 3
    assert min(names.count("plate"), names.count("pin")) >= 7
    chosen = contacts.points[[i for i in index if contacts.features[i] == "plate"]]
    whole = contacts.on("plate").points
    assert np.ptp(chosen, axis=0).max() > 0.9 * np.ptp(whole, axis=0).max()
    assert spread_indices(truth.contacts().subset(range(10)), 18) == list(range(10))
