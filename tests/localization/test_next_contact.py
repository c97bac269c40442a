"""The proposed next contact can be made, and distinguishes the poses whichever of them is true."""

import numpy as np
import pytest

from tactfix.geometry.surfaces import moved
from tactfix.localization.locate import locate
from tests.support.plain_surfaces import depth
from tests.support.problems import BALLS, CYLINDER_SPHERE, CYLINDER_SPHERE_TOUCH, PLATE, placed, pose_error, touch_all

AMBIGUOUS = {
    "plate 3-2-1": (PLATE, {"plate": 3, "pin": 2, "ball": 1}, {}, 0.02, 2.0),
    "balls 2-2-2": (BALLS, {"a": 2, "b": 2, "c": 2}, {}, 0.02, 2.0),
    "bar 4-2": (CYLINDER_SPHERE, {"bar": 4, "ball": 2}, CYLINDER_SPHERE_TOUCH, 1e-4, 0.0),
}


def ambiguous_cases(name, most=2):
    patches, counts, touch, sigma, tip = AMBIGUOUS[name]
    for seed in range(30):
        rng = np.random.default_rng([9, seed])
        truth = touch_all(patches, counts, rng, sigma=sigma, tip=tip)
        contacts = truth.contacts(rng)
        result = locate(placed(patches, touch), contacts)
        if result.status == "ambiguous":
            yield patches, touch, truth, contacts, result
            most -= 1
            if not most:
                return


@pytest.mark.parametrize("name", AMBIGUOUS)
def test_the_next_contact_lies_on_the_first_pose_and_off_all_others(name):
    sigma, tip = AMBIGUOUS[name][3:]
    for _, touch, _, _, result in ambiguous_cases(name):
        proposal = result.next_contact
        assert proposal is not None
        assert np.linalg.norm(proposal.approach) == pytest.approx(1)
        first, *others = [c for c in result.candidates if c.accepted]
        here = first.surfaces[proposal.feature]
        assert abs(depth(here, proposal.point)) < 1e-6
        assert depth(here, proposal.point - 1e-3 * proposal.approach) > 0
        local = first.base_from_fixture[:3, :3].T @ (proposal.point - first.base_from_fixture[:3, 3])
        if proposal.feature in touch:
            assert (local >= touch[proposal.feature].low - 1e-9).all()
            assert (local <= touch[proposal.feature].high + 1e-9).all()
        centre = proposal.point - tip * proposal.approach
        # The message states large distances only in the fixture's unit, not in sigma.
        stated = float(proposal.message.rpartition("(")[2].split()[0])
        for other in others:
            gap = abs(depth(other.surfaces[proposal.feature], centre) - tip)
            behind = depth(other.surfaces[proposal.feature], centre + 1e-3 * proposal.approach) > depth(
                other.surfaces[proposal.feature], centre
            )
            assert gap > 5 * sigma or behind
            assert gap >= 0.99 * stated or behind or touch


@pytest.mark.parametrize("name", AMBIGUOUS)
def test_the_next_contact_leaves_fewer_poses(name):
    patches, _, touch, sigma, tip = AMBIGUOUS[name]
    for _, _, truth, contacts, result in ambiguous_cases(name):
        proposal = result.next_contact
        first, *_ = left = [c for c in result.candidates if c.accepted]
        extra = type(contacts)(
            features=(*contacts.features, proposal.feature),
            points=np.vstack([contacts.points, proposal.point - tip * proposal.approach]),
            approaches=np.vstack([contacts.approaches, proposal.approach]),
            sigmas=np.append(contacts.sigmas, sigma),
            tip_radius=tip,
            rows=(*contacts.rows, len(contacts) + 1),
            ids=(*contacts.ids, None),
        )
        again = locate(placed(patches, touch), extra)
        accepted = [c for c in again.candidates if c.accepted]
        assert len(accepted) < len(left)
        errors = [np.linalg.norm(pose_error(c.base_from_fixture, first.base_from_fixture)[:3]) for c in accepted]
        assert min(errors) < 0.05
        assert moved(truth.pose, patches[proposal.feature].surface()) is not None


def test_located_needs_no_next_contact():
    rng = np.random.default_rng(1)
    truth = touch_all(PLATE, {"plate": 4, "pin": 5, "ball": 4}, rng, sigma=0.02, tip=2.0)
    assert locate(placed(PLATE), truth.contacts(rng)).next_contact is None


def test_indistinguishable_poses_get_no_next_contact():
    """Bar and ball without a touch box: the half-turn maps all features onto themselves."""
    rng = np.random.default_rng(2)
    truth = touch_all(CYLINDER_SPHERE, {"bar": 7, "ball": 4}, rng, sigma=1e-4)
    result = locate(placed(CYLINDER_SPHERE), truth.contacts(rng))
    assert result.status == "ambiguous"
    assert result.next_contact is None
