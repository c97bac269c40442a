"""Fixtures by relations: every noisy set of contacts finds the truth, exact relations hold, all shapes are found."""

import numpy as np
import pytest
from core.problems import BALLS, BALLS_RECIPE, ball_distances, pose_error, related, touch_all

from tactfix.assembly import assembled_solutions

SIX_DOF_UPPER = 38.3
"""Chi-square that six degrees of freedom exceed once in a million (tables)."""


@pytest.mark.parametrize("sigma", [1e-6, 1e-3, 0.1])
@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e3])
def test_exact_distances_hold_and_no_noise_loses_the_truth(sigma, unit):
    fixture = related(BALLS, [*ball_distances()] if unit == 1 else scaled_distances(unit), BALLS_RECIPE, scale=unit)
    rng = np.random.default_rng(5)
    for _ in range(6):
        truth = touch_all(BALLS, {"a": 4, "b": 4, "c": 4}, rng, sigma=sigma, tip=2.0, scale=unit)
        contacts = truth.contacts(rng)
        best = assembled_solutions(fixture, contacts, contacts.sigmas).found[0]
        assert best.chi2 < SIX_DOF_UPPER
        error = pose_error(best.base_from_fixture, truth.pose)
        assert error @ np.linalg.solve(best.covariance, error) < SIX_DOF_UPPER
        for relation in fixture.relations:
            a, b = (best.surfaces[name].center for name in relation.between)
            assert np.linalg.norm(a - b) == pytest.approx(relation.value, rel=1e-8)


def scaled_distances(unit):
    return [type(r)(r.kind, r.between, r.value * unit, r.sigma * unit) for r in ball_distances()]
