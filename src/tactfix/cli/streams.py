"""Standard streams that are closed, full or read by nobody any more: told once, and never taken for a bug."""

import contextlib
import io
import os
import sys
from typing import IO, TextIO, cast

from tactfix.errors import FileError, Problem
from tactfix.wording import printable, wrapped, wrapped_comments


def settle() -> None:
    """Give the process the streams it was started without: input without end, output that refuses, silence.

    A COLUMNS of no column says nothing of a terminal: without this rich would print nothing at all.
    """
    if not os.environ.get("COLUMNS", "80").strip("0"):
        del os.environ["COLUMNS"]
    if sys.stdin is None:
        sys.stdin = io.TextIOWrapper(io.FileIO(os.open(os.devnull, os.O_RDONLY)))
    if sys.stdout is None:
        # Opened for reading: whatever is written there fails as it would on the closed stream.
        sys.stdout = io.TextIOWrapper(io.FileIO(os.open(os.devnull, os.O_RDONLY), "w"))
    if sys.stderr is None:
        sys.stderr = io.TextIOWrapper(io.FileIO(os.open(os.devnull, os.O_WRONLY), "w"))
    if isinstance(sys.stdout, io.TextIOWrapper):
        if sys.stdout.isatty():
            sys.stdout.reconfigure(errors="backslashreplace")
        elif sys.stdout.encoding.lower() != "utf-8":
            # Contact and fixture files are UTF-8, whatever the locale: what is piped on can be read.
            sys.stdout.reconfigure(encoding="utf-8")


def discard(stream: TextIO) -> None:
    """Let what is left in a stream go nowhere: Python would complain once more when it closes it."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def say(text: str) -> None:
    """Write to standard error what a terminal obeys nothing of; where nobody hears it the exit status has to do."""
    _write(sys.stderr, for_people(printable(text), sys.stderr))


def for_people(text: str, stream: TextIO) -> str:
    """Sentences as a stream shows them: a terminal breaks lines wherever it ends, even inside a number."""
    return wrapped(text, _width(stream)) if stream.isatty() else text


def program_for_people(text: str, stream: TextIO) -> str:
    """Lines of a controller's program as a stream shows them: on a terminal long comments are several lines."""
    return wrapped_comments(text, _width(stream)) if stream.isatty() else text


def _width(stream: TextIO) -> int:
    """Columns of a terminal: what COLUMNS says, else what it says itself."""
    told = os.environ.get("COLUMNS", "")
    if told.isdecimal() and int(told) > 0:
        return int(told)
    try:
        return os.get_terminal_size(stream.fileno()).columns or 80
    except (OSError, ValueError):
        return 80


def _write(stream: TextIO, text: str) -> None:
    try:
        stream.write(text)
        stream.flush()
    except OSError:
        discard(stream)


def standard_error() -> IO[str]:
    """Standard error for those that write to a file; where nobody can hear it nothing fails, and no process ends."""
    return cast("IO[str]", _StandardError(sys.stderr))


class _StandardError(io.TextIOBase):
    # The stream of the moment: while rich shows progress, sys.stderr leads back to rich.
    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        _write(self._stream, text)
        return len(text)

    def isatty(self) -> bool:
        return self._stream.isatty()

    def fileno(self) -> int:
        return self._stream.fileno()

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return self._stream.encoding


def refusal(error: OSError) -> FileError:
    """What is told where standard output does not take a result."""
    remedy = "make room, or write the result to a file with --output"
    return FileError("standard output", [Problem(f"cannot be written: {error.strerror}", remedy)])
