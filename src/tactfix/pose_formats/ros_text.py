"""ROS and URDF as people have them: origin tags, static_transform_publisher, the print of tf2_echo.

Metres and radians. A rotation that is told twice (tf2_echo: quaternion, angles, matrix) must be the same one.
"""

import re
from typing import Final

import numpy as np

from tactfix.geometry.arrays import Floats
from tactfix.lexer import Lexer, TextError
from tactfix.pose_formats.literals import the_one, without_comments
from tactfix.pose_formats.orientation import EulerAngles, Quaternion
from tactfix.pose_formats.pose import PoseSyntaxError, syntax_error

_MOST_OFF: Final = 3e-3
"""Entry of R^T R - 1 that numbers with three digits, as tf2_echo prints them, may leave of a rotation: each entry is
off by 5e-4, and a sum of three products of two by 3e-3."""
_RPY: Final = EulerAngles("ZYX", order=(2, 1, 0), degrees=False)
_XYZW: Final = Quaternion(scalar_first=False)

_XML_COMMENT: Final = re.compile(r"<!--.*?-->", re.DOTALL)
_ORIGIN: Final = re.compile(r"<\s*origin\b", re.IGNORECASE)
_ORIGIN_EXAMPLE: Final = '<origin xyz="0.0 0.0 0.0" rpy="0.0 0.0 0.0"/>'

_HASH_COMMENT: Final = re.compile(r"(?<![\w.+-])#[^\r\n]*|<!--.*?-->", re.DOTALL)
_PUBLISHER: Final = re.compile(r"static_transform_publisher")
_ARGUMENTS: Final = re.compile(r"(?:args|arguments)\s*=\s*(?:\"([^\"]*)\"|'([^']*)'|\[([^\]]*)\])")
_STATIC_EXAMPLE: Final = (
    "--x 0.0 --y 0.0 --z 0.0 --qx 0.0 --qy 0.0 --qz 0.0 --qw 1.0, or x y z yaw pitch roll frame child"
)
_STATIC: Final = f"write {_STATIC_EXAMPLE}"
_FRAME_NAMES: Final = ("frame-id", "child-frame-id")

_ECHO: Final = re.compile(r"-\s*Translation\s*:", re.IGNORECASE)
_ECHO_EXAMPLE: Final = "- Translation: [x, y, z] and - Rotation: in Quaternion [x, y, z, w], as tf2_echo prints them"


def read_urdf(text: str) -> Floats:
    """x, y, z, roll, pitch, yaw (6,) of the one origin tag; what it leaves out is zero."""
    return the_one(without_comments(text, _XML_COMMENT), _ORIGIN, _origin, _ORIGIN_EXAMPLE)


def _origin(lexer: Lexer) -> Floats:
    lexer.match(_ORIGIN)
    remedy = f"write {_ORIGIN_EXAMPLE}"
    said: dict[str, tuple[float, ...]] = {}
    while not (lexer.take("/>") or lexer.take(">")):
        name = lexer.name(remedy).lower()
        if name not in ("xyz", "rpy") or name in said:
            lexer.refuse(f"the attribute {name} is not known, or stands twice", remedy)
        lexer.mark("=", remedy)
        mark = "'" if lexer.follows("'") else '"'
        lexer.mark(mark, remedy)
        said[name] = tuple(lexer.number(remedy) for _ in range(3))
        lexer.mark(mark, remedy)
    if not said:
        lexer.refuse("origin without xyz and rpy", remedy)
    return np.array([*said.get("xyz", (0.0,) * 3), *said.get("rpy", (0.0,) * 3)])


def read_static(text: str) -> Floats:
    """x, y, z, qx, qy, qz, qw (7,) of the one static_transform_publisher; what its options leave out is zero."""
    spoken = without_comments(text, _HASH_COMMENT)
    if len(_PUBLISHER.findall(spoken)) > 1:
        raise syntax_error("holds more than one static_transform_publisher", "write one")
    publisher = _PUBLISHER.search(spoken)
    begin = publisher.end() if publisher else 0
    arguments = _ARGUMENTS.search(spoken, begin) or _ARGUMENTS.search(spoken)
    if arguments is not None:
        words = next(inside for inside in arguments.groups() if inside is not None)
    else:
        words = spoken[begin:].replace("\\\n", " ")  # to the end: a line that is broken is no shorter one
    cut = re.sub(r"[\s,'\"\[\]]+", " ", words).split()
    try:
        return _by_options(cut) if any(word.startswith("--") for word in cut) else _by_place(cut)
    except TextError as error:
        raise PoseSyntaxError([error.problem]) from error


def _by_options(words: list[str]) -> Floats:
    """--x 1 --yaw 2 ... in any order."""
    said: dict[str, float] = {}
    position = 0
    while position < len(words) and words[position] != "--ros-args":
        name = words[position].removeprefix("--")
        known = name in (*_FRAME_NAMES, "x", "y", "z", "qx", "qy", "qz", "qw", "roll", "pitch", "yaw")
        if not words[position].startswith("--") or not known or name in said or position + 1 == len(words):
            raise syntax_error(f"{words[position][:40]!r} is not known, stands twice or has no value", _STATIC)
        said[name] = 0.0 if name in _FRAME_NAMES else _number(words[position + 1])
        position += 2
    turn = [name for name in said if name in ("qx", "qy", "qz", "qw")]
    angles = [name for name in said if name in ("roll", "pitch", "yaw")]
    if not said.keys() & {"x", "y", "z"} or (turn and angles) or len(turn) in (1, 2, 3):
        raise syntax_error("is not one whole transform", _STATIC)
    rotation = tuple(said[name] for name in ("qx", "qy", "qz", "qw")) if turn else _of_angles(said)
    return np.array([*(said.get(axis, 0.0) for axis in "xyz"), *rotation])


def _by_place(words: list[str]) -> Floats:
    """x y z yaw pitch roll, or x y z qx qy qz qw; then frame and child, and in ROS 1 a period."""
    count = next((i for i, word in enumerate(words) if word[0] not in "+-.0123456789"), len(words))
    after = words[count:]
    if count not in (6, 7) or len(after) not in (0, 2, 3):
        raise syntax_error("holds no pose of this form", _STATIC)
    if len(after) == 3:
        _number(after[2])
    numbers = [_number(word) for word in words[:count]]
    if count == 7:
        return np.array(numbers)
    return np.array([*numbers[:3], *_of_angles(dict(zip(("yaw", "pitch", "roll"), numbers[3:], strict=True)))])


def _number(word: str) -> float:
    lexer = Lexer(word)
    number = lexer.number(_STATIC)
    lexer.end(_STATIC)
    return number


def _of_angles(said: dict[str, float]) -> tuple[float, ...]:
    rotation = _RPY.rotation(np.array([said.get(name, 0.0) for name in ("roll", "pitch", "yaw")]))
    return tuple(_XYZW.numbers(rotation).tolist())


def is_echo(text: str) -> bool:
    """Whether a text is what tf2_echo prints."""
    return _ECHO.search(text) is not None


def read_echo(text: str) -> Floats:
    """x, y, z, qx, qy, qz, qw (7,) that tf2_echo printed, once or the same ones again and again."""
    lexer = Lexer(text)
    found: list[Floats] = []
    try:
        while (beginning := _ECHO.search(text, lexer.position)) is not None:
            lexer.position = beginning.end()
            found.append(_echoed(lexer))
    except TextError as error:
        raise PoseSyntaxError([error.problem]) from error
    if any(not np.array_equal(pose, found[0]) for pose in found):
        raise syntax_error("the poses that tf2_echo printed differ", "keep one of them")
    return found[0]


def _echoed(lexer: Lexer) -> Floats:
    """One print after its word Translation: translation, then the rotation in one way or several."""
    remedy = f"write {_ECHO_EXAMPLE}"
    translation = _list(lexer, 3, remedy)
    rotations: list[Floats] = []
    turn: tuple[float, ...] | None = None
    while _in(lexer):
        if lexer.take("Quaternion"):
            lexer.take("(xyzw)")
            turn = _list(lexer, 4, remedy)
        else:
            lexer.mark("RPY", remedy)
            degrees = lexer.take("(degree)") or not (lexer.take("(radian)") or True)
            angles = np.array(_list(lexer, 3, remedy))
            rotations.append(_RPY.rotation(np.deg2rad(angles) if degrees else angles))
    if lexer.take("- Matrix:"):
        rows = np.array([[lexer.number(remedy) for _ in range(4)] for _ in range(4)])
        rotations.append(rows[:3, :3])
    if turn is None or abs(np.linalg.norm(turn) - 1) > _MOST_OFF:
        lexer.refuse("there is no unit quaternion", remedy)
    unit = np.array(turn) / np.linalg.norm(turn)
    if any(np.abs(rotation - _XYZW.rotation(unit)).max() > _MOST_OFF for rotation in rotations):
        lexer.refuse("quaternion, angles and matrix are not the same rotation", remedy)
    return np.array([*translation, *unit])


def _in(lexer: Lexer) -> bool:
    """- Rotation: in, or in alone."""
    here = lexer.position
    lexer.take("- Rotation:")
    if lexer.take("in "):
        return True
    lexer.position = here
    return False


def _list(lexer: Lexer, count: int, remedy: str) -> tuple[float, ...]:
    lexer.mark("[", remedy)
    numbers = lexer.numbers(count, remedy)
    lexer.mark("]", remedy)
    return numbers
