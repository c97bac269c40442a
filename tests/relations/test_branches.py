"""Relations near 0, 90 and 180 degrees: every branch is found, and no correct one is rejected."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import tactfix
from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tactfix.noise import chi_square_limit
from tactfix.relations import branches
from tactfix.relations.joint_problem import JointProblem
from tests.support.problems import (
    CYLINDER_SPHERE,
    CYLINDER_SPHERE_RECIPE,
    CYLINDER_SPHERE_TOUCH,
    Patch,
    angle,
    distance,
    placed,
    pose_error,
    recipe,
    related,
    touch_all,
)
from tests.support.shared_data import shared_data

SIX_DOF_UPPER = 38.3
"""Chi-square that six degrees of freedom exceed once in a million (tables)."""


def located(name, fixture="fixture.yaml"):
    folder = shared_data("reference", "faults", name)
    fixture = tactfix.load_fixture(folder / fixture)
    return tactfix.locate(fixture, tactfix.load_contacts(folder / "contacts.csv", fixture))


def test_both_senses_of_an_axis_are_listed():
    """The chi-squares of both minima are those of descents started at either (given with the problem)."""
    result = located("angle_two_branches")
    assert result.status == "ambiguous"
    np.testing.assert_allclose([c.chi2 for c in result.candidates], [6.98, 15.3], rtol=0.01)
    assert result.chi2_limit == pytest.approx(44.8, rel=0.01)


@pytest.mark.parametrize("name", ["angle_near_90", "opposite_faces", "parallel_aligned"])
def test_an_angle_next_to_a_fold_frees_no_motion_and_refuses_no_contact(name):
    assert located(name).status == "located"


def test_one_minimum_is_one_pose():
    result = located("same_pose_twice")
    assert result.status == "located"
    assert [c.chi2 for c in result.candidates if c.accepted] == [pytest.approx(1.9965, abs=1e-3)]


def leaning(degrees, azimuth=0.0):
    turn = (
        Rotation.from_euler("zy", [azimuth, degrees], degrees=True)
        if azimuth
        else Rotation.from_euler("y", degrees, degrees=True)
    )
    return turn.apply([0.0, 0.0, 1.0])


def plate_bar_ball(degrees):
    """A bar that is inclined to the normal of a plate, and a ball next to it."""
    return {
        "plate": Patch("plane", (0, 0, 0), (0, 0, 1), length=40.0),
        "bar": Patch("cylinder", (0, 0, 60), leaning(degrees), 8.0, length=30.0),
        "ball": Patch("sphere", (10, 90, 60), radius=10.0),
    }


RECIPE = recipe(("foot_of", "ball", "bar"), ("z", "along", "plate"), ("y", "from_to", "bar", "ball"))
TURNS = [np.eye(3), Rotation.from_rotvec([0.4, -1.1, 0.7]).as_matrix()]


@pytest.mark.parametrize("turn", TURNS, ids=["along the axes", "turned"])
@pytest.mark.parametrize("sigma", [0.0, 0.02])
@pytest.mark.parametrize("degrees", [0.0, 0.02, 0.3, 45.0, 89.9, 89.99, 90.0])
def test_a_measured_angle_frees_no_motion(degrees, sigma, turn):
    """With nominal and noisy contacts the true pose is among the poses, which are at most two if the angle is 89.9."""
    patches = plate_bar_ball(degrees)
    fixture = related(patches, [angle("plate", "bar", degrees, sigma)], RECIPE)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, [100, -200, 300]
    truth_in_fixture = frame_of(patches)
    for seed in range(2):
        rng = np.random.default_rng(seed)
        touched = touch_all(patches, {"plate": 6, "bar": 8, "ball": 5}, rng, pose=pose, sigma=0.01, cone=5.0)
        contacts = touched.contacts(rng if seed else None)
        result = tactfix.locate(fixture, contacts)
        assert result.status == "located" or (result.status == "ambiguous" and degrees == 89.9)
        errors = [pose_error(c.base_from_fixture, pose @ truth_in_fixture) for c in result.candidates if c.accepted]
        assert min(np.linalg.norm(error[:3]) for error in errors) < np.radians(0.1)
        if result.status == "located":
            assert errors[0] @ np.linalg.pinv(result.covariance) @ errors[0] < SIX_DOF_UPPER


def frame_of(patches):
    """The frame of RECIPE, computed here, in the frame in which the patches are given."""
    axis, point = np.asarray(patches["bar"].along), np.asarray(patches["bar"].at, float)
    ball = np.asarray(patches["ball"].at, float)
    origin = point + ((ball - point) @ axis) * axis
    z = np.array([0.0, 0.0, 1.0])
    y = (ball - origin) - ((ball - origin) @ z) * z
    y /= np.linalg.norm(y)
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = np.column_stack([np.cross(y, z), y, z]), origin
    return frame


PINS = {
    "plate": Patch("plane", (0, 0, 0), (0, 0, 1), length=60.0),
    "one": Patch("cylinder", (0, 0, 0), (0, 0, 1), 8.0, length=15.0, middle=20.0),
    "two": Patch("cylinder", (100, 0, 0), (0, 0, 1), 6.0, length=15.0, middle=20.0),
}
PARALLEL = [angle("plate", "one", 0), angle("plate", "two", 0), distance("one", "two", 100.0)]
ON_PLATE = recipe(("meet_of", "one", "plate"), ("z", "along", "plate"), ("x", "from_to", "one", "two"))


@pytest.mark.parametrize("turn", TURNS, ids=["along the axes", "turned"])
@pytest.mark.parametrize("relations", [PARALLEL, PARALLEL[:2], [angle("plate", "one", 0, 0.01), *PARALLEL[1:]]])
def test_pins_square_to_a_plate_are_located_however_the_machine_lies(relations, turn):
    pose = np.eye(4)
    pose[:3, :3] = turn
    fixture = related(PINS, relations, ON_PLATE)
    for seed in range(3):
        rng = np.random.default_rng(seed)
        touched = touch_all(PINS, {"plate": 4, "one": 6, "two": 6}, rng, pose=pose, sigma=0.001, cone=5.0)
        result = tactfix.locate(fixture, touched.contacts(rng if seed else None))
        assert result.status == "located"
        error = pose_error(result.base_from_fixture, pose)
        assert error @ np.linalg.solve(result.covariance, error) < SIX_DOF_UPPER


LEANING_BARS = 8
ALONG = Rotation.from_euler("z", np.linspace(0, 160, LEANING_BARS)[:, None], degrees=True)


def leaning_bars():
    """Short bars along a plate, whose contacts do not distinguish 89.9 from 90.1 deg: 256 branches."""
    bars = {
        f"bar_{n}": Patch("cylinder", (60 * n, 90, 30), turn.apply(leaning(89.9)), 8.0) for n, turn in enumerate(ALONG)
    }
    patches = {"plate": Patch("plane", (0, 0, 0), (0, 0, 1), length=60.0), **bars}
    frame = recipe(("foot_of", "bar_0", "bar_1"), ("z", "along", "plate"), ("x", "along", "bar_0"))
    fixture = related(patches, [angle("plate", name, 89.9, 0.02) for name in bars], frame)
    rng = np.random.default_rng(3)
    return patches, fixture, touch_all(patches, dict.fromkeys(patches, 6), rng, sigma=0.02).contacts(rng)


def test_of_many_open_branches_the_cheapest_are_followed(monkeypatch):
    """Against a search of all branches."""
    patches, fixture, contacts = leaning_bars()
    # The two senses cost the same for the first bars, which are nearly at 90 degrees, and differ for the last ones.
    found_at = [89.99, 89.99, 89.99, 89.99, 89.8, 89.8, 89.8, 89.8]
    axes = [turn.apply(leaning(degrees)) for turn, degrees in zip(ALONG, found_at, strict=True)]
    surfaces = {f"bar_{n}": Cylinder(patches[f"bar_{n}"].at, axis, 8.0) for n, axis in enumerate(axes)}
    surfaces["plate"] = patches["plate"].surface()
    problem = JointProblem(contacts, np.full(len(contacts), 0.02), fixture.relations, 100.0)
    found = branches.branches(problem, surfaces)
    monkeypatch.setattr(branches, "BRANCH_FITS", 2**LEANING_BARS)
    everything = branches.branches(problem, surfaces)
    assert len(everything.found) > len(found.found) == 96
    kept = [cost for cost, _ in found.found]
    np.testing.assert_allclose(kept, [cost for cost, _ in everything.found[:96]], rtol=1e-6)
    assert found.left_out >= kept[-1]
    assert everything.left_out == np.inf
    for _, equations in found.found:
        assert [e.relation for e in equations] == list(fixture.relations)


def test_branches_not_followed_are_reported():
    _, fixture, contacts = leaning_bars()
    result = tactfix.locate(fixture, contacts)
    assert result.status == "ambiguous"
    assert any("a pose may have been missed" in warning for warning in result.warnings)


def test_a_branch_pruned_before_the_last_relation_counts_as_left_out():
    """The 96 of 256 branches kept have the first bar at 89.9 deg, as its contacts favour; a post then requires 90.1."""
    bars = {f"bar_{n}": Cylinder([60 * n, 90, 30], turn.apply(leaning(90.0)), 8.0) for n, turn in enumerate(ALONG)}
    bars["bar_0"] = Cylinder([0, 90, 30], leaning(89.99), 8.0)
    surfaces = {
        **bars,
        "plate": Patch("plane", (0, 0, 0), (0, 0, 1), length=60.0).surface(),
        "post": Cylinder([0, -90, 0], leaning(0.2), 8.0),
    }
    patches = {n: Patch("cylinder", s.point, s.direction, s.radius, length=20.0) for n, s in bars.items()}
    patches["post"] = Patch("cylinder", (0, -90, 0), leaning(0.2), 8.0, length=20.0)
    patches["plate"] = Patch("plane", (0, 0, 0), (0, 0, 1), length=60.0)
    contacts = touch_all(patches, dict.fromkeys(patches, 9), np.random.default_rng(3), sigma=0.02).contacts()
    sigmas = np.array([2e-4 if name in ("plate", "post") else 0.02 for name in contacts.features])
    relations = [angle("plate", name, 89.9) for name in bars] + [angle("post", "bar_0", 89.9)]
    found = branches.branches(JointProblem(contacts, sigmas, tuple(relations), 100.0), surfaces)
    limit = branches.COSTLY * chi_square_limit(len(contacts))
    assert len(found.found) < 96
    assert found.left_out < limit


def test_directions_left_free_by_exact_contacts_have_the_sigma_of_the_size():
    """The contacts are 1e11 times as accurate as the free directions: normal equations would be singular."""
    surfaces = {"face": Plane(np.zeros(3), np.array([0.6, 0.0, 0.8])), "ball": Sphere(np.array([5.0, 0.0, 3.0]), 1.0)}
    u = np.array([0.8, 0.0, -0.6])
    points = [np.zeros(3), 3 * u, surfaces["ball"].center + u]
    contacts = tactfix.contacts_from_arrays(["face", "face", "ball"], points, sigma=1e-10, tip_radius=0.0)
    problem = JointProblem(contacts, contacts.sigmas, (), 10.0)
    covariance = branches._covariance(problem, surfaces)
    assert np.linalg.eigvalsh(covariance)[-3:] == pytest.approx([1.0, 1.0, 1.0])


@pytest.mark.parametrize(
    ("known", "counts", "sigma", "seed", "most"),
    [
        *((known, (7, 5), 0.03, seed, 0.03) for known in (1e-8, 1e-6, 1e-4) for seed in range(3)),
        # The covariance of the linear model differs by 10 per cent here.
        (1e-6, (6, 3), 0.06, 3, 0.05),
    ],
)
def test_a_distance_known_far_better_than_the_contacts_gives_the_covariance_of_geometry(
    known, counts, sigma, seed, most
):
    """With sigma several per cent of the bar's radius, the linear model violates a distance at the sigma points."""
    rng = np.random.default_rng(seed)
    truth = touch_all(CYLINDER_SPHERE, dict(zip(CYLINDER_SPHERE, counts, strict=True)), rng, sigma=sigma)
    contacts = truth.contacts(rng)
    relations = [distance("bar", "ball", 3.0, known)]
    by_relations = related(CYLINDER_SPHERE, relations, CYLINDER_SPHERE_RECIPE, CYLINDER_SPHERE_TOUCH)
    results = [tactfix.locate(f, contacts) for f in (by_relations, placed(CYLINDER_SPHERE, CYLINDER_SPHERE_TOUCH))]
    assert [result.status for result in results] == ["located", "located"]
    one, other = (np.sqrt(np.diag(result.covariance)) for result in results)
    np.testing.assert_allclose(one, other, rtol=most)
