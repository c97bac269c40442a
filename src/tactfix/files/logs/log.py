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
"""Tolerance of the length of a unit normal printed with few digits; numbers that are no normal miss 1 by far more."""


@frozen_value
class LogContact:
    """One touch in a log: its line number, and its values in the log's unit.

    point (3,): tip centre or surface point, depending on the format; origin of the pose if rotation (3, 3) is given.
    approach (3,): direction of probe travel, into the material, any non-zero length; None if the log does not give it.
    """

    line: int
    point: Vector
    approach: Vector | None = None
    rotation: Floats | None = None
    tip_radius: float | None = None
    id: str | None = None


@frozen_value
class Log:
    """All contacts of a log, in order. units: None if not given. notes: warnings, such as skipped lines."""

    contacts: tuple[LogContact, ...]
    units: str | None = None
    notes: tuple[str, ...] = ()


LogReader: TypeAlias = Callable[[str, list[Problem]], Log]
"""Reader of a format: the text of a log, and a list to which problems are appended -> Log."""


@frozen_value(eq=True)
class LogFormat:
    """A log format by name.

    compensated: whether its points may already be tip-compensated surface points, so that only an option can give the
    tip radius. frame: the frame of its points if the user selects it, such as the active work coordinates; "" if the
    format fixes it.
    """

    name: LogName
    title: str
    read: LogReader
    compensated: bool = False
    frame: str = ""


@dataclass(slots=True)
class ConstantStates:
    """States that must not change between the contacts of one log, by name: rotary axes, tool, frame, unit."""

    values: dict[str, tuple[object, int]] = field(default_factory=dict)

    def keep(self, state: str, value: object, lexer: Lexer, remedy: str = ONE_STATE_REMEDY) -> None:
        """Record the value of a state; a change of the value is an error, reported once per change."""
        before, line = self.values.setdefault(state, (value, lexer.line))
        if before != value:
            self.values[state] = (value, lexer.line)
            lexer.refuse(f"{state} changes: {_shown(value)}, in line {line} {_shown(before)}", remedy)

    def notes(self, *names: str) -> tuple[str, ...]:
        """A note for each state among names whose value is not zero."""
        values = {name: self.values[name][0] for name in names if name in self.values}
        return tuple(f"{name} is {_shown(value)} throughout" for name, value in values.items() if _says(value))


def _says(value: object) -> bool:
    return any(value) if isinstance(value, tuple) else bool(value)


def _shown(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(map(_shown, value)) or "none"
    return f"{value:g}" if isinstance(value, float) else str(value)


def read_lines(text: str, problems: list[Problem], read: Callable[[Lexer], None]) -> None:
    """Read each non-empty line; a TextError is appended to problems, and reading continues with the next line."""
    for number, line in enumerate(text_lines(text), 1):
        if line.strip():
            try_reading(Lexer(line, number), problems, read)


def try_reading(lexer: Lexer, problems: list[Problem], read: Callable[[Lexer], None]) -> None:
    """Read a text; a TextError is appended to problems."""
    try:
        read(lexer)
    except TextError as error:
        problems.append(error.problem)


def vector(numbers: Sequence[float]) -> Vector:
    """Three numbers as a vector."""
    x, y, z = numbers
    return x, y, z


def against(normal: Sequence[float]) -> Vector | None:
    """The approach opposite to an outward normal; None for a zero normal, which machines print if it is unknown."""
    if not any(normal):
        return None
    x, y, z = normal
    return 0.0 - x, 0.0 - y, 0.0 - z


def check_normal(lexer: Lexer, normal: Sequence[float], remedy: str) -> None:
    """Reject a normal whose length is neither 1 nor 0: its numbers are something else, or have decimal commas."""
    length = math.hypot(*normal)
    if length and abs(length - 1) > _NORMAL_OFF_UNIT:
        lexer.refuse(f"i, j, k have the length {length:.6g}, not 1", remedy)


def skipped(lines: Iterable[int], kind: str) -> tuple[str, ...]:
    """A note on lines without contacts, if there are any."""
    found = tuple(lines)
    if not found:
        return ()
    shown = ", ".join(map(str, found[:5])) + (", ..." if len(found) > 5 else "")
    return (f"{len(found)} {kind} skipped (line {shown})",)


ONE_PLACE_MM: Final = 1.0
"""Consecutive touches closer than this repeat one point: the overtravel of a fast touch is less, distinct points are
farther apart."""


def last_of_each_place(contacts: Sequence[LogContact], units: str) -> tuple[tuple[LogContact, ...], tuple[str, ...]]:
    """The last of each run of consecutive touches of one point, and a note for each touch left out."""
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
    """The contacts; one without an approach gets that of its feature."""
    by_feature = dict(approaches)
    by_contact = [by_feature.get(feature, by_feature.get(EVERY)) for feature in features]
    return tuple(
        contact if contact.approach is not None else replace(contact, approach=approach)
        for contact, approach in zip(contacts, by_contact, strict=True)
    )


def in_base(contacts: Sequence[LogContact], base_from_reported: Pose) -> tuple[LogContact, ...]:
    """The contacts in the frame that the work offset is relative to; all lengths in its units."""
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
