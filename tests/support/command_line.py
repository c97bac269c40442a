"""Run the command line in this process and capture its output and exit status, which saves a second for each process.

Signals, closed pipes and the standard streams of the system need a subprocess instead.
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
    """Exit status and output of one call."""

    returncode: int
    stdout: str
    stderr: str


class Terminal(io.TextIOWrapper):
    """A stream that claims to be a terminal."""

    def isatty(self) -> bool:
        """Yes."""
        return True


def tactfix(*words: object, stdin: str | bytes = "", together: bool = False, columns: int | None = None) -> Ran:
    """Run tactfix with these arguments and standard input; standard error may be merged into the output.

    Without columns no stream is a terminal; with columns both outputs are terminals of that width.
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
