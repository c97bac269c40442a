"""The command line run in this process: what it prints and how it leaves, without the second that a process costs.

What a process of its own shows (signals, pipes that close, standard streams of the system) needs one.
"""

import contextlib
import io
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


def tactfix(*words: object, stdin: str | bytes = "", together: bool = False) -> Ran:
    """tactfix with these words, standard input as given, no terminal anywhere; standard error may go to the output."""
    given = stdin.encode() if isinstance(stdin, str) else stdin
    streams = [io.TextIOWrapper(io.BytesIO(), encoding="utf-8", newline="") for _ in range(2)]
    out, err = (streams[0], streams[0]) if together else streams
    with (
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
