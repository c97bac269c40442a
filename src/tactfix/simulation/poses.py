"""Random poses of a fixture, and tool orientations.

A pose is drawn from the placement of the fixture. A measured pose is drawn from its normal distribution; if directions
are constrained, the others are drawn from their conditional distribution. Within limits, and in free directions without
limits, the distribution is uniform: rotations over the great sphere of unit quaternions whose axis has free components
only, translations over the ball of the free components.

The tool's axis is z of the flange. Its orientations are tilted evenly to all sides about the mean approach, which
determines the tip's place in the flange best for their number. With one orientation that place is undetermined, with
two it is free along the axis of the rotation between them.
"""

from typing import Final

import numpy as np

from tactfix.fixture import Fixture
from tactfix.geometry.arrays import Floats, Ints, basis_across, unit
from tactfix.geometry.rigid import homogeneous, rotation_from_quaternion, rotation_from_vector
from tactfix.placement import Placement
from tactfix.units import factor

TABLE_STEPS = 512
"""Steps of the table of the distribution of angles, which is linear between them."""


def drawn_pose(fixture: Fixture, rng: np.random.Generator) -> Floats:
    """base_from_fixture (4, 4): a random pose that the fixture's placement allows, without one any pose."""
    metre = factor("m", fixture.units)
    return random_pose(rng, metre) if fixture.placement is None else placed_pose(fixture.placement, rng, metre)


def random_pose(rng: np.random.Generator, metre: float) -> Floats:
    """base_from_fixture (4, 4): uniform over all rotations, one to three metres from the base's origin."""
    rotation = rotation_from_quaternion(unit(rng.standard_normal(4)))
    translation = unit(rng.standard_normal(3)) * metre * rng.uniform(1.0, 3.0)
    return homogeneous(rotation, translation)


def placed_pose(placement: Placement, rng: np.random.Generator, metre: float) -> Floats:
    """base_from_fixture (4, 4); up to metre from near along a free direction without a limit.

    Near itself if the placement has neither limits nor sigma nor free directions.
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
    """A rotation vector (axes,) of up to most (rad), uniform over the rotations with so many free components.

    On the great sphere the density of the angle is sin^(axes - 1) of its half.
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


TILT_DEG: Final = 30.0
"""Tilt that most robots reach near a fixture; the larger, the better the tip is determined."""
_NO_WAY: Final = 0.1
"""Length of the mean approach below which it has no direction."""


def tool_orientations(count: int, approaches: Floats, spin: float = 0.0) -> Floats:
    """Rotations (count, 3, 3) of the flange, in the frame of approaches (n, 3), of which rows may be nan.

    A single one is not tilted; more are tilted by TILT_DEG about evenly spaced axes. spin (rad): rotation of all about
    the mean approach.
    """
    known = approaches[np.isfinite(approaches).all(axis=1)]
    way = known.sum(axis=0) / max(len(known), 1)
    axis = unit(way) if np.linalg.norm(way) > _NO_WAY else np.array([0.0, 0.0, -1.0])
    first = basis_across(axis)[0]
    upright = np.stack([first, np.cross(axis, first), axis], axis=1) @ rotation_from_vector(np.array([0.0, 0.0, spin]))
    if count == 1:
        return np.asarray(upright[None])
    around = 2 * np.pi * np.arange(count) / count
    tilts = np.radians(TILT_DEG) * np.stack([np.cos(around), np.sin(around), np.zeros(count)], axis=1)
    return np.asarray(upright @ rotation_from_vector(tilts))


def in_turn(features: tuple[str, ...], count: int) -> Ints:
    """The orientation (n,), below count, of each touch: in turn on each feature, starting with another on each."""
    made: dict[str, int] = {}
    chosen = []
    for feature in features:
        chosen.append((made.setdefault(feature, len(made))) % count)
        made[feature] += 1
    return np.array(chosen, dtype=np.intp)
