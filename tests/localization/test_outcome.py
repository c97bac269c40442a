"""Elimination of candidates: each reason and each doubt, for a known pose and a known sigma."""

from dataclasses import replace

import numpy as np
import pytest

from tactfix.localization.outcome import assess
from tactfix.poses.rigid import rigid_solutions
from tests.support.problems import CYLINDER_SPHERE, PLATE, Patch, box, placed, touch_all

COUNTS = {"plate": 5, "pin": 6, "ball": 5}


def trial_of(patches, counts, touch=None, seed=0, sigma=0.05, **changes):
    """A fixture, contacts and the solution next to the truth."""
    truth = touch_all(patches, counts, np.random.default_rng(seed), pose=np.eye(4), sigma=sigma, tip=2.0)
    contacts = truth.contacts(**changes)
    solutions = rigid_solutions({n: p.surface() for n, p in patches.items()}, contacts, contacts.sigmas)
    best = min(solutions.found, key=lambda s: np.abs(s.base_from_fixture - np.eye(4)).max())
    return placed(patches, touch), truth, contacts, best


def codes(assessment):
    return [(reason.code, reason.feature, reason.row) for reason in assessment.reasons]


def test_the_true_pose_is_accepted():
    fixture, _, contacts, trial = trial_of(PLATE, COUNTS)
    assessment = assess(fixture, contacts, trial)
    assert assessment.reasons == ()
    assert assessment.warnings == ()


@pytest.mark.parametrize(("row", "feature"), [(2, "plate"), (8, "pin"), (14, "ball")])
def test_an_approach_out_of_the_material(row, feature):
    fixture, truth, contacts, trial = trial_of(PLATE, COUNTS)
    approaches = truth.approaches.copy()
    approaches[row - 1] *= -1
    assessment = assess(fixture, replace(contacts, approaches=approaches), trial)
    assert codes(assessment) == [("approach", feature, row)]
    assert f"row {row}" in assessment.reasons[0].message


def test_an_inner_surface_is_approached_from_within():
    bore = {**PLATE, "pin": Patch("cylinder", (0, 0, 0), (0, 0, 1), 10.0, side="inner", length=20.0, middle=-26.0)}
    fixture, truth, contacts, trial = trial_of(bore, COUNTS)
    assert assess(fixture, contacts, trial).reasons == ()
    inwards = np.einsum("ij,ij->i", truth.approaches[5:11], truth.points[5:11] * [1, 1, 0])
    assert (inwards > 0).all()
    assessment = assess(fixture, replace(contacts, approaches=-truth.approaches), trial)
    assert {feature for _, feature, _ in codes(assessment)} == {"plate", "pin", "ball"}


def test_one_reason_for_each_feature_at_its_worst_contact():
    fixture, truth, contacts, trial = trial_of(PLATE, COUNTS)
    approaches = truth.approaches.copy()
    approaches[:3] *= -1
    assessment = assess(fixture, replace(contacts, approaches=approaches), trial)
    cosine = np.einsum("ij,ij->i", approaches, truth.normals)[:3]
    assert codes(assessment) == [("approach", "plate", int(np.argmax(cosine)) + 1)]
    assert "2 more" in assessment.reasons[0].message


def test_contacts_without_approach_eliminate_nothing():
    fixture, truth, contacts, trial = trial_of(PLATE, COUNTS)
    nothing = replace(contacts, approaches=np.full_like(truth.approaches, np.nan))
    assert assess(fixture, nothing, trial).reasons == ()


@pytest.mark.parametrize("sigmas_inside", [-50.0, -3.0, 3.0, 50.0])
def test_the_box_rejects_only_beyond_its_margin(sigmas_inside):
    """The pin's lowest contact lies this number of sigma above the lower end of its box."""
    truth = touch_all(PLATE, COUNTS, np.random.default_rng(0), pose=np.eye(4), sigma=0.05, tip=2.0)
    lowest = int(np.argmin(truth.points[5:11, 2])) + 6
    low = truth.points[lowest - 1, 2] - sigmas_inside * 0.05
    fixture, _, contacts, trial = trial_of(PLATE, COUNTS, {"pin": box(z=(low, 1e3))})
    assessment = assess(fixture, contacts, trial)
    assert codes(assessment) == ([("touch", "pin", lowest)] if sigmas_inside == -50 else [])
    assert bool(assessment.warnings) == (sigmas_inside == -3)


def test_the_box_applies_to_the_surface_point_not_the_tip_centre():
    """The centre of a tip of radius 2 that touches the top of the ball is above the box."""
    fixture, _, contacts, trial = trial_of(PLATE, COUNTS, {"ball": box(z=(-1e3, 60.0 + 19.05 + 0.01))})
    assert assess(fixture, contacts, trial).reasons == ()


def test_a_path_through_a_ball():
    """The plate is approached from straight above, through the ball."""
    fixture, truth, contacts, trial = trial_of(PLATE, COUNTS)
    points, approaches = contacts.points.copy(), truth.approaches.copy()
    points[0], approaches[0] = (300.0, 180.0, 2.0), (0, 0, -1)
    below = replace(contacts, points=points, approaches=approaches)
    assert codes(assess(fixture, below, trial)) == [("path", "plate", 1)]
    assert "ball" in assess(fixture, below, trial).reasons[0].message
    assert assess(fixture, below, trial, use_path=False).reasons == ()
    near = placed(PLATE, approach=20.0)
    assert assess(near, below, trial).reasons == ()


def test_the_path_is_tested_only_for_otherwise_accepted_poses():
    fixture, truth, contacts, trial = trial_of(PLATE, COUNTS)
    points, approaches = contacts.points.copy(), truth.approaches.copy()
    points[0], approaches[0] = (300.0, 180.0, 2.0), (0, 0, -1)
    approaches[7] *= -1
    assessment = assess(fixture, replace(contacts, points=points, approaches=approaches), trial)
    assert [code for code, _, _ in codes(assessment)] == ["approach"]


def test_an_uncertain_pose_is_doubted_instead_of_rejected():
    """Two contacts determine the ball's place weakly: a deviation within that uncertainty only raises a doubt."""
    seed = 3
    truth = touch_all(CYLINDER_SPHERE, {"bar": 5, "ball": 3}, np.random.default_rng(seed), pose=np.eye(4), sigma=1e-3)
    low = truth.points[:5, 1].min()
    verdicts = []
    for sigma in (1e-6, 2e-2):
        _, _, contacts, trial = trial_of(CYLINDER_SPHERE, {"bar": 5, "ball": 3}, seed=seed, sigma=sigma)
        fixture = placed(CYLINDER_SPHERE, {"bar": box(y=(low + 1e-3, 10.0))})
        verdicts.append(assess(fixture, contacts, trial))
    sure, unsure = verdicts
    assert [code for code, _, _ in codes(sure)] == ["touch"]
    assert unsure.reasons == ()
    assert unsure.warnings
