"""A mistake in all of many contacts is estimated from all of them, although the search uses a part."""

from dataclasses import replace

import numpy as np
import pytest

from tactfix import locate
from tests.support.flange_touches import PLATE, RADIUS, SIGMA, fixture_of, orientations, plate_touches, touched


@pytest.mark.parametrize("off", [SIGMA, 2 * SIGMA])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_small_error_of_the_tip_radius_is_estimated_from_all_contacts(off, seed):
    """With a tenth of the contacts the radius is three times less certain, and mirrored coordinates fit as well."""
    rng = np.random.default_rng(seed)
    cell = plate_touches(rng, 100)
    contacts = touched(cell, rng, orientations(1, 0.0), np.zeros(3), stated_radius=RADIUS + off).contacts
    result = locate(fixture_of(PLATE), replace(contacts, flange_rotations=None, tip_offset=None))
    first = result.diagnosis[0]
    assert (first.code, first.one_of) == ("tip_radius", False)
    assert first.value == pytest.approx(RADIUS, abs=0.01)
    assert {entry.code for entry in result.diagnosis} <= {"tip_radius", "radius", "sigma"}
    assert all(200 < entry.chi2 <= result.chi2_limit for entry in result.diagnosis)
