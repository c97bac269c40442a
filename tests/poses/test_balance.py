"""The poses of six contacts have determinants of both signs, as many of one as of the other; all but one do not."""

import numpy as np
import pytest

from tactfix.geometry.surfaces import Cylinder, Plane, Sphere
from tactfix.poses.equations import pose_equations
from tactfix.poses.zeros import Zeros, are_balanced
from tests.validation.pose_oracle import all_real_poses
from tests.validation.pose_problems import oracle_features, problem_number

MAKE = {
    "plane": lambda f, unit: Plane(f.point / unit, f.direction),
    "sphere": lambda f, unit: Sphere(f.point / unit, f.radius / unit, f.side),
    "cylinder": lambda f, unit: Cylinder(f.point / unit, f.direction, f.radius / unit, f.side),
}


def solved(kind, layout, number=0):
    """Equations and poses as the search has them, rotations (3, 3, k) and offsets (3, k), by path tracking.

    Contacts about their mean, all lengths in units of their spread.
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


def exact(rotations, offsets):
    """These poses (3, 3, k), (3, k), each met once."""
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
    zeros = exact(rotations, offsets)
    assert are_balanced(equations, zeros)
    for missing in range(len(zeros)):
        assert not are_balanced(equations, zeros.subset(np.delete(np.arange(len(zeros)), missing)))


def test_what_may_have_either_sign_may_stand_for_what_is_missing():
    """A minimum that is no zero, as noise makes of two poses that are nearly one."""
    equations, rotations, offsets, _ = solved("sphere3+sphere2+sphere1", "loose")
    zeros = exact(rotations, offsets)
    zeros.costs[1] = 1e-8
    assert are_balanced(equations, zeros.since(1))


def test_seven_contacts_say_nothing():
    equations, rotations, offsets, _ = solved("sphere3+sphere2+sphere1", "loose")
    seven = equations.subset([0, 1, 2, 3, 4, 5, 5])
    assert are_balanced(seven, exact(rotations, offsets).since(1))
