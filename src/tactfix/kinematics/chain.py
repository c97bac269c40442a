"""The forward kinematics of a serial chain with error parameters, and the Jacobian of the tip's place.

A chain is a product of elementary motions, base_from_tip = M_1 M_2 ... M_k. Each is fixed, or a rotation about or a
translation along an axis of its own frame by an amount that is a joint's coordinate or the value of a parameter. URDF
and Denavit-Hartenberg rows differ only in the order of these motions.

Geometric Jacobian: with z the axis and o the origin of the frame in which an elementary motion acts, both in base,
the tip at x moves by  z x (x - o)  for each rad of a rotation and by  z  for each unit of a translation. It is exact
at every value of the parameters, not only where all are zero.

1. The motions between two joints are multiplied once for all touches (a segment); the joints' motions give the frame in
   which each segment begins.
2. Axis and origin of each parameter's motion are transformed to base.
3. The last frame gives the tip.
4. The columns of angles become z x (x - o); those of lengths are z.
"""

from collections.abc import Sequence
from functools import cached_property, lru_cache
from typing import Literal, TypeAlias

import numpy as np

from tactfix.geometry.arrays import Floats, Frozen, Ints, cross
from tactfix.geometry.rigid import homogeneous, skew
from tactfix.values import frozen_value

ParameterKind: TypeAlias = Literal["joint_offset", "length", "angle", "tip"]


@frozen_value(eq=True)
class Parameter:
    """An error parameter of the robot, 0 for the nominal one.

    name: "joint_3.offset". kind: of its prior. is_angle: in rad, else a length. meaning: in words.
    """

    name: str
    kind: ParameterKind
    is_angle: bool
    meaning: str


@frozen_value(eq=True)
class Joint:
    """A moving joint: its name in the file, and its limits (rad or length), infinite if it has none."""

    name: str
    is_prismatic: bool = False
    low: float = -np.inf
    high: float = np.inf


@frozen_value
class FixedMotion:
    """A constant rigid motion (4, 4)."""

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
Frame: TypeAlias = tuple[Floats, Floats]
"""Rotations (n, 3, 3) and origins (n, 3) in base."""


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
        frames, segments = self._frames(joints, values)  # step 1
        count = len(self.parameters)
        axes, origins = np.zeros((len(joints), 3, count)), np.zeros((len(joints), 3, count))
        for (rotation, origin), segment in zip(frames, segments, strict=True):  # step 2
            axes[:, :, segment.parameters] = _times(rotation, segment.axes)
            origins[:, :, segment.parameters] = origin[:, :, None] + _times(rotation, segment.origins)
        tip = _after(*frames[-1], segments[-1].matrix)[1]  # step 3
        turns = np.array([p.is_angle for p in self.parameters], dtype=bool)
        arms = tip[:, :, None] - origins[:, :, turns]  # step 4
        axes[:, :, turns] = np.moveaxis(cross(np.moveaxis(axes[:, :, turns], 1, 2), np.moveaxis(arms, 1, 2)), 2, 1)
        return TipMotion(tip, axes)

    def points(self, joints: Floats, values: Floats) -> Floats:
        """The tip's places (n, 3) in base, without their Jacobian."""
        frames, segments = self._frames(joints, values)
        return _after(*frames[-1], segments[-1].matrix)[1]

    def base_from_tip(self, joints: Floats, values: Floats) -> Floats:
        """The tip's frames (n, 4, 4) in base; its axes are those of the flange."""
        frames, segments = self._frames(joints, values)
        return homogeneous(*_after(*frames[-1], segments[-1].matrix))

    def _frames(self, joints: Floats, values: Floats) -> tuple[list[Frame], tuple["_Segment", ...]]:
        """The frame in which each segment begins, and the segments: before, between and after the joints."""
        segments = _segments(self, np.ascontiguousarray(values, dtype=np.float64).tobytes())
        frames = [(np.broadcast_to(np.eye(3), (len(joints), 3, 3)), np.zeros((len(joints), 3)))]
        turns = _turns(self, np.ascontiguousarray(joints, dtype=np.float64).tobytes())
        for segment, motion, turn in zip(segments, self._moving, turns, strict=False):
            rotation, origin = _after(*frames[-1], segment.matrix)
            if motion.rotates:
                frames.append((rotation @ turn, origin))
            else:
                frames.append((rotation, origin + joints[:, motion.joint, None] * (rotation @ motion.axis)))
        return frames, segments

    @cached_property
    def _moving(self) -> tuple[ElementaryMotion, ...]:
        """The motions of the joints, in order."""
        return tuple(m for m in self.motions if isinstance(m, ElementaryMotion) and m.joint is not None)

    def names(self) -> tuple[str, ...]:
        """The parameters' names, in the order of the values."""
        return tuple(parameter.name for parameter in self.parameters)


def _after(rotation: Floats, origin: Floats, matrix: Floats) -> Frame:
    """Frames (n, 3, 3), (n, 3) after one motion (4, 4)."""
    return _times(rotation, matrix[:3, :3]), origin + _times(rotation, matrix[:3, 3:])[:, :, 0]


def _times(rotation: Floats, matrix: Floats) -> Floats:
    """Rotations (n, 3, 3) times one matrix (3, k): one product of (3 n, 3), several times as fast as n small ones."""
    return np.asarray((rotation.reshape(-1, 3) @ matrix).reshape(len(rotation), 3, matrix.shape[1]))


@frozen_value
class _Segment:
    """Motions without a joint: their product (4, 4), and the indices (k,) of their parameters.

    axes, origins (3, k): of the parameters' motions, in the frame of the first motion.
    """

    matrix: Floats
    parameters: Ints
    axes: Floats
    origins: Floats


@lru_cache(maxsize=4)
def _segments(chain: Chain, values: bytes) -> tuple[_Segment, ...]:
    """The segments for parameter values (m,), the same at every touch and place.

    Cached for the last values: each place, the cost and the next step need them.
    """
    found, start, motions = [], 0, chain.motions
    ends = [i for i, m in enumerate(motions) if isinstance(m, ElementaryMotion) and m.joint is not None]
    for end in (*ends, len(motions)):
        found.append(_segment(motions[start:end], np.frombuffer(values)))
        start = end + 1
    return tuple(found)


def _segment(motions: Sequence[Motion], values: Floats) -> _Segment:
    rotation, origin = np.eye(3), np.zeros(3)
    parameters, axes, origins = [], [], []
    for motion in motions:
        if isinstance(motion, FixedMotion):
            origin = origin + rotation @ motion.matrix[:3, 3]
            rotation = rotation @ motion.matrix[:3, :3]
            continue
        assert motion.parameter is not None  # there is no joint in a segment
        parameters.append(motion.parameter)
        axes.append(rotation @ motion.axis)
        origins.append(origin)
        amount = values[motion.parameter]
        if amount and motion.rotates:
            rotation = rotation @ motion.turn(amount)
        elif amount:
            origin = origin + amount * axes[-1]
    columns = (np.array(vectors).reshape(-1, 3).T for vectors in (axes, origins))
    return _Segment(homogeneous(rotation, origin), np.array(parameters, dtype=np.intp), *columns)


@lru_cache(maxsize=32)
def _turns(chain: Chain, joints: bytes) -> tuple[Floats, ...]:
    """The rotations (n, 3, 3) of the moving joints in order, (n, 0) for prismatic ones, at joints (n, k).

    They depend on no parameter: cached for the touches of each place, since every step needs them.
    """
    values = np.frombuffer(joints).reshape(-1, len(chain.joints))
    none = np.zeros((len(values), 0))
    return tuple(m.turn(values[:, m.joint]) if m.rotates else none for m in chain._moving)


def motions_of(motions: Sequence[Motion], values: Floats) -> Floats:
    """The product (4, 4) of motions without a joint, for parameter values (m,)."""
    return _segment(motions, values).matrix
