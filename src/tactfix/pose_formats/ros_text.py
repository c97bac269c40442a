"""Reads poses of ROS and URDF: origin tags, static_transform_publisher, output of tf2_echo.

Metres and radians. A rotation given in several forms (tf2_echo: quaternion, angles, matrix) must be the same in each.
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
"""Largest entry of R^T R - 1 of a rotation printed with three decimals, as by tf2_echo: entries are off by up to 5e-4,
and sums of three products of two entries by 3e-3."""
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
    """x, y, z, roll, pitch, yaw (6,) of the one origin tag; omitted attributes are zero."""
    return the_one(without_comments(text, _XML_COMMENT), _ORIGIN, _origin, _ORIGIN_EXAMPLE)


def _origin(lexer: Lexer) -> Floats:
    lexer.match(_ORIGIN)
    remedy = f"write {_ORIGIN_EXAMPLE}"
    attributes: dict[str, tuple[float, ...]] = {}
    while not (lexer.take("/>") or lexer.take(">")):
        name = lexer.name(remedy).lower()
        if name not in ("xyz", "rpy") or name in attributes:
            lexer.refuse(f"the attribute {name} is not known, or is given twice", remedy)
        lexer.mark("=", remedy)
        mark = "'" if lexer.follows("'") else '"'
        lexer.mark(mark, remedy)
        attributes[name] = tuple(lexer.number(remedy) for _ in range(3))
        lexer.mark(mark, remedy)
    if not attributes:
        lexer.refuse("origin without xyz and rpy", remedy)
    return np.array([*attributes.get("xyz", (0.0,) * 3), *attributes.get("rpy", (0.0,) * 3)])


def read_static(text: str) -> Floats:
    """x, y, z, qx, qy, qz, qw (7,) of the one static_transform_publisher; omitted options are zero."""
    content = without_comments(text, _HASH_COMMENT)
    if len(_PUBLISHER.findall(content)) > 1:
        raise syntax_error("contains more than one static_transform_publisher", "write one")
    publisher = _PUBLISHER.search(content)
    begin = publisher.end() if publisher else 0
    arguments = _ARGUMENTS.search(content, begin) or _ARGUMENTS.search(content)
    if arguments is not None:
        words = next(inside for inside in arguments.groups() if inside is not None)
    else:
        words = content[begin:].replace("\\\n", " ")  # all the rest, so that a broken line is an error
    cut = re.sub(r"[\s,'\"\[\]]+", " ", words).split()
    try:
        return _by_options(cut) if any(word.startswith("--") for word in cut) else _by_place(cut)
    except TextError as error:
        raise PoseSyntaxError([error.problem]) from error


def _by_options(words: list[str]) -> Floats:
    """--x 1 --yaw 2 ... in any order."""
    values: dict[str, float] = {}
    position = 0
    while position < len(words) and words[position] != "--ros-args":
        name = words[position].removeprefix("--")
        known = name in (*_FRAME_NAMES, "x", "y", "z", "qx", "qy", "qz", "qw", "roll", "pitch", "yaw")
        if not words[position].startswith("--") or not known or name in values or position + 1 == len(words):
            raise syntax_error(f"{words[position][:40]!r} is not known, is given twice or has no value", _STATIC)
        values[name] = 0.0 if name in _FRAME_NAMES else _number(words[position + 1])
        position += 2
    turn = [name for name in values if name in ("qx", "qy", "qz", "qw")]
    angles = [name for name in values if name in ("roll", "pitch", "yaw")]
    if not values.keys() & {"x", "y", "z"} or (turn and angles) or len(turn) in (1, 2, 3):
        raise syntax_error("is not one whole transform", _STATIC)
    rotation = tuple(values[name] for name in ("qx", "qy", "qz", "qw")) if turn else _of_angles(values)
    return np.array([*(values.get(axis, 0.0) for axis in "xyz"), *rotation])


def _by_place(words: list[str]) -> Floats:
    """x y z yaw pitch roll, or x y z qx qy qz qw; then frame and child, and in ROS 1 a period."""
    count = next((i for i, word in enumerate(words) if word[0] not in "+-.0123456789"), len(words))
    after = words[count:]
    if count not in (6, 7) or len(after) not in (0, 2, 3):
        raise syntax_error("contains no pose of this form", _STATIC)
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


def _of_angles(values: dict[str, float]) -> tuple[float, ...]:
    rotation = _RPY.rotation(np.array([values.get(name, 0.0) for name in ("roll", "pitch", "yaw")]))
    return tuple(_XYZW.numbers(rotation).tolist())


def is_echo(text: str) -> bool:
    """Whether a text is output of tf2_echo."""
    return _ECHO.search(text) is not None


def read_echo(text: str) -> Floats:
    """x, y, z, qx, qy, qz, qw (7,) printed by tf2_echo, once or repeatedly; repetitions must be equal."""
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
    """One output after the word Translation: translation, then the rotation in one or several forms."""
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
    start = lexer.position
    lexer.take("- Rotation:")
    if lexer.take("in "):
        return True
    lexer.position = start
    return False


def _list(lexer: Lexer, count: int, remedy: str) -> tuple[float, ...]:
    lexer.mark("[", remedy)
    numbers = lexer.numbers(count, remedy)
    lexer.mark("]", remedy)
    return numbers
