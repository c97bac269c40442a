"""Parts chosen blindly: fair to the features, others each time, and free of a few wrong contacts."""

from dataclasses import replace

import numpy as np

from tactfix.localization.locate import locate
from tactfix.poses.subsets import PART_CONTACTS, PARTS_SEARCHED, blind_part
from tests.support.problems import PLATE, placed, touch_all


def contacts_of(each, **patches):
    truth = touch_all(patches or PLATE, dict.fromkeys(patches or PLATE, each), np.random.default_rng(3), sigma=0.01)
    return truth, truth.contacts(np.random.default_rng(4))


def test_a_part_is_shared_between_the_features():
    _, contacts = contacts_of(40)
    part = blind_part(contacts, PART_CONTACTS, 0)
    assert len(set(part.tolist())) == PART_CONTACTS
    assert [sum(i in part for i in index) for index in contacts.by_feature.values()] == [4, 4, 4]


def test_parts_are_others_each_time_also_where_there_are_more_features_than_contacts_in_one():
    _, contacts = contacts_of(40)
    assert (
        len({tuple(blind_part(contacts, PART_CONTACTS, number)) for number in range(PARTS_SEARCHED)}) == PARTS_SEARCHED
    )
    single = replace(contacts, features=tuple(f"f{i}" for i in range(len(contacts))))
    seen = {int(i) for number in range(PARTS_SEARCHED) for i in blind_part(single, PART_CONTACTS, number)}
    assert len(seen) == PART_CONTACTS * PARTS_SEARCHED


def test_some_part_is_free_of_a_few_wrong_contacts():
    """What `poses.consensus` promises of two among forty, wherever they are: but for once in a hundred times."""
    _, contacts = contacts_of(14)
    rng = np.random.default_rng(9)
    free = 0
    for _ in range(200):
        wrong = set(rng.choice(len(contacts), size=len(contacts) // 20, replace=False).tolist())
        free += any(
            not wrong & set(blind_part(contacts, PART_CONTACTS, number).tolist()) for number in range(PARTS_SEARCHED)
        )
    assert free >= 195  # 198 wanted, one standard deviation 1.4


def test_the_nearest_miss_is_where_most_contacts_are():
    """Three contacts of sixty, off by a centimetre: without the parts the search would look at just these."""
    truth, contacts = contacts_of(20)
    points = contacts.points.copy()
    points[[0, 21, 45]] += 10.0 * truth.normals[[0, 21, 45]]
    result = locate(placed(PLATE), replace(contacts, points=points))
    assert result.status == "inconsistent"
    off = np.array([abs(contact.residual) for contact in result.contacts])
    assert set(np.argsort(off)[-3:].tolist()) == {0, 21, 45}
    assert np.abs(result.candidates[0].base_from_fixture[:3, :3] - truth.pose[:3, :3]).max() < 0.05
