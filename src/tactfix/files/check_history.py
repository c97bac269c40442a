"""The history of checks: a file of JSON lines, one for each check."""

import json
import os
from pathlib import Path
from typing import Any, Final

import numpy as np

from tactfix.errors import FileError, Problem
from tactfix.files.reading import decode, read_bytes
from tactfix.monitoring.drift import CheckRecord

HISTORY_SCHEMA: Final = "tactfix/check-history/1"
_SHAPES: Final = {"reference": (4, 4), "motion": (6,), "covariance": (6, 6), "reference_covariance": (6, 6)}


def read_history(path: Path) -> tuple[CheckRecord, ...]:
    """The checks in the file, oldest first; none if the file does not exist.

    Raises FileError naming the first line that is not a check.
    """
    if not path.exists():
        return ()
    content = read_bytes(path)
    if content and not content.endswith(b"\n"):
        line = content.count(b"\n") + 1
        raise FileError(str(path), [Problem("the last line is cut off", "remove it", line=line)])
    lines = decode(str(path), content).splitlines()
    return tuple(_record(path, number, line) for number, line in enumerate(lines, 1))


def append_history(path: Path, record: CheckRecord) -> None:
    """Append one line; on failure FileError, and the file is left unchanged."""
    entries = {"schema": HISTORY_SCHEMA, "time": record.time, "fixture": record.fixture, "units": record.units}
    arrays = {name: getattr(record, name).tolist() for name in _SHAPES}
    line = (json.dumps({**entries, **arrays}, allow_nan=False) + "\n").encode()
    try:
        handle = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
        try:
            before = os.fstat(handle).st_size
            try:
                written = os.write(handle, line)
            except OSError:
                os.ftruncate(handle, before)
                raise
            if written != len(line):
                os.ftruncate(handle, before)
                raise OSError(0, "no room for the line")
            os.fsync(handle)
        finally:
            os.close(handle)
    except OSError as error:
        message = f"the check cannot be appended: {error.strerror}"
        raise FileError(str(path), [Problem(message, "check the path, its permissions and the disk")]) from None


def _record(path: Path, number: int, line: str) -> CheckRecord:
    try:
        entries: Any = json.loads(line)
        if entries["schema"] != HISTORY_SCHEMA:
            raise ValueError
        arrays = {name: np.array(entries[name], dtype=np.float64) for name in _SHAPES}
        if not all(np.isfinite(array).all() for array in arrays.values()):
            raise ValueError
        record = CheckRecord(str(entries["time"]), str(entries["fixture"]), str(entries["units"]), **arrays)
        if any(getattr(record, name).shape != shape for name, shape in _SHAPES.items()):
            raise ValueError
    except (ValueError, KeyError, TypeError):
        remedy = "name a history that check has written, or a new file"
        raise FileError(str(path), [Problem("this is no check", remedy, line=number)]) from None
    return record
