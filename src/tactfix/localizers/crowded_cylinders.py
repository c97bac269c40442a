"""Cylinders through five contacts where roots crowd: slower, and sound on tidy layouts, double roots and flat sets."""

import numpy as np

from tactfix.geometry.arrays import Floats, Ints
from tactfix.localizers.cylinder_directions import DIRECTIONS, direction_zeros
from tactfix.localizers.cylinder_refinement import CylinderProblem, circle_states
from tactfix.localizers.cylinder_search import real_directions

_SAME = 1e-6
_LARGEST_RADIUS = 1e5

_STEPS = 30
"""Real zeros need a few; the real part of a pair far from real may wander on and is not waited for."""


def crowded_cylinders(points: Floats, tolerance: Floats) -> Floats:
    """The cylinders (m, 6, 7: point, direction, radius) that miss five contacts (m, 5, 3) by no more than tolerance.

    tolerance (m,), in the contacts' unit. Empty slots are nan. Double roots are given once.
    """
    origin = points.mean(axis=1, keepdims=True)
    scale = np.sqrt(np.mean(np.sum((points - origin) ** 2, axis=2), axis=1))
    scale[scale == 0] = 1.0
    unit_points = (points - origin) / scale[:, None, None]
    directions, owner = real_directions(direction_zeros, unit_points)
    contacts = unit_points[owner]
    states = circle_states(directions, contacts, np.ones(5))
    usable = np.isfinite(states).all(axis=1)
    states, owner, contacts = states[usable], owner[usable], contacts[usable]
    problem = CylinderProblem(contacts, np.ones(5), radius_known=False)
    states = problem.refined(states, _STEPS)
    misses = np.abs(problem.evaluate(states, np.arange(len(states)))[0]).max(axis=1)
    good = (misses <= tolerance[owner] / scale[owner]) & (states[:, 6] < _LARGEST_RADIUS)
    found = np.full((len(points), DIRECTIONS, 7), np.nan)
    for k in np.unique(owner[good]):
        mine = states[good & (owner == k)]
        kept = mine[_distinct(mine)][:DIRECTIONS]
        found[k, : len(kept)] = kept
        found[k, : len(kept), :3] = kept[:, :3] * scale[k] + origin[k]
        found[k, : len(kept), 6] *= scale[k]
    return found


def _distinct(states: Floats) -> Ints:
    """The indices of states (k, 7) that differ as surfaces."""
    tilt_squared = 1.0 - (states[:, 3:6] @ states[:, 3:6].T) ** 2
    place = states[:, [0, 1, 2, 6]]
    shift_squared = np.sum((place[:, None] - place) ** 2, axis=-1)
    same = np.maximum(tilt_squared, shift_squared) < _SAME**2
    return np.flatnonzero(~np.tril(same, -1).any(axis=1))
