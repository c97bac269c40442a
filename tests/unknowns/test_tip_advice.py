"""Advice if pose and tip are not found together: a wrong contact, a distinguishing contact, a turned tool."""

from dataclasses import replace

import numpy as np
import pytest

from tactfix import locate
from tactfix.contact_arrays import contacts_from_arrays
from tactfix.localization import tip_advice
from tests.support.flange_touches import PLATE, RADIUS, SIGMA, fixture_of, orientations, plate_touches, touched
from tests.unknowns.test_unknown_tip import SIDEWAYS, plate_problem


@pytest.mark.parametrize("row", [2, 9, 17])
def test_the_contact_that_is_wrong_is_named(row):
    problem = plate_problem(40 + row, 4, 45.0)
    points = problem.contacts.points.copy()
    points[row - 1] += 1.5 * problem.contacts.approaches[row - 1]
    result = locate(fixture_of(PLATE), replace(problem.contacts, points=points), unknown=["tip"])
    assert result.status == "inconsistent"
    first = result.diagnosis[0]
    assert first.code == "outlier"
    assert row in first.rows
    assert first.message in result.warnings
    # Without it the remaining contacts locate.
    again = locate(fixture_of(PLATE), problem.contacts.subset([i for i in range(18) if i != row - 1]), unknown=["tip"])
    assert again.status == "located"


@pytest.mark.parametrize("row", [3, 50, 88])
def test_of_many_contacts_the_most_suspicious_are_deleted(monkeypatch, row):
    rng, deletions = np.random.default_rng(row), []
    problem = touched(plate_touches(rng, 30), rng, orientations(6, 30.0), SIDEWAYS)
    points = problem.contacts.points.copy()
    points[row - 1] += 1.5 * problem.contacts.approaches[row - 1]
    original = tip_advice.descend
    monkeypatch.setattr(tip_advice, "descend", lambda *given: deletions.append(given) or original(*given))
    result = locate(fixture_of(PLATE), replace(problem.contacts, points=points), unknown=["tip"])
    assert result.status == "inconsistent"
    assert result.diagnosis[0].code == "outlier"
    assert result.diagnosis[0].rows == (row,)
    assert len(deletions) < len(points) / 3


def test_a_tip_beyond_its_bound_blames_no_contact():
    problem = plate_problem(5, 4, 45.0, np.array([8.0, 0.0, 0.0]))
    result = locate(fixture_of(PLATE, 5.0), problem.contacts, unknown=["tip"])
    assert result.status == "inconsistent"
    assert result.diagnosis == ()


@pytest.mark.parametrize("count", [1, 2])
def test_too_few_orientations_ask_for_a_touch_with_the_tool_turned(count):
    problem = plate_problem(50 + count, count, 20.0)
    result = locate(fixture_of(PLATE), problem.contacts, unknown=["tip"])
    assert result.status == "underdetermined"
    touch = result.next_contact
    assert "with the tool turned about another axis" in touch.message
    assert touch.point is None
    # With touches as advised, in different orientations, the tip is found.
    rng = np.random.default_rng(6)
    more = touched(plate_touches(rng, 2), rng, orientations(4, 40.0), problem.tip - [2.0, -5.0, 150.0])
    rotation = problem.turn * more.turn.inv()
    points = rotation.apply(more.contacts.points - more.shift) + problem.shift
    both = contacts_from_arrays(
        [*problem.contacts.features, *more.contacts.features],
        np.vstack([problem.contacts.points, points]),
        sigma=SIGMA,
        tip_radius=RADIUS,
        flange_rotations=np.concatenate(
            [problem.contacts.flange_rotations, rotation.as_matrix() @ more.contacts.flange_rotations]
        ),
        tip_offset=problem.contacts.tip_offset,
    )
    assert locate(fixture_of(PLATE), both, unknown=["tip"]).status != "underdetermined"


@pytest.mark.parametrize("seed", [63, 64, 68])
def test_a_touch_distinguishes_the_remaining_poses(seed):
    """Nine contacts without approaches for the nine unknowns of pose and tip."""
    problem = plate_problem(seed, 4, 45.0)
    keep = [0, 1, 2, 6, 7, 8, 9, 12, 13]
    bare = replace(problem.contacts.subset(keep), approaches=np.full((len(keep), 3), np.nan))
    result = locate(fixture_of(PLATE, 5.0), bare, unknown=["tip"])
    assert result.status == "ambiguous"
    assert "the poses disagree by" in result.next_contact.message
    assert result.next_contact.point is not None
