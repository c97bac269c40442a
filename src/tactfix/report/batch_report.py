"""The rows of a batch as a table (CSV, JSON lines or parquet), and the number of sets with each status.

The table is written row after row, never all in memory.
"""

import csv
import io
import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO, Final

from tactfix.batching.row import BatchRow, row_json
from tactfix.errors import MissingExtraError, UsageError
from tactfix.report.json_report import text_of
from tactfix.report.text_report import decimal
from tactfix.wording import spreadsheet_cell

_TWIST: Final = ("rx", "ry", "rz", "tx", "ty", "tz")
CSV_COLUMNS: Final = (
    *("set", "status", "acceptable", "message", "units"),
    *(f"m{i}{k}" for i in range(1, 5) for k in range(1, 5)),
    *(f"sigma_{name}" for name in _TWIST),
    *("chi2", "dof", "rms", "warnings"),
)
"""m11 to m44 are base_from_fixture, row by row. Warnings are separated by " | "."""
_GROUP: Final = 65536
"""Rows that are held in memory for parquet."""

Writer = Callable[[Iterable[BatchRow], BinaryIO], None]


def write_jsonl(rows: Iterable[BatchRow], file: BinaryIO) -> None:
    """One JSON object a line; see row_json."""
    for row in rows:
        file.write(json.dumps(row_json(row), allow_nan=False).encode() + b"\n")


def write_csv(rows: Iterable[BatchRow], file: BinaryIO) -> None:
    """CSV with CSV_COLUMNS; unknown values are empty cells. Numbers read back as the same doubles."""
    text = io.TextIOWrapper(file, encoding="utf-8", newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(CSV_COLUMNS)
    writer.writerows(map(_cells, rows))
    text.flush()
    text.detach()


def write_parquet(rows: Iterable[BatchRow], file: BinaryIO) -> None:
    """Parquet: transform is a list of 16 numbers, sigmas one of 6, warnings a list; null for unknown values."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    schema = _parquet_schema(pa)
    remaining = iter(rows)
    with pq.ParquetWriter(file, schema) as writer:
        while group := list(islice(remaining, _GROUP)):
            writer.write_table(pa.Table.from_pylist([_record(row) for row in group], schema=schema))


WRITERS: Final[dict[str, Writer]] = {".parquet": write_parquet, ".csv": write_csv, ".jsonl": write_jsonl}
"""The writer of a table, by the file suffix."""


def find_writer(suffix: str) -> Writer:
    """The writer for this file suffix. Raises UsageError for an unknown suffix, MissingExtraError without pyarrow."""
    if suffix not in WRITERS:
        raise UsageError(f"a batch is not written as {suffix!r}; end its name with {', '.join(WRITERS)}")
    if suffix == ".parquet" and find_spec("pyarrow") is None:
        raise MissingExtraError("batch", "parquet")
    return WRITERS[suffix]


def _cells(row: BatchRow) -> list[str]:
    transform = [""] * 16 if row.transform is None else [decimal(value) for value in row.transform]
    sigmas = [""] * 6 if row.sigmas is None else [decimal(value) for value in row.sigmas]
    return [
        *(spreadsheet_cell(row.name), row.status, "true" if row.acceptable else "false"),
        *(spreadsheet_cell(row.message), row.units),
        *transform,
        *sigmas,
        *("" if row.chi2 is None else decimal(row.chi2), "" if row.dof is None else str(row.dof)),
        *("" if row.rms is None else decimal(row.rms), spreadsheet_cell(" | ".join(row.warnings))),
    ]


def _parquet_schema(pa: Any) -> Any:
    numbers = pa.float64()
    columns = {
        "set": pa.string(),
        "status": pa.string(),
        "acceptable": pa.bool_(),
        "message": pa.string(),
        "units": pa.string(),
        "transform": pa.list_(numbers, 16),
        "sigmas": pa.list_(numbers, 6),
        "chi2": numbers,
        "dof": pa.int64(),
        "rms": numbers,
        "warnings": pa.list_(pa.string()),
    }
    return pa.schema(list(columns.items()))


def _record(row: BatchRow) -> dict[str, Any]:
    """A row of the parquet table: the transform as a flat list."""
    return {**row_json(row), "transform": None if row.transform is None else list(row.transform)}


BATCH_SCHEMA: Final = "tactfix/batch/1"
STATUSES: Final = ("located", "underdetermined", "ambiguous", "inconsistent", "error")
_MESSAGES_SHOWN: Final = 5
"""Sets without a pose whose message is shown."""


@dataclass(slots=True)
class BatchCount:
    """Counts the rows that pass through it."""

    by_status: Counter[str] = field(default_factory=Counter)
    refused: int = 0
    first_failures: list[str] = field(default_factory=list)

    def counted(self, rows: Iterable[BatchRow]) -> Iterator[BatchRow]:
        """The same rows."""
        for row in rows:
            self.by_status[row.status] += 1
            if not row.acceptable:
                self.refused += 1
                if len(self.first_failures) < _MESSAGES_SHOWN:
                    self.first_failures.append(f"{row.name}: {row.message.partition(chr(10))[0]}")
            yield row

    @property
    def sets(self) -> int:
        """The number of rows counted."""
        return self.by_status.total()


def batch_lines(count: BatchCount) -> Iterator[str]:
    """The counts in words, and the first sets that have no acceptable pose."""
    counts = ", ".join(f"{count.by_status[status]} {status}" for status in STATUSES if count.by_status[status])
    yield f"{count.sets} sets: {counts or 'none'}"
    yield from (f"  {failure}" for failure in count.first_failures)
    if count.refused > len(count.first_failures):
        yield f"  and {count.refused - len(count.first_failures)} more without an acceptable pose"


def batch_json(count: BatchCount, output: Path) -> str:
    """The counts as JSON."""
    by_status = {status: count.by_status[status] for status in STATUSES}
    total = {"sets": count.sets, "acceptable": count.sets - count.refused, "statuses": by_status, "output": str(output)}
    return text_of({"schema": BATCH_SCHEMA, **total})
