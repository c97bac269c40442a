"""Many contact sets of one fixture, located by workers: one row of results for each, in order.

1. Sets whose rows are not in the journal are sent to workers in chunks.
2. If a worker dies, the sets that it may have worked on are located again, one at a time. A set with which a worker
   dies alone gets a row with that message.
3. Rows are added to the journal as they come, so that a batch can be continued later.
"""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from itertools import islice
from typing import Protocol

from tactfix.batching.row import BatchRow, row_of_failure
from tactfix.batching.task import BatchTask, ChunkDone, ContactSet, Numbered, NumberedRow, locate_chunk, locate_set

_CHUNK_TIME = 0.2
"""Intended time of a chunk (s), which determines the size of the next one. A process locates some 200 sets a second
(tests/README.md), so a chunk has about forty: the cost of sending is small, and a stop loses no more than this time of
each worker."""
_MOST_TOGETHER = 256
"""Sets in one chunk at most: without a limit, sets that fail at once would form chunks of thousands, and all sets of a
chunk whose process dies are located again, one at a time."""
_CHUNKS_AHEAD = 2
"""Chunks for each worker: one in work and one waiting, so that no worker is idle while rows are received."""


class Workers(Protocol):
    """Workers that locate sets: processes of this machine, or of a cluster."""

    @property
    def deaths(self) -> tuple[type[BaseException], ...]:
        """The exceptions of a chunk whose worker died."""

    def open(self) -> AbstractContextManager[tuple[Executor, int]]:
        """An executor, a new one after a failure, and the number of chunks that it works on at the same time."""


def here(task: BatchTask, numbered: Iterator[Numbered]) -> Iterator[NumberedRow]:
    """The rows of all sets, one after the other, in this process."""
    for one in numbered:
        yield from locate_chunk(task, (one,)).rows


def spread_over(workers: Workers, task: BatchTask, numbered: Iterator[Numbered]) -> Iterator[NumberedRow]:
    """The row of each set, in order of completion (step 2). numbered is read no faster than sets are located."""
    supply = _Supply(numbered)
    while not supply.is_empty:
        orphans: list[Numbered] = []
        yield from _until_a_death(workers, task, supply, orphans)
        yield from _one_at_a_time(workers, task, deque(orphans))


@dataclass(slots=True)
class _Supply:
    """Sets in chunks, whose size follows from the time of the last ones."""

    numbered: Iterator[Numbered]
    size: int = 1
    is_empty: bool = False

    def next_chunk(self) -> tuple[Numbered, ...]:
        """The next sets; fewer or none at the end."""
        chunk = tuple(islice(self.numbered, self.size))
        self.is_empty = len(chunk) < self.size
        return chunk

    def learn(self, done: ChunkDone) -> None:
        """Set the size to the sets that take _CHUNK_TIME, at most twice the size before."""
        fitting = int(_CHUNK_TIME * len(done.rows) / max(done.seconds, 1e-9))
        self.size = max(1, min(fitting, 2 * self.size, _MOST_TOGETHER))


def _until_a_death(
    workers: Workers, task: BatchTask, supply: _Supply, orphans: list[Numbered]
) -> Iterator[NumberedRow]:
    """Rows until all sets are done, or a worker died and every set sent has its row or is among orphans."""
    under_way: dict[Future[ChunkDone], tuple[Numbered, ...]] = {}
    with workers.open() as (executor, width):
        while True:
            while not orphans and not supply.is_empty and len(under_way) < _CHUNKS_AHEAD * width:
                chunk = supply.next_chunk()
                try:
                    under_way[executor.submit(locate_chunk, task, chunk)] = chunk
                except workers.deaths:
                    orphans.extend(chunk)
            if not under_way:
                return
            for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                chunk = under_way.pop(future)
                try:
                    done = future.result()
                except workers.deaths:
                    orphans.extend(chunk)
                else:
                    supply.learn(done)
                    yield from done.rows


def _one_at_a_time(workers: Workers, task: BatchTask, orphans: deque[Numbered]) -> Iterator[NumberedRow]:
    while orphans:
        with workers.open() as (executor, _):
            alive = True
            while orphans and alive:
                number, contact_set = orphans.popleft()
                try:
                    yield from executor.submit(locate_chunk, task, ((number, contact_set),)).result().rows
                except workers.deaths:
                    alive = False
                    message = (
                        "the process that located this set died, alone with it: it may need more memory than there is"
                    )
                    yield number, row_of_failure(contact_set.name, message, task.fixture.units)


Spread = Callable[[BatchTask, Iterator[Numbered]], Iterator[NumberedRow]]
"""Locates numbered sets, in any order: in this process, or by workers."""


ProgressCallback = Callable[[int], None]
"""Called with the number of sets that are done, each time one is."""


class Journal(Protocol):
    """Storage of rows, by the key of their set."""

    def __contains__(self, key: object) -> bool:
        """Whether it has the row of the set with this key."""

    def add(self, key: str, row: BatchRow) -> None:
        """Store the row of the set with this key."""

    def row(self, key: str) -> BatchRow:
        """The row of the set with this key."""


def run_batch(
    task: BatchTask,
    sets: Iterable[ContactSet],
    spread: Spread,
    journal: Journal,
    digest: str,
    progress: ProgressCallback,
) -> Iterator[BatchRow]:
    """Locate every set that is not in the journal; return all rows in the order of the sets.

    digest: a checksum of fixture, options and program; with the set's name and contacts it gives the key of its row.
    Only the sets in work and the keys are held in memory. Sets that cannot be read are not sent to workers. Raises what
    spread and journal raise; the journal then has all rows that were done.
    """
    batch = _Batch(task, journal, digest, progress)
    for number, row in spread(task, batch.still_open(sets)):  # steps 1 and 2
        batch.keep(batch.keys[number], row)  # step 3
    return map(journal.row, batch.keys)


@dataclass(slots=True)
class _Batch:
    """A running batch: the keys of the sets that were read, in order, and how many of them are done."""

    task: BatchTask
    journal: Journal
    digest: str
    progress: ProgressCallback
    keys: list[str] = field(default_factory=list)
    done: int = 0

    def still_open(self, sets: Iterable[ContactSet]) -> Iterator[Numbered]:
        """The sets that are still to be located, with their number."""
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
        """Add the row to the journal."""
        self.journal.add(key, row)
        self._count()

    def _count(self) -> None:
        self.done += 1
        self.progress(self.done)
