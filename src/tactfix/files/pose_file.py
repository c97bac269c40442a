"""A pose from a file, in any dialect that tactfix writes."""

import sys
from dataclasses import replace
from pathlib import Path

from tactfix.errors import FileError, UsageError
from tactfix.files.reading import read_bytes
from tactfix.formats import SUFFIXES
from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.pose import Pose, PoseSyntaxError
from tactfix.pose_formats.recognition import recognized
from tactfix.settings import Setting
from tactfix.units import UNITS, which_unit

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
        The unit of a file that does not say.
    dialect : str, optional
        The name of its format; without one the ending tells (.json, .yaml, .csv, .npy, .src ...), else the content:
        marks that only one format has, JSON, a numpy array, or four rows of four numbers.

    Returns
    -------
    Pose
        With the covariance and the name of the fixture where the file has them.

    Raises
    ------
    FileError
        What is no pose, and a result of locate whose status is not "located".
    UsageError
        A file that says another unit itself.

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
    if dialect is not None and dialect not in DIALECTS:
        raise UsageError(f"no dialect {dialect!r}; there are {', '.join(DIALECTS)}")
    name = "standard input" if str(path) == "-" else str(path)
    content = sys.stdin.buffer.read() if str(path) == "-" else read_bytes(path)
    try:
        pose = DIALECTS[dialect or _dialect_of(name, content)].read(content)
    except PoseSyntaxError as error:
        raise FileError(name, error.problems) from error
    if units is not None and pose.units not in (None, units):
        raise UsageError(f"{name} is in {pose.units}, not in {units}; leave out " + Setting.UNITS.to(units))
    return replace(pose, units=pose.units or units or default_units)


def _dialect_of(name: str, content: bytes) -> str:
    """What the ending says, else what the content is recognized by."""
    suffix = Path(name).suffix.lower()
    if suffix in SUFFIXES and suffix != ".txt":
        return SUFFIXES[suffix]
    if content.startswith(_NUMPY_MAGIC):
        return "npy"
    known = recognized(content.decode("utf-8", errors="replace"))
    if known is not None:
        return known
    return "json" if content.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] == b"{" else "matrix"
