"""A link as six error parameters and a joint: how the URDF joints of a chain become elementary motions.

Where a joint's frame sits may be wrong by a rigid motion: three lengths along and three angles about the axes of the
joint's axis frame, whose z is the axis of the joint. The angle about z of a revolute joint, and the length along z of a
prismatic one, is its offset. All six stand between the joint's nominal origin and the joint itself, so that a corrected
robot is the nominal one with other origins. Which of them are independent is left to `calibration.independence`.
"""

from collections.abc import Sequence

import numpy as np

from tactfix.geometry.arrays import Floats, Frozen, UnitVector, basis_across, cross
from tactfix.kinematics.chain import Chain, ElementaryMotion, FixedMotion, Joint, Motion, Parameter, ParameterKind
from tactfix.values import frozen_value

_SHIFTS = ("x", "y", "z")
_ROTATION_VECTOR = ("rx", "ry", "rz")


@frozen_value
class Link:
    """A nominal origin (4, 4) in the frame before, and the joint that moves about or along axis (3,) there."""

    origin: Frozen
    axis: UnitVector
    joint: Joint


def chain_of_links(links: Sequence[Link], flange_from_tip: Floats) -> Chain:
    """The chain of links and the tip at the origin of flange_from_tip (4, 4) behind the last of them."""
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
    """The three lengths by which the tip may be off, along the axes of the tip's frame; appended to parameters."""
    motions: list[Motion] = []
    for name, axis in zip(_SHIFTS, np.eye(3), strict=True):
        motions.append(ElementaryMotion(rotates=False, axis=axis, parameter=len(parameters)))
        parameters.append(Parameter(f"tip.{name}", "tip", False, f"the tip along {name} of its frame"))
    return motions


def axis_frame(axis: Floats) -> Floats:
    """A rotation (3, 3) whose third column is the unit axis (3,): axes exchanged in turn where axis is one of them."""
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
            motions.append(ElementaryMotion(rotates, axis, parameter=len(parameters)))
            parameters.append(_parameter(joint, name, rotates, is_offset))
    return motions


def _parameter(joint: str, name: str, rotates: bool, is_offset: bool) -> Parameter:
    if is_offset:
        kind: ParameterKind = "joint_offset" if rotates else "length"
        return Parameter(f"{joint}.offset", kind, rotates, f"the zero of {joint}")
    kind = "angle" if rotates else "length"
    where = f"about {name[-1]}" if rotates else f"along {name}"
    return Parameter(f"{joint}.{name}", kind, rotates, f"the frame of {joint} {where} of its axis frame")
