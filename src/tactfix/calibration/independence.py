"""Which error parameters are independent: by rank, in an order of preference.

Six parameters for each joint are redundant: those along and about parallel axes have the same effect, those of the
first joint that of the base, those of the last one that of the tip.

1. The identification Jacobian of the tip's place is taken at random configurations over the joints' ranges.
2. The motions of the base that the placements allow are its first columns.
3. The columns of the parameters to calibrate follow: the tip, joint offsets, lengths and angles, each in the order of
   the chain. The components along the columns before are subtracted from each (Gram-Schmidt, twice).
4. If the rest of a column is not zero, its parameter is estimated. If it is zero, or the parameter, times the sigma of
   its prior, does not move the tip, it is held at its nominal value.

That is a QR decomposition with pivots in a given order instead of by size.

L. J. Everett, T. W. Hsu: The theory of kinematic parameter identification for industrial robots, 1988.
M. A. Meggiolaro, S. Dubowsky: An analytical method to eliminate the redundant parameters in robot calibration, 2000.
"""

from typing import Final

import numpy as np

from tactfix.calibration.cell import Cell, Touches
from tactfix.geometry.arrays import Bools, Floats, cross
from tactfix.kinematics.chain import Parameter
from tactfix.poses.placement_terms import terms_at
from tactfix.values import frozen_value

INDEPENDENCE_SAMPLES: Final = 80
"""Random configurations whose rows show which parameters are independent: several times as many rows as columns."""
_NOTHING_LEFT: Final = 1e-7
"""Share of a column's length below which its rest is zero. On samples/robot-calibration it is 9e-16 at most for columns
held, 0.079 at least for those kept."""
_CHOSEN_FIRST: Final = ("tip", "joint_offset", "length", "angle")
"""Kinds of parameters in order of preference: of two with the same effect, that of the later kind is held."""
_PARTNER: Final = 0.05
"""Least share of a held column for another parameter to be named in its message. On the robot of
samples/robot-calibration 0.025 names the same ones; with 0.1 the places of the fixtures and the tip are missing
from three of the messages."""


@frozen_value(eq=True)
class Held:
    """A parameter (index) that is held at nominal, and in words why."""

    index: int
    message: str


def asked_for(cell: Cell) -> Bools:
    """Which of the cell's parameters (m,) its file declares unknown, by group or by name."""
    return np.array([_is_asked(parameter, cell) for parameter in cell.parameters])


def _is_asked(parameter: Parameter, cell: Cell) -> bool:
    if parameter.name in cell.unknown:
        return True
    if parameter.name.startswith("tip."):
        return "tip" in cell.unknown or "all" in cell.unknown
    if parameter.name == "tip_radius":
        return False
    offset = parameter.name.endswith(".offset")
    return "all" in cell.unknown or (offset and "joint_offsets" in cell.unknown)


def joint_ranges(cell: Cell, touches: Touches | None) -> Floats:
    """The joint ranges (k, 2) of the cell, else the joints' limits, else the touches' ranges made wider.

    Wider: angles to at least 60 degrees to either side of their middle, lengths by a half.
    """
    if cell.joint_ranges is not None:
        return cell.joint_ranges
    ranges = np.array([[joint.low, joint.high] for joint in cell.chain.joints])
    for k, joint in enumerate(cell.chain.joints):
        if not np.isfinite(ranges[k]).all():
            seen = np.array([-np.pi, np.pi]) if touches is None else touches.joints[:, k]
            middle, half = (seen.max() + seen.min()) / 2, (seen.max() - seen.min()) / 2
            half = 1.5 * half if joint.is_prismatic else max(half, np.deg2rad(60.0))
            ranges[k] = [middle - half, middle + half]
    return ranges


def random_configurations(ranges: Floats, count: int, seed: int = 0) -> Floats:
    """Joint coordinates (count, k), evenly spread over ranges (k, 2)."""
    return np.random.default_rng(seed).uniform(ranges[:, 0], ranges[:, 1], (count, len(ranges)))


def base_motions(points: Floats) -> Floats:
    """Derivatives (3 n, 6) of points (n, 3) by motions of the base: rotations about their mean (rad), translations."""
    arms = points - points.mean(axis=0)
    turns = np.stack([cross(np.broadcast_to(axis, arms.shape), arms) for axis in np.eye(3)], axis=2)
    shifts = np.broadcast_to(np.eye(3), (len(points), 3, 3))
    return np.concatenate([turns, shifts], axis=2).reshape(-1, 6)


def _free_base(cell: Cell, touches: Touches | None, centre: Floats) -> Floats:
    """The motions (6, k) of the base that all places touched allow: rotations about centre (3,) in rad, translations.

    Each placement allows a subspace of motions; the result is their intersection.
    """
    names = cell.places if touches is None else touches.touched
    placements = [cell.places[cell.root(name)[0]].placement for name in names]
    forbidden = np.zeros((6, 6))
    scale = float(np.linalg.norm(centre)) or 1.0
    for placement in placements:
        if placement is None:
            continue
        allowed, _, _ = terms_at(placement, placement.near, centre, scale)
        forbidden += np.eye(6) if placement.covariance is not None else np.eye(6) - allowed @ allowed.T
    values, vectors = np.linalg.eigh(forbidden)
    free = vectors[:, values < _NOTHING_LEFT]
    free[:3] /= scale
    return np.asarray(free)


def independent(cell: Cell, touches: Touches | None) -> tuple[Bools, tuple[Held, ...]]:
    """Which of the cell's parameters (m,) are estimated, and those that are held at nominal."""
    asked = asked_for(cell)
    # Step 1.
    motion = cell.chain.tip(
        random_configurations(joint_ranges(cell, touches), INDEPENDENCE_SAMPLES), np.zeros(len(cell.chain.parameters))
    )
    columns = motion.jacobian.reshape(-1, motion.jacobian.shape[2])
    # Step 2.
    moves = base_motions(motion.points) @ _free_base(cell, touches, motion.points.mean(axis=0))
    basis = list(np.linalg.qr(moves)[0].T)
    names = ["the poses of the fixtures"] * len(basis)
    scales = np.array([cell.prior.sigma(parameter) for parameter in cell.parameters])
    largest = float((np.linalg.norm(columns, axis=0) * scales[:-1])[asked[:-1]].max(initial=0.0))
    free, held = np.zeros(len(asked), dtype=bool), []
    free[-1] = asked[-1]
    for index in _in_order(cell, asked):
        column = columns[:, index]
        left, shares = _without(column, basis)  # step 3
        size = float(np.linalg.norm(column))
        # Step 4.
        if np.linalg.norm(left) > _NOTHING_LEFT * size and size * scales[index] > _NOTHING_LEFT * largest:
            free[index] = True
            basis.append(left / np.linalg.norm(left))
            names.append(cell.parameters[index].name)
        else:
            moved = size * scales[index] > _NOTHING_LEFT * largest
            held.append(
                Held(index, _words(cell.parameters[index].name, _partners(names, shares / size) if moved else []))
            )
    return free, tuple(held)


def _in_order(cell: Cell, asked: Bools) -> list[int]:
    return sorted(
        (i for i in np.flatnonzero(asked).tolist() if i < len(cell.chain.parameters)),
        key=lambda i: _CHOSEN_FIRST.index(cell.parameters[i].kind),
    )


def _without(column: Floats, basis: list[Floats]) -> tuple[Floats, Floats]:
    """The component of a column orthogonal to a basis, and its components (k,) along the orthonormal basis."""
    if not basis:
        return column, np.zeros(0)
    matrix = np.array(basis)
    shares = matrix @ column
    left = column - matrix.T @ shares
    return left - matrix.T @ (matrix @ left), shares


def _partners(names: list[str], shares: Floats) -> list[str]:
    """The three parameters at most whose columns contribute most to a held one's."""
    by_size = [names[i] for i in np.argsort(-np.abs(shares)) if abs(shares[i]) > _PARTNER]
    return list(dict.fromkeys(by_size))[:3]


def _words(name: str, partners: list[str]) -> str:
    if not partners:
        return f"{name} does not move the tip: held at its nominal value"
    with_ = ", ".join(partners)
    return f"{name} trades off exactly with {with_}: held at its nominal value"
