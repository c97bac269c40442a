"""Exit status: the only module that defines the numbers."""

from enum import IntEnum

from tactfix.errors import DegenerateContactsError, NotQualifiedError, PoseRefusedError, TactfixError, UsageError


class Exit(IntEnum):
    """The exit status of a command."""

    DONE = 0
    NOT_ACCEPTABLE = 1
    USAGE = 2
    FILE = 3
    UNDERDETERMINED = 4
    AMBIGUOUS = 5
    INCONSISTENT = 6
    BUG = 70
    PIPE_CLOSED = 141


_OF_STATUS = {
    "located": Exit.DONE,
    "underdetermined": Exit.UNDERDETERMINED,
    "ambiguous": Exit.AMBIGUOUS,
    "inconsistent": Exit.INCONSISTENT,
}


def exit_of_status(status: str) -> Exit:
    """The exit status of a result's status."""
    return _OF_STATUS[status]


def exit_of_error(error: TactfixError) -> Exit:
    """The exit status of an error; any other error is that of an invalid input file."""
    match error:
        case UsageError():
            return Exit.USAGE
        case PoseRefusedError():
            return Exit.NOT_ACCEPTABLE
        case DegenerateContactsError() | NotQualifiedError():
            return Exit.UNDERDETERMINED
        case _:
            return Exit.FILE
