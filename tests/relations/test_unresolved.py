"""Solutions that the contacts do not distinguish: their probabilities, and which of them are merged."""

import numpy as np
import pytest

from tactfix import contacts_from_arrays
from tactfix.geometry.surfaces import Plane
from tactfix.relations.unresolved import are_one, weight

SIGMA = 0.01


@pytest.mark.parametrize(("chi2", "other"), [(0.0, 0.0), (1.0, 3.2), (40.0, 41.0), (5.0, 90.0)])
def test_the_probability_of_the_other_solution_is_its_share_of_the_likelihood(chi2, other):
    likelihoods = np.exp([-chi2 / 2, -other / 2])
    assert weight(chi2, other) == pytest.approx(likelihoods[1] / likelihoods.sum(), rel=1e-12)


@pytest.mark.parametrize(
    ("degrees", "same_branch", "merged"), [(0.5, False, True), (1.0, False, False), (1.0, True, True)]
)
def test_an_unseen_tilt_of_100_sigma_is_another_solution_on_another_branch(degrees, same_branch, merged):
    """Two contacts on a line about which a plane is tilted; at 100 mm one degree is 1.7 mm, that is 175 sigma."""
    points = np.array([[-30.0, 0.0, 0.0], [30.0, 0.0, 0.0]])
    contacts = contacts_from_arrays(["plate"] * 2, points, sigma=SIGMA, tip_radius=0.0)
    tilt = np.radians(degrees)
    one, other = ({"plate": Plane(np.zeros(3), np.array([0.0, np.sin(t), np.cos(t)]))} for t in (0.0, tilt))
    assert are_one(one, other, contacts, np.full(2, SIGMA), 100.0, same_branch) == merged
