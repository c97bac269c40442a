"""Where descents start, and when what they meet is too much to be single poses."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactfix.poses.equations import centred_offsets, pose_equations
from tactfix.poses.pose_domain import ALL_POSES
from tactfix.poses.starts import NEIGHBOURS, SIDES, START_OFFSET, around, covering
from tactfix.poses.zeros import MOST_ZEROS, Zeros, together
from tests.support.problems import PLATE, touch_all


def equations():
    rng = np.random.default_rng(2)
    contacts = touch_all(PLATE, {"plate": 4, "pin": 4, "ball": 4}, rng).contacts(rng)
    index = [list(PLATE).index(name) for name in contacts.features]
    points = (contacts.points - contacts.points.mean(axis=0)) / 100
    return pose_equations([patch.surface(0.01) for patch in PLATE.values()], index, points, np.ones(12), 0.0)


@pytest.mark.parametrize("number", [0, 3])
def test_a_covering_is_even_and_off_the_best_translations(number):
    there = equations()
    rotations, offsets = covering(there, 400, number)
    away = offsets - centred_offsets(there, rotations)
    np.testing.assert_allclose(np.linalg.norm(away, axis=0), START_OFFSET)
    assert np.linalg.norm(away.mean(axis=1)) < 0.1
    rotations = Rotation.from_matrix(np.moveaxis(rotations, -1, 0))
    # 400 caps of 23 degrees would fill all rotations without a gap or an overlap.
    nearest = [(rotations * one.inv()).magnitude().min() for one in Rotation.random(50, random_state=1)]
    assert np.degrees(max(nearest)) < 45


def test_coverings_differ():
    there = equations()
    one, other = (covering(there, 50, number)[0] for number in (1, 2))
    assert np.abs(one - other).max() > 0.1


def test_neighbours_are_at_every_scale():
    centre = Zeros(np.eye(3)[:, :, None], np.array([[1.0], [2.0], [3.0]]), np.zeros(1), np.ones(1, dtype=np.intp))
    rotations, offsets = around(ALL_POSES, centre, 1)
    assert offsets.shape == (3, NEIGHBOURS)
    # Cayley's map turns by twice the arc tangent of half the vector.
    angles = Rotation.from_matrix(np.moveaxis(rotations, -1, 0)).magnitude()
    steps = np.hypot(2 * np.tan(angles / 2), np.linalg.norm(offsets - centre.offsets, axis=0))
    assert 0.05 <= steps.min() < 0.1
    assert 0.8 < steps.max() <= 1.2


def test_sides_are_none_and_all_six():
    np.testing.assert_allclose(sorted(np.linalg.norm(SIDES, axis=0)), [0.0, *[START_OFFSET] * 6])
    np.testing.assert_allclose(SIDES.sum(axis=1), 0.0)


def test_more_zeros_than_any_problem_has_are_samples_of_a_motion():
    """As many different ones as are enough to tell are kept of a thousand, and those tell."""
    there = equations()
    rotations, offsets = covering(there, 1000, 0)
    found = Zeros(rotations, offsets, np.zeros(1000), np.ones(1000, dtype=np.intp))
    kept = Zeros.none().joined(found)
    assert len(kept) == MOST_ZEROS + 1
    assert kept.merged(there).continuum
    part = found.subset(np.arange(300))
    kept = Zeros.none().joined(together([part, part]))
    assert (kept.counts == 2).all()
    assert not kept.merged(there).continuum
    assert (kept.joined(part).counts == 3).all()
