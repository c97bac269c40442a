"""Where features can be located neither alone nor as one rigid body: fits from features placed at random.

They show what contacts and relations leave free. Where they leave nothing free together, though no feature could be
located alone, they are the solutions; but nothing says that they are all.
"""

from dataclasses import replace
from random import Random

import numpy as np

from tactfix.contacts import Contacts
from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats
from tactfix.geometry.surfaces import Sphere, Surface
from tactfix.noise import chi_square_limit
from tactfix.poses.solution import Solutions
from tactfix.relations.branch_fits import branch_fit, nearest_start
from tactfix.relations.joint_problem import JointFit, JointProblem
from tactfix.relations.joint_solutions import RELATIONS_HOLD, joint_solutions
from tactfix.relations.realization import random_surface

SAMPLE_STARTS = 16
"""Random starts from which FREE_SAMPLES are collected."""
FREE_SAMPLES = 8
"""Configurations that show what contacts and relations leave free."""


def sampled_solutions(fixture: Fixture, problem: JointProblem, with_misses: bool) -> Solutions:
    """The least chi-squares next to random configurations; marked as a continuum unless all motions are held."""
    if not with_misses:
        return joint_solutions(fixture, problem, [], continuum=True)
    rng = Random(20261122)
    fits = []
    for _ in range(SAMPLE_STARTS):
        surfaces = {
            name: _moved_to(random_surface(feature, problem.scale, rng), _middle(name, problem.contacts))
            for name, feature in fixture.features.items()
        }
        fits.append(branch_fit(problem, nearest_start(problem, surfaces)))
    held = [fit for fit in fits if _explains(fit) and not len(fit.spread()[1])]
    if held:
        return replace(joint_solutions(fixture, problem, held), complete=False)
    best = sorted(fits, key=lambda fit: fit.chi2)[:FREE_SAMPLES]
    return joint_solutions(fixture, problem, best, continuum=True)


def _explains(fit: JointFit) -> bool:
    return fit.missing < RELATIONS_HOLD and fit.dof >= 0 and fit.chi2 <= chi_square_limit(fit.dof)


def _middle(name: str, contacts: Contacts) -> Floats:
    """The middle of a feature's contacts, or of all."""
    index = contacts.by_feature.get(name)
    return contacts.centre if index is None else np.asarray(contacts.points[index].mean(axis=0))


def _moved_to(surface: Surface, middle: Floats) -> Surface:
    if isinstance(surface, Sphere):
        return replace(surface, center=surface.center + middle)
    return replace(surface, point=surface.point + middle)
