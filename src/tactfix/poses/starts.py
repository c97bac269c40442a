"""Where descents to the poses start: coverings of all rotations, and the surroundings of poses already found."""

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.poses.descent import rotation_matrices, turned
from tactfix.poses.equations import PoseEquations, centred_offsets

OFF_CENTRE = 0.75
"""Of 64 minimal problems with cylinders and spheres the rarest zeros were met five times as often as from the centre;
0.5 and 1 do as well, a step of the fixture's radii or a translation at random less."""
NEIGHBOURS = 32
SIDES = np.concatenate([np.zeros((3, 1)), OFF_CENTRE * np.eye(3), -OFF_CENTRE * np.eye(3)], axis=1)
"""Translations (3, 7) off the best one: none, and OFF_CENTRE along the axes either way."""


def covering_rotations(count: int) -> Floats:
    """Rotation matrices (3, 3, count), evenly spread (super-Fibonacci spiral, Alexa 2022)."""
    s = np.arange(count) + 0.5
    inner, outer = np.sqrt(s / count), np.sqrt(1 - s / count)
    # The two constants of the paper: sqrt 2 and the positive root of x^4 = x + 4.
    first, second = 2 * np.pi * s / np.sqrt(2.0), 2 * np.pi * s / 1.533751168755204288118041
    return rotation_matrices(
        inner * np.sin(first), inner * np.cos(first), outer * np.sin(second), outer * np.cos(second)
    )


def covering(equations: PoseEquations, count: int, number: int) -> tuple[Floats, Floats]:
    """So many poses over all rotations, others for each number."""
    rotations = covering_rotations(count)
    if number:
        rotations = turned(np.repeat(_steps(1, number)[:3], count, axis=1), rotations)
    return rotations, centred_offsets(equations, rotations) + _away(count, number)


def _away(count: int, number: int) -> Floats:
    """Vectors (3, count) of length OFF_CENTRE in all directions, others for each number."""
    away = _steps(count, number)[3:]
    return np.asarray(away * (OFF_CENTRE / np.sqrt((away**2).sum(axis=0))))


def around(centres: Floats, number: int) -> tuple[Floats, Floats]:
    """NEIGHBOURS poses around each of the centres (k, 13), at every scale, others in each round."""
    poses = np.repeat(centres, NEIGHBOURS, axis=0).T
    step = _steps(poses.shape[1], number)
    return turned(step[:3], poses[:9].reshape(3, 3, -1)), poses[9:12] + step[3:]


def _steps(count: int, number: int) -> Floats:
    """Steps (6, count) of lengths 0.05 to 1.2, evenly spread (Kronecker sequence): numpy.random is slow to import."""
    index = np.arange(count) + 1 + number * 7919
    # Powers of the root of x^8 = x + 1: the sequence of least discrepancy in seven dimensions (Roberts).
    uniform = (0.5 + index * 1.0969815577985598 ** -np.arange(1, 8)[:, None]) % 1.0
    size = np.sqrt(-2 * np.log(uniform[:3] + 1e-12))
    step = np.concatenate([size * np.cos(2 * np.pi * uniform[3:6]), size * np.sin(2 * np.pi * uniform[3:6])])
    return np.asarray(step * 0.05 * 24 ** uniform[6] / np.sqrt((step**2).sum(axis=0)))
