"""Where results and messages go: standard output, a file that is written whole or not at all, standard error.

A stream that is closed or full is reported once, and not as a bug.
"""

import contextlib
import io
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import IO, Final, TextIO, TypeAlias, cast

from tactfix.cli.exits import Exit
from tactfix.errors import FileError, Problem
from tactfix.files.writing import write_whole
from tactfix.wording import printable, wrapped, wrapped_comments

ProgressCallback: TypeAlias = Callable[[float, str], None]
"""Takes the share that is done (0 to 1), and what is being done."""
LISTED_BY_JSON: Final = "; --json lists them"
"""Added to a message that does not list all poses."""


def emit(result: str | bytes, output: Path | None = None) -> None:
    """Write a result to standard output, or to the file output."""
    if output is not None:
        write_whole(output, result)
        return
    try:
        if isinstance(result, bytes):
            sys.stdout.flush()
            sys.stdout.buffer.write(result)
        else:
            sys.stdout.write(result)
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader has closed the pipe.
        discard(sys.stdout)
        raise SystemExit(Exit.PIPE_CLOSED) from None
    except OSError as error:
        discard(sys.stdout)
        raise refusal(error) from None


def emit_program(text: str, output: Path | None = None) -> None:
    """Write a result of unbroken lines and comments: on a terminal long comments are wrapped."""
    emit(program_for_people(text, sys.stdout) if output is None else text, output)


def emit_lines(lines: Iterable[str], output: Path | None = None) -> None:
    """Write a result of sentences, one per line; on a terminal long ones are broken between words."""
    text = "".join(f"{line}\n" for line in lines)
    emit(text if output is not None else for_people(text, sys.stdout), output)


def note(message: str, *, quiet: bool = False) -> None:
    """Write a message to standard error, unless quiet."""
    if not quiet:
        say(f"tactfix: {message}\n")


def print_notes(messages: Iterable[str], *, quiet: bool = False) -> None:
    """Write each of the messages to standard error, unless quiet."""
    for message in messages:
        note(message, quiet=quiet)


def on_screen(output: Path | None) -> bool:
    """Whether the result goes to a terminal, for people."""
    return output is None and sys.stdout.isatty()


def wants_summary(*, quiet: bool, verbose: bool) -> bool:
    """Whether a summary for people is wanted: on a terminal, or when asked for."""
    return verbose or (not quiet and sys.stderr.isatty())


def wants_json(output: Path | None, *, as_json: bool) -> bool:
    """Whether the result is wanted as JSON: by --json, or by the ending of the output."""
    return as_json or (output is not None and output.suffix.lower() == ".json")


@contextlib.contextmanager
def progress_bar(activity: str, *, quiet: bool) -> Iterator[ProgressCallback]:
    """A function to call with the progress; a terminal shows it while it lasts."""
    if quiet or not sys.stderr.isatty():
        yield lambda share, doing: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(file=standard_error()), transient=True) as bar:
        task = bar.add_task(activity, total=1.0)
        yield lambda share, doing: bar.update(task, completed=share, description=f"{activity}: {doing}")


def settle() -> None:
    """Replace standard streams that the process was started without: empty input, output that fails, silent errors.

    COLUMNS=0 is removed: with it rich would print nothing.
    """
    if not os.environ.get("COLUMNS", "80").strip("0"):
        del os.environ["COLUMNS"]
    if sys.stdin is None:
        sys.stdin = io.TextIOWrapper(io.FileIO(os.open(os.devnull, os.O_RDONLY)))
    if sys.stdout is None:
        # Opened for reading, so that writing fails as it would on the closed stream.
        sys.stdout = io.TextIOWrapper(io.FileIO(os.open(os.devnull, os.O_RDONLY), "w"))
    if sys.stderr is None:
        sys.stderr = io.TextIOWrapper(io.FileIO(os.open(os.devnull, os.O_WRONLY), "w"))
    if isinstance(sys.stdout, io.TextIOWrapper):
        if sys.stdout.isatty():
            sys.stdout.reconfigure(errors="backslashreplace")
        elif sys.stdout.encoding.lower() != "utf-8":
            # Contact and fixture files are UTF-8 in every locale, and output may be piped into such a file.
            sys.stdout.reconfigure(encoding="utf-8")


def discard(stream: TextIO) -> None:
    """Discard what is still buffered in a stream: Python would report the error again when it closes the stream."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def say(text: str) -> None:
    """Write to standard error, control characters escaped; errors of the stream are ignored."""
    _write(sys.stderr, for_people(printable(text), sys.stderr))


def for_people(text: str, stream: TextIO) -> str:
    """The text with lines broken between words if the stream is a terminal, which would break them inside a number."""
    return wrapped(text, _width(stream)) if stream.isatty() else text


def program_for_people(text: str, stream: TextIO) -> str:
    """A controller's program, its long comments broken into several lines if the stream is a terminal."""
    return wrapped_comments(text, _width(stream)) if stream.isatty() else text


def _width(stream: TextIO) -> int:
    """Columns of a terminal: from COLUMNS, else from the terminal itself."""
    columns = os.environ.get("COLUMNS", "")
    if columns.isdecimal() and int(columns) > 0:
        return int(columns)
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
    """Standard error as a file that ignores errors of the stream."""
    return cast("IO[str]", _StandardError(sys.stderr))


class _StandardError(io.TextIOBase):
    # Keeps the stream: while rich shows progress, sys.stderr is rich's own.
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
    """The error of standard output that does not take a result."""
    remedy = "make room, or write the result to a file with --output"
    return FileError("standard output", [Problem(f"cannot be written: {error.strerror}", remedy)])
