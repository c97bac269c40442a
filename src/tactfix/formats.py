"""What help and completion tell of the formats of poses and contacts: names, endings, and a default.

It stands apart from the formats themselves (`pose_formats`, `files.logs`), which need numpy: help does not wait for it.
A format has no other name than one of these, which mypy sees to, and each of these has a format, or the import fails.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, Literal, TypeAlias, get_args

PoseFormat: TypeAlias = Literal[
    "matrix",
    "json",
    "yaml",
    "csv",
    "npy",
    "ros",
    "ros-static",
    "urdf",
    "kuka",
    "abb",
    "abb-wobjdata",
    "fanuc",
    "ur",
    "yaskawa",
    "staubli",
    "mecademic",
    "kawasaki",
    "comau",
    "doosan",
    "mitsubishi",
    "siemens",
    "heidenhain",
    "g68.2",
    "g10",
]
LogName: TypeAlias = Literal["linuxcnc", "grbl", "msr", "xyzijk", "xyz", "ippdme", "dmis", "ur", "kuka", "abb", "fanuc"]

POSE_FORMATS: Final[tuple[PoseFormat, ...]] = get_args(PoseFormat)
"""Dialects of poses, as in --format, --to and --from, in the order in which they are listed."""
LOG_NAMES: Final[tuple[LogName, ...]] = get_args(LogName)
"""Machine logs, as in --contacts-format; csv, tactfix's own contact file, is not among them."""

SUFFIXES: Final[Mapping[str, PoseFormat]] = MappingProxyType(
    {
        ".txt": "matrix",
        ".json": "json",
        ".yaml": "yaml",
        ".yml": "yaml",
        ".csv": "csv",
        ".npy": "npy",
        ".urdf": "urdf",
        ".src": "kuka",
        ".mod": "abb-wobjdata",
        ".script": "ur",
        ".h": "heidenhain",
        ".mpf": "siemens",
        ".ngc": "g10",
        ".nc": "g68.2",
    }
)
"""Which dialect a file name's ending means."""

LEVER_ARM_MM: Final = 500.0
"""How far from the fixture's origin the effect of rounding is told: the reach of a large plate in a cell."""
