"""The contacts that a command line names: a contact file, or the log of a machine."""

from dataclasses import replace

from tactfix.cli.arguments import vector
from tactfix.cli.output import note
from tactfix.errors import UsageError
from tactfix.files.contact_file import ContactFile, read_contact_file
from tactfix.files.contact_options import ContactOptions
from tactfix.fixture import Fixture


def read_contacts(
    path: str,
    format_name: str,
    fixture: Fixture,
    options: ContactOptions,
    features: str | None,
    tip_offset: str | None,
    *,
    quiet: bool,
) -> ContactFile:
    """The contacts in path; format_name, features and tip_offset as in --contacts-format and so on."""
    if format_name == "csv":
        if features is not None:
            raise UsageError("--features is for machine logs; name theirs with --contacts-format")
        offset = None if tip_offset is None else vector(tip_offset, "--tip-offset")
        return read_contact_file(path, fixture, replace(options, tip_offset=offset))
    from tactfix.files.logs.load import load_log, parse_features

    runs = () if features is None else parse_features(features)
    offset = None if tip_offset is None else vector(tip_offset, "--tip-offset")
    read, notes = load_log(format_name, path, fixture, options, runs, offset)
    for line in notes:
        note(line, quiet=quiet)
    return read
