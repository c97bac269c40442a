"""Placement, the prior knowledge of a fixture's pose: accepted and rejected values."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from tactfix.errors import UsageError
from tactfix.placement import Placement
from tests.support.problems import PLATE, placed, pose_of

NEAR = pose_of(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), (1200, -350, 400))


def test_sigma_is_a_covariance_of_rotation_then_translation():
    covariance = Placement(NEAR, sigma=(0.5, 0.01)).covariance
    np.testing.assert_array_equal(covariance, np.diag([1e-4] * 3 + [0.25] * 3))


def test_free_names_the_axes_of_turns_and_shifts():
    placement = Placement(NEAR, free=frozenset({"y", "rx"}))
    assert placement.turns.tolist() == [True, False, False]
    assert placement.shifts.tolist() == [False, True, False]
    assert Placement(NEAR).turns.all()
    assert Placement(NEAR).shifts.all()


def test_a_placement_can_be_pickled_with_its_fixture():
    fixture = replace(placed(PLATE), placement=Placement(NEAR, within=(20.0, 0.3), free=frozenset({"x"})))
    copy = pickle.loads(pickle.dumps(fixture)).placement
    np.testing.assert_array_equal(copy.near, NEAR)
    assert (copy.within, copy.free) == ((20.0, 0.3), frozenset({"x"}))


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_a_covariance_is_singular_in_every_unit_or_in_none(unit):
    sigmas = np.array([1e-4] * 3 + [0.05 * unit] * 3)
    mixed = np.eye(6) + 0.3 * np.ones((6, 6))
    assert Placement(NEAR, sigma=mixed * np.outer(sigmas, sigmas)).covariance.shape == (6, 6)
    held = mixed * np.outer(sigmas, sigmas)
    held[5], held[:, 5] = 0.0, 0.0
    with pytest.raises(UsageError, match="free"):
        Placement(NEAR, sigma=held)
    with pytest.raises(UsageError, match="free"):
        Placement(NEAR, sigma=np.ones((6, 6)) * np.outer(sigmas, sigmas))


@pytest.mark.parametrize(
    ("settings", "word"),
    [
        ({"within": (1.0, 0.1), "sigma": (1.0, 0.1)}, "not both"),
        ({"within": (-1.0, 0.1)}, "negative"),
        ({"within": (np.nan, 0.1)}, "negative"),
        ({"free": frozenset()}, "rx"),
        ({"sigma": (0.0, 0.1)}, "above zero"),
        ({"sigma": (np.inf, 0.1)}, "above zero"),
        ({"sigma": np.eye(3)}, "above zero"),
    ],
)
def test_contradictory_input_is_rejected(settings, word):
    with pytest.raises(UsageError, match=word):
        Placement(NEAR, **settings)
