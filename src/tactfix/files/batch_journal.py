"""The journal of a batch: rows in a file beside its output, as they come, until the output can be written whole."""

import json
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Final

from tactfix.batching.row import BatchRow, row_json, row_of_json
from tactfix.errors import FileError, Problem

_FIRST_LINE: Final = b'{"journal": "tactfix/batch/1"}\n'


def journal_path(output: Path) -> Path:
    """Where the journal of this output is: results.parquet.partial.jsonl."""
    return output.with_name(output.name + ".partial.jsonl")


class BatchJournal:
    """An append-only file with a line for each row, under the key of its set.

    Rows with status "error" are kept for this run alone: when a batch goes on, what caused them may be gone. A last
    line that was cut off when its writer was killed is dropped. In memory is only where each row stands.
    """

    def __init__(self, path: Path) -> None:
        """Open the journal, with the rows of earlier runs; FileError where the file is something else, or in use."""
        self._path = path
        self._places: dict[str, int] = {}
        try:
            self._file: BinaryIO = path.open("a+b")
        except OSError as error:
            what = f"the journal of the batch cannot be written: {error.strerror}"
            raise FileError(
                str(path), [Problem(what, "choose an --output in a directory that can be written to")]
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
        """Keep the row; it is in the file, though perhaps not yet on the disk, when this returns."""
        line = json.dumps({"key": key, "row": row_json(row)}, allow_nan=False).encode() + b"\n"
        place = self._file.seek(0, 2)
        self._file.write(line)
        self._file.flush()
        self._places[key] = place

    def row(self, key: str) -> BatchRow:
        """The row under this key; KeyError where there is none."""
        self._file.seek(self._places[key])
        return row_of_json(json.loads(self._file.readline())["row"])

    def remove(self) -> None:
        """Close the journal and delete its file: the output is written."""
        self._file.close()
        self._path.unlink()

    def _read(self) -> None:
        """Find the rows that are there; write the first line of a new journal."""
        self._file.seek(0)
        first = self._file.readline()
        if first != _FIRST_LINE:
            if not _FIRST_LINE.startswith(first):
                what = "this is not the journal of a batch"
                raise FileError(str(self._path), [Problem(what, "move it away, or choose another --output")])
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
        try:
            told = json.loads(line)
            is_answer = told["row"]["status"] != "error"
            key = str(told["key"])
        except (ValueError, KeyError, TypeError):
            what = f"the line at byte {place} is not a row"
            raise FileError(str(self._path), [Problem(what, "remove the journal to begin anew")]) from None
        if is_answer:
            self._places[key] = place


def _lock(file: BinaryIO, path: Path) -> None:
    """Keep a second batch from the same journal as long as the file is open, where the system can."""
    try:
        import fcntl
    except ImportError:  # Windows
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        what = "another batch is writing to this journal"
        raise FileError(str(path), [Problem(what, "wait for it, or choose another --output")]) from None
