"""The order of solutions; sigmas of points and normals against the scatter of many poses; effects of free motions."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix import load_fixture
from tactfix.contact_arrays import contacts_from_arrays
from tactfix.geometry.surfaces import Plane, Sphere, moved
from tactfix.poses.rigid import rigid_solutions
from tactfix.poses.solution import Solution, in_order, place_and_normal_sigmas
from tests.support.problems import PLATE, Patch, pose_of, touch_all
from tests.support.project import ROOT


@pytest.fixture(scope="module")
def mirrored() -> tuple[Solution, Solution]:
    """Two of the poses of three planes with three, two and one contacts, without noise."""
    fixture = load_fixture(ROOT / "fixtures" / "three-planes.yaml")
    surfaces = {name: feature.surface for name, feature in fixture.features.items() if feature.surface is not None}
    points = [[-10, -20, 0], [-70, -20, 0], [-30, -60, 0], [0, -20, -5], [0, -60, -9], [-40, 0, -7]]
    names = ["top", "top", "top", "right", "right", "back"]
    contacts = contacts_from_arrays(names, points, sigma=0.01, tip_radius=0.0)
    first, second, *_ = rigid_solutions(surfaces, contacts, np.full(6, 0.01), True).found
    return first, second


@pytest.mark.parametrize("chi2", [0.0, 7.0, 1e6])
def test_the_last_digit_does_not_choose_the_first(mirrored: tuple[Solution, Solution], chi2: float) -> None:
    one, other = (replace(solution, chi2=chi2) for solution in mirrored)
    digit = 1e-12 * max(1.0, chi2)
    orders = [
        in_order(found)
        for found in (
            [one, replace(other, chi2=chi2 + digit)],
            [replace(one, chi2=chi2 + digit), other],
            [other, one],
        )
    ]
    leaders = [found[0].base_from_fixture for found in orders]
    for leader in leaders:
        np.testing.assert_array_equal(leader, leaders[0])


def test_the_better_pose_leads(mirrored: tuple[Solution, Solution]) -> None:
    for better, worse in (mirrored, mirrored[::-1]):
        found = in_order([replace(worse, chi2=2.0), replace(better, chi2=1.0)])
        np.testing.assert_array_equal(found[0].base_from_fixture, better.base_from_fixture)


FOUR = {**PLATE, "bore": Patch("cylinder", (100, -50, 0), (0.6, 0, 0.8), 15.0, side="inner", length=10.0)}


def setting(seed=0):
    rng = np.random.default_rng(seed)
    truth = touch_all(FOUR, {"plate": 4, "pin": 4, "ball": 4, "bore": 4}, rng, sigma=1e-3, tip=2.0)
    return truth, truth.contacts(), {n: moved(truth.pose, p.surface()) for n, p in FOUR.items()}, rng


def normal_below(surface, point):
    """The outward normal by its definition: away from the plane, centre or axis."""
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
        moved_surfaces = {n: moved(motion, s) for n, s in surfaces.items()}
        shifted = contacts.points @ turn.T + motion[:3, 3] - contacts.points
        places += (shifted**2).sum(axis=1) / count
        off = [normal_below(moved_surfaces[n], p) for n, p in zip(contacts.features, contacts.points, strict=True)]
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
def test_a_free_motion_makes_only_what_it_changes_uncertain(name, unsure_places, unsure_normals):
    """A rotation about the pin maps plate and pin onto themselves, so their normals stay known."""
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
    # The ball's contacts move although its centre does not.
    assert set(names[np.isinf(place)]) >= unsure_places
