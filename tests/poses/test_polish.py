"""With more contacts than are followed at once: the same poses, each at the optimum of all contacts."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tactfix.localization.locate import locate
from tactfix.poses.subsets import THINNED
from tests.support.problems import CORNER, PLATE, placed, touch_all


def touched(patches, each, seed=3):
    truth = touch_all(patches, dict.fromkeys(patches, each), np.random.default_rng(seed), sigma=0.02, tip=1.0)
    return truth, truth.contacts(np.random.default_rng(seed + 1))


def squares_of_planes(contacts, pose):
    """Chi-square of the nearest least squares for the three planes of CORNER, which meet in the origin."""

    def residuals(step):
        turn = Rotation.from_rotvec(step[:3]).as_matrix() @ pose[:3, :3]
        in_fixture = (contacts.points - pose[:3, 3] - step[3:]) @ turn
        axis = {"right": 0, "back": 1, "top": 2}
        own = in_fixture[np.arange(len(contacts)), [axis[name] for name in contacts.features]]
        return (own - contacts.tip_radius) / contacts.sigmas

    return 2 * least_squares(residuals, np.zeros(6), x_scale=[1e-4] * 3 + [1e-2] * 3, xtol=1e-15, ftol=1e-15).cost


def test_all_mirror_images_of_many_contacts_are_found_and_each_is_the_optimum():
    _, contacts = touched(CORNER, THINNED // 2)
    contacts = replace(contacts, approaches=np.full_like(contacts.points, np.nan))
    result = locate(placed(CORNER), contacts)
    assert result.status == "ambiguous"
    assert len(result.candidates) == 4
    for candidate in result.candidates:
        assert candidate.chi2 == pytest.approx(squares_of_planes(contacts, candidate.base_from_fixture), rel=1e-9)


def test_one_bad_contact_among_thousands_is_seen_wherever_it_is():
    """Also where the thousand that are looked at first do without it."""
    truth, contacts = touched(PLATE, THINNED)
    assert locate(placed(PLATE), contacts).status == "located"
    for row in (17, 1500, 2999):
        points = contacts.points.copy()
        points[row] += 3.0 * truth.normals[row]
        result = locate(placed(PLATE), replace(contacts, points=points), explain=False)
        assert result.status == "inconsistent"
        result = locate(placed(PLATE), replace(contacts, points=points))
        assert np.argmax(np.abs([contact.residual for contact in result.contacts])) == row
