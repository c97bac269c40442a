"""Units of length, and the factors between them. Angles are degrees outside and radians inside."""

from typing import Final, Literal, TypeAlias, get_args

Unit: TypeAlias = Literal["mm", "m", "um", "in"]

UNITS: Final[tuple[str, ...]] = get_args(Unit)

# As whole numbers of the largest length that divides them all, a tenth of a micrometre, so that ratios are exact.
_UNIT_LENGTHS: Final[dict[str, int]] = {"mm": 10_000, "m": 10_000_000, "um": 10, "in": 254_000}


LEAST_LENGTH: Final = 1e-30
"""Lengths in files and arguments are between these two, so that squares and ratios of lengths are finite doubles."""
MOST_LENGTH: Final = 1e30
"""See LEAST_LENGTH."""


def factor(source: str, target: str) -> float:
    """The factor that converts a length from source to target; the double nearest to the exact ratio.

    Raises KeyError for a unit that is not one of UNITS.
    """
    return _UNIT_LENGTHS[source] / _UNIT_LENGTHS[target]


def which_unit(written: str) -> str:
    """The remedy for a unit that is not one of UNITS."""
    plain = written.strip().lower().removesuffix(".").removesuffix("s")
    for unit, names in _ALSO.items():
        if plain == unit or plain in names:
            return f"did you mean {unit!r}?"
    return f"use one of: {', '.join(UNITS)}"


_ALSO: Final[dict[str, tuple[str, ...]]] = {
    "mm": ("millimeter", "millimetre"),
    "m": ("meter", "metre"),
    "um": ("\u00b5m", "\u03bcm", "micron", "micrometer", "micrometre"),
    "in": ("inch", "inche", '"'),
}
