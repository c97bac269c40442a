"""The contacts that a command line names: a contact file, or the log of a machine."""

from dataclasses import replace

from tactfix.cli.output import note
from tactfix.errors import UsageError
from tactfix.files.contact_file import ContactFile, read_contact_file
from tactfix.files.contact_options import ContactOptions
from tactfix.files.log_options import LogOptions
from tactfix.fixture import Fixture
from tactfix.settings import FOR_LOGS


def read_contacts(
    source: str | bytes,
    format_name: str,
    fixture: Fixture,
    options: ContactOptions,
    log_options: LogOptions,
    *,
    quiet: bool,
) -> ContactFile:
    """The contacts in source, a path or what was read of it; format_name as in --contacts-format."""
    if format_name == "csv":
        refuse_log_options(log_options)
        return read_contact_file(source, fixture, replace(options, tip_offset=log_options.tip_offset))
    from tactfix.files.logs.load import load_log

    read, notes = load_log(format_name, source, fixture, options, log_options)
    for line in notes:
        note(line, quiet=quiet)
    return read


def refuse_log_options(log_options: LogOptions) -> None:
    """A contact file says itself what these options say of a machine log."""
    if log_options.of_log:
        raise UsageError(FOR_LOGS)
