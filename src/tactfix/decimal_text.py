"""Decimal numbers in text: ASCII digits, a point, an exponent.

float() accepts more: 1_0, digits of other scripts, nan, inf and four hundred digits. These are rejected here.
"""

import re
from typing import Final

from tactfix.units import MOST_LENGTH

MOST_CHARACTERS: Final = 100
"""A double has 17 digits; a longer text is not a number."""
FIXED_POINT: Final = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)")
"""A number without an exponent."""
NUMBER: Final = re.compile(rf"{FIXED_POINT.pattern}(?:[eE][-+]?[0-9]+)?")
"""A number with or without an exponent; without capture groups, so that grammars can embed it."""

DECIMAL_COMMA: Final = re.compile(r"[-+]?[0-9]{0,20},[0-9]{1,20}")
"""A number with a decimal comma."""


def number_of(text: str) -> float | None:
    """The number in text; None if it is not a decimal number, or above 1e30."""
    if len(text) > MOST_CHARACTERS or not NUMBER.fullmatch(text):
        return None
    value = float(text)
    return value if abs(value) <= MOST_LENGTH else None


def numbers_of(text: str) -> list[float | None]:
    """The numbers in text, separated by commas; None for a part that is not a number."""
    return [number_of(part.strip()) for part in text.split(",")]
