"""Names, file endings and limits of the formats of poses and contacts.

This is separate from the formats themselves (`pose_formats`, `files.logs`), which take long to import and are not
needed for help, JSON and contact files. mypy checks that every format has one of these names; a name without a format
fails at import.
"""

import math
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
"""Formats of poses, as in --format, --to and --from, in the order in which they are listed."""
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
"""The pose format of each file suffix."""

TEMPLATES: Final = ("cylinder-sphere", "three-spheres", "three-planes", "robot-cell-plate", "machine-tool-ball-bar")
"""The fixture files that come with tactfix."""
LEVER_ARM_MM: Final = 500.0
"""Distance from the fixture's origin at which the effect of rounding is given: half a metre, as on a large plate."""
LOCATE_SCHEMA: Final = "tactfix/locate/1"
"""Schema name of the JSON of `locate`, from which a pose can be read too."""
MOST_OFF_UNIT: Final = 1e-3
"""A quaternion printed with four digits is off by up to 1e-4 in length; anything worse is not a unit quaternion."""
MOST_RADIANS: Final = 2 * math.pi + 0.01
"""A full turn in rad, with a margin for rounding; a larger angle was probably written in degrees."""
