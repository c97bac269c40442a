"""All lines tangent to four spheres."""

import numpy as np

from tactfix.errors import DegenerateContactsError
from tactfix.geometry.arrays import Floats
from tactfix.localizers.cylinder_refinement import CylinderProblem, distinct_roots, refined_roots
from tactfix.localizers.cylinder_search import tangent_states
from tactfix.localizers.unit_contacts import refuse_collinear, unit_contacts


def tangent_lines(centers: Floats, radii: Floats, tolerance: float = 0.0) -> tuple[Floats, Floats]:
    """All lines at four given distances from four points: the common tangents of four spheres.

    Solves |(c_i - a) x s| = radii_i, i = 1..4, |s| = 1, for the point a and the direction s of a line.

    centers (4, 3), radii (4,) >= 0, tolerance: largest error of the distances for a double root; all in one unit.
    Returns the points (k, 3) of the lines nearest to the mean of the centres, and unit directions (k, 3), k <= 12; a
    multiple root counts once; without a line the result is empty.
    Raises DegenerateContactsError for collinear centres: the lines then form a continuum.
    Source: Macdonald, Pach and Theobald 2001 for equal radii; see `tangent_zeros` for the equations.
    """
    contacts = unit_contacts(centers, tolerance)
    refuse_collinear("tangent line", contacts)
    sizes = radii / contacts.scale
    slack = contacts.rounding + tolerance / contacts.scale
    if np.any(radii < 0):
        raise DegenerateContactsError("tangent line", "a distance is negative", float(radii.min()), 0.0, "check it")
    problem = CylinderProblem(contacts.points, np.ones(4), radius_known=True, extra=sizes - sizes[0])
    states, _ = refined_roots(problem, tangent_states(contacts.points[None], sizes[None]), slack)
    misses = np.abs(problem.evaluate(states, np.arange(len(states)))[0]).max(axis=1)
    good = np.flatnonzero(misses <= slack)
    kept = states[good[distinct_roots(problem, states[good], misses[good], slack)]]
    return contacts.origin + contacts.scale * kept[:, :3], kept[:, 3:6]
