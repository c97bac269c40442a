"""Cylinders through five contacts where roots crowd: slower, and sound on tidy layouts, double roots and flat sets."""

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.localizers.cylinder_directions import MOST_DIRECTIONS, direction_zeros
from tactfix.localizers.cylinder_refinement import CylinderProblem, circle_states, distinct_roots, refined_roots
from tactfix.localizers.cylinder_search import real_directions


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
    granted = tolerance / scale
    states, index = refined_roots(CylinderProblem(contacts, np.ones(5), radius_known=False), states, granted[owner])
    owner = owner[index]
    problem = CylinderProblem(contacts[index], np.ones(5), radius_known=False)
    misses = np.abs(problem.evaluate(states, np.arange(len(states)))[0]).max(axis=1)
    good = misses <= granted[owner]
    found = np.full((len(points), MOST_DIRECTIONS, 7), np.nan)
    for k in np.unique(owner[good]):
        mine = np.flatnonzero(good & (owner == k))
        own = CylinderProblem(unit_points[k], np.ones(5), radius_known=False)
        kept = states[mine[distinct_roots(own, states[mine], misses[mine], float(granted[k]))[:MOST_DIRECTIONS]]]
        found[k, : len(kept)] = kept
        found[k, : len(kept), :3] = kept[:, :3] * scale[k] + origin[k]
        found[k, : len(kept), 6] *= scale[k]
    return found


def polished_cylinders(points: Floats, answers: Floats) -> Floats:
    """The cylinders (7, 6, m: point, direction, radius) through five contacts (m, 5, 3), two refining steps on."""
    slot, owner = np.nonzero(np.isfinite(answers[6]))
    middle = points.mean(axis=1)[owner]
    scale = np.linalg.norm(points - points.mean(axis=1, keepdims=True), axis=2).max(axis=1)[owner]
    contacts = (points[owner] - middle[:, None]) / scale[:, None, None]
    states = answers[:, slot, owner].T
    foot, direction = (states[:, :3] - middle) / scale[:, None], states[:, 3:6]
    foot -= np.sum(foot * direction, axis=1, keepdims=True) * direction
    problem = CylinderProblem(contacts, np.ones(5), radius_known=False)
    states = problem.polished(np.column_stack([foot, direction, states[:, 6] / scale]), 2)
    better = answers.copy()
    better[:3, slot, owner] = (states[:, :3] * scale[:, None] + middle).T
    better[3:6, slot, owner] = states[:, 3:6].T
    better[6, slot, owner] = states[:, 6] * scale
    return better
