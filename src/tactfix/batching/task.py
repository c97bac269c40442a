"""The location of the sets of a batch: no set, whatever its content, stops the others."""

from collections.abc import Callable, Sequence
from hashlib import sha256
from time import perf_counter
from typing import TypeAlias

import numpy as np

from tactfix.acceptance import exceeded_gates
from tactfix.batching.row import BatchRow, row_of_failure, row_of_result
from tactfix.contacts import Contacts
from tactfix.errors import FileError, TactfixError
from tactfix.fixture import Fixture
from tactfix.localization.locate import locate
from tactfix.locate_result import LocateResult
from tactfix.settings import joined
from tactfix.values import frozen_value


@frozen_value(eq=True)
class ContactSet:
    """The contacts of one set as the bytes of a file, so that a worker does not need the file.

    name: its name in the results. unreadable: why there is no content, None if there is. lines: the line of the table
    for each line of content; None if content is a file of its own, empty if there are no lines.
    """

    name: str
    content: bytes = b""
    unreadable: str | None = None
    lines: tuple[int, ...] | None = None

    def key(self, task_digest: str) -> str:
        """A checksum of the task's digest, the name and the contacts: of all that its row depends on."""
        parts = (task_digest.encode(), self.name.encode(), self.content)
        return sha256(b"".join(len(part).to_bytes(8, "big") + part for part in parts)).hexdigest()


Reader: TypeAlias = Callable[[Fixture, ContactSet], tuple[Contacts, tuple[str, ...]]]
"""Reads the contacts of a set, with notes on what was left out. Raises TactfixError."""
Describe: TypeAlias = Callable[[LocateResult], str]
"""Why a result is not located, in one line."""
Numbered: TypeAlias = tuple[int, ContactSet]
NumberedRow: TypeAlias = tuple[int, BatchRow]


@frozen_value(eq=True)
class BatchTask:
    """The task for all sets of a batch; it is sent to every worker.

    max_sigma: limit on the worst sigma of point_fixture (3,), of the origin if that is None; max_rms: on the residuals;
    both in units. words: replaces the names of settings in messages.
    """

    fixture: Fixture
    read: Reader
    describe: Describe
    scale_sigma: bool = False
    max_sigma: float | None = None
    max_rms: float | None = None
    point_fixture: tuple[float, float, float] | None = None
    words: Callable[[str], str] = str


@frozen_value(eq=True)
class ChunkDone:
    """The rows of a chunk of sets, and the time they took (s)."""

    rows: tuple[NumberedRow, ...]
    seconds: float


def locate_chunk(task: BatchTask, chunk: Sequence[Numbered]) -> ChunkDone:
    """Locate each set of a chunk; runs in a worker."""
    start = perf_counter()
    rows = tuple((number, locate_set(task, contact_set)) for number, contact_set in chunk)
    return ChunkDone(rows, perf_counter() - start)


def locate_set(task: BatchTask, contact_set: ContactSet) -> BatchRow:
    """The row of one set. No content of a set makes it raise."""
    name, units = contact_set.name, task.fixture.units
    if contact_set.unreadable is not None:
        return row_of_failure(name, contact_set.unreadable, units)
    try:
        contacts, notes = task.read(task.fixture, contact_set)
        return _row(task, name, locate(task.fixture, contacts, scale_sigma=task.scale_sigma), notes)
    except FileError as error:
        # The row has the name of the set: the message omits that of the file.
        return row_of_failure(name, task.words(joined("\n", error.lines)), units)
    except TactfixError as error:
        return row_of_failure(name, task.words(error.args[0]), units)
    except Exception as error:  # whatever it is, the other sets must not be lost
        message = f"a bug in tactfix: {type(error).__name__}: {error}"
        return row_of_failure(name, f"{message}; please report it with this set", units)


def _row(task: BatchTask, name: str, result: LocateResult, notes: tuple[str, ...]) -> BatchRow:
    if result.status != "located":
        return row_of_result(name, result, task.describe(result), acceptable=False, notes=notes)
    point = None if task.point_fixture is None else np.array(task.point_fixture)
    exceeded = exceeded_gates(result, point, task.max_sigma, task.max_rms)
    return row_of_result(name, result, "; ".join(exceeded), acceptable=not exceeded, notes=notes)
