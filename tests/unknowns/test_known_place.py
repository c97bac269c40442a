"""An unknown tip with a roughly known pose: limits, a measured pose, constrained directions."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from scipy.stats import chi2 as chi_square

from tactfix import locate
from tactfix.placement import Placement
from tests.support.flange_touches import PLATE, fixture_of
from tests.unknowns.test_unknown_tip import plate_problem, residuals_of


def near_of(problem, turn=(0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0)):
    """A pose that differs from the true one by a rotation vector and a shift in base axes."""
    near = problem.pose.copy()
    near[:3, :3] = Rotation.from_rotvec(turn).as_matrix() @ near[:3, :3]
    near[:3, 3] += shift
    return near


FLAT = frozenset(("x", "y", "rz"))


@pytest.mark.parametrize(
    ("count", "how"),
    [
        (4, {"sigma": (0.2, 1e-3)}),
        (1, {"sigma": (0.2, 1e-3)}),
        (2, {"free": FLAT}),
        (3, {"free": FLAT, "sigma": (0.2, 1e-3)}),
    ],
    ids=["measured", "one orientation, measured", "two orientations, held", "measured and held"],
)
def test_it_is_the_least_squares_that_scipy_finds(count, how):
    problem = plate_problem(31, count, 30.0)
    shift = (0.0, 0.0, 0.0) if "free" in how else (0.2, -0.1, 0.15)
    near = near_of(problem, shift=shift)
    placement = Placement(near, **how)
    fixture = replace(fixture_of(PLATE), placement=placement)
    result = locate(fixture, problem.contacts, unknown=["tip"])
    assert result.status == "located"
    free = np.flatnonzero(np.concatenate([placement.turns, placement.shifts, [True] * 3]))
    turned = Rotation.from_matrix(near[:3, :3])

    def misses(values):
        motion = np.zeros(9)
        motion[free] = values
        rotation = Rotation.from_rotvec(motion[:3]) * turned
        unknowns = np.concatenate([rotation.as_rotvec(), near[:3, 3] + motion[3:6], motion[6:], [3.0]])
        found = residuals_of(problem, unknowns)
        if placement.covariance is None:
            return found
        return np.concatenate([found, motion[:6] / np.sqrt(np.diag(placement.covariance))])

    best = least_squares(misses, np.zeros(len(free)), x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    motion = np.zeros(9)
    motion[free] = best.x
    assert result.chi2 == pytest.approx(2 * best.cost, rel=1e-5, abs=1e-6)
    assert result.dof == len(best.fun) - len(free)
    assert np.allclose(result.base_from_fixture[:3, 3] - near[:3, 3], motion[3:6], atol=1e-4)
    assert np.allclose(result.tip.offset - problem.contacts.tip_offset, motion[6:], atol=1e-4)
    covariance = np.zeros((9, 9))
    covariance[np.ix_(free, free)] = np.linalg.inv(best.jac.T @ best.jac)
    assert np.allclose(np.diag(result.joint_covariance), np.diag(covariance), rtol=1e-2, atol=1e-12)
    off = result.tip.offset - problem.tip
    assert off @ np.linalg.solve(result.tip.covariance, off) < chi_square.isf(1e-4, 3)


def test_limits_change_no_pose_and_only_eliminate():
    problem = plate_problem(32, 4, 45.0)
    alone = locate(fixture_of(PLATE), problem.contacts, unknown=["tip"])
    around = replace(fixture_of(PLATE), placement=Placement(near_of(problem, shift=(5.0, 0, 0)), (20.0, 0.1)))
    within = locate(around, problem.contacts, unknown=["tip"])
    assert within.status == "located"
    assert np.allclose(within.base_from_fixture, alone.base_from_fixture, atol=1e-6)
    assert within.without_prior.status == "located"
    elsewhere = replace(around, placement=Placement(near_of(problem, shift=(50.0, 0, 0)), (20.0, 0.1)))
    beyond = locate(elsewhere, problem.contacts, unknown=["tip"])
    assert beyond.status == "inconsistent"
    assert {reason.code for candidate in beyond.candidates for reason in candidate.reasons} == {"prior"}
    assert "along x" in beyond.warnings[0]


def test_prior_knowledge_decides_if_one_orientation_leaves_the_tip_free():
    problem = plate_problem(33, 1, 0.0)
    fixture = replace(fixture_of(PLATE), placement=Placement(near_of(problem), sigma=(0.1, 1e-3)))
    result = locate(fixture, problem.contacts, unknown=["tip"])
    assert result.status == "located"
    assert result.without_prior.status == "underdetermined"
    assert any("depends on what is known beforehand" in warning for warning in result.warnings)
