"""Logs of robots: one pose a line in the controller's own literal, or its six numbers alone."""

from collections.abc import Sequence

from tactfix.errors import Problem
from tactfix.files.logs.log import Log, LogContact, LogReader, numbers_in, vector
from tactfix.geometry.arrays import Floats
from tactfix.pose_formats import DIALECTS
from tactfix.pose_formats.dialect import Numbers
from tactfix.pose_formats.pose import PoseSyntaxError


def pose_line_reader(name: str) -> LogReader:
    """A reader of the pose lines of dialect name, in its unit and convention.

    A line is the literal (p[...] or {X ...}) or the numbers in the same order with commas, semicolons or blanks
    between; a first line that names the columns is passed over. The pose is that of the tool, its origin the tip's
    centre; or that of the flange, where the caller knows the offset of the tip.
    """
    dialect = DIALECTS[name]
    numbers = dialect.numbers
    assert numbers is not None

    def read(lines: Sequence[str], problems: list[Problem]) -> Log:
        contacts: list[LogContact] = []
        header = [label.lower() for label in numbers.labels]
        for number, line in enumerate(lines, 1):
            words = line.replace(",", " ").replace(";", " ").split()
            if not words or line.lstrip().startswith("#") or [word.lower() for word in words] == header:
                continue
            try:
                pose = _pose(numbers, words) if len(words) == len(header) else None
                pose = dialect.read(line).base_from_fixture if pose is None else pose
            except PoseSyntaxError as error:
                problems.extend(Problem(p.what, p.remedy, line=number) for p in error.problems)
                continue
            contacts.append(LogContact(number, vector(pose[:3, 3].tolist()), rotation=pose[:3, :3]))
        return Log(tuple(contacts), numbers.units)

    return read


def _pose(numbers: Numbers, words: Sequence[str]) -> Floats | None:
    """The pose that bare numbers say, None where the words are not bare numbers."""
    import numpy as np

    values = numbers_in(words, len(numbers.labels))
    return None if values is None else numbers.pose(np.array(values))
