"""Units of length, and the factors between them. Angles are degrees outside and radians inside."""

from fractions import Fraction
from typing import Final, Literal, TypeAlias, get_args

Unit: TypeAlias = Literal["mm", "m", "um", "in"]

UNITS: Final[tuple[str, ...]] = get_args(Unit)

_METRES: Final[dict[str, Fraction]] = {
    "mm": Fraction(1, 1000),
    "m": Fraction(1),
    "um": Fraction(1, 1_000_000),
    "in": Fraction(254, 10_000),
}


def factor(source: str, target: str) -> float:
    """What a length in source is multiplied by to be in target; the double nearest to the exact ratio.

    Raises KeyError for a unit that is not one of UNITS.
    """
    return float(_METRES[source] / _METRES[target])
