"""Starts of descents; sets of zeros: continua, and the sum of signs over all zeros of six equations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tactfix.poses.equations import centred_offsets, pose_equations
from tactfix.poses.pose_domain import ALL_POSES
from tactfix.poses.starts import NEIGHBOURS, SIDES, START_OFFSET, around, covering
from tactfix.poses.zeros import MOST_ZEROS, Zeros, are_balanced, together
from tests.support.problems import PLATE, touch_all
from tests.validation.pose_oracle import all_real_poses
from tests.validation.pose_problems import oracle_features, problem_number


def equations():
    rng = np.random.default_rng(2)
    contacts = touch_all(PLATE, {"plate": 4, "pin": 4, "ball": 4}, rng).contacts(rng)
    index = [list(PLATE).index(name) for name in contacts.features]
    points = (contacts.points - contacts.points.mean(axis=0)) / 100
    return pose_equations([patch.surface(0.01) for patch in PLATE.values()], index, points, np.ones(12), 0.0)


@pytest.mark.parametrize("number", [0, 3])
def test_a_covering_is_even_and_off_the_best_translations(number):
    system = equations()
    rotations, offsets = covering(system, 400, number)
    away = offsets - centred_offsets(system, rotations)
    np.testing.assert_allclose(np.linalg.norm(away, axis=0), START_OFFSET)
    assert np.linalg.norm(away.mean(axis=1)) < 0.1
    rotations = Rotation.from_matrix(np.moveaxis(rotations, -1, 0))
    # 400 caps of 23 degrees would fill the group of rotations without gap or overlap.
    nearest = [(rotations * one.inv()).magnitude().min() for one in Rotation.random(50, random_state=1)]
    assert np.degrees(max(nearest)) < 45


def test_coverings_differ():
    system = equations()
    one, other = (covering(system, 50, number)[0] for number in (1, 2))
    assert np.abs(one - other).max() > 0.1


def test_neighbours_are_at_every_scale():
    centre = Zeros(np.eye(3)[:, :, None], np.array([[1.0], [2.0], [3.0]]), np.zeros(1), np.ones(1, dtype=np.intp))
    rotations, offsets = around(ALL_POSES, centre, 1)
    assert offsets.shape == (3, NEIGHBOURS)
    # Cayley's map rotates by twice the arc tangent of half the vector's length.
    angles = Rotation.from_matrix(np.moveaxis(rotations, -1, 0)).magnitude()
    steps = np.hypot(2 * np.tan(angles / 2), np.linalg.norm(offsets - centre.offsets, axis=0))
    assert 0.05 <= steps.min() < 0.1
    assert 0.8 < steps.max() <= 1.2


def test_sides_of_no_and_of_all_six_contacts():
    np.testing.assert_allclose(sorted(np.linalg.norm(SIDES, axis=0)), [0.0, *[START_OFFSET] * 6])
    np.testing.assert_allclose(SIDES.sum(axis=1), 0.0)


def test_more_zeros_than_any_problem_has_are_samples_of_a_motion():
    """Of a thousand distinct zeros MOST_ZEROS + 1 are kept, enough to recognize a continuum."""
    system = equations()
    rotations, offsets = covering(system, 1000, 0)
    found = Zeros(rotations, offsets, np.zeros(1000), np.ones(1000, dtype=np.intp))
    kept = Zeros.none().joined(found)
    assert len(kept) == MOST_ZEROS + 1
    assert kept.merged(system).continuum
    part = found.subset(np.arange(300))
    kept = Zeros.none().joined(together([part, part]))
    assert (kept.counts == 2).all()
    assert not kept.merged(system).continuum
    assert (kept.joined(part).counts == 3).all()


MAKE = {
    "plane": lambda f, unit: Plane(f.point / unit, f.direction),
    "sphere": lambda f, unit: Sphere(f.point / unit, f.radius / unit, f.side),
    "cylinder": lambda f, unit: Cylinder(f.point / unit, f.direction, f.radius / unit, f.side),
}


def solved(kind, layout, number=0):
    """Equations in the form of the search, and their poses by path tracking: rotations (3, 3, k), offsets (3, k).

    Contacts are relative to their mean, in units of their spread.
    """
    problem = problem_number(kind, layout, 1, number)
    answer = all_real_poses(oracle_features(problem), problem.feature_of_contact, problem.points, problem.rho)
    middle, unit = problem.points.mean(axis=0), np.sqrt(problem.points.var(axis=0).sum())
    surfaces = [MAKE[f.type](f, unit) for f in problem.features]
    points = (problem.points - middle) / unit
    equations = pose_equations(
        surfaces, list(problem.feature_of_contact), points, np.ones(6), problem.tip_radius / unit
    )
    rotations = np.transpose(answer.poses[:, :3, :3], (2, 1, 0))
    offsets = np.einsum("abN,bN->aN", rotations, middle[:, None] - answer.poses[:, :3, 3].T) / unit
    return equations, rotations, offsets, answer


def zeros_at(rotations, offsets):
    """These poses (3, 3, k), (3, k) as zeros, each found once."""
    count = offsets.shape[1]
    return Zeros(rotations, offsets, np.zeros(count), np.ones(count, dtype=np.intp))


@pytest.mark.parametrize("layout", ["loose", "symmetric", "mixed"])
@pytest.mark.parametrize(
    "kind",
    [
        "plane3+plane2+plane1",
        "plane2+plane2+plane2",
        "sphere3+sphere2+sphere1",
        "sphere2+plane3+plane1",
        "cylinder3+plane3",
        "cylinder2+plane3+plane1",
    ],
)
def test_all_poses_balance_and_all_but_one_do_not(kind, layout):
    equations, rotations, offsets, answer = solved(kind, layout)
    assert not answer.multiple.any()
    zeros = zeros_at(rotations, offsets)
    assert are_balanced(equations, zeros)
    for missing in range(len(zeros)):
        assert not are_balanced(equations, zeros.subset(np.delete(np.arange(len(zeros)), missing)))


def test_a_zero_of_uncertain_sign_may_replace_a_missing_one():
    """A minimum that is not a zero, as that of two nearly equal poses with noise."""
    equations, rotations, offsets, _ = solved("sphere3+sphere2+sphere1", "loose")
    zeros = zeros_at(rotations, offsets)
    zeros.costs[1] = 1e-8
    assert are_balanced(equations, zeros.since(1))


def test_seven_contacts_have_no_sum_of_signs():
    equations, rotations, offsets, _ = solved("sphere3+sphere2+sphere1", "loose")
    seven = equations.subset([0, 1, 2, 3, 4, 5, 5])
    assert are_balanced(seven, zeros_at(rotations, offsets).since(1))
