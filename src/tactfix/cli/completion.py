"""What a shell offers when it is asked to complete a value: formats, units, features."""

import os
from collections.abc import Iterator

from tactfix.errors import TactfixError
from tactfix.files.templates import TEMPLATES
from tactfix.units import UNITS


def pose_formats(incomplete: str) -> list[str]:
    """The formats of poses."""
    from tactfix.pose_formats import DIALECTS

    return [name for name in DIALECTS if name.startswith(incomplete)]


def contact_formats(incomplete: str) -> list[str]:
    """The formats of contacts."""
    from tactfix.files.logs import LOG_FORMATS

    return [name for name in ("csv", *LOG_FORMATS) if name.startswith(incomplete)]


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


def words_of_shell() -> list[str]:
    """The words of the line that a shell wants completed, without the program's name."""
    line = os.environ.get("_TYPER_COMPLETE_ARGS") or os.environ.get("COMP_WORDS", "")
    return line.split()[1:]


def _features() -> Iterator[str]:
    """The features of the fixture file; none where it cannot be read, for this is no time to complain."""
    from tactfix.files.reading import decode, read_bytes
    from tactfix.yaml_tree import read_tree

    # The arguments are not parsed yet where an option still waits for its value.
    path = next((word for word in words_of_shell() if word.endswith((".yaml", ".yml"))), None)
    if path is not None:
        try:
            value = read_tree(decode(path, read_bytes(path))).value
        except TactfixError:
            return
        features = value.get("features") if isinstance(value, dict) else None
        yield from features if isinstance(features, dict) else ()
