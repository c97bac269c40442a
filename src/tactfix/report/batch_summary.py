"""What became of a batch, in counts."""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from tactfix.batching.row import BatchRow
from tactfix.report.json_report import text_of

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
        """How many rows there were."""
        return self.by_status.total()


def batch_lines(count: BatchCount) -> Iterator[str]:
    """The counts in words, and the first sets that have no acceptable pose."""
    told = ", ".join(f"{count.by_status[status]} {status}" for status in STATUSES if count.by_status[status])
    yield f"{count.sets} sets: {told or 'none'}"
    yield from (f"  {failure}" for failure in count.first_failures)
    if count.refused > len(count.first_failures):
        yield f"  and {count.refused - len(count.first_failures)} more without an acceptable pose"


def batch_json(count: BatchCount, output: Path) -> str:
    """The counts as JSON."""
    by_status = {status: count.by_status[status] for status in STATUSES}
    told = {"sets": count.sets, "acceptable": count.sets - count.refused, "statuses": by_status, "output": str(output)}
    return text_of({"schema": BATCH_SCHEMA, **told})
