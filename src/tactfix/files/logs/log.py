"""The contacts of any machine log, functions that the readers share, and the options that change contacts.

Options leave out repetitions, give approaches, and apply the work offset.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, TypeAlias

import numpy as np

from tactfix.errors import Problem
from tactfix.files.contact_options import EVERY, Vector
from tactfix.formats import LogName
from tactfix.geometry.arrays import Floats
from tactfix.lexer import Lexer, TextError, text_lines
from tactfix.pose_formats.pose import Pose
from tactfix.units import factor
from tactfix.values import frozen_value

ONE_STATE_REMEDY: Final = "move it back, or log the contacts of one state in a file of their own"
_NORMAL_OFF_UNIT: Final = 0.01
"""Of the length of a normal that was printed with few digits; numbers of another kind are off by far more."""


@frozen_value
class LogContact:
    """One touch in a log: its line, and the numbers there in the log's own unit.

    point: tip centre or surface point, as the format has it; origin of the pose where rotation (3, 3) is given.
    approach: the probe's travel, into the material, any length but zero; None where the log does not give it.
    """

    line: int
    point: Vector
    approach: Vector | None = None
    rotation: Floats | None = None
    tip_radius: float | None = None
    id: str | None = None


@frozen_value
class Log:
    """All contacts of a log, in order. units: None where the format does not say. notes: what was passed over."""

    contacts: tuple[LogContact, ...]
    units: str | None = None
    notes: tuple[str, ...] = ()


LogReader: TypeAlias = Callable[[str, list[Problem]], Log]
"""The text of a log and a list for what is wrong with it -> what the log says."""


@frozen_value(eq=True)
class LogFormat:
    """A log format by name.

    compensated: whether its points may already be points of the surface, so that only an option can give the tip.
    frame: the frame that it reports in where somebody has to choose it, such as the active work coordinates; "" where
    the format itself fixes the frame.
    """

    name: LogName
    title: str
    read: LogReader
    compensated: bool = False
    frame: str = ""


@dataclass(slots=True)
class Standing:
    """States that must not change between the contacts of one log, by name: rotary axes, tool, frame, unit."""

    said: dict[str, tuple[object, int]] = field(default_factory=dict)

    def keep(self, what: str, value: object, lexer: Lexer, remedy: str = ONE_STATE_REMEDY) -> None:
        """Record the value of a state; a value that differs from the one before is an error, once for each change."""
        before, line = self.said.setdefault(what, (value, lexer.line))
        if before != value:
            self.said[what] = (value, lexer.line)
            lexer.refuse(f"{what} changes: {_shown(value)}, in line {line} {_shown(before)}", remedy)

    def notes(self, *names: str) -> tuple[str, ...]:
        """A note for each of names that stands at anything but zero."""
        said = {name: self.said[name][0] for name in names if name in self.said}
        return tuple(f"{name} stands at {_shown(value)} throughout" for name, value in said.items() if _says(value))


def _says(value: object) -> bool:
    return any(value) if isinstance(value, tuple) else bool(value)


def _shown(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(map(_shown, value)) or "none"
    return f"{value:g}" if isinstance(value, float) else str(value)


def read_lines(text: str, problems: list[Problem], read: Callable[[Lexer], None]) -> None:
    """Read each line that is not empty; a TextError becomes a problem, and reading goes on with the next line."""
    for number, line in enumerate(text_lines(text), 1):
        if line.strip():
            try_reading(Lexer(line, number), problems, read)


def try_reading(lexer: Lexer, problems: list[Problem], read: Callable[[Lexer], None]) -> None:
    """Read a text; a TextError becomes a problem."""
    try:
        read(lexer)
    except TextError as error:
        problems.append(error.problem)


def vector(numbers: Sequence[float]) -> Vector:
    """Three numbers as a vector."""
    x, y, z = numbers
    return x, y, z


def against(normal: Sequence[float]) -> Vector | None:
    """The approach against an outward normal; None for a normal of zeros, by which machines say that they know none."""
    if not any(normal):
        return None
    x, y, z = normal
    return 0.0 - x, 0.0 - y, 0.0 - z


def check_normal(lexer: Lexer, normal: Sequence[float], remedy: str) -> None:
    """Refuse a normal whose length is neither 1 nor 0: its numbers mean something else, or have decimal commas."""
    length = math.hypot(*normal)
    if length and abs(length - 1) > _NORMAL_OFF_UNIT:
        lexer.refuse(f"i, j, k have the length {length:.6g}, not 1", remedy)


def passed_over(lines: Iterable[int], what: str) -> tuple[str, ...]:
    """A note on lines without contacts, if there are any."""
    found = tuple(lines)
    if not found:
        return ()
    shown = ", ".join(map(str, found[:5])) + (", ..." if len(found) > 5 else "")
    return (f"{len(found)} {what} passed over (line {shown})",)


ONE_PLACE_MM: Final = 1.0
"""Consecutive touches nearer than this are of one place: a fast touch overruns by less, other places are farther."""


def last_of_each_place(contacts: Sequence[LogContact], units: str) -> tuple[tuple[LogContact, ...], tuple[str, ...]]:
    """Of consecutive touches of one place the last one; and a note for each that is left out."""
    near = ONE_PLACE_MM * factor("mm", units)
    kept: list[LogContact] = []
    notes = []
    for contact in contacts:
        if kept and np.linalg.norm(np.subtract(contact.point, kept[-1].point)) < near:
            notes.append(f"line {kept[-1].line}: the same place is touched again in line {contact.line}; dropped")
            kept.pop()
        kept.append(contact)
    return tuple(kept), tuple(notes)


def with_approaches(
    contacts: Sequence[LogContact], features: Sequence[str], approaches: Sequence[tuple[str, Vector]]
) -> tuple[LogContact, ...]:
    """The contacts, those without an approach with the one of their feature."""
    by_feature = dict(approaches)
    said = [by_feature.get(feature, by_feature.get(EVERY)) for feature in features]
    return tuple(
        contact if contact.approach is not None else replace(contact, approach=approach)
        for contact, approach in zip(contacts, said, strict=True)
    )


def in_base(contacts: Sequence[LogContact], base_from_reported: Pose) -> tuple[LogContact, ...]:
    """The contacts in the frame in which the work offset is written; all lengths in its units."""
    turn, shift = base_from_reported.rotation, base_from_reported.translation

    def moved(contact: LogContact) -> LogContact:
        approach, rotation = contact.approach, contact.rotation
        return replace(
            contact,
            point=vector((turn @ contact.point + shift).tolist()),
            approach=None if approach is None else vector((turn @ approach).tolist()),
            rotation=None if rotation is None else turn @ rotation,
        )

    return tuple(map(moved, contacts))
