"""tactfix batch."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tactfix.cli.exits import Exit
from tactfix.cli.inputs import ContactInput, PlacementInput, takes_groups
from tactfix.cli.options import AsJson, FixturePath, Quiet, ScaleSigma, Scheduler, vector
from tactfix.cli.output import emit, note, print_notes, progress_bar
from tactfix.errors import UsageError
from tactfix.settings import on_command_line
from tactfix.version import VERSION

if TYPE_CHECKING:
    from tactfix.batching.batch import Spread
    from tactfix.batching.row import BatchRow
    from tactfix.batching.task import BatchTask
    from tactfix.files.batch_journal import BatchJournal
    from tactfix.locate_result import LocateResult
    from tactfix.report.batch_report import BatchCount, Writer


@takes_groups
def command(
    fixture_path: FixturePath,
    *,
    contacts: Annotated[
        list[str],
        typer.Argument(
            metavar="CONTACTS...",
            help="Contact files, directories of them, or tables (CSV or parquet) with a column set.",
            show_default=False,
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="FILE", help="A .parquet, .csv or .jsonl file; without it JSON lines are printed."
        ),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", metavar="N", min=1, help="Worker processes; one for each core.")
    ] = None,
    scheduler: Scheduler = None,
    touches: ContactInput,
    max_sigma: Annotated[
        float | None,
        typer.Option(metavar="S", min=0, help="Not acceptable if the worst sigma of the origin (or --at) exceeds S."),
    ] = None,
    max_rms: Annotated[
        float | None, typer.Option(metavar="R", min=0, help="Not acceptable if the rms of the residuals exceeds R.")
    ] = None,
    at: Annotated[
        str | None, typer.Option(metavar="X,Y,Z", help="Apply --max-sigma at this point of the fixture frame.")
    ] = None,
    placement: PlacementInput,
    scale_sigma: ScaleSigma = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> int:
    """Locate many contact sets of one fixture: a row for each, in their order, whatever its status.

    A batch that was stopped continues when the same command is run again: until all is done, its rows are kept next
    to the output, in FILE.partial.jsonl. parquet needs the extra 'batch', a cluster 'dask'.

    Exit status: 0 all are located and acceptable, 1 some are not (their rows say why), 3 none could be read.
    """
    from tactfix.batching.batch import run_batch
    from tactfix.batching.task import BatchTask
    from tactfix.files.contact_sets import SetReader, find_sets
    from tactfix.files.fixture_file import load_fixture
    from tactfix.report.batch_report import BatchCount, batch_json, batch_lines, find_writer, write_jsonl

    if as_json and output is None:
        raise UsageError("--json prints the number of sets by status; write their rows to a file: --output FILE")
    write = write_jsonl if output is None else find_writer(output.suffix.lower())
    spread = _spread(jobs, scheduler)
    task = BatchTask(
        fixture=placement.placed(load_fixture(fixture_path), quiet=quiet),
        read=SetReader(touches.contacts_format, touches.options(), touches.log_options()),
        describe=_in_one_line,
        scale_sigma=scale_sigma,
        max_sigma=max_sigma,
        max_rms=max_rms,
        point_fixture=None if at is None else vector(at, "--at"),
        words=on_command_line,
    )
    sets = find_sets(contacts, touches.contacts_format, output)
    count = BatchCount()
    with _journal(output) as journal:
        with _reporting_interrupts(journal, len(sets), output), progress_bar("locating", quiet=quiet) as show:
            rows = run_batch(
                task, sets, spread, journal, _digest(fixture_path, task), lambda n: show(n / len(sets), f"{n} sets")
            )
        _write(count.counted(rows), write, output)
        journal.remove()
    if as_json and output is not None:
        emit(batch_json(count, output))
    print_notes(batch_lines(count), quiet=quiet)
    return _exit_of(count)


def _in_one_line(result: "LocateResult") -> str:
    """Why a result is not located; empty if it is."""
    from tactfix.report.text_report import status_lines

    return "; ".join(line.strip() for line in status_lines(result))


def _spread(jobs: int | None, scheduler: str | None) -> "Spread":
    """Where the work is done: on a cluster, in processes of this machine, or in this process if one is enough."""
    from tactfix.batching.batch import here, spread_over
    from tactfix.batching.cluster import DaskCluster
    from tactfix.batching.processes import LocalProcesses, cores

    if scheduler is not None:
        if jobs is not None:
            raise UsageError("--jobs is for this machine; a cluster has the workers that it has")
        return partial(spread_over, DaskCluster(scheduler))
    wanted = cores() if jobs is None else jobs
    return here if wanted == 1 else partial(spread_over, LocalProcesses(wanted))


def _digest(fixture_path: Path, task: "BatchTask") -> str:
    """A checksum of everything that the rows depend on, except the contacts."""
    from hashlib import sha256

    from tactfix.files.reading import read_bytes

    rest = (VERSION, task.read, task.scale_sigma, task.max_sigma, task.max_rms, task.point_fixture)
    # Its poses may come from other files than the fixture's.
    known = task.fixture.placement
    placement = (
        None if known is None else (known.near.tolist(), known.within, str(known.sigma), sorted(known.free or ()))
    )
    return sha256(read_bytes(fixture_path) + repr((rest, placement)).encode()).hexdigest()


@contextmanager
def _journal(output: Path | None) -> "Iterator[BatchJournal]":
    """The journal next to the output; without an output, a temporary one."""
    from tactfix.files.batch_journal import BatchJournal, journal_path

    if output is not None:
        with BatchJournal(journal_path(output)) as journal:
            yield journal
        return
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as directory, BatchJournal(Path(directory) / "journal") as journal:
        yield journal


@contextmanager
def _reporting_interrupts(journal: "BatchJournal", sets: int, output: Path | None) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        if output is not None:
            note(f"{len(journal)} of {sets} sets are done and kept; run the same command again to continue")
        raise


def _write(rows: "Iterable[BatchRow]", write: "Writer", output: Path | None) -> None:
    """Write the rows to the output, whole or not at all, or to standard output."""
    from tactfix.files.writing import whole_file

    if output is not None:
        with whole_file(output) as file:
            write(rows, file)
        return
    printed = BytesIO()
    write(rows, printed)
    emit(printed.getvalue())


def _exit_of(count: "BatchCount") -> Exit:
    """0 if all sets are acceptable, 3 if none could be read, 1 otherwise."""
    if not count.refused:
        return Exit.DONE
    return Exit.FILE if count.by_status["error"] == count.sets else Exit.NOT_ACCEPTABLE
