"""A wrong tip offset in the flange: named first, with the correct offset, and no good contact is blamed."""

from dataclasses import replace

import numpy as np
import pytest

from tactfix.localization.locate import locate
from tests.support.flange_touches import NOMINAL, PLATE, RADIUS, fixture_of, orientations, plate_touches, touched

SIGMA = 0.02


def off_sideways(size, seed, count=6):
    """Eighteen touches in six tool orientations, the tip displaced by size perpendicular to the flange's z axis."""
    rng = np.random.default_rng([seed, 77])
    angle = rng.uniform(0, 2 * np.pi)
    error = size * np.array([np.cos(angle), np.sin(angle), 0.0])
    return touched(plate_touches(rng), rng, orientations(count, 25.0), error, sigma=SIGMA)


def blames_one_contact(result):
    first = next(iter(result.diagnosis), None)
    return first is not None and first.code == "outlier" and not first.one_of


@pytest.mark.parametrize("seed", [0, 1, 2, *(pytest.param(s, marks=pytest.mark.slow) for s in (3, 4, 5))])
def test_half_a_millimetre_sideways_is_named_first_with_its_value(seed):
    problem = off_sideways(0.5, seed)
    result = locate(fixture_of(PLATE), problem.contacts)
    assert result.status == "inconsistent"
    first = result.diagnosis[0]
    assert first.code == "tip_offset", result.warnings
    assert first.value == pytest.approx(tuple(problem.tip), abs=0.1)
    assert "in the flange frame" in first.message


@pytest.mark.parametrize("unknown", ["tip-radius"])
@pytest.mark.parametrize("seed", range(3))
def test_a_tip_error_is_named_with_an_unknown_radius(seed, unknown):
    problem = off_sideways(0.5, seed)
    result = locate(fixture_of(PLATE), replace(problem.contacts, tip_radius=RADIUS + 0.3), unknown=[unknown])
    assert result.status == "inconsistent"
    assert [cause.code for cause in result.diagnosis] == ["tip_offset"]
    assert result.diagnosis[0].value == pytest.approx(tuple(problem.tip), abs=0.1)
    assert result.warnings[-1] == result.diagnosis[0].message


@pytest.mark.parametrize(("size", "least"), [(0.1, 1), (0.2, 5), pytest.param(0.3, 8, marks=pytest.mark.slow)])
def test_a_small_tip_error_blames_no_good_contact(size, least):
    """The tip is also named if residuals are only suspicious; one contact alone is never named."""
    named = 0
    for seed in range(8):
        problem = off_sideways(size, seed)
        result = locate(fixture_of(PLATE), problem.contacts)
        assert not blames_one_contact(result), result.warnings
        codes = {cause.code for entry in result.diagnosis[:1] for cause in (entry.causes or (entry,))}
        named += "tip_offset" in codes
    assert named >= least


def test_one_tool_orientation_does_not_determine_the_tip():
    """The wrong tip only shifts the pose: the contacts are consistent, and nothing is named."""
    rng = np.random.default_rng(3)
    problem = touched(plate_touches(rng), rng, orientations(1, 0.0), np.array([0.5, 0.0, 0.0]), sigma=SIGMA)
    result = locate(fixture_of(PLATE), problem.contacts)
    assert result.status == "located"
    assert result.diagnosis == ()


def test_a_bad_contact_is_still_named_where_the_tip_is_right():
    for seed in range(4):
        problem = off_sideways(0.0, seed)
        assert problem.tip == pytest.approx(NOMINAL)
        points = problem.contacts.points.copy()
        points[7] -= 0.4 * problem.contacts.approaches[7]
        result = locate(fixture_of(PLATE), replace(problem.contacts, points=points))
        assert (result.diagnosis[0].code, result.diagnosis[0].rows) == ("outlier", (8,)), result.warnings
