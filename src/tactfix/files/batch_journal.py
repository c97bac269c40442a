"""The journal of a batch: a file next to the output that holds finished rows until the output is complete."""

import json
import re
from hashlib import sha256
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, Final

from tactfix.batching.row import BatchRow, row_json, row_of_json
from tactfix.errors import FileError, Problem

_FIRST_LINE: Final = b'{"journal": "tactfix/batch/2"}\n'
_JOURNAL_LINE: Final = re.compile(rb'\{"sha256": "([0-9a-f]{64})", "done": (.*)\}\n')
"""A line: the key and row of a finished set, and their checksum."""


def journal_path(output: Path) -> Path:
    """Path of the journal of an output: results.parquet.partial.jsonl."""
    return output.with_name(output.name + ".partial.jsonl")


class BatchJournal:
    """An append-only file with one line for each row, identified by the key of its set.

    Rows with status "error" are not reused by the next run, since their cause may be gone. An incomplete last line
    (its writer was killed) is dropped, and a line with a wrong checksum is ignored, so that its set is located again.
    Only the position of each row is kept in memory.
    """

    def __init__(self, path: Path) -> None:
        """Open or create the journal and index its rows; FileError if the file is not a journal, or is in use."""
        self._path = path
        self._places: dict[str, int] = {}
        try:
            self._file: BinaryIO = path.open("a+b")
        except OSError as error:
            message = f"the journal of the batch cannot be written: {error.strerror}"
            raise FileError(
                str(path), [Problem(message, "choose an output in a directory that can be written to")]
            ) from None
        try:
            _lock(self._file, path)
            self._read()
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> "BatchJournal":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._file.close()

    def __contains__(self, key: object) -> bool:
        return key in self._places

    def __len__(self) -> int:
        return len(self._places)

    def add(self, key: str, row: BatchRow) -> None:
        """Append the row to the file; the system may write it to the disk later."""
        done = json.dumps({"key": key, "row": row_json(row)}, allow_nan=False).encode()
        line = b'{"sha256": "%s", "done": %s}\n' % (_checksum(done), done)
        place = self._file.seek(0, 2)
        self._file.write(line)
        self._file.flush()
        self._places[key] = place

    def row(self, key: str) -> BatchRow:
        """The row under this key; KeyError if there is none."""
        self._file.seek(self._places[key])
        done = _done(self._file.readline())
        if done is None:
            raise FileError(str(self._path), [Problem("the journal was changed meanwhile", "run the batch again")])
        return row_of_json(done["row"])

    def remove(self) -> None:
        """Close the journal and delete its file, once the output is written."""
        self._file.close()
        self._path.unlink()

    def _read(self) -> None:
        """Index the existing rows; write the first line of a new journal."""
        self._file.seek(0)
        first = self._file.readline()
        if first != _FIRST_LINE:
            if not _FIRST_LINE.startswith(first):
                message = "this is not the journal of a batch"
                raise FileError(str(self._path), [Problem(message, "move it away, or choose another output")])
            self._file.truncate(0)
            self._file.write(_FIRST_LINE)
            return
        place = len(first)
        for line in self._file:
            if not line.endswith(b"\n"):
                break
            self._find(line, place)
            place += len(line)
        self._file.truncate(place)

    def _find(self, line: bytes, place: int) -> None:
        done = _done(line)
        if done is not None and done["row"]["status"] != "error":
            self._places[done["key"]] = place


def _done(line: bytes) -> dict[str, Any] | None:
    """The key and the row of a line, None if the line was changed."""
    match = _JOURNAL_LINE.fullmatch(line)
    if match is None or match[1] != _checksum(match[2]):
        return None
    done: dict[str, Any] = json.loads(match[2])
    return done


def _checksum(done: bytes) -> bytes:
    return sha256(done).hexdigest().encode()


def _lock(file: BinaryIO, path: Path) -> None:
    """Lock the file until it is closed, so that no second batch writes to it; not available on Windows."""
    try:
        import fcntl
    except ImportError:  # Windows
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        message = "another batch is writing to this journal"
        raise FileError(str(path), [Problem(message, "wait for it, or choose another output")]) from None
