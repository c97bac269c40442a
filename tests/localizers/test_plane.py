"""Planes through three or more contacts."""

import numpy as np
import pytest

from tactfix.errors import DegenerateContactsError
from tactfix.localizers.plane import localize_plane
from tests.support.touched_surfaces import random_rotation


def _touched_plane(rng, n, tip=0.0):
    normal, point = random_rotation(rng)[:, 2], rng.normal(size=3)
    across = np.linalg.svd(normal[None])[2][1:]
    return point + rng.normal(size=(n, 2)) @ across + tip * normal, point, normal


@pytest.mark.parametrize("n", [3, 4, 30])
@pytest.mark.parametrize("tip", [0.0, 1.5])
def test_truth_is_one_of_two_sides(n, tip):
    rng = np.random.default_rng(n)
    points, point, normal = _touched_plane(rng, n, tip)
    first, second = (c.surface for c in localize_plane(points, None, tip))
    assert first.normal == pytest.approx(-second.normal)
    right = max((first, second), key=lambda s: s.normal @ normal)
    assert right.normal == pytest.approx(normal, abs=1e-9)
    assert (right.point - point) @ normal == pytest.approx(0, abs=1e-9)
    assert (first.point - second.point) @ first.normal == pytest.approx(-2 * tip, abs=1e-12)


def test_three_contacts_give_eq_1():
    x = np.array([[0.0, 0, 1], [2, 0, 1], [0, 3, 2]])
    normal = np.cross(x[1] - x[0], x[2] - x[0])
    found = localize_plane(x)[0].surface.normal
    assert abs(found @ normal) == pytest.approx(np.linalg.norm(normal))


def test_orthogonal_least_squares_by_brute_force():
    rng = np.random.default_rng(5)
    points = rng.normal(size=(8, 3)) * [3, 2, 0.3]
    best = localize_plane(points, 0.01)[0]
    centred = points - points.mean(axis=0)
    trials = rng.normal(size=(200_000, 3))
    trials /= np.linalg.norm(trials, axis=1, keepdims=True)
    assert best.chi2 * 0.01**2 <= np.min(np.sum((centred @ trials.T) ** 2, axis=0))
    assert best.rms == pytest.approx(0.01 * np.sqrt(best.chi2 / 8))


def test_weights_follow_sigma():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]])
    normal = localize_plane(points, np.array([1e-6, 1e-6, 1e-6, 10.0]))[0].surface.normal
    assert abs(normal[2]) == pytest.approx(1)


@pytest.mark.parametrize(("scale", "away"), [(1.0, 0.0), (1e-3, 0.0), (1e3, 0.0), (1.0, 1e4)])
def test_refusals(scale, away):
    line = np.array([[0.0, 0, 0], [1, 1, 0], [2, 2, 0], [5, 5, 0]])
    with pytest.raises(DegenerateContactsError, match="one straight line"):
        localize_plane(line * scale + away)
    with pytest.raises(DegenerateContactsError, match="different places"):
        localize_plane(line[[0, 1, 1]] * scale + away)


def test_noise_decides_what_is_a_line():
    nearly = np.array([[0.0, 0, 0], [1, 0, 0], [2, 1e-3, 0], [3, 0, 0]])
    assert localize_plane(nearly, 1e-6)
    with pytest.raises(DegenerateContactsError):
        localize_plane(nearly, 1e-3)
