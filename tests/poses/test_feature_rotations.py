"""Rotations from features located alone: one is near the true one; none without a known direction."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.poses.feature_rotations import TURNS, feature_rotations
from tests.support.problems import BALLS, CORNER, CYLINDER_SPHERE, PLATE, Patch, touch_all

FACE_BALLS = {"face": Patch("plane", (0, 0, 0), (0, 0, 1), length=100.0), **BALLS}
BORES = {
    "plate": Patch("plane", (0, 0, 0), (1, 0, 0), length=150.0),
    "pin": Patch("cylinder", (0, 90, -20), (-1, 0, 0), 12.0, length=20.0, middle=-26.0),
    "bore": Patch("cylinder", (0, -60, 80), (1, 0, 0), 25.0, side="inner", length=10.0, middle=-15.0),
}
BALL_ON_PIN = {**PLATE, "ball": Patch("sphere", (3.0, 0.0, 60.0), radius=19.05)}
LEANING = {**PLATE, "pin": Patch("cylinder", (0, 0, 0), (0, 0.1, 1), 10.0, length=20.0, middle=26.0)}


def rotations_for(patches, counts, seed, sigma=0.01):
    rng = np.random.default_rng(seed)
    truth = touch_all(patches, counts, rng, sigma=sigma, tip=1.0)
    contacts = truth.contacts(rng)
    surfaces = {name: patch.surface() for name, patch in patches.items()}
    found = feature_rotations(surfaces, contacts, contacts.sigmas)
    return found and found.matrices, truth.pose[:3, :3].T


def nearest(rotations, true):
    """The angle (rad) between the true rotation and the nearest of rotations (3, 3, N)."""
    return min(Rotation.from_matrix(r @ true.T).magnitude() for r in np.moveaxis(rotations, -1, 0))


@pytest.mark.parametrize(
    ("patches", "counts", "most", "within"),
    [
        # Of eight choices of sides four are right-handed.
        (CORNER, {"right": 3, "back": 3, "top": 3}, 8, 0.01),
        (BALLS, dict.fromkeys(BALLS, 4), 1, 0.01),
        (PLATE, {"plate": 4, "pin": 4, "ball": 2}, 2 * TURNS, np.radians(180 / TURNS) + 0.01),
        # Two sides of the plane; the ball's centre may be on either side of its three contacts.
        (PLATE, {"plate": 4, "pin": 4, "ball": 5}, 4, 0.02),
        (BORES, {"plate": 3, "pin": 4, "bore": 4}, 2, 0.02),
        (BALL_ON_PIN, {"plate": 4, "pin": 4, "ball": 5}, 2 * TURNS, np.radians(180 / TURNS) + 0.01),
        (LEANING, {"plate": 4, "pin": 4, "ball": 5}, 2 * TURNS, np.radians(180 / TURNS) + 0.01),
        (FACE_BALLS, {"face": 4, "a": 1, "b": 2, "c": 3}, 2 * TURNS, np.radians(180 / TURNS) + 0.01),
    ],
    ids=["corner", "balls", "plate", "pin and ball", "pin and bore", "ball on pin", "leaning pin", "face and ball"],
)
def test_the_true_rotation_is_near_one_of_them(patches, counts, most, within):
    for seed in range(12):
        rotations, true = rotations_for(patches, counts, seed)
        assert rotations is not None
        assert rotations.shape[2] <= most
        assert np.allclose(np.einsum("ijn,kjn->ikn", rotations, rotations), np.eye(3)[:, :, None], atol=1e-12)
        assert np.linalg.det(np.moveaxis(rotations, -1, 0)) == pytest.approx(1.0)
        assert nearest(rotations, true) < within


@pytest.mark.parametrize(
    ("patches", "counts"),
    [(CYLINDER_SPHERE, {"bar": 6, "ball": 6}), (BALLS, {"a": 5, "b": 2, "c": 2}), (CORNER, {"right": 2, "back": 2})],
    ids=["no direction", "one ball", "planes touched twice"],
)
def test_no_rotations_if_no_feature_gives_a_direction(patches, counts):
    assert rotations_for(patches, counts, 1)[0] is None


def test_weakly_determined_features_are_not_used():
    """A plane whose contacts have an extent of the size of the noise has no direction."""
    tight = {**CORNER, "right": Patch("plane", (0, -50, -50), (1, 0, 0), length=0.05)}
    rotations, true = rotations_for(tight, {"right": 4, "back": 4, "top": 1}, 3, sigma=0.01)
    assert rotations.shape[2] == 2 * TURNS
    assert nearest(rotations, true) < np.radians(180 / TURNS) + 0.01


def test_a_pin_touched_on_a_short_arc_is_not_used():
    rng = np.random.default_rng(4)
    truth = touch_all(PLATE, {"plate": 4, "pin": 4, "ball": 5}, rng, sigma=0.0)
    contacts = truth.contacts(rng)
    angles = np.radians([0.0, 1.0, 2.0, 3.0])
    pin = np.column_stack([10 * np.cos(angles), 10 * np.sin(angles), [10.0, 40.0, 20.0, 30.0]])
    points = contacts.points.copy()
    points[contacts.by_feature["pin"]] = pin @ truth.pose[:3, :3].T + truth.pose[:3, 3]
    surfaces = {name: patch.surface() for name, patch in PLATE.items()}
    found = feature_rotations(surfaces, replace(contacts, points=points), np.full(len(points), 0.01))
    assert len(found) == 2 * TURNS
    assert found.are_samples


@pytest.mark.parametrize(
    ("patches", "counts", "fixed"),
    [
        (CORNER, {"right": 3, "back": 3, "top": 3}, True),
        (PLATE, {"plate": 4, "pin": 4, "ball": 5}, True),
        (BALLS, dict.fromkeys(BALLS, 4), True),
        # A ball with three contacts has two possible centres, possibly for the same rotation.
        (BALLS, dict.fromkeys(BALLS, 3), False),
        (CORNER, {"right": 4, "back": 4, "top": 1}, False),
    ],
)
def test_the_place_is_fixed_where_the_features_leave_one_translation(patches, counts, fixed):
    rng = np.random.default_rng(6)
    contacts = touch_all(patches, counts, rng, sigma=0.01).contacts(rng)
    surfaces = {name: patch.surface() for name, patch in patches.items()}
    assert feature_rotations(surfaces, contacts, contacts.sigmas).fix_place is fixed


def test_a_tall_pin_on_a_plate_of_uncertain_tilt_is_not_used():
    """Within a square centimetre the plate's normal has errors of 10 mrad, which a pin of 400 mm would share."""
    tall = {
        "plate": Patch("plane", (0, 0, 0), (0, 0, 1), length=5.0),
        "pin": Patch("cylinder", (100, 0, 0), (0, 0, 1), 8.0, length=200.0, middle=210.0),
        "ball": PLATE["ball"],
    }
    rotations, _ = rotations_for(tall, {"plate": 4, "pin": 6, "ball": 5}, 2, sigma=0.03)
    assert rotations.shape[2] == 2 * TURNS
