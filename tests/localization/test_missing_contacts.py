"""Contacts that leave a motion free: the motion is named correctly, and the proposed contacts constrain it."""

from dataclasses import replace

import numpy as np
import pytest

from tactfix.localization.locate import locate
from tests.support.problems import CORNER, PLATE, placed, touch_all


def with_missing(fixture, truth, contacts, result):
    """The contacts together with the proposed ones, made at the true pose."""
    touches = [result.next_contact, *result.next_contact.further]
    points = np.array([t.point_in_fixture - truth.tip * t.approach_in_fixture for t in touches])
    ways = np.array([t.approach_in_fixture for t in touches])
    turn, shift = truth.pose[:3, :3], truth.pose[:3, 3]
    count = len(contacts) + len(touches)
    return replace(
        contacts,
        features=(*contacts.features, *(t.feature for t in touches)),
        points=np.vstack([contacts.points, points @ turn.T + shift]),
        approaches=np.vstack([contacts.approaches, ways @ turn.T]),
        sigmas=np.full(count, truth.sigma),
        rows=tuple(range(1, count + 1)),
        ids=(None,) * count,
    )


def rank(contacts, patches, pose):
    """The number of motions that the contacts constrain at the true pose, computed independently."""
    rows = []
    for name, point in zip(contacts.features, contacts.points, strict=True):
        local = pose[:3, :3].T @ (point - pose[:3, 3])
        patch = patches[name]
        arm = local - np.asarray(patch.at, float)
        along = np.asarray(patch.along, float) / np.linalg.norm(patch.along)
        if patch.kind == "plane":
            normal = along
        else:
            arm = arm - (arm @ along) * along if patch.kind == "cylinder" else arm
            normal = arm / np.linalg.norm(arm)
        rows.append(np.concatenate([np.cross(local, normal) / 100, normal]))
    return np.linalg.matrix_rank(np.array(rows), tol=1e-4)


@pytest.mark.parametrize(
    ("patches", "counts"),
    [
        (PLATE, {"plate": 3, "pin": 2, "ball": 0}),
        (PLATE, {"plate": 3, "pin": 0, "ball": 0}),
        (CORNER, {"top": 3, "right": 1, "back": 1}),
        (CORNER, {"top": 3, "right": 1, "back": 0}),
    ],
)
def test_the_fewest_missing_contacts_constrain_all_motions(patches, counts):
    rng = np.random.default_rng(4)
    truth = touch_all(patches, counts, rng, sigma=0.01, tip=2.0)
    contacts = truth.contacts()
    result = locate(placed(patches), contacts)
    assert result.status == "underdetermined"
    proposal = result.next_contact
    assert proposal.point is None
    assert proposal.approach is None
    missing = 6 - rank(contacts, patches, truth.pose)
    assert 1 + len(proposal.further) == missing
    assert ("contacts are missing" if missing > 1 else "one contact is missing") in proposal.message
    assert rank(with_missing(placed(patches), truth, contacts, result), patches, truth.pose) == 6


def test_ambiguous_contacts_have_their_place_in_both_frames():
    for seed in range(30):
        rng = np.random.default_rng([9, seed])
        truth = touch_all(PLATE, {"plate": 3, "pin": 2, "ball": 1}, rng, sigma=0.02, tip=2.0)
        result = locate(placed(PLATE), truth.contacts(rng))
        if result.status == "ambiguous":
            break
    proposal = result.next_contact
    pose = next(c for c in result.candidates if c.accepted).base_from_fixture
    assert proposal.point == pytest.approx(pose[:3, :3] @ proposal.point_in_fixture + pose[:3, 3], abs=1e-9)
    assert proposal.approach == pytest.approx(pose[:3, :3] @ proposal.approach_in_fixture, abs=1e-12)
    assert f"touch {proposal.feature} at x {proposal.point[0]:.2f} y" in proposal.message


def test_planes_through_one_point_turn_and_do_not_slide():
    """Three contacts on the top and one on each side leave a rotation about a line perpendicular to the top."""
    truth = touch_all(CORNER, {"top": 3, "right": 1, "back": 1}, np.random.default_rng(0), pose=np.eye(4), tip=1.5)
    contacts = truth.contacts()
    result = locate(placed(CORNER), contacts)
    (motion,) = result.free_motions
    assert np.linalg.norm(motion.rotation) == pytest.approx(1)
    assert "the fixture rotates about the line through" in motion.message
    assert "parallel to right and back" in motion.message
    # At one of the possible poses the motion leaves every contact on its plane, and its axis is the top's normal.
    moves = np.cross(motion.rotation, contacts.points) + motion.translation
    off = []
    for candidate in result.candidates:
        normals = np.array([candidate.surfaces[name].normal for name in contacts.features])
        off.append(np.abs(np.einsum("ij,ij->i", moves, normals)).max())
        off[-1] += np.linalg.norm(np.cross(motion.rotation, candidate.surfaces["top"].normal))
    assert min(off) < 1e-6
