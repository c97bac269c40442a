"""Every mistake is diagnosed, at any position in the file."""

from dataclasses import replace

import numpy as np
import pytest

from tactfix.localization.locate import locate
from tests.support.problems import CORNER, PLATE, Patch, box, placed, touch_all

BUSH = {
    "face": Patch("plane", (100, 0, 0), (0, 0, 1), length=25.0),
    "bush": Patch("cylinder", (0, 0, 0), (0, 0, 1), 15.0, side="inner", length=10.0, middle=-14.0),
    "ball": Patch("sphere", (200, 0, 45), radius=12.7, up=0.0),
}


def touched(patches, counts, seed=0, sigma=0.02, tip=2.0):
    rng = np.random.default_rng(seed)
    truth = touch_all(patches, counts, rng, sigma=sigma, tip=tip)
    return truth, truth.contacts(rng)


def assert_diagnosis(fixture, contacts, *words):
    result = locate(fixture, contacts)
    assert result.status == "inconsistent", result.status
    assert result.chi2 is None or result.chi2 > 0
    found = [w for w in result.warnings if all(word in w for word in words)]
    assert found, result.warnings
    return result


@pytest.mark.parametrize("row", [19])
def test_one_bad_contact_is_named_wherever_it_stands(row):
    truth, contacts = touched(PLATE, {"plate": 7, "pin": 7, "ball": 6})
    points = contacts.points.copy()
    points[row - 1] += 0.7 * truth.normals[row - 1]
    result = assert_diagnosis(placed(PLATE), replace(contacts, points=points), f"without row {row} ")
    assert sum("without row" in warning for warning in result.warnings) == 1
    # The message contains the chi-square of the best pose and its limit.
    assert result.chi2 > result.chi2_limit
    assert result.base_from_fixture is None
    (best, *_) = result.candidates
    assert {reason.code for reason in best.reasons} == {"fit"}
    assert len(result.contacts) == len(contacts)


@pytest.mark.parametrize("row", [15])
def test_one_reversed_approach_is_named(row):
    _, contacts = touched(PLATE, {"plate": 7, "pin": 7, "ball": 6})
    approaches = contacts.approaches.copy()
    approaches[row - 1] *= -1
    assert_diagnosis(placed(PLATE), replace(contacts, approaches=approaches), f"approach of row {row} reversed")


def test_all_approaches_reversed_are_normals():
    _, contacts = touched(PLATE, {"plate": 4, "pin": 5, "ball": 4})
    assert_diagnosis(placed(PLATE), replace(contacts, approaches=-contacts.approaches), "all approaches reversed")


@pytest.mark.parametrize(
    ("patches", "counts", "pair"),
    [
        (CORNER, (4, 4, 4), (6, 12)),
        (PLATE, (4, 5, 4), (6, 12)),
        pytest.param(PLATE, (5, 5, 5), (7, 14), marks=pytest.mark.slow),
    ],
)
def test_two_swapped_labels_are_named(patches, counts, pair):
    _, contacts = touched(patches, dict(zip(patches, counts, strict=True)))
    names = list(contacts.features)
    i, k = pair[0] - 1, pair[1] - 1
    names[i], names[k] = names[k], names[i]
    assert_diagnosis(
        placed(patches), replace(contacts, features=tuple(names)), f"row {pair[0]} and row {pair[1]}", "swapped"
    )


@pytest.mark.parametrize("each", [6, 20, 400])
def test_two_swapped_labels_among_many_contacts_are_named(each):
    """The search starts with contacts that are far from the others of their feature, as those with wrong labels are."""
    _, contacts = touched(PLATE, dict.fromkeys(PLATE, each))
    names = list(contacts.features)
    i, k = 5, each + 3
    names[i], names[k] = names[k], names[i]
    result = assert_diagnosis(
        placed(PLATE), replace(contacts, features=tuple(names)), f"row {i + 1} and row {k + 1} swapped"
    )
    assert [w for w in result.warnings if "without" in w] == []


def test_a_few_bad_contacts_among_many_are_named_together():
    truth, contacts = touched(PLATE, dict.fromkeys(PLATE, 100))
    points = contacts.points.copy()
    wrong = [4, 120, 250]
    points[wrong] += 3.0 * truth.normals[wrong]
    result = assert_diagnosis(
        placed(PLATE), replace(contacts, points=points), "without row 5, row 121 and row 251 the others"
    )
    assert len([w for w in result.warnings if "consistent" in w]) == 1


def test_the_best_pose_of_many_contacts_is_the_one_most_agree_on():
    truth, contacts = touched(PLATE, dict.fromkeys(PLATE, 50))
    names = list(contacts.features)
    names[7], names[60] = names[60], names[7]
    result = locate(placed(PLATE), replace(contacts, features=tuple(names)))
    pose = result.candidates[0].base_from_fixture
    # Two of 150 contacts, off by the size of the fixture, move the pose by a hundredth of that size.
    assert np.abs(pose[:3, :3] - truth.pose[:3, :3]).max() < 0.1


@pytest.mark.parametrize(
    ("factor", "words", "whole"),
    [
        (1 / 25.4, ("25.4", "inches given as mm"), False),
        (1000 / 25.4, ("0.0254", "inches given as metres"), True),
        (1e6, ("1e-06", "micrometres given as metres"), False),
        (1e-3, ("1000", "metres given as mm"), True),
    ],
)
def test_a_wrong_unit_is_named(factor, words, whole):
    """The wrong unit applies to the coordinates alone, or to tip radius and sigma as well."""
    _, contacts = touched(PLATE, {"plate": 4, "pin": 5, "ball": 4})
    wrong = replace(contacts, points=contacts.points * factor)
    if whole:
        wrong = replace(wrong, sigmas=contacts.sigmas * factor, tip_radius=contacts.tip_radius * factor)
    quantity = "all lengths of the contacts" if whole else "the coordinates"
    assert_diagnosis(placed(PLATE), wrong, f"multiplied by {words[0]} {quantity} are consistent", words[1])


def test_a_wrong_unit_of_planes_shows_in_their_touch_boxes():
    """Points on planes fit in any unit."""
    boxes = {name: box(*[(-100, 0)] * 3) for name in CORNER}
    _, contacts = touched(CORNER, dict.fromkeys(CORNER, 4), sigma=0.01)
    wrong = replace(contacts, points=contacts.points * 25.4)
    assert_diagnosis(placed(CORNER, boxes), wrong, "mm given as inches")


def test_contacts_that_are_corrected_for_the_tip_already():
    """The points lie on the surface, but the file states a tip radius of 3."""
    _, contacts = touched(PLATE, {"plate": 4, "pin": 5, "ball": 4}, tip=0.0)
    assert_diagnosis(placed(PLATE), replace(contacts, tip_radius=3.0), "tip radius 0 instead of 3")


@pytest.mark.parametrize("patches", [PLATE, BUSH], ids=["plate", "bush"])
def test_a_forgotten_tip_is_estimated(patches):
    _, contacts = touched(patches, dict.fromkeys(patches, 5), tip=3.0)
    result = assert_diagnosis(
        placed(patches, approach=6.0), replace(contacts, tip_radius=0.0), "tip radius of", "instead of 0"
    )
    warning = next(w for w in result.warnings if "tip radius of" in w)
    assert float(warning.split("tip radius of ")[1].split()[0]) == pytest.approx(3.0, abs=0.1)


def test_a_wrong_fixture_is_no_single_mistake():
    """The pin is displaced by 5 mm, and the ball has another radius."""
    built = {**PLATE, "ball": Patch("sphere", (290.0, 190.0, 67.0), radius=15.0, up=-0.4)}
    _, contacts = touched(built, {"plate": 5, "pin": 6, "ball": 6})
    assert_diagnosis(placed(PLATE), contacts, "right fixture file")


def test_planes_in_too_large_a_unit_ask_for_the_unit():
    """The file states mm but is in metres: no point contradicts another, and all lie within a few sigma."""
    _, contacts = touched(CORNER, dict.fromkeys(CORNER, 3), sigma=0.05)
    result = locate(placed(CORNER), replace(contacts, points=contacts.points * 1e-3))
    assert result.status == "underdetermined"
    assert any("is their unit the right one?" in warning for warning in result.warnings)
    right = locate(placed(CORNER), contacts)
    assert right.status == "located"
    assert right.warnings == ()
