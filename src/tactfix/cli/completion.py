"""The values that shell completion offers: formats, units, features, names."""

import os
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING

from tactfix.errors import TactfixError
from tactfix.formats import LOG_NAMES, POSE_FORMATS, TEMPLATES
from tactfix.units import UNITS

if TYPE_CHECKING:
    from tactfix.explanations import Room


def offers(names: Callable[[], Iterable[str]]) -> Callable[[str], list[str]]:
    """A function that offers the names that begin like an incomplete word."""

    def offer(incomplete: str) -> list[str]:
        return [name for name in names() if name.startswith(incomplete)]

    return offer


def _fault_names() -> Iterable[str]:
    from tactfix.mistakes import FAULT_KINDS

    return FAULT_KINDS


def _json_commands() -> Iterable[str]:
    from tactfix.report.json_schema import JSON_COMMANDS

    return JSON_COMMANDS


def _codes(room: "Room") -> Iterable[str]:
    from tactfix.explanations import explanations

    return explanations(room)


pose_formats = offers(lambda: POSE_FORMATS)
contact_formats = offers(lambda: ("csv", *LOG_NAMES))
log_formats = offers(lambda: LOG_NAMES)
templates = offers(lambda: TEMPLATES)
units = offers(lambda: UNITS)
unknowns = offers(lambda: ("tip", "tip-radius", "tip,tip-radius"))
repeats = offers(lambda: ("all", "last"))
fault_names = offers(_fault_names)
json_commands = offers(_json_commands)
finding_codes = offers(lambda: _codes("design"))
verdict_codes = offers(lambda: _codes("localization"))
features = offers(lambda: (*_keys("features"), *_touched()))
places = offers(lambda: _keys("places"))


def feature_runs(incomplete: str) -> list[str]:
    """bar: and ball: of --features bar:5,ball:3, from the fixture file on the line."""
    done, comma, begun = incomplete.rpartition(",")
    return [f"{done}{comma}{name}:" for name in _keys("features") if name.startswith(begun)]


def free_directions(incomplete: str) -> list[str]:
    """x, y, z, rx, ry and rz, one after the other."""
    done, comma, begun = incomplete.rpartition(",")
    left = [name for name in ("x", "y", "z", "rx", "ry", "rz") if name not in done.split(",")]
    return [f"{done}{comma}{name}" for name in left if name.startswith(begun)]


def words_of_shell() -> list[str]:
    """The words of the line that a shell wants completed, without the program's name."""
    line = os.environ.get("_TYPER_COMPLETE_ARGS") or os.environ.get("COMP_WORDS", "")
    return line.split()[1:]


def _touched() -> Iterator[str]:
    """The features that the contact file on the line names, in order; none if it cannot be read."""
    from tactfix.files.contact_header import split_header

    text = _text_of((".csv", ".txt"))
    rows = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    separator, names = split_header(rows[0], "feature".__eq__) if rows else (",", [])
    if "feature" in names:
        column = names.index("feature")
        table = [[cell.strip() for cell in row.split(separator)] for row in rows[1:]]
        yield from dict.fromkeys(row[column] for row in table if len(row) > column)


def _keys(section: str) -> list[str]:
    """The names in a section of the fixture or cell file on the line."""
    from tactfix.yaml_tree import read_tree

    text = _text_of((".yaml", ".yml"))
    if not text:
        return []
    try:
        value = read_tree(text).value
    except TactfixError:
        return []
    found = value.get(section) if isinstance(value, dict) else None
    return list(found) if isinstance(found, dict) else []


def _text_of(endings: tuple[str, ...]) -> str:
    """The text of the first file with such an ending on the line; empty if it cannot be read, without an error."""
    from tactfix.files.reading import decode, read_bytes

    # The arguments are not parsed yet while an option still needs its value.
    path = next((word for word in words_of_shell() if word.endswith(endings)), None)
    try:
        return "" if path is None else decode(path, read_bytes(path))
    except TactfixError:
        return ""
