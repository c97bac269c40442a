"""Every mistake is named, by problems that are made without the package (validation.diagnosis)."""

from dataclasses import replace

import numpy as np
import pytest

from tactfix.localization.locate import locate
from tests.support.problems import placed
from tests.validation.diagnosis import is_named
from tests.validation.made_mistakes import FIXTURES, MISTAKES, touched

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


def made(mistake, fixture, draw):
    patches, counts = FIXTURES[fixture]
    return MISTAKES[mistake](patches, counts, np.random.default_rng(draw))


@pytest.mark.parametrize(("mistake", "fixture"), CASES)
def test_the_mistake_that_was_made_is_named(mistake, fixture):
    case = made(mistake, fixture, 3)
    result = locate(placed(case.said), case.contacts)
    assert result.status == "inconsistent"
    first = result.diagnosis[0]
    causes = first.causes if first.one_of else (first,)
    assert any(is_named(case, cause) for cause in causes), result.warnings
    assert result.warnings[-len(result.diagnosis) :] == tuple(cause.message for cause in result.diagnosis)


def test_the_values_are_those_of_the_truth():
    """What is right instead: a radius, a place, a tip radius, a factor."""
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


def test_the_same_is_said_in_another_unit_and_order():
    case = made("one contact 0.3-3 mm off", "plate, two pins", 7)
    order = np.random.default_rng(1).permutation(len(case.contacts))
    shuffled = locate(placed(case.said), case.contacts.subset(order)).diagnosis[0]
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
        for name, patch in case.said.items()
    }
    assert frozenset(locate(placed(small), metres).diagnosis[0].rows) == case.rows
