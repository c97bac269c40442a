"""Long studies in blocks: numbered tasks on several processes, whose results are recorded and not computed again.

A record holds one line of JSON for each block: its task and its result. A record belongs to one version of the code:
start a new one after a change.
"""

import argparse
import json
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any, TypeVar

from tests.validation.kinds import KINDS
from tests.validation.pose_problems import LAYOUTS

Task = tuple[Any, ...]
Name = TypeVar("Name")
BLOCK = 50


def numbered(first: int, count: int) -> list[tuple[int, int]]:
    """First number and size of each block of problems; blocks do not depend on the first and last number of a run."""
    last, blocks = first + count, []
    while first < last:
        size = min(BLOCK - first % BLOCK, last - first)
        blocks.append((first, size))
        first += size
    return blocks


def options_of_series(description: str, kinds: Sequence[str]) -> argparse.ArgumentParser:
    """The options of a study of numbered problems, with the default kinds."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", nargs="+", choices=list(KINDS), default=list(kinds), metavar="KIND")
    parser.add_argument("--layout", nargs="+", choices=LAYOUTS, default=list(LAYOUTS))
    parser.add_argument("--problems", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="number of the first problem")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--record", type=Path, help="file of finished blocks; those in it are not done again")
    parser.add_argument("--replay", type=int, metavar="NUMBER", help="show this problem of the kind and layout alone")
    return parser


def by_row(
    rows: dict[Name, Sequence[Task]], work: Callable[..., Any], jobs: int, record: Path | None
) -> Iterator[tuple[Name, Any, list[Any] | None]]:
    """work(*task) for every task of every row: row, result, and with the last block of a row all its results in order.

    work must be a module-level function, and its results must be representable in JSON.
    """
    kept = _kept(record)
    names = {task: name for name, tasks in rows.items() for task in tasks}
    done: dict[Task, Any] = {}
    for task, result, is_new in _results(list(names), kept, work, jobs):
        if is_new and record is not None:
            with record.open("a") as file:
                file.write(json.dumps([task, result]) + "\n")
        done[task] = result
        name = names[task]
        complete = all(other in done for other in rows[name])
        yield name, result, [done[other] for other in rows[name]] if complete else None


def _kept(record: Path | None) -> dict[Task, Any]:
    if record is None or not record.exists():
        return {}
    return {tuple(task): result for task, result in map(json.loads, record.read_text().splitlines())}


def _results(
    tasks: list[Task], kept: dict[Task, Any], work: Callable[..., Any], jobs: int
) -> Iterator[tuple[Task, Any, bool]]:
    """Each task, its result, and whether it was computed in this run."""
    for task in tasks:
        if task in kept:
            yield task, kept[task], False
    left = [task for task in tasks if task not in kept]
    if jobs == 1:
        for task in left:
            yield task, work(*task), True
        return
    with ProcessPoolExecutor(jobs) as pool:
        futures = {pool.submit(work, *task): task for task in left}
        for future in as_completed(futures):
            yield futures[future], future.result(), True
