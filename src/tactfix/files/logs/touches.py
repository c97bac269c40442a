"""Touches of a log with what the options say: repetitions left out, approaches given, the work offset undone."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from tactfix.files.log_options import EVERY
from tactfix.files.logs.log import LogContact, Vector, vector
from tactfix.pose_formats.pose import Pose
from tactfix.units import factor

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
