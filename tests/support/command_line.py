"""The command line run in this process: what it prints and how it leaves, without the second that a process costs.

What a process of its own shows (signals, pipes that close, standard streams of the system) needs one.
"""

import contextlib
import io
import os
import sys
from dataclasses import dataclass
from unittest import mock

from tactfix.cli import main


@dataclass(frozen=True)
class Ran:
    """What became of one call."""

    returncode: int
    stdout: str
    stderr: str


class Terminal(io.TextIOWrapper):
    """A stream that somebody looks at."""

    def isatty(self) -> bool:
        """Yes."""
        return True


def tactfix(*words: object, stdin: str | bytes = "", together: bool = False, columns: int | None = None) -> Ran:
    """tactfix with these words, standard input as given; standard error may go to the output.

    No terminal anywhere, or where columns are given one so wide for both.
    """
    given = stdin.encode() if isinstance(stdin, str) else stdin
    kind = io.TextIOWrapper if columns is None else Terminal
    streams = [kind(io.BytesIO(), encoding="utf-8", newline="") for _ in range(2)]
    terminal = {} if columns is None else {"COLUMNS": str(columns), "TERM": "xterm"}
    out, err = (streams[0], streams[0]) if together else streams
    with (
        mock.patch.dict(os.environ, terminal),
        mock.patch.object(sys, "stdin", io.TextIOWrapper(io.BytesIO(given), encoding="utf-8")),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            status = main([str(word) for word in words])
        except SystemExit as leaving:
            status = int(leaving.code or 0)
    texts = []
    for stream in streams:
        stream.flush()
        texts.append(stream.buffer.getvalue().decode())
    return Ran(status, *texts)
