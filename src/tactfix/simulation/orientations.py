"""How the tool is turned at each touch: so many orientations about the way that the probe comes on the whole.

The tool's axis is z of the flange. Tilted evenly to all sides, orientations tell the tip's place in the flange best for
their number; one alone tells none of it, and two leave it free along the axis about which they differ.
"""

from typing import Final

import numpy as np

from tactfix.geometry.arrays import Floats, Ints, basis_across, unit
from tactfix.geometry.rigid import rotation_from_vector

TILT_DEG: Final = 30.0
"""What most robots can still turn a probe by beside a fixture; the more, the better the tip is known."""
_NO_WAY: Final = 0.1
"""Shorter mean approaches say nothing of where the tool comes from."""


def tool_orientations(count: int, approaches: Floats, spin: float = 0.0) -> Floats:
    """count rotations (count, 3, 3) of the flange, in the frame of approaches (n, 3), of which rows may be nan.

    One is not tilted, more are by TILT_DEG about axes evenly around; spin (rad): of all about the mean approach.
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
    """Which of count orientations each touch has (n,): those on each feature in turn, and no two features alike."""
    made: dict[str, int] = {}
    chosen = []
    for feature in features:
        chosen.append((made.setdefault(feature, len(made))) % count)
        made[feature] += 1
    return np.array(chosen, dtype=np.intp)
