"""What a shell offers when it is asked to complete a value: formats, units, features, names."""

import os
from collections.abc import Callable, Iterator

from tactfix.errors import TactfixError
from tactfix.files.templates import TEMPLATES
from tactfix.formats import LOG_NAMES, POSE_FORMATS
from tactfix.units import UNITS


def pose_formats(incomplete: str) -> list[str]:
    """The formats of poses."""
    return [name for name in POSE_FORMATS if name.startswith(incomplete)]


def contact_formats(incomplete: str) -> list[str]:
    """The formats of contacts."""
    return [name for name in ("csv", *LOG_NAMES) if name.startswith(incomplete)]


def templates(incomplete: str) -> list[str]:
    """The fixture files to start from."""
    return [name for name in TEMPLATES if name.startswith(incomplete)]


def units(incomplete: str) -> list[str]:
    """The units of length."""
    return [unit for unit in UNITS if unit.startswith(incomplete)]


def unknowns(incomplete: str) -> list[str]:
    """What of the tip may be unknown."""
    return [what for what in ("tip", "tip-radius", "tip,tip-radius") if what.startswith(incomplete)]


def feature_runs(incomplete: str) -> list[str]:
    """bar: and ball: of --features bar:5,ball:3, from the fixture that stands on the line."""
    done, comma, begun = incomplete.rpartition(",")
    return [f"{done}{comma}{name}:" for name in _features() if name.startswith(begun)]


def names(*known: str) -> Callable[[str], list[str]]:
    """Offers these names."""

    def offer(incomplete: str) -> list[str]:
        return [name for name in known if name.startswith(incomplete)]

    return offer


def fault_names(incomplete: str) -> list[str]:
    """The mistakes that simulate makes."""
    from tactfix.mistakes import FAULT_KINDS

    return [name for name in FAULT_KINDS if name.startswith(incomplete)]


def json_commands(incomplete: str) -> list[str]:
    """The commands that print JSON."""
    from tactfix.report.json_schema import JSON_COMMANDS

    return [name for name in JSON_COMMANDS if name.startswith(incomplete)]


def finding_codes(incomplete: str) -> list[str]:
    """The findings of design-check that have an explanation."""
    from tactfix.explanations import explanations

    return [code for code in explanations("design") if code.startswith(incomplete)]


def verdict_codes(incomplete: str) -> list[str]:
    """The statuses, reasons and diagnoses of locate, which have an explanation."""
    from tactfix.explanations import explanations

    return [code for code in explanations("localization") if code.startswith(incomplete)]


def features(incomplete: str) -> list[str]:
    """The features of the fixture that stands on the line, or of the contact file."""
    return [name for name in (*_features(), *_touched()) if name.startswith(incomplete)]


def places(incomplete: str) -> list[str]:
    """The places of the cell file that stands on the line."""
    return [name for name in _keys("places") if name.startswith(incomplete)]


def free_directions(incomplete: str) -> list[str]:
    """x, y, z, rx, ry and rz, one after the other."""
    done, comma, begun = incomplete.rpartition(",")
    left = [name for name in ("x", "y", "z", "rx", "ry", "rz") if name not in done.split(",")]
    return [f"{done}{comma}{name}" for name in left if name.startswith(begun)]


def words_of_shell() -> list[str]:
    """The words of the line that a shell wants completed, without the program's name."""
    line = os.environ.get("_TYPER_COMPLETE_ARGS") or os.environ.get("COMP_WORDS", "")
    return line.split()[1:]


def _features() -> list[str]:
    """The features of the fixture file on the line."""
    return _keys("features")


def _touched() -> Iterator[str]:
    """The features that the contact file on the line names, in order; none where it cannot be read."""
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
    """The first file with such an ending on the line; empty where it cannot be read: this is no time to complain."""
    from tactfix.files.reading import decode, read_bytes

    # The arguments are not parsed yet where an option still waits for its value.
    path = next((word for word in words_of_shell() if word.endswith(endings)), None)
    try:
        return "" if path is None else decode(path, read_bytes(path))
    except TactfixError:
        return ""
