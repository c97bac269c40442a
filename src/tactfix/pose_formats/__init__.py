"""Poses in the words of those who use them: matrices, robot controllers, machine tools, ROS."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from tactfix.pose_formats.controllers import MACHINES, ROBOTS, ROS_LINES
from tactfix.pose_formats.dialect import Dialect
from tactfix.pose_formats.plain import PLAIN, ROS_MESSAGE

DIALECTS: Final[Mapping[str, Dialect]] = MappingProxyType(
    {dialect.name: dialect for dialect in (*PLAIN, ROS_MESSAGE, *ROS_LINES, *ROBOTS, *MACHINES)}
)

SUFFIXES: Final[Mapping[str, str]] = MappingProxyType(
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
