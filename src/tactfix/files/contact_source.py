"""Contacts from whatever holds them: a contact file, or the log of a machine."""

import warnings

from tactfix.contacts import Contacts
from tactfix.errors import UsageError
from tactfix.files.contact_file import read_contact_file
from tactfix.files.contact_options import ContactOptions
from tactfix.files.log_options import log_options
from tactfix.files.logs.load import load_log
from tactfix.files.reading import Source
from tactfix.fixture import Fixture


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
    """The contacts of a contact file, or of a machine's log, in the units of the fixture.

    source: a path, "-" for standard input, bytes, or an open file. fixture: whose features the contacts touch; a
    contact file without it stays in its own unit. options: what beats the file: units, tip radius, sigma, tip offset.
    format: csv, or the name of a machine's format, such as kuka. For these, what the log cannot say: features, such as
    "bar:5,ball:4", in order; approach, such as "0,0,-1"; repeats, "all" or "last"; work_offset, the file of a pose.
    What was dropped or passed over in a log is told as a UserWarning.

    Raises FileError with all that is wrong, by row and line; UsageError for arguments that do not go together.
    """
    said = options or ContactOptions()
    wanted = log_options(features, said.tip_offset, approach, repeats, work_offset)
    if format == "csv":
        if wanted.of_log:
            raise UsageError("features, approach, repeats and work_offset are for machine logs; give format too")
        return read_contact_file(source, fixture, options).contacts
    if fixture is None:
        raise UsageError("a machine's log does not say what was touched; give the fixture too")
    read, notes = load_log(format, source, fixture, said, wanted)
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return read.contacts
