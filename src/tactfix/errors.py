"""Everything that tactfix raises on purpose.

One base, few subclasses. An error has its facts as attributes, and its text gives the remedy. Only `tactfix.cli`
knows exit codes; nothing else catches more than these.
"""

import re
from collections.abc import Sequence
from typing import Final

from tactfix.settings import joined, on_command_line
from tactfix.values import frozen_value


class TactfixError(Exception):
    """Base of every error that tactfix raises on purpose.

    Attributes
    ----------
    on_command_line : str
        Its text with settings as command-line options; str() names them as keyword arguments.
    """

    @property
    def on_command_line(self) -> str:
        """The text with settings as options."""
        return on_command_line(self.args[0]) if self.args else ""


@frozen_value(eq=True)
class Problem:
    """One thing wrong in a file: where, what, and what to do instead.

    Parameters
    ----------
    what : str
        What is wrong.
    remedy : str
        What to do instead.
    line, column : int, optional
        Of the file, counted from 1; None if not applicable.
    row : int, optional
        Of the data rows of a contact file, counted from 1.

    Examples
    --------
    >>> print(tactfix.Problem("sigma is 0", "write a number above 0", line=3))
    line 3: sigma is 0; write a number above 0
    """

    what: str
    remedy: str
    line: int | None = None
    column: int | None = None
    row: int | None = None

    @property
    def text(self) -> str:
        """Place, what and remedy in one line."""
        place = [f"{word} {n}" for word, n in (("row", self.row), ("line", self.line), ("column", self.column)) if n]
        return (f"{', '.join(place)}: " if place else "") + self.what + "; " + self.remedy

    def __str__(self) -> str:
        return str(self.text)


class FileError(TactfixError):
    """A file cannot be read or its content is invalid. Has all problems of that file at once.

    Parameters
    ----------
    path : str
        The file name as given.
    problems : sequence of Problem
        All problems of the file.

    Attributes
    ----------
    lines : tuple of str
        The problems for display: one line for a mistake repeated in many rows, and a limited number of lines.
    """

    def __init__(self, path: str, problems: Sequence[Problem]) -> None:
        self.path = path
        self.problems = tuple(problems)
        self.lines = tuple(_lines(self.problems))
        super().__init__(joined("\n", [f"{path}: " + line for line in self.lines]))


PROBLEMS_LISTED: Final = 20
"""Problems of one file that are listed at most."""
_MANY_PROBLEMS: Final = 4
"""Number of problems of one kind from which only the first is listed, with their number."""
_VALUE: Final = re.compile(r"^(\S+ is )('(?:[^'\\]|\\.)*'|[^\s,]+)")
"""The value in a message: problems that differ only in it are of one kind."""


def _lines(problems: Sequence[Problem]) -> list[str]:
    kinds: dict[tuple[str, str], list[Problem]] = {}
    for problem in problems:
        kinds.setdefault((_VALUE.sub(r"\1...", problem.what), problem.remedy), []).append(problem)
    lines: list[str] = []
    for problem in problems:
        kind = kinds[_VALUE.sub(r"\1...", problem.what), problem.remedy]
        if len(kind) < _MANY_PROBLEMS:
            lines.append(problem.text)
        elif problem is kind[0]:
            lines.append(problem.text + f"; the same in {len(kind)} {'rows' if problem.row else 'places'}")
    if len(lines) <= PROBLEMS_LISTED:
        return lines
    return [*lines[:PROBLEMS_LISTED], f"{len(lines) - PROBLEMS_LISTED} more problems; correct the ones above first"]


class UsageError(TactfixError):
    """Inconsistent arguments, or an invalid value; the message says what to write."""


class DegenerateContactsError(TactfixError):
    """The contacts are degenerate: infinitely many surfaces pass through them.

    Parameters
    ----------
    kind : str
        The surface sought.
    reason : str
        How the contacts are arranged.
    ratio, limit : float
        The dimensionless quantity that was tested, and the limit that it violates.
    remedy : str
        Where to touch instead.
    """

    def __init__(self, kind: str, reason: str, ratio: float, limit: float, remedy: str) -> None:
        self.kind, self.reason, self.ratio, self.limit, self.remedy = kind, reason, ratio, limit, remedy
        super().__init__(f"{kind}: {reason} (ratio {ratio:.2g}, limit {limit:.2g}); {remedy}")


class NotQualifiedError(TactfixError):
    """The touches are too few, or too badly distributed, to qualify the probe."""


class TipDoesNotFitError(TactfixError):
    """The tip is not smaller than the bore that the contacts name.

    Parameters
    ----------
    feature : str
        The bore.
    radius, tip_radius : float
        Of the bore and of the tip, in one unit.
    """

    def __init__(self, feature: str, radius: float, tip_radius: float) -> None:
        self.feature, self.radius, self.tip_radius = feature, radius, tip_radius
        super().__init__(
            f"{feature}: a tip of radius {tip_radius:g} does not fit into an inner surface of radius {radius:g}; "
            f"check tip_radius, the radius and the side of {feature}"
        )


class NotLocatedError(TactfixError):
    """A pose is requested from a result without one.

    Parameters
    ----------
    fixture, status : str
        Of the result.
    """

    def __init__(self, fixture: str, status: str) -> None:
        self.fixture, self.status = fixture, status
        super().__init__(f"{fixture} is {status}: there is no pose; ask for status, warnings and free_motions instead")


class OtherFixtureError(TactfixError):
    """The two poses to compare belong to different fixtures.

    Parameters
    ----------
    expected, found : str
        Their names.
    """

    def __init__(self, expected: str, found: str) -> None:
        self.expected, self.found = expected, found
        super().__init__(
            f"one pose is of the fixture {expected!r}, the other of {found!r}: they cannot be compared; "
            f"give a pose of {expected!r}"
        )


class PoseRefusedError(TactfixError):
    """A pose cannot be written in a format without losing more than its own uncertainty allows.

    Parameters
    ----------
    dialect : str
        The format.
    reason, remedy : str
        What is lost, and what to do instead.
    """

    def __init__(self, dialect: str, reason: str, remedy: str) -> None:
        self.dialect, self.reason, self.remedy = dialect, reason, remedy
        super().__init__(f"{dialect}: {reason}; " + remedy)


class MissingExtraError(TactfixError):
    """An optional extra that is needed is not installed.

    Parameters
    ----------
    extra, purpose : str
        Its name, and what it is needed for.
    """

    def __init__(self, extra: str, purpose: str) -> None:
        self.extra, self.purpose = extra, purpose
        super().__init__(f"{purpose} needs the extra '{extra}'; in the folder of tactfix: pip install '.[{extra}]'")
