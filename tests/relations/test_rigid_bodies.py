"""Fixtures with many rigid shapes: the true shape is found, or the search reports that it is incomplete."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import tactfix
from tactfix.relations import realization, rigid_bodies
from tactfix.relations.assembly import assembled_solutions
from tactfix.relations.realization import bodies
from tests.relations.touched_parts import as_read, few_contacts_on, few_touches
from tests.validation.relation_geometry import Part, bar

SEEDS = range(6)


def holds_truth(solutions, touched) -> bool:
    truth = touched.base_from_fixture
    apart = [np.abs(s.base_from_fixture[:3, :3] - truth[:3, :3]).max() for s in solutions.found]
    return min(apart, default=np.inf) < 0.02


@pytest.mark.parametrize("seed", SEEDS)
def test_of_many_shapes_the_one_touched_is_found_and_the_search_complete(seed, tmp_path):
    fixture, contacts, touched = few_contacts_on("three bars", seed, tmp_path)
    assert len(bodies(fixture)) > 2
    solutions = assembled_solutions(fixture, contacts, contacts.sigmas)
    assert holds_truth(solutions, touched)
    assert solutions.complete


def test_a_shape_that_the_coverings_overlook_leaves_the_search_incomplete(tmp_path, monkeypatch):
    """Coverings of two starts miss most poses: whenever the true one is missed, the search is marked incomplete."""
    monkeypatch.setattr(rigid_bodies, "FEW_BODY_STARTS", 2)
    monkeypatch.setattr("tactfix.poses.all_poses.BEYOND_SHARE", 0.001)
    lost = 0
    for seed in SEEDS:
        fixture, contacts, touched = few_contacts_on("three bars", seed, tmp_path)
        solutions = assembled_solutions(fixture, contacts, contacts.sigmas)
        if not holds_truth(solutions, touched):
            lost += 1
            assert not solutions.complete
            warnings = tactfix.locate(fixture, contacts).warnings
            assert any("a pose may have been missed" in warning for warning in warnings)
    assert lost


def test_chi_square_of_a_miss_uses_the_contacts_own_sigma(tmp_path):
    """The shape is searched with a larger sigma of the contacts, but chi-square is reported for their own sigma."""
    fixture, contacts, _ = few_contacts_on("three bars", 1, tmp_path, angle=(60.0, 0.1))
    points = contacts.points.copy()
    points[4] += [9.0, 9.0, 9.0]
    result = tactfix.locate(fixture, replace(contacts, points=points))
    assert result.status == "inconsistent"
    own = sum(contact.residual**2 for contact in result.contacts) / contacts.sigmas[0] ** 2
    assert result.chi2 == pytest.approx(own, rel=0.5)
    assert result.chi2 >= own * (1 - 1e-9)  # equal, but for rounding, where relations hold


def four_bars():
    """All distances and angles of four bars: a dozen shapes, each found by one random start in twenty."""
    turns = Rotation.from_euler("xyz", [[0, 0, 0], [50, 0, 0], [60, 40, 0], [-30, 60, 20]], degrees=True)
    places = [[0, 0, 0], [80, 20, 10], [10, 90, 30], [-60, -50, 20]]
    bars = {name: bar(at, turn.apply([0, 0, 1])) for name, at, turn in zip("abcd", places, turns, strict=True)}
    relations = []
    for one, other in combinations(bars, 2):
        u, v, gap = bars[one].along, bars[other].along, bars[other].at - bars[one].at
        apart = abs(gap @ np.cross(u, v)) / np.linalg.norm(np.cross(u, v))
        relations += [("distance", one, other, float(apart), 0.0)]
        relations += [("angle", one, other, float(np.degrees(np.arccos(abs(u @ v)))), 0.0)]
    frame = {"origin": {"foot_of": "b", "on": "a"}, "x": {"from": "a", "to": "b"}, "y": {"from": "a", "to": "c"}}
    return Part(bars, relations, frame)


def test_shapes_that_few_starts_lead_to_are_not_looked_for_at_length(tmp_path, monkeypatch):
    """240 starts took three seconds and found only part of the shapes; features located alone are sufficient."""
    starts, relaxed = [], realization._relaxed
    monkeypatch.setattr(realization, "_relaxed", lambda *given: starts.append(1) or relaxed(*given))
    part, rng = four_bars(), np.random.default_rng(1)
    touched = few_touches(part, rng, most=7)
    result = tactfix.locate(*as_read(part, touched, rng, tmp_path))
    assert result.status == "located"
    assert np.abs(result.base_from_fixture - touched.base_from_fixture).max() < 0.1
    assert len(starts) < 100
