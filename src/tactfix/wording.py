"""Text formatting shared by messages: lists of names, numbers with significant digits, the nearest name."""

import math
import re
from collections.abc import Iterable, Sequence
from typing import Final

UNPRINTABLE: Final = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
)
"""Characters that a terminal interprets or XML rejects: control characters, other line ends, bidirectional marks."""


def printable(text: str) -> str:
    """The text with unprintable characters as escapes."""
    return UNPRINTABLE.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def wrapped(text: str, width: int) -> str:
    """The text with lines of at most width characters, broken between words; continued lines are indented."""
    from textwrap import wrap

    return "".join(
        "\n".join(
            wrap(
                line,
                max(width, 20),
                subsequent_indent=" " * (len(line) - len(line.lstrip(" ")) + 2),
                break_long_words=False,
                break_on_hyphens=False,
            )
            if len(line) > width
            else [line.rstrip("\n")]
        )
        + "\n" * line.endswith("\n")
        for line in text.splitlines(keepends=True)
    )


_COMMENT_OPENS: Final = re.compile(r"(?:;|!|#|//|--) ")
"""The start of a comment in the programs of controllers."""


def wrapped_comments(text: str, width: int) -> str:
    """Comments no longer than width, each of their lines a comment; all other lines as they are.

    Lines of the program itself must stay whole, or they could not be copied from a terminal.
    """
    from textwrap import wrap

    lines = []
    for line in text.splitlines():
        mark = _COMMENT_OPENS.match(line)
        if mark is None or len(line) <= width:
            lines.append(line)
            continue
        room = max(width - mark.end(), 20)
        parts = wrap(line[mark.end() :], room, break_long_words=False, break_on_hyphens=False)
        lines += [mark[0] + part for part in parts]
    return "\n".join(lines) + "\n" * text.endswith("\n")


def spreadsheet_cell(text: str) -> str:
    """Text for a cell of a CSV file; an apostrophe keeps a spreadsheet from evaluating a formula."""
    return f"'{text}" if text.startswith(("=", "+", "-", "@", "\t", "\r")) else text


def did_you_mean(wrong: str, known: Iterable[str]) -> str:
    """The advice "did you mean 'ball'?" if a name is similar, else "use one of: ball, bar"."""
    # difflib is imported only for an error, so that valid files load faster.
    from difflib import get_close_matches

    names = list(known)
    if not names:
        return "there are none to choose from"
    by_lower = {name.lower(): name for name in reversed(names)}
    near = get_close_matches(wrong.strip().lower(), by_lower, n=1, cutoff=0.6)
    return f"did you mean {by_lower[near[0]]!r}?" if near else f"use one of: {', '.join(names)}"


def decimals(sigma: float) -> int:
    """Decimals that show a number to a hundredth of its sigma; 6 if sigma is 0."""
    return 6 if sigma <= 0 else max(0, min(12, 2 - math.ceil(math.log10(sigma))))


def fixed(value: float, digits: int) -> str:
    """A number with this many decimals; zero has no sign."""
    return f"{round(float(value), digits) + 0.0:.{digits}f}"


def borne(value: float, sigma: float | None, sign: str = "") -> str:
    """A number with decimals down to a hundredth of its sigma, never in powers of ten; sign: "+" to show every sign.

    Without sigma: at most six decimals, or six digits of a smaller number.
    """
    if sigma is not None and sigma > 0:
        number = fixed(value, decimals(sigma))
    else:
        # In m, a length may be less than a millionth.
        size = abs(float(value))
        digits = 6 if size == 0 else min(12, max(6, 5 - math.floor(math.log10(size))))
        number = fixed(value, digits).rstrip("0").rstrip(".")
    return number if number.startswith("-") else sign + number


def with_unit(text: str, unit: str | None) -> str:
    """The text and its unit, if any."""
    return f"{text} {unit}" if unit else text


def coordinates(values: Sequence[float], sigma: float) -> str:
    """x 534.1 y -162.8 z 136.3: decimals down to a tenth of sigma."""
    digits = max(0, decimals(sigma) - 1)
    return " ".join(f"{axis} {fixed(value, digits)}" for axis, value in zip("xyz", values, strict=True))


def listed(names: Sequence[str]) -> str:
    """Names as a sentence lists them: a, b and c."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
