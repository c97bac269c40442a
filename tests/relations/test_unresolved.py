"""Solutions that the contacts do not distinguish: their probabilities, and which of them are merged."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix import contacts_from_arrays
from tactfix.fixture import Relation
from tactfix.geometry.surfaces import Cylinder, Plane
from tactfix.relations.branches import are_same_branches, nearest_branch
from tactfix.relations.unresolved import are_one, weight

SIGMA = 0.01


@pytest.mark.parametrize(("chi2", "other"), [(0.0, 0.0), (1.0, 3.2), (40.0, 41.0), (5.0, 90.0)])
def test_the_probability_of_the_other_solution_is_its_share_of_the_likelihood(chi2, other):
    likelihoods = np.exp([-chi2 / 2, -other / 2])
    assert weight(chi2, other) == pytest.approx(likelihoods[1] / likelihoods.sum(), rel=1e-12)


@pytest.mark.parametrize(
    ("degrees", "same_branch", "merged"),
    [(0.5, False, True), (1.0, False, False), (0.5, True, True), (1.0, True, False)],
)
def test_an_unseen_tilt_of_100_sigma_is_another_solution(degrees, same_branch, merged):
    """Two contacts on a line about which a plane is tilted; at 100 mm one degree is 1.7 mm, that is 175 sigma."""
    points = np.array([[-30.0, 0.0, 0.0], [30.0, 0.0, 0.0]])
    contacts = contacts_from_arrays(["plate"] * 2, points, sigma=SIGMA, tip_radius=0.0)
    tilt = np.radians(degrees)
    one, other = ({"plate": Plane(np.zeros(3), np.array([0.0, np.sin(t), np.cos(t)]))} for t in (0.0, tilt))
    assert are_one(one, other, contacts, np.full(2, SIGMA), 100.0, same_branch) == merged


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("along", [0.0, 300.0])
@pytest.mark.parametrize(("degrees", "merged"), [(0.55, True), (0.59, False)])
def test_merging_depends_neither_on_base_nor_on_reference_points(seed, along, degrees, merged):
    """100 sigma at 100 mm are 0.573 deg; along: how far a reference point is moved within its plane."""
    turn = Rotation.random(random_state=seed)
    points = turn.apply([[-30.0, 0.0, 0.0], [30.0, 0.0, 0.0]])
    contacts = contacts_from_arrays(["plate"] * 2, points, sigma=SIGMA, tip_radius=0.0)
    slopes = np.radians([0.0, degrees])
    normals = turn.apply(np.column_stack([np.zeros(2), np.sin(slopes), np.cos(slopes)]))
    within = turn.apply(np.column_stack([np.zeros(2), np.cos(slopes), -np.sin(slopes)]))
    one, other = ({"plate": Plane(along * w, n)} for w, n in zip(within, normals, strict=True))
    assert are_one(one, other, contacts, np.full(2, SIGMA), 100.0, same_branch=False) == merged


@pytest.mark.parametrize("flipped", [(), ("one",), ("one", "two")])
@pytest.mark.parametrize("kind", ["angle", "distance"])
def test_a_branch_is_the_same_with_axes_in_the_opposite_direction(kind, flipped):
    """Bars at 89 deg, or at 91 deg; one above the other, or below it."""
    value = np.radians(89.0) if kind == "angle" else 5.0
    relation = Relation(kind, ("one", "two"), value, 0.0)

    def bars(degrees, height, turned=()):
        slope = np.radians(degrees)
        directions = {"one": np.array([1.0, 0.0, 0.0]), "two": np.array([np.cos(slope), np.sin(slope), 0.0])}
        places = {"one": np.zeros(3), "two": np.array([0.0, 0.0, height])}
        return {n: Cylinder(places[n], -d if n in turned else d, 1.0, "outer") for n, d in directions.items()}

    def same(one, other):
        return are_same_branches(nearest_branch([relation], one), nearest_branch([relation], other), one, other)

    here = bars(89.0, 5.0)
    assert same(here, bars(89.0, 5.0, flipped))
    assert not same(here, bars(91.0, 5.0, flipped) if kind == "angle" else bars(89.0, -5.0, flipped))
