"""A robot from a URDF: the chain from its root, or a base link, to the tip link; and the corrected URDF.

URDF has m and rad, and rpy are rotations about fixed x, y and z, in this order. The chain's lengths are in the cell's
units.
"""

import re
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.geometry.rigid import homogeneous, orthonormalized, rotation_from_vector
from tactfix.kinematics.chain import Chain, FixedMotion, Joint, Motion, motions_of
from tactfix.kinematics.link import Link, chain_of_links
from tactfix.kinematics.urdf_syntax import UrdfError, UrdfJoint, UrdfTree, read_urdf
from tactfix.values import frozen_value
from tactfix.wording import did_you_mean

_MOVING: Final = ("revolute", "continuous", "prismatic")


@frozen_value
class UrdfRobot:
    """A URDF text, the joints of its chain in order, and the chain with lengths in units (units_per_metre).

    start: the byte at which the tag of the robot begins.
    """

    text: str
    joints: tuple[UrdfJoint, ...]
    chain: Chain
    units_per_metre: float
    start: int

    @property
    def has_place_for_tip(self) -> bool:
        """Whether a fixed joint after the last moving one can hold the tip's offset."""
        return self.joints[-1].type == "fixed"

    @property
    def flange(self) -> tuple[str, Floats]:
        """The parent of the tip link by a fixed joint, or else the tip link; and the tip link's pose (4, 4) in it."""
        last = self.joints[-1]
        if last.type != "fixed":
            return last.child, np.eye(4)
        return last.parent, _origin(last, self.units_per_metre)

    @property
    def moving(self) -> tuple[UrdfJoint, ...]:
        """The joints that move, in the order of the chain."""
        return tuple(joint for joint in self.joints if joint.type in _MOVING)


def urdf_robot(
    text: str, tip_link: str, base_link: str | None, units_per_metre: float, tip_offset: Floats | None = None
) -> UrdfRobot:
    """The robot between base_link (None: the root) and tip_link of a URDF text.

    tip_offset (3,): the tip's centre in the frame of tip_link, in units; None: its origin.
    Raises UrdfError for an unknown link, a loop, a joint that cannot be calibrated, or a chain without moving joints.
    """
    tree = read_urdf(text)
    joints = _path(tree, tip_link, base_link)
    links: list[Link] = []
    before = np.eye(4)
    for joint in joints:
        before = before @ _origin(joint, units_per_metre)
        if joint.type in _MOVING:
            links.append(Link(before, joint.axis, _joint(joint, units_per_metre)))
            before = np.eye(4)
    if not links:
        remedy = "name the link that holds the tip as tip_link"
        raise UrdfError(f"no joint between the base and {tip_link!r} moves", remedy)
    offset = homogeneous(np.eye(3), np.zeros(3) if tip_offset is None else tip_offset)
    return UrdfRobot(text, tuple(joints), chain_of_links(links, before @ offset), units_per_metre, tree.start)


def _path(tree: UrdfTree, tip_link: str, base_link: str | None) -> list[UrdfJoint]:
    """The joints from the base to the tip."""
    for name in (tip_link, *((base_link,) if base_link else ())):
        if name not in tree.links:
            raise UrdfError(f"there is no link {name!r}", did_you_mean(name, tree.links))
    above: dict[str, UrdfJoint] = {}
    for joint in tree.joints:
        for role, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in tree.links:
                message = f"joint {joint.name!r} has the {role} {link!r}, which is no link"
                raise UrdfError(message, did_you_mean(link, tree.links), joint.line)
        if joint.child in above:
            message = f"link {joint.child!r} is the child of two joints, {above[joint.child].name!r} and {joint.name!r}"
            raise UrdfError(message, "a chain has one joint above each link: remove one", joint.line)
        above[joint.child] = joint
    return list(_up(above, tip_link, base_link))[::-1]


def _up(above: dict[str, UrdfJoint], tip_link: str, base_link: str | None) -> Iterator[UrdfJoint]:
    """The joints from the tip to the base."""
    link, met = tip_link, {tip_link}
    while link in above and link != base_link:
        joint = above[link]
        if joint.type not in (*_MOVING, "fixed") or joint.mimics is not None:
            how = f"is {joint.type}" if joint.mimics is None else f"mimics {joint.mimics!r}"
            remedy = "choose base_link and tip_link so that only revolute, prismatic and fixed joints lie between"
            raise UrdfError(f"joint {joint.name!r} {how}", remedy, joint.line)
        yield joint
        link = joint.parent
        if link in met:
            raise UrdfError(f"the joints above {tip_link!r} close a loop at {link!r}", "break the loop", joint.line)
        met.add(link)
    if base_link is not None and link != base_link:
        raise UrdfError(f"{base_link!r} is not above {tip_link!r}", "name a link between the root and the tip")


def _joint(joint: UrdfJoint, units_per_metre: float) -> Joint:
    is_prismatic = joint.type == "prismatic"
    scale = units_per_metre if is_prismatic else 1.0
    limited = joint.type != "continuous" and joint.lower < joint.upper
    low, high = (joint.lower * scale, joint.upper * scale) if limited else (-np.inf, np.inf)
    return Joint(joint.name, is_prismatic, low, high)


def _origin(joint: UrdfJoint, units_per_metre: float) -> Floats:
    return homogeneous(_rotation_of_rpy(joint.rpy), joint.xyz * units_per_metre)


def _rotation_of_rpy(rpy: Floats) -> Floats:
    """Rz(yaw) Ry(pitch) Rx(roll)."""
    x, y, z = (rotation_from_vector(angle * axis) for angle, axis in zip(rpy, np.eye(3), strict=True))
    return np.asarray(z @ y @ x)


def _rpy_of_rotation(rotation: Floats) -> Floats:
    """Roll, pitch and yaw (3,) of a rotation (3, 3); if pitch is a right angle, yaw is 0."""
    pitch = float(np.arctan2(-rotation[2, 0], np.hypot(rotation[0, 0], rotation[1, 0])))
    if np.hypot(rotation[0, 0], rotation[1, 0]) < 1e-12:
        turned = rotation @ rotation_from_vector(-pitch * np.eye(3)[1])
        return np.array([np.arctan2(turned[2, 1], turned[1, 1]), pitch, 0.0])
    roll = np.arctan2(rotation[2, 1], rotation[2, 2])
    return np.array([roll, pitch, np.arctan2(rotation[1, 0], rotation[0, 0])])


def corrected_urdf(robot: UrdfRobot, values: Floats, notes: Sequence[str]) -> str:
    """The text with the origins of the chain's joints moved by parameter values (m,), and notes as one comment.

    Nothing but the origins changes. Raises UrdfError if the tip has moved and there is no fixed joint after the last
    moving one for it.
    """
    # No comment may hold two hyphens in a row.
    comment = "\n".join(["<!--", *(f"  {re.sub('-(?=-)', '- ', note)}" for note in notes), "-->\n"])
    edits = [*_edits(robot, values), ((robot.start, robot.start), comment.encode())]
    content = robot.text.encode()
    for (start, end), tag in sorted(edits, reverse=True):
        content = content[:start] + tag + content[end:]
    return content.decode()


def _edits(robot: UrdfRobot, values: Floats) -> Iterator[tuple[tuple[int, int], bytes]]:
    """The spans of bytes to replace, each with its new tag."""
    corrections = _corrections(robot, values)
    for index, joint in enumerate(robot.joints):
        correction = corrections.get(index)
        if correction is None or np.array_equal(correction, np.eye(4)):
            continue
        moved = _origin(joint, robot.units_per_metre) @ correction
        xyz = moved[:3, 3] / robot.units_per_metre
        rpy = joint.rpy
        if not np.array_equal(correction[:3, :3], np.eye(3)):
            rpy = _rpy_of_rotation(orthonormalized(moved[:3, :3]))
        tag = f'<origin xyz="{_words(xyz)}" rpy="{_words(rpy)}"'
        if joint.origin_span is None:
            yield (joint.end, joint.end), f"\n    {tag}/>".encode()
        else:
            old = robot.text.encode()[slice(*joint.origin_span)]
            yield joint.origin_span, (tag + ("/>" if old.endswith(b"/>") else ">")).encode()


def _words(values: Floats) -> str:
    return " ".join(repr(float(value) + 0.0) for value in values)


def _corrections(robot: UrdfRobot, values: Floats) -> dict[int, Floats]:
    """The factors (4, 4), from the right, of the joints' origins, by index in robot.joints.

    The errors of a link are between its nominal origin and its joint, so they move the origin of the moving joint;
    those of the tip move the last fixed joint after the last moving one.
    """
    found: dict[int, Floats] = {}
    pending: list[Motion] = []
    moving = iter([index for index, joint in enumerate(robot.joints) if joint.type in _MOVING])
    for motion in robot.chain.motions:
        if isinstance(motion, FixedMotion):
            pending = []
        elif motion.joint is None:
            pending.append(motion)
        else:
            found[next(moving)] = motions_of(pending, values)
            pending = []
    tip = motions_of(pending, values)
    if not np.array_equal(tip, np.eye(4)):
        last = len(robot.joints) - 1
        if not robot.has_place_for_tip:
            message = f"{robot.joints[last].child!r} moves with the last joint, so that the tip's offset has no place"
            raise UrdfError(message, "put a link with a fixed joint at the tip's centre, and name it as tip_link")
        found[last] = tip
    return found
