"""A machine log as a contact file: CSV that locate reads without options."""

import csv
import io
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

from tactfix.files.logs.load import LogContacts
from tactfix.pose_formats import DIALECTS
from tactfix.wording import spreadsheet_cell

_FORMAT_ORIENTATIONS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {"ur": ("rx", "ry", "rz"), "kuka": ("a", "b", "c"), "abb": ("qw", "qx", "qy", "qz"), "fanuc": ("w", "p", "r")}
)
"""The columns of a contact file that hold the orientation of a format in its own numbers."""


def contact_csv(read: LogContacts) -> str:
    """The text of a contact file; tip_radius and sigma are left out if not given.

    Numbers are written so that they read back as the same doubles; the id of a contact is
    its line in the log if the log does not name it. Points are tip centres or surface points; orientations are kept.
    """
    buffer = io.StringIO()
    offset = None if read.tip_offset is None else ", ".join(map(repr, read.tip_offset))
    settings = (("units", read.units), ("tip_radius", read.tip_radius), ("sigma", read.sigma), ("tip_offset", offset))
    for key, value in settings:
        if value is not None:
            buffer.write(f"# {key}: {value}\n")
    is_known = np.asarray(np.isfinite(read.approaches).all(axis=1))
    names, orientations = _orientations(read)
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(["feature", "x", "y", "z", *(["ax", "ay", "az"] if is_known.any() else []), *names, "id"])
    for i, contact in enumerate(read.contacts):
        approach = (read.approaches[i].tolist() if is_known[i] else [""] * 3) if is_known.any() else []
        row = [spreadsheet_cell(read.features[i]), *read.points[i].tolist(), *approach, *orientations[i]]
        writer.writerow([*row, spreadsheet_cell(contact.id or f"line {contact.line}")])
    return buffer.getvalue()


def _orientations(read: LogContacts) -> tuple[tuple[str, ...], list[list[float]]]:
    """The names of the orientation columns and their numbers in each row; empty if the log has no poses."""
    numbers, rotations = DIALECTS.get(read.format_name), read.rotations
    if numbers is None or numbers.numbers is None or rotations is None or read.format_name not in _FORMAT_ORIENTATIONS:
        return (), [[]] * len(read.contacts)
    orientation = numbers.numbers.orientation
    return _FORMAT_ORIENTATIONS[read.format_name], [orientation.numbers(rotation).tolist() for rotation in rotations]
