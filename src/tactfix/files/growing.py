"""Contact files and machine logs that are still being written: their text after each whole line."""

import sys
import time
from collections.abc import Iterator
from typing import Final

from tactfix.errors import FileError, Problem
from tactfix.files.reading import read_bytes

PAUSE: Final = 0.2
"""Seconds between two looks at a file: nobody who touches by hand notices it."""


def growing_text(path: str, *, follow: bool) -> Iterator[bytes]:
    """What stands in a file, or has come in on standard input ("-"), after each of its lines.

    A file is read to its end; with follow, it is waited for more, for ever. A line counts when its end is there;
    where nothing more can come the last line counts without. Raises FileError where a file has become shorter.
    """
    if path == "-":
        yield from _accumulated(iter(sys.stdin.buffer.readline, b""))
        return
    if follow:
        yield from _accumulated(_followed(path))
        return
    yield from _accumulated(iter(read_bytes(path).splitlines(keepends=True)))


def _accumulated(lines: Iterator[bytes]) -> Iterator[bytes]:
    text = b""
    for line in lines:
        text += line
        yield text


def _followed(path: str) -> Iterator[bytes]:
    seen = 0
    while True:
        content = read_bytes(path)
        if len(content) < seen:
            what = "the file has become shorter while it was followed"
            raise FileError(path, [Problem(what, "append touches to it, or begin anew")])
        whole = content[seen : content.rfind(b"\n") + 1]
        seen += len(whole)
        yield from whole.splitlines(keepends=True)
        time.sleep(PAUSE)


def contacts_in(text: bytes, format_name: str, repeats_units: str | None = None) -> tuple[int, int]:
    """How many touches a text has so far, and of how many contacts: rows of a contact file, which need not be right.

    repeats_units: unit of a machine log of which the last of consecutive touches of one place is the contact; None
    where every touch is one.
    """
    if format_name == "csv":
        lines = [line for line in text.splitlines() if line.strip() and not line.startswith(b"#")]
        rows = max(len(lines) - 1, 0)
        return rows, rows
    from tactfix.files.logs.load import find_format
    from tactfix.files.logs.source import read_log_text
    from tactfix.files.logs.touches import last_of_each_place

    log = find_format(format_name).read(read_log_text(text)[1], [])
    touches = len(log.contacts)
    if repeats_units is None:
        return touches, touches
    return touches, len(last_of_each_place(log.contacts, log.units or repeats_units)[0])
