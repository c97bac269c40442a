"""Many contact sets of one fixture: a row for each, in order, kept in a journal so that a batch can go on later."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Protocol

from tactfix.batching.contact_set import ContactSet
from tactfix.batching.row import BatchRow
from tactfix.batching.task import BatchTask, Numbered, locate_set
from tactfix.batching.workers import Spread

ProgressCallback = Callable[[int], None]
"""Told how many sets are done, each time one is."""


class Journal(Protocol):
    """Where rows are kept as they come, by the key of their set."""

    def __contains__(self, key: object) -> bool:
        """Whether the row of the set with this key is there."""

    def add(self, key: str, row: BatchRow) -> None:
        """Keep the row of the set with this key."""

    def row(self, key: str) -> BatchRow:
        """The row of the set with this key."""


def run_batch(
    task: BatchTask, sets: Iterable[ContactSet], spread: Spread, journal: Journal, digest: str, told: ProgressCallback
) -> Iterator[BatchRow]:
    """Locate every set that is not in the journal yet; then all rows in the order of the sets.

    digest: a checksum of all that rows depend on but the contacts (fixture, options, program); with the set's name and
    contacts it makes the key of its row. Only the sets under way and the keys are held in memory. Sets that cannot be
    read are sent to nobody. Raises what spread and journal raise; the journal then has all rows that were done.
    """
    batch = _Batch(task, journal, digest, told)
    for number, row in spread(task, batch.still_open(sets)):
        batch.keep(batch.keys[number], row)
    return map(journal.row, batch.keys)


@dataclass(slots=True)
class _Batch:
    """A batch under way: the keys of the sets that were looked at, in order, and how many of them are done."""

    task: BatchTask
    journal: Journal
    digest: str
    told: ProgressCallback
    keys: list[str] = field(default_factory=list)
    done: int = 0

    def still_open(self, sets: Iterable[ContactSet]) -> Iterator[Numbered]:
        """The sets that someone has to locate, with their number."""
        for number, contact_set in enumerate(sets):
            key = contact_set.key(self.digest)
            self.keys.append(key)
            if key in self.journal:
                self._count()
            elif contact_set.unreadable is not None:
                self.keep(key, locate_set(self.task, contact_set))
            else:
                yield number, contact_set

    def keep(self, key: str, row: BatchRow) -> None:
        """Write the row down."""
        self.journal.add(key, row)
        self._count()

    def _count(self) -> None:
        self.done += 1
        self.told(self.done)
