"""Poses in the formats of other programs: matrices, robot controllers, machine tools, ROS."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Final

from tactfix.errors import UsageError
from tactfix.formats import POSE_FORMATS
from tactfix.wording import did_you_mean

if TYPE_CHECKING:
    from tactfix.pose_formats.dialect import Dialect


class _Dialects(Mapping[str, "Dialect"]):
    """The dialects by name, built on first access: reading a pose from JSON does not import those of controllers."""

    def __init__(self) -> None:
        self._made: dict[str, Dialect] = {}

    def __getitem__(self, name: str) -> "Dialect":
        if name in POSE_FORMATS and name not in self._made:
            from tactfix.pose_formats.plain import PLAIN_DIALECTS

            self._made |= {dialect.name: dialect for dialect in PLAIN_DIALECTS}
            if name not in self._made:
                from tactfix.pose_formats.controllers import MACHINES, ROBOTS, ROS_LINES

                self._made |= {dialect.name: dialect for dialect in (*ROS_LINES, *ROBOTS, *MACHINES)}
        return self._made[name]

    def __contains__(self, name: object) -> bool:
        return name in POSE_FORMATS

    def __iter__(self) -> Iterator[str]:
        return iter(POSE_FORMATS)

    def __len__(self) -> int:
        return len(POSE_FORMATS)


DIALECTS: Final[Mapping[str, "Dialect"]] = _Dialects()
"""The dialects by name, in the order of POSE_FORMATS."""


def find_dialect(name: str) -> "Dialect":
    """The dialect of that name; UsageError with the nearest name if there is none."""
    if name not in DIALECTS:
        raise UsageError(f"there is no pose format {name!r}; {did_you_mean(name, DIALECTS)}")
    return DIALECTS[name]
