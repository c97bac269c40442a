"""Exchanged coordinates of a feature: in point and direction, or in the point alone; both corrections are tried."""

from dataclasses import replace

import numpy as np
import pytest

from tactfix.diagnosis.fixture_mistakes import coordinates_of_each
from tactfix.diagnosis.hypotheses import Explanation, Problem
from tactfix.diagnosis.hypothesis_tests import other_coordinates
from tests.support.problems import Patch
from tests.validation.made_mistakes import FIXTURES, touched

TRUE_PIN = Patch("cylinder", (40.0, 15.0, 0.0), (0.3, 0.1, 1.0), radius=10.0, length=15.0, middle=25.0)


@pytest.mark.parametrize("accepted", ["whole", "place"])
def test_one_way_to_exchange_coordinates_does_not_hide_the_other(accepted):
    direction = (0.1, 0.3, 1.0) if accepted == "place" else TRUE_PIN.along
    patches = {**FIXTURES["plate, pin, ball"][0], "pin": TRUE_PIN}
    truth, contacts = touched(patches, (8, 8, 6), np.random.default_rng(3))
    in_file = {**patches, "pin": replace(TRUE_PIN, at=(15.0, 40.0, 0.0), along=direction)}
    problem = Problem({name: patch.surface() for name, patch in in_file.items()}, contacts, contacts.sigmas)
    whole, place = (h for h in coordinates_of_each(problem) if (h.features, h.note) == (("pin",), "xy"))
    already, other = (whole, place) if accepted == "whole" else (place, whole)
    given = Explanation(already, np.zeros(0), truth.pose, 0.0, 0.0)
    found = [one.hypothesis for one in other_coordinates(problem, [(given, "")])]
    points = [h.surfaces["pin"].direction for h in found if (h.features, h.note) == (("pin",), "xy")]
    np.testing.assert_allclose(points, [other.surfaces["pin"].direction])
