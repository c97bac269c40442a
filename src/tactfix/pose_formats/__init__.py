"""Poses in the formats of other programs: matrices, robot controllers, machine tools, ROS."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from tactfix.formats import POSE_FORMATS
from tactfix.pose_formats.controllers import MACHINES, ROBOTS, ROS_LINES
from tactfix.pose_formats.dialect import Dialect
from tactfix.pose_formats.plain import PLAIN_DIALECTS, ROS_MESSAGE

_DIALECTS_MADE: Final = {
    dialect.name: dialect for dialect in (*PLAIN_DIALECTS, ROS_MESSAGE, *ROS_LINES, *ROBOTS, *MACHINES)
}
DIALECTS: Final[Mapping[str, Dialect]] = MappingProxyType({name: _DIALECTS_MADE[name] for name in POSE_FORMATS})
"""The dialect of each name, in the order in which they are listed."""
