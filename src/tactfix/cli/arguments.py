"""Text of arguments as values; what cannot be one is a usage error that names its option."""

from typing import TYPE_CHECKING, Final

from tactfix.decimal_text import numbers_of
from tactfix.errors import UsageError

if TYPE_CHECKING:
    from tactfix.contacts import Unknown

UNKNOWN_CHOICES: Final[dict[str, "Unknown"]] = {"tip": "tip", "tip-radius": "tip-radius"}


def vector(text: str, option: str) -> tuple[float, float, float]:
    """'x,y,z' as three numbers, none beyond 1e30."""
    numbers = numbers_of(text)
    x, y, z = numbers if len(numbers) == 3 else (None, None, None)
    if x is None or y is None or z is None:
        raise UsageError(f"{option} {text!r} is not three numbers; write x,y,z such as 10,0,-2.5")
    return x, y, z


def unknowns(text: str | None) -> "frozenset[Unknown]":
    """'tip', 'tip-radius' or both, divided by a comma; nothing where None."""
    names = [] if text is None else [part.strip() for part in text.split(",")]
    for name in names:
        if name not in UNKNOWN_CHOICES:
            raise UsageError(f"--unknown {name!r}: write tip, tip-radius, or tip,tip-radius")
    return frozenset(UNKNOWN_CHOICES[name] for name in names)
