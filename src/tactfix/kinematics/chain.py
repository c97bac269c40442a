"""The forward kinematics of a serial chain with errors in it, and the Jacobian of the tip's place.

A chain is a product of elementary motions, base_from_tip = M_1 M_2 ... M_k. Each is fixed, or a rotation about or a
translation along an axis of its own frame by an amount that is a joint's coordinate or the value of a parameter. URDF
and Denavit-Hartenberg rows differ in the order of these motions only, so nothing below knows which of them it has.

Geometric Jacobian: with z the axis and o the origin of the frame in which an elementary motion acts, both in base,
the tip at x moves by  z x (x - o)  for each rad of a rotation and by  z  for each unit of a translation. It is exact
at every value of the parameters, not only where all are zero.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

from tactfix.geometry.arrays import Floats, Frozen, cross
from tactfix.geometry.rigid import homogeneous, skew
from tactfix.values import frozen_value

ParameterKind: TypeAlias = Literal["joint_offset", "length", "angle", "tip"]


@frozen_value(eq=True)
class Parameter:
    """What the robot may be off by: value 0 is the nominal robot.

    name: "joint_3.offset". kind: which of the four priors it has. is_angle: in rad, else a length. meaning: in words.
    """

    name: str
    kind: ParameterKind
    is_angle: bool
    meaning: str


@frozen_value(eq=True)
class Joint:
    """A joint that moves: its name in its file, and its limits (rad or length), infinite where it has none."""

    name: str
    is_prismatic: bool = False
    low: float = -np.inf
    high: float = np.inf


@frozen_value
class FixedMotion:
    """A rigid motion (4, 4) that is always the same."""

    matrix: Frozen


@frozen_value
class ElementaryMotion:
    """A rotation about, or translation along, the unit axis (3,) through the origin of its frame.

    Its amount is the coordinate of the joint with index `joint`, or the value of the parameter with index `parameter`.
    """

    rotates: bool
    axis: Frozen
    joint: int | None = None
    parameter: int | None = None

    @cached_property
    def generators(self) -> tuple[Floats, Floats]:
        """The cross product with the axis, (3, 3), and its square."""
        return skew(self.axis), skew(self.axis) @ skew(self.axis)

    def turn(self, amount: Floats) -> Floats:
        """The rotations (..., 3, 3) about the axis by amount (...) in rad (Rodrigues)."""
        once, twice = self.generators
        angle = amount[..., None, None]
        return np.asarray(np.eye(3) + np.sin(angle) * once + 2 * np.sin(angle / 2) ** 2 * twice)


Motion: TypeAlias = FixedMotion | ElementaryMotion


@frozen_value
class TipMotion:
    """n places of the tip (n, 3) in base and their Jacobian (n, 3, m) by the chain's m parameters."""

    points: Floats
    jacobian: Floats


@frozen_value
class Chain:
    """A serial chain from the robot's base to the tip: its motions in order, its joints and its parameters."""

    motions: tuple[Motion, ...]
    joints: tuple[Joint, ...]
    parameters: tuple[Parameter, ...]

    def tip(self, joints: Floats, values: Floats) -> TipMotion:
        """The tip's motion at joint coordinates (n, k) in rad and lengths, for parameter values (m,)."""
        rotation, origin = _start(len(joints))
        axes = np.zeros((len(self.parameters), len(joints), 3))
        origins = np.zeros_like(axes)
        for motion in self.motions:
            if isinstance(motion, ElementaryMotion) and motion.parameter is not None:
                axes[motion.parameter] = rotation @ motion.axis
                origins[motion.parameter] = origin
            rotation, origin = _moved(rotation, origin, motion, joints, values)
        turns = np.array([p.is_angle for p in self.parameters], dtype=bool)
        columns = axes
        columns[turns] = cross(axes[turns], origin - origins[turns])
        return TipMotion(origin, np.moveaxis(columns, 0, -1))

    def points(self, joints: Floats, values: Floats) -> Floats:
        """The tip's places (n, 3) in base alone."""
        rotation, origin = _start(len(joints))
        for motion in self.motions:
            rotation, origin = _moved(rotation, origin, motion, joints, values)
        return origin

    def base_from_tip(self, joints: Floats, values: Floats) -> Floats:
        """The tip's frames (n, 4, 4) in base; its axes are those of the flange."""
        rotation, origin = _start(len(joints))
        for motion in self.motions:
            rotation, origin = _moved(rotation, origin, motion, joints, values)
        return homogeneous(np.broadcast_to(rotation, (len(joints), 3, 3)), origin)

    def names(self) -> tuple[str, ...]:
        """The parameters' names, in the order of the values."""
        return tuple(parameter.name for parameter in self.parameters)


def _start(count: int) -> tuple[Floats, Floats]:
    return np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3))


def _moved(rotation: Floats, origin: Floats, motion: Motion, joints: Floats, values: Floats) -> tuple[Floats, Floats]:
    """The frames after one more motion."""
    if isinstance(motion, FixedMotion):
        return rotation @ motion.matrix[:3, :3], origin + rotation @ motion.matrix[:3, 3]
    if motion.joint is not None:
        amount = joints[:, motion.joint]
    else:
        amount = values[motion.parameter, None]
        if not amount[0]:
            return rotation, origin
    if motion.rotates:
        return rotation @ motion.turn(amount), origin
    return rotation, origin + amount[:, None] * (rotation @ motion.axis)


def motions_of(motions: Sequence[Motion], values: Floats) -> Floats:
    """The product (4, 4) of motions that no joint is among, for parameter values (m,)."""
    rotation, origin = _start(1)
    for motion in motions:
        rotation, origin = _moved(rotation, origin, motion, np.zeros((1, 0)), values)
    return homogeneous(rotation[0], origin[0])
