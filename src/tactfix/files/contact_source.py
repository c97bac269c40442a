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
        Whose features the contacts touch; a contact file without it stays in its own unit.
    options : ContactOptions, optional
        What beats the file: units, tip radius, sigma, tip offset.
    format : str
        "csv", or the name of a machine's format, such as "kuka".
    features : str, optional
        Of a log: what was touched, in order, such as "bar:5,ball:4".
    approach : str, optional
        Of a log: the direction in which the probe travelled, such as "0,0,-1".
    repeats : {"all", "last"}
        Of a log: all of consecutive touches of one place, or the last of them.
    work_offset : str, optional
        Of a log: the file of the pose of the frame in which the machine reported.

    Returns
    -------
    Contacts
        In base coordinates and in the units of the fixture.

    Raises
    ------
    FileError
        With all that is wrong with the file, by row and line.
    UsageError
        Arguments that do not go together.

    Notes
    -----
    What was dropped or passed over in a log is told as a UserWarning. An option beats the file, the file beats the
    probe block of the fixture; where nothing says the tip radius or sigma, the file is refused.

    Examples
    --------
    >>> fixture = tactfix.load_fixture("fixtures/robot-cell-plate.yaml")
    >>> tactfix.load_contacts("samples/robot-cell-plate/contacts.csv", fixture)
    <Contacts: 15 (plate 4, pin 6, ball 5), tip radius 3 mm>
    """
    said = options or ContactOptions()
    wanted = log_options(features, said.tip_offset, approach, repeats, work_offset)
    if format == "csv":
        if wanted.of_log:
            raise UsageError(FOR_LOGS)
        return read_contact_file(source, fixture, options).contacts
    if fixture is None:
        raise UsageError("a machine's log does not say what was touched; give the fixture too")
    read, notes = load_log(format, source, fixture, said, wanted)
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return read.contacts


PAUSE: Final = 0.2
"""Seconds between two reads of a file that is followed."""


def growing_text(path: str, *, follow: bool) -> Iterator[bytes]:
    """What stands in a file, or has come in on standard input ("-"), after each of its lines.

    A file is read to its end; with follow, it is waited for more, for ever. A line counts when its end is there;
    where nothing more can come the last line counts without. Raises FileError where a file has become shorter.
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
    seen = 0
    while True:
        content = read_bytes(path)
        if len(content) < seen:
            what = "the file has become shorter while it was followed"
            raise FileError(path, [Problem(what, "append touches to it, or begin anew")])
        whole = content[seen : content.rfind(b"\n") + 1]
        seen += len(whole)
        yield from whole.splitlines(keepends=True)
        time.sleep(PAUSE)


def contacts_in(text: bytes, format_name: str, repeats_units: str | None = None) -> tuple[int, int]:
    """How many touches a text has so far, and of how many contacts: rows of a contact file, which need not be right.

    repeats_units: unit of a machine log of which the last of consecutive touches of one place is the contact; None
    where every touch is one.
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
