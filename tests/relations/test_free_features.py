"""Untouched features that are undetermined, or may be on either side of others: neither leaves a motion free."""

import numpy as np
import pytest

import tactfix
from tactfix.relations.free_features import without_free_features
from tests.support.problems import (
    BALLS,
    BALLS_RECIPE,
    Patch,
    angle,
    ball_distances,
    distance,
    pose_error,
    recipe,
    related,
    touch_all,
)
from tests.support.project import FIXTURES, ROOT

BAR_AND_BALL = (FIXTURES / "cylinder-sphere.yaml").read_text(encoding="utf-8")
RADIUS = "ball: {type: sphere, radius: 1.0}\n"
KNOWN = "- {between: [bar, ball], value: 3.0}\n"


def with_extra(*relations: str) -> tactfix.Fixture:
    """The paper's fixture with one more ball and these relations for it."""
    text = BAR_AND_BALL.replace(RADIUS, f"{RADIUS}  extra: {{type: sphere, radius: 1.0}}\n")
    return tactfix.Fixture.from_text(text.replace(KNOWN, KNOWN + "".join(f"  - {line}\n" for line in relations)))


@pytest.mark.parametrize(
    "relations",
    [
        (),
        ("{between: [ball, extra], value: 5.0}",),
        ("{between: [ball, extra], value: 5.0}", "{between: [bar, extra], value: 4.0, sigma: 0.1}"),
    ],
    ids=len,
)
def test_an_untouched_feature_frees_no_motion(relations):
    alone = tactfix.load_fixture(FIXTURES / "cylinder-sphere.yaml")
    contacts = tactfix.load_contacts(ROOT / "samples" / "cylinder-sphere" / "contacts.csv", alone)
    expected, result = tactfix.locate(alone, contacts), tactfix.locate(with_extra(*relations), contacts)
    assert result.status == "located"
    np.testing.assert_array_equal(result.base_from_fixture, expected.base_from_fixture)
    np.testing.assert_array_equal(result.covariance, expected.covariance)


@pytest.mark.parametrize("relations", [(), ("{between: [ball, extra], value: 5.0}",)], ids=len)
def test_a_touch_of_a_feature_that_stays_free_changes_no_pose(relations):
    fixture = with_extra(*relations)
    contacts = tactfix.load_contacts(ROOT / "samples" / "cylinder-sphere" / "contacts.csv", fixture)
    more = contacts + tactfix.contacts_from_arrays("extra", [[9.0, 1.0, 2.0]], [[0, 0, 1]], sigma=2e-6, tip_radius=0.0)
    expected, result = tactfix.locate(fixture, contacts), tactfix.locate(fixture, more)
    assert result.status == "located"
    np.testing.assert_array_equal(result.base_from_fixture, expected.base_from_fixture)
    (warning,) = set(result.warnings) - set(expected.warnings)
    assert "row 1 not counted: contacts and relations leave extra free" in warning
    assert tactfix.html_report(fixture, more, result)
    assert tactfix.guide(fixture, more).is_done


def test_touches_of_a_free_feature_alone_leave_the_fixture_free():
    contacts = tactfix.contacts_from_arrays("extra", [[9.0, 1.0, 2.0]], sigma=0.01, tip_radius=0.0)
    assert tactfix.locate(with_extra(), contacts).status == "underdetermined"


def test_an_untouched_ball_on_either_side_of_others_is_no_second_pose():
    """Its distances to three touched balls allow places above and below their plane."""
    balls = {**BALLS, "fourth": Patch("sphere", (60, 40, 90), radius=10.0)}
    away = {name: float(np.linalg.norm(np.subtract(balls["fourth"].at, balls[name].at))) for name in BALLS}
    relations = [*ball_distances(), *(distance(name, "fourth", value) for name, value in away.items())]
    fixture = related(balls, relations, BALLS_RECIPE)
    rng = np.random.default_rng(3)
    truth = touch_all(balls, dict.fromkeys(BALLS, 4), rng, sigma=0.01)
    result = tactfix.locate(fixture, truth.contacts(rng))
    assert result.status == "located"
    assert [candidate.accepted for candidate in result.candidates].count(True) == 1
    assert set(result.surfaces) == set(BALLS)
    assert np.linalg.norm(pose_error(result.base_from_fixture, truth.pose)[3:]) < 0.1


@pytest.mark.parametrize(
    ("relations", "is_kept"),
    [
        ([], False),
        ([angle("one", "extra", 0)], False),
        ([angle("one", "extra", 30), angle("two", "extra", 60), distance("one", "extra", 20)], False),
        # Parallel to both, it makes them parallel.
        ([angle("one", "extra", 0), angle("two", "extra", 0)], True),
        # Angles of one direction to three others relate the three.
        ([angle("one", "extra", 30), angle("two", "extra", 60), angle("three", "extra", 70)], True),
        ([angle("one", "extra", 0), distance("one", "extra", 20), distance("two", "extra", 30)], True),
    ],
)
def test_an_untouched_bar_is_kept_if_it_relates_others(relations, is_kept):
    patches = {name: Patch("cylinder", (0, 0, 0), (0, 0, 1), 5.0) for name in ("one", "two", "three", "extra")}
    fixture = related(
        patches, relations, recipe(("foot_of", "one", "two"), ("x", "along", "one"), ("y", "from_to", "one", "three"))
    )
    contacts = tactfix.contacts_from_arrays(["one", "two", "three"], np.zeros((3, 3)), sigma=0.1, tip_radius=1.0)
    kept, counted = without_free_features(fixture, contacts)
    assert counted is contacts
    assert ("extra" in kept.features) == is_kept
    assert (kept is fixture) == is_kept
    assert kept.relations == (tuple(relations) if is_kept else ())


def test_features_of_the_frame_are_kept_and_chains_are_left_out_from_their_end():
    patches = {name: Patch("sphere", (0, 0, 0), radius=5.0) for name in ("one", "two", "three", "near", "far")}
    relations = [distance("one", "near", 20), distance("two", "near", 20), distance("near", "far", 30)]
    fixture = related(
        patches,
        relations,
        recipe(("center_of", "one"), ("x", "from_to", "one", "two"), ("y", "from_to", "one", "three")),
    )
    contacts = tactfix.contacts_from_arrays("one", [[0, 0, 0]], sigma=0.1, tip_radius=1.0)
    assert list(without_free_features(fixture, contacts)[0].features) == ["one", "two", "three"]
