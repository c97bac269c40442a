"""A pose from a file, in any format that tactfix writes.

The format follows from the file's extension, or from text that occurs in no other format; it is never guessed. Numbers
alone must be a matrix: the meaning of six numbers differs between vendors.
"""

import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Final

from tactfix.errors import FileError, Problem, UsageError
from tactfix.files.reading import read_bytes
from tactfix.formats import SUFFIXES
from tactfix.pose_formats import DIALECTS, find_dialect
from tactfix.pose_formats.pose import Pose, PoseSyntaxError
from tactfix.settings import Setting
from tactfix.units import UNITS, which_unit

_ROUGH_NUMBER: Final = r"\s{0,20}[-+.0-9eE]{1,40}\s{0,20}"
_MARKS: Final = (
    ("kuka", r"\{\s*(?:(?:E6POS|POS|FRAME)\s*:\s*)?[XYZABC]\s+[-+.0-9]"),
    ("abb-wobjdata", r"\[\s*(?:TRUE|FALSE)\s*,\s*(?:TRUE|FALSE)\s*,"),
    (
        "abb",
        rf"\[\s*\[{_ROUGH_NUMBER},{_ROUGH_NUMBER},{_ROUGH_NUMBER}\]\s*,\s*\[{_ROUGH_NUMBER},{_ROUGH_NUMBER},{_ROUGH_NUMBER},{_ROUGH_NUMBER}\]",
    ),
    (
        "fanuc",
        r"(?<!\w)X\s*[=:]\s*[-+.0-9][^{}]{0,120}(?<!\w)W\s*[=:][^{}]{0,120}(?<!\w)P\s*[=:][^{}]{0,120}(?<!\w)R\s*[=:]",
    ),
    ("ur", rf"(?<!\w)p\s*\[{_ROUGH_NUMBER},"),
    ("kawasaki", r"(?<!\w)TRANS\s*\("),
    ("comau", r"(?<!\w)POS\s*\("),
    ("doosan", r"(?<!\w)posx\s*\("),
    ("mecademic", r"(?<!\w)SetWrf\s*\("),
    ("siemens", r"(?<!\w)CTRANS\s*\("),
    ("heidenhain", r"PLANE\s+SPATIAL"),
    ("g68.2", r"G\s*0*68\.2(?![0-9])"),
    ("g10", r"G\s*0*10\s*L\s*0*20?(?![0-9.])"),
    ("ros-static", r"static_transform_publisher"),
    ("urdf", r"<origin\s"),
    ("ros", r"^[ \t-]*(?:translation|position|transformation|Rotation: in Quaternion[^\[]*)\s*:?[ \t]*(?:$|[\[{])"),
    ("yaml", r"^[ \t]*schema[ \t]*:\s*['\"]?tactfix/"),
)
"""A pattern for each format; compiled on first use, since compiling takes longer than reading a pose."""
_LINE_BREAK: Final = re.compile(r"\r\n?|\n")
_POSE_WITHIN: Final = 1 << 16
"""Only this many characters of a text are searched for the format of its pose."""


def recognized(text: str) -> str | None:
    """The one format whose marks the text contains; None if it contains those of no format or of several."""
    content = _LINE_BREAK.sub("\n", text[:_POSE_WITHIN])
    found = [name for name, mark in _MARKS if re.search(mark, content, re.IGNORECASE | re.MULTILINE)]
    # A work object contains poses that match the ABB mark too.
    found = [name for name in found if name != "abb"] if "abb-wobjdata" in found else found
    return found[0] if len(found) == 1 else None


_NUMPY_MAGIC = b"\x93NUMPY"


def load_pose(
    path: str | Path, *, units: str | None = None, default_units: str | None = None, dialect: str | None = None
) -> Pose:
    """Read the pose in a file.

    Parameters
    ----------
    path : str or Path
        The file; "-" for standard input.
    units : str, optional
        The unit of the file.
    default_units : str, optional
        The unit if the file does not give one.
    dialect : str, optional
        The name of its format. Default: by the extension (.json, .yaml, .csv, .npy, .src ...), else by the content:
        text that occurs in one format only, JSON, a numpy array, or four rows of four numbers.

    Returns
    -------
    Pose
        With the covariance and the name of the fixture if the file has them.

    Raises
    ------
    FileError
        The file holds no pose, or a result of locate whose status is not "located".
    UsageError
        The file gives another unit than units.

    Notes
    -----
    Rotations are read by the convention of the format: A, B, C of KUKA are Rz(A) Ry(B) Rx(C), in degrees, and so on.

    Examples
    --------
    >>> tactfix.load_pose("samples/robot-cell-plate/expected.json").translation.round(1)
    array([1184.2, -356.7,  412.9])
    """
    for unit in (units, default_units):
        if unit is not None and unit not in UNITS:
            raise UsageError(f"units is {unit!r}; {which_unit(unit)}")
    given = None if dialect is None else find_dialect(dialect)
    name = "standard input" if str(path) == "-" else str(path)
    content = sys.stdin.buffer.read() if str(path) == "-" else _content(path)
    try:
        pose = (given or DIALECTS[_dialect_of(name, content)]).read(content)
    except PoseSyntaxError as error:
        raise FileError(name, error.problems) from error
    if units is not None and pose.units not in (None, units):
        raise UsageError(f"{name} is in {pose.units}, not in {units}; leave out " + Setting.UNITS.to(units))
    return replace(pose, units=pose.units or units or default_units)


def _content(path: str | Path) -> bytes:
    if recognized(str(path)) and not Path(path).exists():
        raise FileError(
            str(path), [Problem("this is a pose, not the name of a file", "write it to a file and name that")]
        )
    return read_bytes(path)


def _dialect_of(name: str, content: bytes) -> str:
    """The format by the extension, else by the content."""
    suffix = Path(name).suffix.lower()
    if suffix in SUFFIXES and suffix != ".txt":
        return SUFFIXES[suffix]
    if content.startswith(_NUMPY_MAGIC):
        return "npy"
    known = recognized(content.decode("utf-8", errors="replace"))
    if known is not None:
        return known
    return "json" if content.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] == b"{" else "matrix"
