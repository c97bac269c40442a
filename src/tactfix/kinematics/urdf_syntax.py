"""The joints and links of a URDF text with their positions in it; everything else of the file is ignored.

expat gives the byte at which each tag begins, so that a corrected file is the same file with other origins. A document
type is rejected: its entities could read other files and the network.
"""

import re
from dataclasses import dataclass, field
from typing import Any, Final, Literal, TypeAlias, get_args
from xml.parsers import expat

import numpy as np

from tactfix.decimal_text import number_of
from tactfix.errors import Problem, TactfixError
from tactfix.geometry.arrays import Floats

JointType: TypeAlias = Literal["revolute", "continuous", "prismatic", "fixed", "floating", "planar"]


class UrdfError(TactfixError):
    """An invalid URDF text; the reader of the file makes a FileError of it."""

    def __init__(self, message: str, remedy: str, line: int | None = None, column: int | None = None) -> None:
        self.problem = Problem(message, remedy, line=line, column=column)
        super().__init__(self.problem.text)


@dataclass(slots=True)
class UrdfJoint:
    """A <joint> of the robot: lengths in m, angles in rad.

    start, end: the bytes of its own tag; origin_span: those of its <origin> tag, if it has one.
    """

    name: str
    type: JointType
    line: int
    start: int
    end: int
    parent: str = ""
    child: str = ""
    xyz: Floats = field(default_factory=lambda: np.zeros(3))
    rpy: Floats = field(default_factory=lambda: np.zeros(3))
    axis: Floats = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))
    lower: float = -np.inf
    upper: float = np.inf
    mimics: str | None = None
    origin_span: tuple[int, int] | None = None


@dataclass(slots=True)
class UrdfTree:
    """Names of the links and the joints, in the order of the file; start: the byte at which the robot's tag begins."""

    links: list[str]
    joints: list[UrdfJoint]
    start: int


def read_urdf(text: str) -> UrdfTree:
    """The joints and links of a URDF text. Raises UrdfError with line and column for an invalid text."""
    parser = expat.ParserCreate("utf-8")
    reader = _Reader(text.encode(), parser)
    parser.StartElementHandler = reader.start
    parser.EndElementHandler = reader.end
    parser.StartDoctypeDeclHandler = reader.doctype
    try:
        parser.Parse(reader.content, True)
    except expat.ExpatError as error:
        message = f"this is not XML: {expat.errors.messages.get(error.code, error)}"
        raise UrdfError(message, "correct the tag there", error.lineno, error.offset + 1) from None
    if not reader.is_robot:
        raise UrdfError("this is no URDF: its outermost tag is not <robot>", "name the robot's URDF file", 1)
    return UrdfTree(reader.links, reader.joints, reader.robot_start)


_TAG_END: Final = re.compile(rb"""(?:[^>"']|"[^"]*"|'[^']*')*>""")


class _Reader:
    """Handlers of the parser, and the links and joints found so far."""

    def __init__(self, content: bytes, parser: Any) -> None:
        self.content, self.parser = content, parser
        self.links: list[str] = []
        self.joints: list[UrdfJoint] = []
        self.path: list[str] = []
        self.is_robot = False
        self.robot_start = 0
        self.parts: set[str] = set()

    def doctype(self, *_: object) -> None:
        raise self.error("the file has a document type (<!DOCTYPE>)", "remove it: no URDF needs one")

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        if ":" in tag and tag.startswith("xacro:"):
            raise self.error(f"<{tag}> is xacro, not URDF", "expand it first: xacro robot.xacro > robot.urdf")
        self.path.append(tag)
        match self.path:
            case ["robot"]:
                self.is_robot = True
                self.robot_start = int(self.parser.CurrentByteIndex)
            case ["robot", "link"]:
                name = self.needed(attributes, "name", tag)
                if name in self.links:
                    raise self.error(f"there is a second link {name!r}", "give each link its own name")
                self.links.append(name)
            case ["robot", "joint"]:
                self.parts = set()
                self.joints.append(self.joint(attributes))
            case ["robot", "joint", part]:
                self.part(self.joints[-1], part, attributes)

    def end(self, _: str) -> None:
        if self.path == ["robot", "joint"] and (missing := {"parent", "child"} - self.parts):
            message = f"joint {self.joints[-1].name!r} has no <{max(missing)}>"
            raise self.error(message, f'write <{max(missing)} link="..."/>')
        self.path.pop()

    def joint(self, attributes: dict[str, str]) -> UrdfJoint:
        name, kind = self.needed(attributes, "name", "joint"), self.needed(attributes, "type", "joint")
        if any(joint.name == name for joint in self.joints):
            raise self.error(f"there is a second joint {name!r}", "give each joint its own name")
        if kind not in get_args(JointType):
            raise self.error(f"joint {name!r} has the unknown type {kind!r}", "write revolute, prismatic or fixed")
        start, end = self.span()
        return UrdfJoint(name, kind, self.parser.CurrentLineNumber, start, end)  # type: ignore[arg-type]

    def part(self, joint: UrdfJoint, part: str, attributes: dict[str, str]) -> None:
        """One of the tags inside a joint."""
        if part in self.parts and part in ("parent", "child", "origin", "axis", "limit"):
            raise self.error(f"joint {joint.name!r} has a second <{part}>", "remove one")
        self.parts.add(part)
        match part:
            case "parent" | "child":
                setattr(joint, part, self.needed(attributes, "link", part))
            case "origin":
                joint.origin_span = self.span()
                joint.xyz = self.vector(attributes, "xyz", joint.xyz)
                joint.rpy = self.vector(attributes, "rpy", joint.rpy)
            case "axis":
                joint.axis = self.vector(attributes, "xyz", joint.axis)
                if not joint.axis.any() and joint.type != "fixed":
                    raise self.error(f"the axis of joint {joint.name!r} is zero", "write its direction")
            case "limit":
                joint.lower = self.number(attributes, "lower", 0.0)
                joint.upper = self.number(attributes, "upper", 0.0)
                if joint.lower > joint.upper:
                    message = f"joint {joint.name!r} has the limits {joint.lower:g} to {joint.upper:g}"
                    raise self.error(message, "write the lower one as lower")
            case "mimic":
                joint.mimics = attributes.get("joint", "")

    def span(self) -> tuple[int, int]:
        """The bytes of the tag that begins here."""
        start = int(self.parser.CurrentByteIndex)
        end = _TAG_END.match(self.content, start)
        assert end is not None  # the parser has read it
        return start, end.end()

    def needed(self, attributes: dict[str, str], key: str, tag: str) -> str:
        if not attributes.get(key):
            raise self.error(f"<{tag}> has no {key}", f'write <{tag} {key}="...">')
        return attributes[key]

    def number(self, attributes: dict[str, str], key: str, default: float) -> float:
        if key not in attributes:
            return default
        value = number_of(attributes[key].strip())
        if value is None:
            raise self.error(f"{key} is {attributes[key]!r}, not a number", "write a finite number")
        return value

    def vector(self, attributes: dict[str, str], key: str, default: Floats) -> Floats:
        if key not in attributes:
            return default
        values = [number_of(word) for word in attributes[key].split()]
        if len(values) != 3 or None in values:
            raise self.error(f"{key} is {attributes[key]!r}, not three numbers", f'write {key}="0 0 0"')
        return np.array(values, dtype=np.float64)

    def error(self, message: str, remedy: str) -> UrdfError:
        return UrdfError(message, remedy, self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1)
