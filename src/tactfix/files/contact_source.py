"""Contacts from a contact file or the log of a machine, complete or still being written."""

import sys
import time
import warnings
from collections.abc import Iterator
from typing import Final

from tactfix.contacts import Contacts
from tactfix.errors import FileError, Problem, UsageError
from tactfix.files.contact_file import read_contact_file
from tactfix.files.contact_options import ContactOptions, log_options
from tactfix.files.logs.load import load_log
from tactfix.files.reading import Source, read_bytes
from tactfix.fixture import Fixture
from tactfix.settings import FOR_LOGS


def load_contacts(
    source: Source,
    fixture: Fixture | None = None,
    options: ContactOptions | None = None,
    *,
    format: str = "csv",  # noqa: A002 - as the command line calls it
    features: str | None = None,
    approach: str | None = None,
    repeats: str = "all",
    work_offset: str | None = None,
) -> Contacts:
    """Read the contacts of a contact file, or of a machine's log.

    Parameters
    ----------
    source : str, Path, bytes or open file
        A path, "-" for standard input, the bytes themselves, or an open file.
    fixture : Fixture, optional
        The touched fixture; without it the contacts of a contact file keep the file's unit.
    options : ContactOptions, optional
        Units, tip radius, sigma and tip offset, which override those of the file.
    format : str
        "csv", or the name of a machine's format, such as "kuka".
    features : str, optional
        Of a log: the touched features, in order, such as "bar:5,ball:4".
    approach : str, optional
        Of a log: the direction of probe travel, such as "0,0,-1".
    repeats : {"all", "last"}
        Of a log: keep all consecutive touches of one point, or the last.
    work_offset : str, optional
        Of a log: a file with the pose of the frame in which the machine reports.

    Returns
    -------
    Contacts
        In base coordinates, in the units of the fixture if it is given.

    Raises
    ------
    FileError
        With every problem of the file, by row and line.
    UsageError
        Arguments that exclude or need each other.

    Notes
    -----
    Skipped contacts and lines of a log raise a UserWarning. Options override the file, and the file overrides the probe
    block of the fixture; a tip radius or sigma that none of them gives is a problem.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    <Contacts: 15 (plate 4, pin 6, ball 5), tip radius 3 mm>
    """
    chosen = options or ContactOptions()
    wanted = log_options(features, chosen.tip_offset, approach, repeats, work_offset)
    if format == "csv":
        if wanted.of_log:
            raise UsageError(FOR_LOGS)
        return read_contact_file(source, fixture, options).contacts
    if fixture is None:
        raise UsageError("a machine's log does not say what was touched; give the fixture too")
    read, notes = load_log(format, source, fixture, chosen, wanted)
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return read.contacts


PAUSE: Final = 0.2
"""Seconds between two reads of a file that is followed."""


def growing_text(path: str, *, follow: bool) -> Iterator[bytes]:
    """The content so far of a file or of standard input ("-"), after each of its lines.

    A file is read to its end; with follow, this waits for more, without end. A line counts once it has a line ending;
    if nothing can follow, the last line counts without one. Raises FileError if a file becomes shorter.
    """
    if path == "-":
        yield from _accumulated(iter(sys.stdin.buffer.readline, b""))
        return
    if follow:
        yield from _accumulated(_followed(path))
        return
    yield from _accumulated(iter(read_bytes(path).splitlines(keepends=True)))


def _accumulated(lines: Iterator[bytes]) -> Iterator[bytes]:
    text = b""
    for line in lines:
        text += line
        yield text


def _followed(path: str) -> Iterator[bytes]:
    consumed = 0
    while True:
        content = read_bytes(path)
        if len(content) < consumed:
            message = "the file has become shorter while it was followed"
            raise FileError(path, [Problem(message, "append touches to it, or start again")])
        whole = content[consumed : content.rfind(b"\n") + 1]
        consumed += len(whole)
        yield from whole.splitlines(keepends=True)
        time.sleep(PAUSE)


def contacts_in(text: bytes, format_name: str, repeats_units: str | None = None) -> tuple[int, int]:
    """Numbers of touches and of contacts in a text so far: rows of a contact file, even if they are malformed.

    repeats_units: unit of a machine log if only the last of consecutive touches of one point is a contact; None if
    every touch is one.
    """
    if format_name == "csv":
        lines = [line for line in text.splitlines() if line.strip() and not line.startswith(b"#")]
        rows = max(len(lines) - 1, 0)
        return rows, rows
    from tactfix.files.logs.load import find_format
    from tactfix.files.logs.log import last_of_each_place
    from tactfix.files.reading import read_log_text

    log = find_format(format_name).read(read_log_text(text)[1], [])
    touches = len(log.contacts)
    if repeats_units is None:
        return touches, touches
    return touches, len(last_of_each_place(log.contacts, log.units or repeats_units)[0])
