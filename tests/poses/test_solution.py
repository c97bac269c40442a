"""The order in which poses are told is no accident of rounding."""

from dataclasses import replace

import numpy as np
import pytest

from tactfix import load_fixture
from tactfix.contact_arrays import contacts_from_arrays
from tactfix.poses.rigid import rigid_solutions
from tactfix.poses.solution import Solution, in_order
from tests.support.project import ROOT


@pytest.fixture(scope="module")
def mirrored() -> tuple[Solution, Solution]:
    """Two of the poses of three planes touched three, two and one times, without noise."""
    fixture = load_fixture(ROOT / "fixtures" / "three-planes.yaml")
    surfaces = {name: feature.surface for name, feature in fixture.features.items() if feature.surface is not None}
    points = [[-10, -20, 0], [-70, -20, 0], [-30, -60, 0], [0, -20, -5], [0, -60, -9], [-40, 0, -7]]
    names = ["top", "top", "top", "right", "right", "back"]
    contacts = contacts_from_arrays(names, points, sigma=0.01, tip_radius=0.0)
    first, second, *_ = rigid_solutions(surfaces, contacts, np.full(6, 0.01), True).found
    return first, second


@pytest.mark.parametrize("chi2", [0.0, 7.0, 1e6])
def test_the_last_digit_does_not_choose_the_first(mirrored: tuple[Solution, Solution], chi2: float) -> None:
    one, other = (replace(solution, chi2=chi2) for solution in mirrored)
    digit = 1e-12 * max(1.0, chi2)
    orders = [
        in_order(found)
        for found in (
            [one, replace(other, chi2=chi2 + digit)],
            [replace(one, chi2=chi2 + digit), other],
            [other, one],
        )
    ]
    leaders = [found[0].base_from_fixture for found in orders]
    for leader in leaders:
        np.testing.assert_array_equal(leader, leaders[0])


def test_the_better_pose_leads(mirrored: tuple[Solution, Solution]) -> None:
    for better, worse in (mirrored, mirrored[::-1]):
        found = in_order([replace(worse, chi2=2.0), replace(better, chi2=1.0)])
        np.testing.assert_array_equal(found[0].base_from_fixture, better.base_from_fixture)
