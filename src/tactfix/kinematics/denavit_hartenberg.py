"""Chains from Denavit-Hartenberg rows, standard and modified, and the corrected rows.

standard: frame_before from frame_after = Rz(theta + q) Tz(d) Tx(a) Rx(alpha) Ry(beta)
modified (Craig): Rx(alpha) Tx(a) Ry(beta) Rz(theta + q) Tz(d)

beta is Hayati's parameter, for axes that are nominally parallel (sin alpha = 0): if one is tilted a little, the other
numbers are discontinuous, because the common perpendicular may be anywhere. It is 0 in a row of four numbers, and an
error parameter only for parallel axes.

J. Denavit, R. S. Hartenberg: A kinematic notation for lower-pair mechanisms, 1955. J. J. Craig: Introduction to
robotics, 1986. S. A. Hayati: Robot arm geometric link parameter estimation, 1983.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, Literal, TypeAlias

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import homogeneous, rotation_from_vector
from tactfix.kinematics.chain import Chain, ElementaryMotion, FixedMotion, Joint, Motion, Parameter
from tactfix.kinematics.link import joint_error, joint_offset, tip_errors
from tactfix.values import frozen_value

Convention: TypeAlias = Literal["standard", "modified"]
_X, _Y, _Z = np.eye(3)
_PARALLEL_AXES: Final = 1e-6
"""Sine of alpha below which neighbouring axes count as parallel: the rounding of multiples of pi in files."""


@frozen_value(eq=True)
class Row:
    """a and d (lengths), alpha, theta and beta (rad), and the joint, None for a fixed row."""

    a: float
    d: float
    alpha: float
    theta: float
    beta: float
    joint: Joint | None


_ROW_MOTIONS: Final = {
    "standard": (("theta", True, _Z), ("d", False, _Z), ("a", False, _X), ("alpha", True, _X), ("beta", True, _Y)),
    "modified": (("alpha", True, _X), ("a", False, _X), ("beta", True, _Y), ("theta", True, _Z), ("d", False, _Z)),
}
"""The elementary motions of a row in order: number, whether it rotates, and the axis."""


def chain_of_rows(rows: Sequence[Row], convention: Convention, flange_from_tip: Floats) -> Chain:
    """The chain of rows, with the tip at the origin of flange_from_tip (4, 4) after the last row."""
    motions: list[Motion] = []
    parameters: list[Parameter] = []
    joints: list[Joint] = []
    for row in rows:
        motions += _row_motions(row, convention, joints, parameters)
    motions.append(FixedMotion(flange_from_tip))
    motions += tip_errors(parameters)
    return Chain(tuple(motions), tuple(joints), tuple(parameters))


def _row_motions(row: Row, convention: Convention, joints: list[Joint], parameters: list[Parameter]) -> list[Motion]:
    """The motions of one row; its joint and its parameters are appended."""
    motions: list[Motion] = []
    moving = None if row.joint is None else ("d" if row.joint.is_prismatic else "theta")
    name = f"joint_{len(joints) + 1}"
    for number, rotates, axis in _ROW_MOTIONS[convention]:
        motions.append(_fixed(rotates, axis, getattr(row, number)))
        if moving is None:
            continue
        if number != "beta" or abs(np.sin(row.alpha)) < _PARALLEL_AXES:
            motions.append(ElementaryMotion(rotates, axis, parameter=len(parameters)))
            other = joint_error(name, number, rotates, f"{number} of {name}")
            parameters.append(joint_offset(name, rotates) if number == moving else other)
        if number == moving:
            motions.append(ElementaryMotion(rotates, axis, joint=len(joints)))
    if row.joint is not None:
        joints.append(row.joint)
    return motions


def _fixed(rotates: bool, axis: Floats, amount: float) -> FixedMotion:
    if rotates:
        return FixedMotion(homogeneous(rotation_from_vector(amount * axis), np.zeros(3)))
    return FixedMotion(homogeneous(np.eye(3), amount * axis))


def corrected_rows(rows: Sequence[Row], convention: Convention, chain: Chain, values: Floats) -> tuple[Row, ...]:
    """The rows with the values (m,) of the chain's parameters added to their numbers.

    Exact, since the motion of an error parameter is next to that of the number to which it is added.
    """
    by_name = dict(zip(chain.names(), values.tolist(), strict=True))
    corrected: list[Row] = []
    number = 0
    for row in rows:
        if row.joint is None:
            corrected.append(row)
            continue
        number += 1
        moving = "d" if row.joint.is_prismatic else "theta"
        shifts = {
            field: by_name.get(f"joint_{number}.{'offset' if field == moving else field}", 0.0)
            for field, _, _ in _ROW_MOTIONS[convention]
        }
        corrected.append(replace(row, **{field: getattr(row, field) + shift for field, shift in shifts.items()}))
    return tuple(corrected)
