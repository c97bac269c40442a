"""Joint least squares of contacts and relations: a fit with contradictory constraints ends early."""

import numpy as np
import pytest

import tactfix
from tactfix.geometry.surfaces import Cylinder
from tactfix.relations import joint, joint_solutions, samples
from tactfix.relations.branches import nearest_branch
from tactfix.relations.joint_problem import JointProblem
from tactfix.relations.joint_sigma_points import JointSpread
from tests.relations.touched_parts import as_read, few_touches
from tests.support.problems import angle
from tests.validation import relation_touches
from tests.validation.relation_geometry import Part, bar, leaning, plane
from tests.validation.relation_touches import by_relations
from tests.validation.relations_study import Cell, drawn, loaded, located


def leaning_bar(degrees, rng):
    """A bar inclined towards x, slightly displaced, and six contacts around it."""
    lean = np.radians(degrees)
    direction = np.array([np.sin(lean), 0.0, np.cos(lean)]) + 1e-4 * rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    u = np.cross(direction, [0.0, 1.0, 0.0]) / np.linalg.norm(np.cross(direction, [0.0, 1.0, 0.0]))
    v, at = np.cross(direction, u), 10 * rng.normal(size=3)
    places = [(-5, 0), (-5, 2), (-5, 4), (5, 1), (5, 3), (5, 5)]
    return Cylinder(at, direction, 1.0), [at + h * direction + np.cos(t) * u + np.sin(t) * v for h, t in places]


@pytest.mark.parametrize("seed", [1, 2])
def test_constraints_that_contradict_each_other_end_the_fit(seed, monkeypatch):
    """Two angles of 10 deg allow at most 20 deg between the outer two: a violation remains at which steps gain almost
    nothing.
    """
    steps, linearized = [], joint.linearized
    monkeypatch.setattr(joint, "linearized", lambda *given: steps.append(1) or linearized(*given))
    rng = np.random.default_rng(seed)
    touched = {name: leaning_bar(degrees, rng) for name, degrees in (("a", 0), ("b", 10), ("c", 20))}
    bars = {name: surface for name, (surface, _) in touched.items()}
    points = np.concatenate([points for _, points in touched.values()])
    contacts = tactfix.contacts_from_arrays(["a"] * 6 + ["b"] * 6 + ["c"] * 6, points, sigma=0.01, tip_radius=0.0)
    relations = (angle("a", "b", 10), angle("b", "c", 10), angle("a", "c", 20.02))
    problem = JointProblem(contacts, contacts.sigmas, relations, 10.0)
    fit = joint.joint_fit(problem, bars, nearest_branch(relations, bars))
    assert fit.missing > 1e-5
    assert len(steps) < 40


def crossing_bars():
    """Two bars at 0.1 deg to each other and a third that crosses both: all distances are nearly 0."""
    one, other = leaning(0.0), leaning(57.8)
    turned = leaning(0.1, 167.0)
    at, normal = np.zeros(3), np.cross(turned, other)
    bars = {"a": bar(at + 0.02 * normal / np.linalg.norm(normal), turned, 8.0, "inner"), "b": bar(at, one, 6.0)}
    things = {**bars, "c": plane([30, 0, -20], one), "d": bar(at, other, 10.0, "inner")}
    to_d = float(np.degrees(np.arccos(turned @ other)))
    degrees = {"ab": 0.1, "ac": 0.1, "ad": to_d, "bc": 0.0, "bd": 57.8, "cd": 57.8}
    relations = [("angle", *pair, value, 0.0) for pair, value in degrees.items()]
    relations += [("distance", "a", "d", 0.02, 0.0), ("distance", "b", "d", 0.0, 0.0)]
    frame = {"origin": {"foot_of": "b", "on": "d"}, "x": {"along": "b"}, "y": {"along": "d"}}
    return Part(things, relations, frame)


def test_the_size_of_a_fixture_is_not_that_of_axes_that_nearly_cross(tmp_path):
    """Lengths in units of 0.02 mm made the constraints differ so much that dependent ones were not recognized."""
    part, rng = crossing_bars(), np.random.default_rng(4)
    touched = few_touches(part, rng, most=5)
    result = tactfix.locate(*as_read(part, touched, rng, tmp_path))
    off = [np.abs(c.base_from_fixture - touched.base_from_fixture).max() for c in result.candidates if c.accepted]
    assert result.status in ("located", "ambiguous")  # bars have no sense, so both signs may remain
    assert min(off) < 0.1


def test_a_fit_at_a_fold_ends_when_chi_square_no_longer_falls(tmp_path, monkeypatch):
    """J is singular there, so that the undamped step always predicts a gain; 14 of 26 fits took all 200 steps."""
    monkeypatch.setattr(relation_touches, "COUNTS", {"cylinder": 3})
    part, touched, noise, _ = drawn(Cell("three bars by angles", 0.0, 0.1, turned=False, noisy=True), 250295)
    counts, improved, fit = [], joint._improved, samples.branch_fit
    monkeypatch.setattr(samples, "branch_fit", lambda *given: counts.append(0) or fit(*given))

    def counted(*given):
        counts[-1] += 1
        return improved(*given)

    monkeypatch.setattr(joint, "_improved", counted)
    located(loaded(by_relations(part), tmp_path), touched, noise, tmp_path, explain=False)
    assert max(counts) < joint.MOST_JOINT_STEPS / 2


def test_fits_along_a_curved_valley_reach_its_minimum(tmp_path, monkeypatch):
    """Steps violate the constraints anew, to second order; fits that were given up for it left nine poses of one.

    With constraints alone corrected, 24 fits from ends along one valley took 4,139 evaluations; 368 with residuals too.
    """
    evaluations, linearized = [], joint.linearized
    monkeypatch.setattr(joint, "linearized", lambda *given: evaluations.append(1) or linearized(*given))
    monkeypatch.setattr(relation_touches, "COUNTS", {"plane": 2, "sphere": 5})
    part, touched, noise, _ = drawn(Cell("three faces at all angles", 0.3, 0.0, turned=True, noisy=True), 440170)
    result = located(loaded(by_relations(part), tmp_path), touched, noise, tmp_path, explain=False)
    chi2 = [candidate.chi2 for candidate in result.candidates]
    assert max(chi2) - min(chi2) < 0.01
    assert len(evaluations) < 1000


def test_sigma_points_are_computed_only_for_solutions_that_approaches_allow(tmp_path, monkeypatch):
    """Most solutions are rejected because the probe would have come out of the material; the result is the same."""
    part, touched, noise, _ = drawn(Cell("socket and bar", 45.0, 0.1, turned=True, noisy=True), 1)
    fixture, curved, at = loaded(by_relations(part), tmp_path), [], JointSpread.at
    monkeypatch.setattr(JointSpread, "at", lambda *given: curved.append(1) or at(*given))
    few = located(fixture, touched, noise, tmp_path)
    backwards = [reason.code == "approach" for candidate in few.candidates for reason in candidate.reasons]
    assert any(backwards)
    assert len(curved) == len(few.candidates) - sum(backwards)
    monkeypatch.setattr(joint_solutions, "SURE_IF_CURVED", np.inf)
    every = located(fixture, touched, noise, tmp_path)
    assert len(curved) > len(few.candidates)
    np.testing.assert_array_equal(few.covariance, every.covariance)
    assert [c.reasons for c in few.candidates] == [c.reasons for c in every.candidates]
