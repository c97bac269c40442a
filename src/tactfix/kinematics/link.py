"""A link as six error parameters and a joint: the elementary motions of the URDF joints of a chain.

The pose of a joint's frame has errors: three lengths along and three angles about the axes of the joint's axis frame,
whose z is the axis of the joint. The angle about z of a revolute joint, and the length along z of a prismatic one, is
its offset. All six are between the joint's nominal origin and the joint itself, so that a corrected robot is the
nominal one with other origins. `calibration.independence` selects independent ones.
"""

from collections.abc import Sequence

import numpy as np

from tactfix.geometry.arrays import Floats, Frozen, UnitVector, basis_across, cross
from tactfix.kinematics.chain import Chain, ElementaryMotion, FixedMotion, Joint, Motion, Parameter
from tactfix.values import frozen_value

_SHIFTS = ("x", "y", "z")
_ROTATION_VECTOR = ("rx", "ry", "rz")


@frozen_value
class Link:
    """A nominal origin (4, 4) in the frame of the link before, and a joint about or along axis (3,) there."""

    origin: Frozen
    axis: UnitVector
    joint: Joint


def chain_of_links(links: Sequence[Link], flange_from_tip: Floats) -> Chain:
    """The chain of links, with the tip at the origin of flange_from_tip (4, 4) after the last link."""
    motions: list[Motion] = []
    parameters: list[Parameter] = []
    for index, link in enumerate(links):
        motions.append(FixedMotion(link.origin))
        motions += _errors(link, f"joint_{index + 1}", parameters)
        motions.append(ElementaryMotion(not link.joint.is_prismatic, link.axis, joint=index))
    motions.append(FixedMotion(flange_from_tip))
    motions += tip_errors(parameters)
    return Chain(tuple(motions), tuple(link.joint for link in links), tuple(parameters))


def tip_errors(parameters: list[Parameter]) -> list[Motion]:
    """The motions of the tip's three errors along the axes of its frame; their parameters are appended."""
    motions: list[Motion] = []
    for name, axis in zip(_SHIFTS, np.eye(3), strict=True):
        motions.append(ElementaryMotion(rotates=False, axis=axis, parameter=len(parameters)))
        parameters.append(Parameter(f"tip.{name}", "tip", False, f"the tip along {name} of its frame"))
    return motions


def axis_frame(axis: Floats) -> Floats:
    """A rotation (3, 3) whose third column is the unit axis (3,): a cyclic permutation if axis is a coordinate axis."""
    largest = int(np.argmax(np.abs(axis)))
    aligned = abs(axis[largest]) > 1 - 1e-12
    first = np.eye(3)[(largest + 1) % 3] if aligned else basis_across(axis)[0]
    return np.stack([first, cross(axis, first), axis], axis=1)


def _errors(link: Link, joint: str, parameters: list[Parameter]) -> list[Motion]:
    """The six elementary motions of one link; their parameters are appended."""
    frame = axis_frame(link.axis)
    motions: list[Motion] = []
    for rotates, names in ((False, _SHIFTS), (True, _ROTATION_VECTOR)):
        for name, axis in zip(names, frame.T, strict=True):
            is_offset = name[-1] == "z" and rotates != link.joint.is_prismatic
            where = f"about {name[-1]}" if rotates else f"along {name}"
            other = joint_error(joint, name, rotates, f"the frame of {joint} {where} of its axis frame")
            motions.append(ElementaryMotion(rotates, axis, parameter=len(parameters)))
            parameters.append(joint_offset(joint, rotates) if is_offset else other)
    return motions


def joint_offset(joint: str, rotates: bool) -> Parameter:
    """The error of a joint's zero."""
    return Parameter(f"{joint}.offset", "joint_offset" if rotates else "length", rotates, f"the zero of {joint}")


def joint_error(joint: str, name: str, rotates: bool, meaning: str) -> Parameter:
    """Any other error of a joint's frame or row."""
    return Parameter(f"{joint}.{name}", "angle" if rotates else "length", rotates, meaning)
