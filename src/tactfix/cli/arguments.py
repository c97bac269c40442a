"""Text of arguments as values; what cannot be one is a usage error that names its option."""

import math
from typing import TYPE_CHECKING, Final

from tactfix.errors import UsageError

if TYPE_CHECKING:
    from tactfix.contacts import Unknown

UNKNOWN: Final[dict[str, "Unknown"]] = {"tip": "tip", "tip-radius": "tip-radius"}


def vector(text: str, option: str) -> tuple[float, float, float]:
    """'x,y,z' as three finite numbers."""
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise UsageError(f"{option} {text!r} is not three numbers; write x,y,z such as 10,0,-2.5") from None
    if not all(map(math.isfinite, (x, y, z))):
        raise UsageError(f"{option} {text!r} is not finite; write x,y,z such as 10,0,-2.5")
    return x, y, z


def unknowns(text: str | None) -> "frozenset[Unknown]":
    """'tip', 'tip-radius' or both, divided by a comma; nothing where None."""
    names = [] if text is None else [part.strip() for part in text.split(",")]
    for name in names:
        if name not in UNKNOWN:
            raise UsageError(f"--unknown {name!r}: write tip, tip-radius, or tip,tip-radius")
    return frozenset(UNKNOWN[name] for name in names)
