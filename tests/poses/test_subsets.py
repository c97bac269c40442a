"""Random subsets of contacts, and poses of more contacts than are fitted at once."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from tactfix.localization.locate import locate
from tactfix.poses.subsets import PART_CONTACTS, PARTS_SEARCHED, THINNED, blind_part
from tests.support.problems import CORNER, PLATE, placed, touch_all


def contacts_of(each, **patches):
    truth = touch_all(patches or PLATE, dict.fromkeys(patches or PLATE, each), np.random.default_rng(3), sigma=0.01)
    return truth, truth.contacts(np.random.default_rng(4))


def test_a_subset_contains_every_feature():
    _, contacts = contacts_of(40)
    part = blind_part(contacts, PART_CONTACTS, 0)
    assert len(set(part.tolist())) == PART_CONTACTS
    assert [sum(i in part for i in index) for index in contacts.by_feature.values()] == [4, 4, 4]


def test_subsets_differ_even_with_more_features_than_contacts():
    _, contacts = contacts_of(40)
    assert (
        len({tuple(blind_part(contacts, PART_CONTACTS, number)) for number in range(PARTS_SEARCHED)}) == PARTS_SEARCHED
    )
    single = replace(contacts, features=tuple(f"f{i}" for i in range(len(contacts))))
    drawn = {int(i) for number in range(PARTS_SEARCHED) for i in blind_part(single, PART_CONTACTS, number)}
    assert len(drawn) == PART_CONTACTS * PARTS_SEARCHED


def test_some_subset_contains_no_wrong_contact():
    """In 99 of 100 cases some subset contains neither of two wrong contacts among forty, wherever they are."""
    _, contacts = contacts_of(14)
    rng = np.random.default_rng(9)
    free = 0
    for _ in range(200):
        wrong = set(rng.choice(len(contacts), size=len(contacts) // 20, replace=False).tolist())
        free += any(
            not wrong & set(blind_part(contacts, PART_CONTACTS, number).tolist()) for number in range(PARTS_SEARCHED)
        )
    assert free >= 195  # 198 expected, standard deviation 1.4


def test_the_nearest_miss_is_where_most_contacts_are():
    """Three of sixty contacts are off by a centimetre, and are among those that the search uses without subsets."""
    truth, contacts = contacts_of(20)
    points = contacts.points.copy()
    points[[0, 21, 45]] += 10.0 * truth.normals[[0, 21, 45]]
    result = locate(placed(PLATE), replace(contacts, points=points))
    assert result.status == "inconsistent"
    off = np.array([abs(contact.residual) for contact in result.contacts])
    assert set(np.argsort(off)[-3:].tolist()) == {0, 21, 45}
    assert np.abs(result.candidates[0].base_from_fixture[:3, :3] - truth.pose[:3, :3]).max() < 0.05


def touched(patches, each, seed=3):
    truth = touch_all(patches, dict.fromkeys(patches, each), np.random.default_rng(seed), sigma=0.02, tip=1.0)
    return truth, truth.contacts(np.random.default_rng(seed + 1))


def squares_of_planes(contacts, pose):
    """Chi-square of the nearest local minimum for the three planes of CORNER, which meet in the origin."""

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


def test_one_bad_contact_among_thousands_is_detected_anywhere():
    """Also if it is not among the thousand contacts that are fitted first."""
    truth, contacts = touched(PLATE, THINNED)
    assert locate(placed(PLATE), contacts).status == "located"
    for row in (17, 1500, 2999):
        points = contacts.points.copy()
        points[row] += 3.0 * truth.normals[row]
        result = locate(placed(PLATE), replace(contacts, points=points), explain=False)
        assert result.status == "inconsistent"
        result = locate(placed(PLATE), replace(contacts, points=points))
        assert np.argmax(np.abs([contact.residual for contact in result.contacts])) == row
