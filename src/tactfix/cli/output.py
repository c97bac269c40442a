"""Where results go: standard output, or a file that is written whole or not at all. All else goes to standard error."""

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from tactfix.cli.exits import Exit
from tactfix.cli.streams import discard, for_people, program_for_people, refusal, say
from tactfix.files.writing import write_whole

LISTED_BY_JSON: Final = "; --json lists them"
"""Where more is ambiguous than is told."""


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
        # Whoever read has enough.
        discard(sys.stdout)
        raise SystemExit(Exit.PIPE_CLOSED) from None
    except OSError as error:
        discard(sys.stdout)
        raise refusal(error) from None


def emit_program(text: str, output: Path | None = None) -> None:
    """Write a result of lines that stay whole, and comments: on a terminal long comments are several lines."""
    emit(program_for_people(text, sys.stdout) if output is None else text, output)


def emit_lines(lines: Iterable[str], output: Path | None = None) -> None:
    """Write a result that is sentences, one a line; on a terminal long ones are broken between words."""
    text = "".join(f"{line}\n" for line in lines)
    emit(text if output is not None else for_people(text, sys.stdout), output)


def note(message: str, *, quiet: bool = False) -> None:
    """Tell something on standard error, unless quiet."""
    if not quiet:
        say(f"tactfix: {message}\n")


def tell(messages: Iterable[str], *, quiet: bool = False) -> None:
    """Tell each of the messages on standard error, unless quiet."""
    for message in messages:
        note(message, quiet=quiet)


def on_screen(output: Path | None) -> bool:
    """Whether a result is read from a terminal, by people and by no program."""
    return output is None and sys.stdout.isatty()


def wants_summary(*, quiet: bool, verbose: bool) -> bool:
    """Whether a summary for people is wanted: on a terminal, or when asked for."""
    return verbose or (not quiet and sys.stderr.isatty())
