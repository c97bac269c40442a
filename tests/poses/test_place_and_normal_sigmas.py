"""Sigmas of places and normals against the scatter of many poses; what a free motion touches and what it leaves."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.geometry.surfaces import Plane, Sphere, moved
from tactfix.poses.solution import place_and_normal_sigmas
from tests.support.problems import PLATE, Patch, pose_of, touch_all

FOUR = {**PLATE, "bore": Patch("cylinder", (100, -50, 0), (0.6, 0, 0.8), 15.0, side="inner", length=10.0)}


def setting(seed=0):
    rng = np.random.default_rng(seed)
    truth = touch_all(FOUR, {"plate": 4, "pin": 4, "ball": 4, "bore": 4}, rng, sigma=1e-3, tip=2.0)
    return truth, truth.contacts(), {n: moved(truth.pose, p.surface()) for n, p in FOUR.items()}, rng


def normal_below(surface, point):
    """The outward normal by its definition: away from plane, centre or axis."""
    if isinstance(surface, Plane):
        return surface.normal
    arm = point - (surface.center if isinstance(surface, Sphere) else surface.point)
    if not isinstance(surface, Sphere):
        arm = arm - (arm @ surface.direction) * surface.direction
    return arm / np.linalg.norm(arm) * (1 if surface.side == "outer" else -1)


def test_scatter_of_many_poses():
    truth, contacts, surfaces, rng = setting()
    origin = truth.pose[:3, 3]
    factor = np.vstack([1e-5 * rng.normal(size=(3, 6)), 1e-3 * rng.normal(size=(3, 6))])
    place, normal = place_and_normal_sigmas(surfaces, contacts, truth.normals, origin, factor, np.zeros((6, 0)))
    count = 2000
    places, turns = np.zeros(len(contacts)), np.zeros(len(contacts))
    for twist in rng.standard_normal((count, 6)) @ factor.T:
        turn = Rotation.from_rotvec(twist[:3]).as_matrix()
        motion = pose_of(turn, origin - turn @ origin + twist[3:])
        there = {n: moved(motion, s) for n, s in surfaces.items()}
        shifted = contacts.points @ turn.T + motion[:3, 3] - contacts.points
        places += (shifted**2).sum(axis=1) / count
        off = [normal_below(there[n], p) for n, p in zip(contacts.features, contacts.points, strict=True)]
        turns += ((np.array(off) - truth.normals) ** 2).sum(axis=1) / count
    np.testing.assert_allclose(place, np.sqrt(places), rtol=0.1)
    np.testing.assert_allclose(normal, np.sqrt(turns), rtol=0.1)


@pytest.mark.parametrize(
    ("name", "unsure_places", "unsure_normals"),
    [
        ("turn about the pin", {"plate", "pin", "ball", "bore"}, {"ball", "bore"}),
        ("slide along the pin", {"plate", "pin", "ball", "bore"}, {"ball", "bore"}),
        ("turn about the ball", {"plate", "pin", "bore"}, {"plate", "pin", "bore"}),
    ],
)
def test_a_free_motion_makes_unsure_what_it_changes_and_nothing_else(name, unsure_places, unsure_normals):
    """Turning about the pin lays plate and pin on themselves: their normals stay known."""
    truth, contacts, surfaces, _ = setting(1)
    up, origin = truth.pose[:3, 2], truth.pose[:3, 3]
    centre = surfaces["ball"].center
    axis = truth.pose[:3, 0]
    free = {
        "turn about the pin": np.concatenate([up, np.zeros(3)]),
        "slide along the pin": np.concatenate([np.zeros(3), up]),
        "turn about the ball": np.concatenate([axis, -np.cross(axis, centre - origin)]),
    }[name]
    factor = 1e-6 * np.eye(6)
    place, normal = place_and_normal_sigmas(surfaces, contacts, truth.normals, origin, factor, free[:, None])
    names = np.array(contacts.features)
    assert set(names[np.isinf(normal)]) == unsure_normals
    # The ball's contacts move with it though its centre does not.
    assert set(names[np.isinf(place)]) >= unsure_places
