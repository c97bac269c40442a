"""Every mistake is diagnosed, in problems that are generated without the package (validation.made_mistakes)."""

from dataclasses import replace

import numpy as np
import pytest

from tactfix.contacts import Contacts
from tactfix.diagnosis.contact_mistakes import units
from tactfix.diagnosis.fixture_mistakes import exchanges, reorderings
from tactfix.diagnosis.hypotheses import Problem
from tactfix.files.fixture_file import load_fixture
from tactfix.localization.locate import locate
from tests.support.problems import CORNER, Patch, placed, random_pose
from tests.validation.diagnosis import is_named
from tests.validation.made_mistakes import FIXTURES, MISTAKES, SIGMA, touched

CASES = [
    ("one contact 0.3-3 mm off", "three balls"),
    ("two contacts", "plate, pin, ball"),
    ("three contacts", "bar, ball, plane"),
    ("one approach reversed", "plate, pin, ball"),
    ("all approaches reversed", "four planes"),
    ("two labels swapped", "four planes"),
    ("one label wrong", "plate, two pins"),
    ("two features exchanged", "three balls"),
    ("coordinates in another unit", "bar, ball, plane"),
    ("tip radius", "three balls"),
    ("sigma 5-15 times too small", "four planes"),
    ("one radius", "plate, two pins"),
    ("one diameter", "bar, ball, plane"),
    ("all diameters", "three balls"),
    ("one side", "plate, two pins"),
    ("one feature 0.3-5 mm elsewhere", "plate, pins, balls"),
    ("x and y of one feature", "three balls"),
    ("mirrored", "bar, ball, plane"),
]


def case_for(mistake, fixture, draw):
    patches, counts = FIXTURES[fixture]
    return MISTAKES[mistake](patches, counts, np.random.default_rng(draw))


@pytest.mark.parametrize(("mistake", "fixture"), CASES)
def test_the_mistake_that_was_made_is_named(mistake, fixture):
    case = case_for(mistake, fixture, 3)
    result = locate(placed(case.in_file), case.contacts)
    assert result.status == "inconsistent"
    first = result.diagnosis[0]
    causes = first.causes if first.one_of else (first,)
    assert any(is_named(case, cause) for cause in causes), result.warnings
    assert result.warnings[-len(result.diagnosis) :] == tuple(cause.message for cause in result.diagnosis)


def test_the_values_are_those_of_the_truth():
    """The diagnosis contains the correct value: a radius, a place, a tip radius, a factor."""
    patches, counts = FIXTURES["plate, pins, balls"]
    _, contacts = touched(patches, counts, np.random.default_rng(5))
    for change, code, value in (
        ({"pin": replace(patches["pin"], radius=7.5)}, "radius", 10.0),
        ({"ball": replace(patches["ball"], at=(303.0, 180.0, 60.0))}, "feature_place", (300.0, 180.0, 60.0)),
    ):
        cause = locate(placed({**patches, **change}), contacts).diagnosis[0]
        assert cause.code == code
        assert cause.value == pytest.approx(value, abs=0.1)
    tip = locate(placed(patches), replace(contacts, tip_radius=0.0)).diagnosis[0]
    assert (tip.code, tip.value) == ("tip_radius", pytest.approx(2.0, abs=0.05))
    unit = locate(placed(patches), replace(contacts, points=contacts.points * 1000)).diagnosis[0]
    assert (unit.code, unit.value) == ("unit", 1e-3)


def test_the_diagnosis_does_not_depend_on_unit_and_order():
    case = case_for("one contact 0.3-3 mm off", "plate, two pins", 7)
    order = np.random.default_rng(1).permutation(len(case.contacts))
    shuffled = locate(placed(case.in_file), case.contacts.subset(order)).diagnosis[0]
    assert shuffled.code == "outlier"
    assert frozenset(shuffled.rows) == case.rows
    metres = replace(
        case.contacts,
        points=case.contacts.points * 1e-3,
        sigmas=case.contacts.sigmas * 1e-3,
        tip_radius=case.contacts.tip_radius * 1e-3,
    )
    small = {
        name: replace(patch, at=tuple(1e-3 * np.asarray(patch.at, float)), radius=1e-3 * patch.radius)
        for name, patch in case.in_file.items()
    }
    assert frozenset(locate(placed(small), metres).diagnosis[0].rows) == case.rows


CROSSED_BARS = {
    "bar": Patch("cylinder", (0, 0, 0), (1, 0, 0), 10.0, length=80.0, middle=0.0),
    "rod": Patch("cylinder", (20, 0, 60), (0.3, 1, 0.2), 8.0, length=80.0, middle=0.0),
}


def test_two_bad_contacts_on_three_planes_are_no_other_unit():
    """Any smaller unit fits three planes and reduces the residuals, which must not end the search."""
    truth, contacts = touched(CORNER, (6, 5, 5), np.random.default_rng(4))
    points = contacts.points.copy()
    points[[2, 13]] += np.array([[0.5], [-0.7]]) * truth.normals[[2, 13]]
    first = locate(placed(CORNER), replace(contacts, points=points)).diagnosis[0]
    assert (first.code, first.rows, first.one_of) == ("outlier", (3, 14), False)


def test_several_poses_of_one_mistake_are_one_entry():
    _, contacts = touched(CROSSED_BARS, (11, 10), np.random.default_rng(0))
    fixture = placed(CROSSED_BARS)
    assert locate(fixture, contacts).status == "ambiguous"
    result = locate(fixture, replace(contacts, approaches=-contacts.approaches))
    assert [(cause.code, cause.rows, cause.one_of) for cause in result.diagnosis] == [("approach", (), False)]
    assert "the result is then ambiguous" in result.diagnosis[0].message


def test_two_exchanged_features_are_tried_before_other_orders():
    """Nine contacts on four bores exclude few orders of the labels; searching all orders would take three seconds."""
    patches = {f"bore_{k}": Patch("cylinder", (90 * k, 11 * k * k, 0), radius=20.0, side="inner") for k in range(4)}
    _, contacts = touched(patches, (3, 2, 2, 2), np.random.default_rng(1))
    problem = Problem({n: p.surface() for n, p in patches.items()}, contacts, contacts.sigmas)
    pairs, more = exchanges(problem), reorderings(problem)
    assert {len(one.features) for one in pairs} == {2}
    assert len(pairs) < len(more)
    assert all(len(one.features) > 2 for one in more)


@pytest.mark.parametrize(
    ("mistake", "fixture", "draw"),
    [
        ("one radius", "plate, two pins", 9),  # a bore of that radius fits the contacts, but with reversed approaches
        ("one feature 0.3-5 mm elsewhere", "plate, pin, ball", 6),  # exchanged coordinates fit fairly well by chance
        ("three contacts", "plate, pin, ball", 9),  # two contacts, one of them good, explain it by chance
        ("one contact 0.14-0.3 mm off", "three balls", 9),  # located; another sigma is about equally likely
        ("all diameters", "plate, two pins", 30),  # no pose on which most contacts agree leads to the right one
        ("all diameters", "bar, ball, plane", 36),
    ],
)
def test_equally_likely_causes_do_not_hide_the_mistake(mistake, fixture, draw):
    """Draws of the study whose mistake was not named."""
    patches, counts = FIXTURES[fixture]
    case = MISTAKES[mistake](patches, counts, np.random.default_rng([draw, len(fixture), len(mistake)]))
    first = locate(placed(case.in_file), case.contacts).diagnosis[0]
    assert any(is_named(case, cause) for cause in (first.causes or (first,)))


@pytest.mark.parametrize("draw", [7, 24])
def test_exchanged_coordinates_of_either_of_two_pins_are_one_entry(draw):
    """The exchange for either pin gives the same fixture up to a rotation: no contact can distinguish them."""
    patches, counts = FIXTURES["plate, two pins"]
    mistake = "x and y of one feature"
    case = MISTAKES[mistake](patches, counts, np.random.default_rng([draw, 15, len(mistake)]))
    first = locate(placed(case.in_file), case.contacts).diagnosis[0]
    assert first.one_of
    alike = {cause.features for cause in first.causes if cause.code == "axes"}
    assert alike == {("pin_1",), ("pin_2",)}
    assert np.ptp([cause.chi2 for cause in first.causes if cause.code == "axes"]) < 1e-6


@pytest.mark.parametrize(("inside", "is_late"), [(0.3, True), (8.0, False)])
def test_a_probe_that_triggers_late_reports_points_inside_the_material(inside, is_late):
    """An equal shift of all contacts is one cause, not three bad contacts; millimetres are no late trigger."""
    truth, contacts = touched(*FIXTURES["plate, pin, ball"], np.random.default_rng(2), tip=0.0)
    late = replace(contacts, points=contacts.points - inside * truth.normals)
    result = locate(placed(FIXTURES["plate, pin, ball"][0]), late)
    causes = [cause for entry in result.diagnosis for cause in entry.causes or (entry,) if cause.code == "tip_radius"]
    assert bool(causes) == is_late
    if is_late:
        assert result.diagnosis[0].code == "tip_radius"
        assert causes[0].value == pytest.approx(-inside, abs=5 * SIGMA)
        assert "does the probe trigger late?" in causes[0].message


def test_a_tip_in_mm_with_contacts_in_metres_is_questioned():
    """A tip radius of 3 and a sigma of 0.05 in metres are 3000 mm and 50 mm."""
    _, contacts = touched(*FIXTURES["plate, pin, ball"], np.random.default_rng(2))
    warnings = locate(placed(FIXTURES["plate, pin, ball"][0]), replace(contacts, tip_radius=3000.0)).warnings
    assert any("the tip radius, 3000 mm, is larger than the extent of the contacts" in one for one in warnings)


def test_a_wrong_unit_is_reported_with_a_remedy():
    _, contacts = touched(*FIXTURES["plate, pin, ball"], np.random.default_rng(2))
    lengths = {name: getattr(contacts, name) * 1000 for name in ("points", "sigmas", "tip_radius")}
    patches = placed(FIXTURES["plate, pin, ball"][0])
    first = locate(patches, replace(contacts, **lengths)).diagnosis[0]
    assert (first.code, first.value) == ("unit", 1e-3)
    assert first.message.endswith("If so, give that unit for the contacts")
    first = locate(patches, replace(contacts, points=contacts.points * 25.4)).diagnosis[0]
    assert first.message.endswith("If so, write them in the unit of the other lengths")


def test_two_redundant_contacts_ask_for_more():
    """An error of one of eight contacts is explained as well by a tip radius, a place or two other contacts."""
    patches = FIXTURES["plate, pin, ball"][0]
    truth, contacts = touched(patches, (3, 3, 2), np.random.default_rng(1))
    points = contacts.points.copy()
    points[4] += truth.normals[4]
    first = locate(placed(patches), replace(contacts, points=points)).diagnosis[0]
    assert first.one_of
    assert any(cause.rows == (5,) for cause in first.causes)
    assert first.message.endswith("These contacts give only 2 equations more than a pose needs: make more contacts")


def test_the_worst_good_contact_is_not_blamed_as_a_third():
    """Deleting the worst of eighteen good contacts as well lowers chi-square no more than chance does."""
    case = MISTAKES["two contacts"](FIXTURES["four planes"][0], (5,) * 4, np.random.default_rng(8))
    first = locate(placed(case.in_file), case.contacts).diagnosis[0]
    assert (frozenset(first.rows), first.one_of) == (case.rows, False)


def test_no_second_contact_is_blamed_with_a_wrong_label():
    case = case_for("one label wrong", "plate, pin, ball", [4, len("plate, pin, ball"), len("one label wrong")])
    first = locate(placed(case.in_file), case.contacts).diagnosis[0]
    assert (first.code, frozenset(first.rows), first.one_of) == ("relabel", case.rows, False)


NESTS = """
tactfix: 1
name: nests
units: mm
probe: {tip_radius: 3.0, sigma: 0.05}
features:
  a: {type: point, point: [0, 0, 0]}
  b: {type: point, point: [300, 20, 0]}
  c: {type: point, point: [120, 210, 30]}
"""


@pytest.mark.parametrize(
    ("labels", "code", "rows"),
    [("aabbcb", "relabel", (6,)), ("abbacc", "swapped_labels", (2, 4)), ("aabbcc", "outlier", (3,))],
)
def test_a_wrong_nest_is_distinguished_from_a_bad_touch(tmp_path, labels, code, rows):
    path = tmp_path / "nests.yaml"
    path.write_text(NESTS, encoding="utf-8")
    fixture = load_fixture(path)
    rng = np.random.default_rng(2)
    points = np.array([[0, 0, 0], [300, 20, 0], [120, 210, 30]]).repeat(2, axis=0) + 0.05 * rng.standard_normal((6, 3))
    points = points @ random_pose(rng)[:3, :3].T
    if code == "outlier":
        points[2] += (0.0, 0.0, 2.0)
    nowhere = np.full((6, 3), np.nan)
    contacts = Contacts(tuple(labels), points, nowhere, np.full(6, 0.05), 3.0, tuple(range(1, 7)), (None,) * 6)
    first = locate(fixture, contacts).diagnosis[0]
    assert (first.code, first.rows) == (code, rows)


def test_no_unit_is_tried_in_which_contacts_are_within_noise():
    """Metres taken for millimetres: with sigma scaled too, all contacts lie within five sigma, and any pose fits."""
    case = case_for(
        "coordinates in another unit", "three balls", [1, len("three balls"), len("coordinates in another unit")]
    )
    problem = Problem({n: p.surface() for n, p in case.in_file.items()}, case.contacts, case.contacts.sigmas)
    assert case.contacts.spread < 6 * SIGMA
    right = replace(problem, contacts=case.right)
    assert {one.note for one in units(problem)} == {""}
    assert min(one.points for one in units(problem)) > 1
    assert 1e3 in {one.points for one in units(problem)}
    assert {one.note for one in units(right)} == {"", "whole"}
