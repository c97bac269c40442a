"""Poses as often as what is known beforehand lets a fixture stand there: in its domain, within its limits.

A measured pose is drawn from its normal distribution, in what directions are held from that of the others given that
those are not off. Limits, and free directions without any, are drawn uniformly: rotations over the great sphere of unit
quaternions whose axis has the free components alone, translations over the ball of the free ones.
"""

import numpy as np

from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats, unit
from tactfix.geometry.rigid import homogeneous, rotation_from_quaternion, rotation_from_vector
from tactfix.placement import Placement
from tactfix.units import factor

TABLE_STEPS = 512
"""Of the table from which angles are drawn: their share is exact at each, linear between."""


def drawn_pose(fixture: Fixture, rng: np.random.Generator) -> Floats:
    """base_from_fixture (4, 4): where the fixture's placement lets it stand, anywhere where it says nothing."""
    metre = factor("m", fixture.units)
    return random_pose(rng, metre) if fixture.placement is None else placed_pose(fixture.placement, rng, metre)


def random_pose(rng: np.random.Generator, metre: float) -> Floats:
    """base_from_fixture (4, 4): uniform over all rotations, one to three metres from the base's origin."""
    rotation = rotation_from_quaternion(unit(rng.standard_normal(4)))
    translation = unit(rng.standard_normal(3)) * metre * rng.uniform(1.0, 3.0)
    return homogeneous(rotation, translation)


def placed_pose(placement: Placement, rng: np.random.Generator, metre: float) -> Floats:
    """base_from_fixture (4, 4); up to metre from near along a free direction that has no limit.

    Near itself where the placement does not say how far from it the fixture may stand.
    """
    near = placement.near
    if not placement.is_known:
        return near
    turns, shifts = placement.turns, placement.shifts
    off = np.zeros(6)
    if (covariance := placement.covariance) is not None:
        free = np.flatnonzero(np.concatenate([turns, shifts]))
        information = np.linalg.inv(covariance)[np.ix_(free, free)]
        off[free] = np.linalg.solve(np.linalg.cholesky(information).T, rng.standard_normal(len(free)))
    else:
        shift, turn = placement.within or (metre, np.pi)
        off[:3][turns] = _turn(int(turns.sum()), turn, rng)
        off[3:][shifts] = _in_ball(int(shifts.sum()), shift, rng)
    return homogeneous(rotation_from_vector(off[:3]) @ near[:3, :3], near[:3, 3] + off[3:])


def _turn(axes: int, most: float, rng: np.random.Generator) -> Floats:
    """A rotation vector (axes,) of up to most (rad), uniform over the rotations about so many axes.

    The great sphere has the density sin^(axes - 1) of half the angle.
    """
    direction, share = rng.standard_normal(axes), rng.uniform()
    if axes == 0:
        return np.zeros(0)
    angles = np.linspace(0.0, most, TABLE_STEPS + 1)
    density = np.sin(angles / 2) ** (axes - 1)
    risen = np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1])])
    return np.asarray(unit(direction) * np.interp(share * risen[-1], risen, angles))


def _in_ball(axes: int, radius: float, rng: np.random.Generator) -> Floats:
    """A vector (axes,), uniform in the ball of that radius."""
    direction, share = rng.standard_normal(axes), rng.uniform()
    return np.asarray(unit(direction) * radius * share ** (1 / axes)) if axes else np.zeros(0)
