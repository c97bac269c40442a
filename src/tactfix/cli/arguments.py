"""Text of arguments as values; what cannot be one is a usage error that names its option."""

import math

from tactfix.errors import UsageError


def vector(text: str, option: str) -> tuple[float, float, float]:
    """'x,y,z' as three finite numbers."""
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise UsageError(f"{option} {text!r} is not three numbers; write x,y,z such as 10,0,-2.5") from None
    if not all(map(math.isfinite, (x, y, z))):
        raise UsageError(f"{option} {text!r} is not finite; write x,y,z such as 10,0,-2.5")
    return x, y, z
