"""Timing for the benchmarks: the best of several runs, as a multiple of a numpy operation timed in the same run.

Ratios depend far less on the machine and its load than seconds do. Run the scripts one at a time.
"""

import os
import platform
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path

ROOT = Path(__file__).parents[2]
IMPORT_NUMPY = (sys.executable, "-c", "import numpy")


def heading(title: str) -> str:
    """Title, date, commit and machine of a benchmark."""
    try:
        describe = ["git", "describe", "--always", "--dirty", "--exclude=*"]
        commit = subprocess.run(describe, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        commit = "unknown"
    machine = f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return f"{title} ({datetime.now(UTC):%Y-%m-%d}, commit {commit}; {machine}{load})"


def table(columns: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A markdown table."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def seconds(work: Callable[[], object]) -> float:
    """Elapsed time of one run."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def best_of_each(works: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """The shortest processor time (s) of each function over this number of rounds, each called once in every round.

    Processor time does not depend on other processes; each function must run in one thread.
    """
    best = dict.fromkeys(works, float("inf"))
    for _ in range(rounds):
        for name, work in works.items():
            start = time.process_time()
            work()
            best[name] = min(best[name], time.process_time() - start)
    return best


def best_processes(commands: dict[str, Sequence[str]], rounds: int) -> dict[str, tuple[float, float]]:
    """The shortest elapsed and the shortest processor time (s) of each command, over the whole life of its process."""
    best = dict.fromkeys(commands, (float("inf"), float("inf")))
    for _ in range(rounds):
        for name, command in commands.items():
            before = _children()
            elapsed = seconds(
                lambda command=command: subprocess.run(command, cwd=ROOT, capture_output=True, check=True)
            )
            best[name] = (min(best[name][0], elapsed), min(best[name][1], _children() - before))
    return best


def _children() -> float:
    """Processor time (s) of all child processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
