"""Cylinders through five contacts where roots crowd: slower, and sound on tidy layouts, double roots and flat sets."""

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.localizers.cylinder_directions import DIRECTIONS, direction_zeros
from tactfix.localizers.cylinder_refinement import CylinderProblem, circle_states
from tactfix.localizers.cylinder_search import real_directions
from tactfix.localizers.distinct_cylinders import distinct_roots

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
    directions, owner = real_directions(lambda x, _: direction_zeros(x), unit_points)
    contacts = unit_points[owner]
    states = circle_states(directions, contacts, np.ones(5))
    usable = np.isfinite(states).all(axis=1)
    states, owner, contacts = states[usable], owner[usable], contacts[usable]
    problem = CylinderProblem(contacts, np.ones(5), radius_known=False)
    states = problem.refined(states, _STEPS)
    misses = np.abs(problem.evaluate(states, np.arange(len(states)))[0]).max(axis=1)
    granted = tolerance / scale
    good = misses <= granted[owner]
    found = np.full((len(points), DIRECTIONS, 7), np.nan)
    for k in np.unique(owner[good]):
        mine = np.flatnonzero(good & (owner == k))
        own = CylinderProblem(unit_points[k], np.ones(5), radius_known=False)
        kept = states[mine[distinct_roots(own, states[mine], misses[mine], float(granted[k]))[:DIRECTIONS]]]
        found[k, : len(kept)] = kept
        found[k, : len(kept), :3] = kept[:, :3] * scale[k] + origin[k]
        found[k, : len(kept), 6] *= scale[k]
    return found
