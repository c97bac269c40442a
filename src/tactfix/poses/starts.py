"""Starts of descents: coverings of the rotations, and poses around those already found.

1. Rotations are spread evenly over those of the domain (super-Fibonacci spiral, Alexa 2022), rotated differently in
   each covering.
2. If poses beyond the limits are searched too, the first covering adds rotations over all of them, half as dense.
3. Each rotation starts with its best translation, moved by START_OFFSET in some direction.
4. These poses are projected onto the domain.
5. Or rotations near those of all poses are known from features located alone (`feature_rotations`).
"""

from dataclasses import replace

import numpy as np

from tactfix.geometry.arrays import Bools, Floats
from tactfix.poses.descent import turned
from tactfix.poses.equations import PoseEquations, centred_offsets
from tactfix.poses.pose_domain import PoseDomain
from tactfix.poses.zeros import Zeros
from tactfix.values import frozen_value

START_OFFSET = 0.75
"""Length of the step from the best translation at each start, in the scaled lengths of the equations.

Of 64 minimal problems with cylinders and spheres the rarest zeros were met five times as often as without it. 0.5 and 1
are as good; a step of the fixture's radii or a random translation is worse."""
NEIGHBOURS = 32
"""Starts around each zero in one round, at all scales. 16 and 64 give the same poses of the trial problems
(`search`)."""
SIDES = np.concatenate([np.zeros((3, 1)), START_OFFSET * np.eye(3), -START_OFFSET * np.eye(3)], axis=1)
"""Steps (3, 7) from the best translation: none, and START_OFFSET along the axes in both directions."""
SHARES = (1 / 32, 1 / 8, 1 / 2, 1.0)
"""Number of starts for turns about 0 to 3 axes at equal density, as a share of those for all rotations, each rotation
with translations to eight sides. The cells of 1200 starts are 0.2 rad wide (half angles): a circle has 16 of them, half
a sphere 150."""
DENSER = 2.0
"""Factor on that density within limits, so that the few starts still meet every zero OFTEN."""
FEWEST_STARTS = 32
"""Fewest starts over a domain: enough to meet a zero OFTEN whose basin is a fifth of the domain."""
BEYOND_SHARE = 0.5
"""Factor on the density beyond the limits: poses there are only counted, and some may be missed."""
TURNS = 12
"""Rotations about a single direction: one every 30 degrees. Of 11,400 problems three kept a pose that these starts
led to, and starts around those found no further ones."""
GOLDEN = (5**0.5 - 1) / 2
"""The golden section: any number of its multiples are spread evenly over a circle."""


@frozen_value
class FeatureRotations:
    """Rotations (3, 3, N) of fixture_from_base near that of every pose.

    fix_place: whether the features that gave them leave a single translation at each.
    """

    matrices: Floats
    fix_place: bool

    def __len__(self) -> int:
        return int(self.matrices.shape[2])

    @property
    def are_samples(self) -> bool:
        """Whether they are samples of the rotations about a single direction, not all possible ones."""
        return len(self) >= TURNS

    def of(self, which: Bools) -> "FeatureRotations":
        """Those."""
        return FeatureRotations(self.matrices[..., which], self.fix_place)


def covering_rotations(count: int) -> Floats:
    """Rotation matrices (3, 3, count), evenly spread (super-Fibonacci spiral, Alexa 2022)."""
    s = np.arange(count) + 0.5
    inner, outer = np.sqrt(s / count), np.sqrt(1 - s / count)
    # The two constants of the paper: sqrt 2 and the positive root of x^4 = x + 4.
    first, second = 2 * np.pi * s / np.sqrt(2.0), 2 * np.pi * s / 1.533751168755204288118041
    return _rotation_matrices(
        inner * np.sin(first), inner * np.cos(first), outer * np.sin(second), outer * np.cos(second)
    )


def _rotation_matrices(x: Floats, y: Floats, z: Floats, w: Floats) -> Floats:
    """Rotation matrices (3, 3, N) of unit quaternions, scalar w."""
    xx, yy, zz, xy, xz, yz, wx, wy, wz = x * x, y * y, z * z, x * y, x * z, y * z, w * x, w * y, w * z
    rows = [1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy)]
    rows += [2 * (xy + wz), 1 - 2 * (xx + zz), 2 * (yz - wx), 2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)]
    return np.array(rows).reshape(3, 3, -1)


def covering(equations: PoseEquations, count: int, number: int) -> tuple[Floats, Floats]:
    """Poses over the rotations of the domain, as dense as count over all; different ones for each number."""
    domain = equations.domain
    rotations = domain_rotations(domain, start_count(domain, count), number)  # step 1
    if domain.looks_beyond and not number:  # step 2
        wide = replace(domain, angle=np.pi)
        beyond = domain_rotations(wide, int(np.ceil(BEYOND_SHARE * start_count(wide, count))))
        rotations = np.concatenate([rotations, beyond], axis=2)
    offsets = centred_offsets(equations, rotations) + _away(rotations.shape[2], number)  # step 3
    return domain.onto(rotations, offsets)  # step 4


def start_count(domain: PoseDomain, over_all: int) -> int:
    """The number of starts that cover the domain as densely as over_all starts cover all rotations."""
    axes = int(domain.turns.sum())
    if axes == 3 and domain.search_angle >= np.pi:
        return over_all
    wanted = DENSER * over_all * SHARES[axes] * _part(axes, domain.search_angle)
    return int(min(max(np.ceil(wanted), FEWEST_STARTS), over_all))


def _part(axes: int, search_angle: float) -> float:
    """The part of the turns about so many axes that are no larger than search_angle (rad)."""
    return float(
        (1.0, search_angle / np.pi, 1 - np.cos(search_angle / 2), (search_angle - np.sin(search_angle)) / np.pi)[axes]
    )


def domain_rotations(domain: PoseDomain, count: int, number: int = 0) -> Floats:
    """About count rotations (3, 3, N), spread evenly over those of the domain, different ones for each number."""
    free = np.flatnonzero(domain.turns)
    if len(free) == 3:
        rotations = covering_rotations(int(np.ceil(count / _part(3, domain.search_angle))))
        if number:
            rotations = turned(np.repeat(_steps(1, number)[:3], rotations.shape[2], axis=1), rotations)
        return (
            rotations
            if domain.search_angle >= np.pi
            else rotations[..., domain.angles(rotations) <= domain.search_angle]
        )
    index, quaternions = np.arange(count) + 0.5, np.zeros((4, count))
    quaternions[0] = 1.0
    if len(free) == 1:
        half = domain.search_angle * ((index / count + GOLDEN * number) % 1.0 - 0.5)
        quaternions[0], quaternions[1 + free[0]] = np.cos(half), np.sin(half)
    if len(free) == 2:
        # A spiral on the cap of the sphere around its pole, with equal area for each point.
        cosine, azimuth = 1 - _part(2, domain.search_angle) * index / count, 2 * np.pi * GOLDEN * (index + 97 * number)
        quaternions[0] = cosine
        quaternions[1 + free] = np.sqrt(1 - cosine**2) * np.array([np.cos(azimuth), np.sin(azimuth)])
    return domain.turned_from_near(quaternions)


def _away(count: int, number: int) -> Floats:
    """Vectors (3, count) of length START_OFFSET in all directions, different ones for each number."""
    away = _steps(count, number)[3:]
    return np.asarray(away * (START_OFFSET / np.sqrt((away**2).sum(axis=0))))


def around(domain: PoseDomain, centres: Zeros, number: int) -> tuple[Floats, Floats]:
    """NEIGHBOURS poses of the domain around each of the centres, at all scales, different ones in each round."""
    rotations = np.repeat(centres.rotations, NEIGHBOURS, axis=-1)
    offsets = np.repeat(centres.offsets, NEIGHBOURS, axis=-1)
    step = _steps(offsets.shape[1], number)
    if domain.is_free:
        return turned(step[:3], rotations), offsets + step[3:]
    index = np.flatnonzero([*domain.turns, *domain.shifts])
    whole = np.einsum("iuN,uN->iN", domain.basis(rotations, offsets), step[index])
    return domain.onto(turned(whole[:3], rotations), offsets + whole[3:])


def _steps(count: int, number: int) -> Floats:
    """Steps (6, count) of lengths 0.05 to 1.2, evenly spread (Kronecker sequence): numpy.random is slow to import."""
    index = np.arange(count) + 1 + number * 7919
    # Powers of the root of x^8 = x + 1: the sequence of least discrepancy in seven dimensions (Roberts).
    uniform = (0.5 + index * 1.0969815577985598 ** -np.arange(1, 8)[:, None]) % 1.0
    size = np.sqrt(-2 * np.log(uniform[:3] + 1e-12))
    step = np.concatenate([size * np.cos(2 * np.pi * uniform[3:6]), size * np.sin(2 * np.pi * uniform[3:6])])
    return np.asarray(step * 0.05 * 24 ** uniform[6] / np.sqrt((step**2).sum(axis=0)))
