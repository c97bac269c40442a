"""Joint least squares of contacts and relations: a fit that cannot keep its constraints ends early."""

import numpy as np
import pytest

import tactfix
from tactfix.geometry.surfaces import Cylinder
from tactfix.relations import joint
from tactfix.relations.branches import nearest_branch
from tactfix.relations.joint_problem import JointProblem
from tests.support.problems import angle


def leaning_bar(degrees, rng):
    """A bar that leans towards x, a little off, and six contacts all around it."""
    lean = np.radians(degrees)
    direction = np.array([np.sin(lean), 0.0, np.cos(lean)]) + 1e-4 * rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    u = np.cross(direction, [0.0, 1.0, 0.0]) / np.linalg.norm(np.cross(direction, [0.0, 1.0, 0.0]))
    v, at = np.cross(direction, u), 10 * rng.normal(size=3)
    places = [(-5, 0), (-5, 2), (-5, 4), (5, 1), (5, 3), (5, 5)]
    return Cylinder(at, direction, 1.0), [at + h * direction + np.cos(t) * u + np.sin(t) * v for h, t in places]


@pytest.mark.parametrize("seed", [1, 2])
def test_constraints_that_contradict_each_other_end_the_fit(seed, monkeypatch):
    """Two angles of 10 deg allow none above 20 deg between the outer two: a violation stays, at which steps gain next
    to nothing.
    """
    steps, linearized = [], joint.linearized
    monkeypatch.setattr(joint, "linearized", lambda *given: steps.append(1) or linearized(*given))
    rng = np.random.default_rng(seed)
    touched = {name: leaning_bar(degrees, rng) for name, degrees in (("a", 0), ("b", 10), ("c", 20))}
    bars = {name: surface for name, (surface, _) in touched.items()}
    points = np.concatenate([points for _, points in touched.values()])
    contacts = tactfix.contacts_from_arrays(["a"] * 6 + ["b"] * 6 + ["c"] * 6, points, sigma=0.01, tip_radius=0.0)
    relations = (angle("a", "b", 10), angle("b", "c", 10), angle("a", "c", 20.02))
    problem = JointProblem(contacts, contacts.sigmas, relations, 10.0)
    fit = joint.joint_fit(problem, bars, nearest_branch(relations, bars))
    assert fit.missing > 1e-5
    assert len(steps) < 40
