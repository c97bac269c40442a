"""The contact sets named on a command line: contact files, directories of them, and tables with a set column."""

import io
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field, replace
from pathlib import Path
from typing import Final, Protocol

from tactfix.batching.task import ContactSet
from tactfix.contacts import Contacts
from tactfix.errors import FileError, Problem, UsageError
from tactfix.files.contact_file import read_contact_file
from tactfix.files.contact_options import ContactOptions, LogOptions
from tactfix.files.reading import decode, near_name, read_bytes, read_source
from tactfix.files.table_file import csv_table, is_table, parquet_table
from tactfix.fixture import Fixture
from tactfix.settings import FOR_LOGS
from tactfix.values import frozen_value

_ENDINGS: Final = (".csv", ".tsv", ".txt")
"""Extensions of contact files in a directory."""
_HEADER_BYTES: Final = 1 << 16
"""The header row of a table must begin within this number of bytes."""


class Part(Protocol):
    """Some of the sets, in order; each is read when iterated over."""

    def __len__(self) -> int:
        """How many sets."""

    def __iter__(self) -> Iterator[ContactSet]:
        """The sets."""


@frozen_value(eq=True)
class ContactSets:
    """All sets of a batch, in order."""

    parts: tuple[Part, ...]

    def __len__(self) -> int:
        return sum(map(len, self.parts))

    def __iter__(self) -> Iterator[ContactSet]:
        for part in self.parts:
            yield from part


@frozen_value(eq=True)
class FileSets:
    """One set for each file, named by its path; a file that cannot be read is a set with its error."""

    paths: tuple[Path, ...]

    def __len__(self) -> int:
        return len(self.paths)

    def __iter__(self) -> Iterator[ContactSet]:
        for path in self.paths:
            name = _printable(path)
            try:
                yield ContactSet(name, read_bytes(path))
            except FileError as error:
                yield ContactSet(name, unreadable="; ".join(error.lines))


@frozen_value(eq=True)
class SetReader:
    """Reads the contacts of each set, as a contact file or as a machine log."""

    format_name: str
    options: ContactOptions
    log_options: LogOptions = field(default_factory=LogOptions)

    def __post_init__(self) -> None:
        if self.format_name == "csv" and self.log_options.of_log:
            raise UsageError(FOR_LOGS)

    def __call__(self, fixture: Fixture, contact_set: ContactSet) -> tuple[Contacts, tuple[str, ...]]:
        """The contacts of a set in the fixture's units, and notes; FileError with lines of the table it is from."""
        if self.format_name != "csv":
            return self._of_log(fixture, contact_set)
        try:
            options = replace(self.options, tip_offset=self.log_options.tip_offset)
            return read_contact_file(contact_set.content, fixture, options).contacts, ()
        except FileError as error:
            if contact_set.lines is None:
                raise
            raise FileError(error.path, [_in_table(problem, contact_set.lines) for problem in error.problems]) from None

    def _of_log(self, fixture: Fixture, contact_set: ContactSet) -> tuple[Contacts, tuple[str, ...]]:
        from tactfix.files.logs.load import load_log

        source = io.BytesIO(contact_set.content)
        read, notes = load_log(self.format_name, source, fixture, self.options, self.log_options)
        return read.contacts, notes


def find_sets(sources: Sequence[str], format_name: str = "csv", leave_out: Path | None = None) -> ContactSets:
    """The sets of each source in turn: a contact file, a directory of them by name, a table, or "-".

    In a directory: the files that end with .csv, .tsv or .txt, for machine logs all files; not hidden files and not
    leave_out (the output). Contact files are read when iterated over, tables at once.
    Raises FileError for a table that cannot be read and a directory without contact files.
    """
    return ContactSets(tuple(_part(source, format_name, leave_out) for source in sources))


def _part(source: str, format_name: str, leave_out: Path | None) -> Part:
    path = Path(source)
    if source == "-":
        name, text = read_source(source)
        is_one = format_name != "csv" or not is_table(text[:_HEADER_BYTES])
        return (ContactSet(name, text.encode()),) if is_one else csv_table(name, text)
    if path.is_dir():
        return FileSets(tuple(_files_in(path, format_name, leave_out)))
    if format_name == "csv" and path.suffix.lower() == ".parquet":
        return parquet_table(path)
    if format_name == "csv" and is_table(_head(path)):
        return csv_table(source, decode(source, read_bytes(path)))
    if not os.path.lexists(path):
        return (ContactSet(_printable(path), unreadable=f"there is no such file or folder; {near_name(path)}"),)
    return FileSets((path,))


def _printable(path: Path) -> str:
    """The path as text; bytes that are not UTF-8, which no result could hold, are replaced."""
    return os.fsencode(path).decode(errors="replace")


def _head(path: Path) -> str:
    """The beginning of a file as text, without invalid bytes; empty if it cannot be read."""
    try:
        with path.open("rb") as file:
            return file.read(_HEADER_BYTES).decode("utf-8-sig", errors="ignore")
    except OSError:
        return ""


def _files_in(directory: Path, format_name: str, leave_out: Path | None) -> Iterable[Path]:
    out = None if leave_out is None else leave_out.resolve()
    try:
        found = sorted(
            path
            for path in directory.iterdir()
            if (format_name != "csv" or path.suffix.lower() in _ENDINGS)
            and not path.name.startswith(".")
            and path.is_file()
            and path.resolve() != out
        )
    except OSError as error:
        raise FileError(str(directory), [Problem(f"cannot be read: {error.strerror}", "check its mode")]) from None
    if not found:
        message = "there are no contact files in this directory"
        raise FileError(str(directory), [Problem(message, f"contact files end with {', '.join(_ENDINGS)}")])
    return found


def _in_table(problem: Problem, lines: tuple[int, ...]) -> Problem:
    """The problem with its line in the set's text replaced by the line in the table."""
    line = lines[problem.line - 1] if problem.line is not None and problem.line <= len(lines) else None
    return replace(problem, line=line)
