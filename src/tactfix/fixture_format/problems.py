"""One thing that a fixture file says and should not, by its path in the file; the file layer knows the line."""

from typing import TypeAlias

from tactfix.values import frozen_value

Path: TypeAlias = tuple[str | int, ...]
"""Keys and indices from the root of the file to a value."""


@frozen_value(eq=True)
class Finding:
    """What is wrong and what to do instead; at_key: it is the key itself that is wrong, not its value."""

    path: Path
    what: str
    remedy: str
    at_key: bool = False
