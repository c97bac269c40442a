"""Many solutions of few contacts: those that were not met are not denied."""

from random import Random

import numpy as np
import pytest

import tactfix
from tactfix.noise import chi_square_limit
from tactfix.probe import residual_sigmas
from tactfix.relations import samples
from tactfix.relations.branch_fits import nearest_start
from tactfix.relations.joint_problem import JointProblem, linearized
from tactfix.relations.realization import fixture_scale
from tests.relations.touched_parts import few_contacts_on


@pytest.mark.parametrize("seed", [0, 13, 33])
def test_right_contacts_are_not_inconsistent_where_the_search_did_not_settle(seed, tmp_path):
    """Three contacts on each of three bars have many solutions; approaches reject all that were met."""
    fixture, contacts, _ = few_contacts_on("three bars by angles", seed, tmp_path, (30.0, 0.02), 3)
    result = tactfix.locate(fixture, contacts)
    assert result.status == "underdetermined"
    assert not any(candidate.accepted for candidate in result.candidates)
    assert any("did not settle" in warning for warning in result.warnings)
    assert not result.free_motions


def test_the_only_fit_left_of_a_partial_sample_is_not_located(tmp_path):
    """One of the solutions that were fitted passes all tests; the right one was not among them."""
    fixture, contacts, truth = few_contacts_on("three bars by angles", 1, tmp_path, (30.0, 0.02), 3)
    result = tactfix.locate(fixture, contacts)
    left = [candidate.base_from_fixture for candidate in result.candidates if candidate.accepted]
    assert len(left) == 1
    assert np.abs(left[0] - truth.base_from_fixture)[:3, :3].max() > 0.1
    assert result.status == "underdetermined"
    assert result.base_from_fixture is None


@pytest.mark.parametrize(("fitted", "statuses"), [(12, {"underdetermined"}), (128, {"located", "ambiguous"})])
def test_misses_of_a_part_of_the_ends_deny_no_solution(fitted, statuses, tmp_path, monkeypatch):
    """The worst ends come first, so that more than eight fits miss before one explains the contacts."""
    fixture, contacts, _ = few_contacts_on("bar on plate", 0, tmp_path, most=3)
    distinct = samples._distinct_ends
    monkeypatch.setattr(samples, "END_LIMIT", 1e12)
    monkeypatch.setattr(samples, "_comes_out", lambda *_: False)
    monkeypatch.setattr(samples, "_distinct_ends", lambda *given: distinct(*given)[::-1])
    monkeypatch.setattr(samples, "FITTED_ENDS", fitted)
    assert tactfix.locate(fixture, contacts).status in statuses


def test_a_fit_that_does_not_keep_the_relations_is_no_miss(tmp_path):
    """It has not converged, and tells nothing of what explains the contacts."""
    fixture, contacts, _ = few_contacts_on("bar on plate", 0, tmp_path, most=5)
    problem = JointProblem(contacts, residual_sigmas(fixture, contacts), fixture.relations, fixture_scale(fixture))
    rng = Random(1)
    anywhere = {name: samples._anywhere(f, contacts, problem.scale, rng) for name, f in fixture.features.items()}
    fit = linearized(problem, anywhere, nearest_start(problem, anywhere).equations)
    assert fit.chi2 > chi_square_limit(fit.dof)
    assert fit.missing > samples.RELATIONS_HOLD
    assert not samples._are_misses([fit])
