"""The degrees of freedom of a hypothesis equal those of the contacts or values that remain without the mistake."""

import numpy as np
import pytest

from tactfix.contacts import Contacts
from tactfix.diagnosis.contact_mistakes import (
    relabels,
    relabels_of_points,
    single_outliers,
    swaps,
    swaps_with_points,
    tips,
    units,
)
from tactfix.diagnosis.fixture_mistakes import exchanges, places, radii, sides, signs
from tactfix.diagnosis.hypotheses import Problem
from tactfix.geometry.surfaces import Cylinder, Plane, Point, Sphere

SURFACES = {
    "plate": Plane(np.zeros(3), np.array([0.0, 0.0, 1.0])),
    "pin": Cylinder(np.array([30.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), 5.0),
    "ball": Sphere(np.array([0.0, 40.0, 10.0]), 8.0),
    "seat": Point(np.array([50.0, 50.0, 5.0])),
    "cone": Point(np.array([0.0, 80.0, 5.0])),
}
FEATURES = ("plate", "plate", "plate", "pin", "pin", "ball", "ball", "seat", "cone")
MAKERS = (
    single_outliers, relabels, relabels_of_points, swaps, swaps_with_points, tips, units, exchanges, places, radii,
    sides, signs,
)  # fmt: skip


@pytest.mark.parametrize("make", MAKERS, ids=lambda make: make.__name__)
def test_the_degrees_of_freedom_are_those_without_the_mistake(make):
    """Also for a contact on a point (three equations) that is labelled as on another feature (one equation)."""
    rng = np.random.default_rng(1)
    count = len(FEATURES)
    points, none = rng.uniform(0, 80, (count, 3)), np.full((count, 3), np.nan)
    rows, ids = tuple(range(1, count + 1)), (None,) * count
    contacts = Contacts(FEATURES, points, none, np.full(count, 0.1), 1.0, rows, ids)
    problem = Problem(SURFACES, contacts, contacts.sigmas)
    hypotheses = make(problem)
    assert hypotheses
    for one in hypotheses:
        fitted = 0 if one.free is None else one.directions(problem).shape[1]
        corrected = one.corrected(problem, np.zeros(fitted))
        assert problem.dof - one.numbers(problem) == corrected.dof - fitted, one
