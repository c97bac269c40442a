"""What any machine log says, as far as it says it; and the words that readers of logs share."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

from tactfix.errors import Problem
from tactfix.geometry.arrays import Floats

NUMBER: Final = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_NUMBER_ALONE: Final = re.compile(NUMBER)

Vector: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class LogContact:
    """One touch in a log: the line it stands in, and what that says in the log's own unit.

    point: tip centre or surface point, as the format has it; origin of the pose where rotation (3, 3) is given.
    approach: the probe's travel, into the material, any length but zero; None where the log does not tell it.
    """

    line: int
    point: Vector
    approach: Vector | None = None
    rotation: Floats | None = None
    tip_radius: float | None = None
    id: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Log:
    """All contacts of a log, in order. units: None where the format does not say. notes: what was passed over."""

    contacts: tuple[LogContact, ...]
    units: str | None = None
    notes: tuple[str, ...] = ()


LogReader: TypeAlias = Callable[[Sequence[str], list[Problem]], Log]
"""Lines of a log and a list for what is wrong with them -> what the log says."""


@dataclass(frozen=True, slots=True)
class LogFormat:
    """A log format by name.

    compensated: whether its points may already be points of the surface, so that only an option can tell the tip.
    """

    name: str
    title: str
    read: LogReader
    compensated: bool = False


def numbers_in(words: Sequence[str], count: int) -> tuple[float, ...] | None:
    """The words as finite numbers, or None when one is not a plain number or there are not count of them."""
    if len(words) != count or not all(_NUMBER_ALONE.fullmatch(word.strip()) for word in words):
        return None
    numbers = tuple(float(word) for word in words)
    return numbers if all(map(math.isfinite, numbers)) else None


def vector(numbers: Sequence[float]) -> Vector:
    """Three numbers as a vector."""
    x, y, z = numbers
    return x, y, z


def against(normal: Sequence[float]) -> Vector | None:
    """The approach against an outward normal; None for a normal of zeros, by which machines say that they know none."""
    if not any(normal):
        return None
    x, y, z = normal
    return -x, -y, -z


def passed_over(lines: Sequence[int], what: str) -> tuple[str, ...]:
    """A note on lines that say nothing of contacts; none when there are none."""
    if not lines:
        return ()
    shown = ", ".join(map(str, lines[:5])) + (", ..." if len(lines) > 5 else "")
    return (f"{len(lines)} {what} passed over (line {shown})",)
