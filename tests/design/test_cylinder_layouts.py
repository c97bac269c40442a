"""Contacts that lie on several cylinders: layouts known from theory, and the findings of design-check."""

import numpy as np
import pytest

from tactfix.design.cylinder_layouts import cylinder_layouts
from tactfix.design.design_check import design_check
from tactfix.design.plan_findings import layout_findings
from tactfix.files.fixture_file import load_fixture
from tactfix.geometry.surfaces import Cylinder
from tests.support.plans import QUICK, contacts_of, plan_at
from tests.support.project import BAD_DESIGNS, ROOT

BAR = Cylinder(np.zeros(3), np.array([0.0, 1.0, 0.0]), 8.0)
TIP, SIGMA = 1.0, 0.01


def ring(degrees, height):
    """Outward directions (n, 3) and heights (n,) of contacts at the given angles."""
    a = np.radians(degrees)
    return np.stack([np.cos(a), np.zeros(len(a)), np.sin(a)], axis=1), np.full(len(a), float(height))


def bar_contacts(*rings, tip=TIP):
    out = np.vstack([directions for directions, _ in rings])
    heights = np.concatenate([h for _, h in rings])
    points = (BAR.radius + tip) * out + heights[:, None] * BAR.direction
    return contacts_of(["bar"] * len(out), points, -out, SIGMA, tip)


def layout_of(contacts, surface=BAR):
    (found,) = cylinder_layouts(contacts, {"bar": surface}, contacts.sigmas)
    return found


THREE, FOUR = np.array([0, 120, 240]), np.array([0, 90, 180, 270])


@pytest.mark.parametrize("stagger", [0, 17, 60])
def test_three_and_three_evenly_spaced_lie_on_four_cylinders(stagger):
    found = layout_of(bar_contacts(ring(THREE, 0), ring(THREE + stagger, 20)))
    assert (found.contacts, found.any_radius, found.own_radius) == (6, 4, 1)
    assert found.is_tidy
    assert not found.is_ambiguous


@pytest.mark.parametrize(("stagger", "ratio"), [(60, np.sqrt(2)), (0, np.sqrt(7) / 2)])
def test_at_some_lengths_all_four_have_one_radius(stagger, ratio):
    found = layout_of(bar_contacts(ring(THREE, 0), ring(THREE + stagger, 9 * ratio)))
    assert (found.any_radius, found.own_radius) == (4, 4)
    assert found.is_ambiguous


def test_two_aligned_rows_of_four_lie_on_three_cylinders():
    """The corners of a box: the axis may be parallel to any of its edges; the radii are equal if the box is a cube."""
    box = layout_of(bar_contacts(ring(FOUR, 0), ring(FOUR, 20)))
    assert (box.contacts, box.any_radius, box.own_radius) == (8, 3, 1)
    cube = layout_of(bar_contacts(ring(FOUR, 0), ring(FOUR, 9 * np.sqrt(2))))
    assert (cube.any_radius, cube.own_radius) == (3, 3)


def test_uneven_layouts_lie_on_one_cylinder():
    found = layout_of(bar_contacts(ring(FOUR, 0), ring([45, 135], 20)))
    assert (found.any_radius, found.own_radius) == (1, 1)
    assert not found.is_tidy
    rng = np.random.default_rng(2)
    random = [
        ring([angle], height) for angle, height in zip(rng.uniform(0, 360, 8), rng.uniform(0, 20, 8), strict=True)
    ]
    assert layout_of(bar_contacts(*random)).any_radius == 1


def test_two_rows_along_the_axis_lie_on_infinitely_many():
    rows = [ring([angle], height) for angle in (20, 150) for height in (0, 8, 20)]
    found = layout_of(bar_contacts(*rows))
    assert found.any_radius is None
    assert found.is_tidy


def test_few_contacts_are_reported_but_not_as_regular():
    """Four contacts leave up to twelve cylinders of a known radius, so the layout is not reported as regular."""
    four = layout_of(bar_contacts(ring(THREE, 0), ring([60], 20)))
    assert four.contacts == 4
    assert four.any_radius == 0, "not looked for"
    assert four.own_radius >= 1
    assert not four.is_ambiguous
    assert not four.is_tidy
    assert not cylinder_layouts(bar_contacts(ring(THREE, 0)), {"bar": BAR}, np.full(3, SIGMA))


def test_a_cylinder_that_was_touched_from_the_other_side_does_not_count():
    even = bar_contacts(ring(THREE, 0), ring(THREE + 60, 9 * np.sqrt(2)))
    approaches = even.approaches.copy()
    assert layout_of(even).own_radius == 4
    # One approach tilted by 60 degrees towards the axis: into the bar, but out of some of the other cylinders.
    y, out = np.array([0.0, 1.0, 0.0]), -approaches[0]
    approaches[0] = -0.5 * out - np.sqrt(0.75) * y
    tilted = contacts_of(even.features, even.points, approaches, SIGMA, TIP)
    assert 1 <= layout_of(tilted).own_radius < 4


def plan_with(*rings):
    """A plan with these contacts on the bar, from y = 20 on, and six on the ball."""
    ball = plan_at((20, 40)).on("ball")
    bar = bar_contacts(*rings)
    points = np.vstack([bar.points, ball.points])
    return contacts_of(bar.features + ball.features, points, np.vstack([bar.approaches, ball.approaches]), SIGMA, TIP)


@pytest.mark.parametrize(
    ("rings", "words"),
    [
        ((ring(THREE, 20), ring(THREE, 40)), "lie on 4 cylinders at once, 1 of its radius: without the known radius"),
        ((ring(FOUR, 20), ring(FOUR, 40)), "lie on 3 cylinders at once, 1 of its radius: without the known radius"),
        ((ring(THREE, 20), ring(THREE + 60, 20 + 9 * np.sqrt(2))), "4 of its radius: alone it is ambiguous"),
        ((ring([20] * 3, 20), ring([150] * 3, 20)), None),
    ],
)
def test_the_finding(rings, words):
    if words is None:
        # Two rows along the axis, at three heights each.
        rings = [ring([angle], height) for angle in (20, 150) for height in (20, 28, 40)]
        words = "lie on infinitely many cylinders at once"
    contacts = bar_contacts(*rings)
    (finding,) = layout_findings(cylinder_layouts(contacts, {"bar": BAR}, contacts.sigmas), "plan")
    assert (finding.code, finding.status) == ("tidy_layout", "warning")
    assert words in finding.message
    assert "45, 135" in finding.hint


def test_design_check_reports_a_regular_layout_until_the_remedy_is_applied():
    fixture = load_fixture(BAD_DESIGNS / "box-across-the-middle.yaml")
    for rings, reported in (((ring(THREE, 20), ring(THREE, 40)), True), ((ring(FOUR, 20), ring([45, 135], 40)), False)):
        report = design_check(fixture, plan_with(*rings), QUICK)
        assert ("tidy_layout" in {f.code for f in report.findings}) == reported


def test_a_bore_is_approached_from_inside():
    fixture = load_fixture(ROOT / "fixtures" / "machine-tool-ball-bar.yaml")
    bush = fixture.features["bush"].surface
    assert bush.side == "inner"
    u = np.array([1.0, 0, 0]) if abs(bush.direction[0]) < 0.9 else np.array([0, 1.0, 0])
    u = u - (u @ bush.direction) * bush.direction
    u /= np.linalg.norm(u)
    v = np.cross(bush.direction, u)
    angles = np.radians([*THREE, *(THREE + 60)])
    out = np.outer(np.cos(angles), u) + np.outer(np.sin(angles), v)
    points = bush.point + (bush.radius - TIP) * out - np.outer(np.repeat([2.0, 8.0], 3), bush.direction)
    contacts = contacts_of(["bush"] * 6, points, out, SIGMA, TIP)
    (found,) = cylinder_layouts(contacts, {"bush": bush}, contacts.sigmas)
    assert (found.any_radius, found.own_radius) == (4, 1)
