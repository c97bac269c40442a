"""Processor time of `tactfix batch` by the number of worker processes, compared with single locate calls (Linux only).

python tests/benchmarks/bench_batch.py [SETS] [JOBS ...]
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from clock import ROOT, heading, table

os.environ.setdefault("OMP_NUM_THREADS", "1")

from tactfix import load_fixture, locate, simulate
from tactfix.report.plan_report import simulation_csv

FIXTURE = "fixtures/robot-cell-plate.yaml"


def main(count: int, jobs: list[int]) -> None:
    fixture = load_fixture(ROOT / FIXTURE)
    simulations = [simulate(fixture, seed=seed) for seed in range(min(count, 200))]
    touched = [one.contacts for one in simulations]
    start = time.process_time()
    for contacts in touched:
        locate(fixture, contacts)
    alone = (time.process_time() - start) / len(touched) * count
    rows = [("locate in process", f"{count / alone:.0f}", f"{alone:.1f}", f"{alone:.1f}", "1.00", "")]
    with tempfile.TemporaryDirectory() as directory:
        source = Path(directory) / "table.csv"
        source.write_text(as_table([simulation_csv(one) for one in simulations], count))
        rows += [batch_row(source, count, number, alone) for number in jobs]
    print(heading(f"In bulk, {count} sets of {len(touched[0])} contacts, {FIXTURE}") + "\n")
    print(table(COLUMNS, rows))


COLUMNS = (
    "what",
    "sets a second of the busiest process",
    "processor s, all processes",
    "processor s, busiest process",
    "speed-up where each has a core",
    "elapsed s here",
)


def batch_row(source: Path, count: int, jobs: int, alone: float) -> tuple[str, ...]:
    """One run of the command. Speed-up: processor time of sequential locate calls over that of the busiest process.

    Elapsed time is comparable only on an idle machine.
    """
    out = source.with_name(f"{jobs}.csv")
    command = [sys.executable, "-m", "tactfix", "batch", FIXTURE, str(source), "-o", str(out), "-j", str(jobs), "-q"]
    took, used = watched(command)
    busiest = max(used.values())
    return (
        f"`tactfix batch --jobs {jobs}`, whole command",
        f"{count / busiest:.0f}",
        f"{sum(used.values()):.1f}",
        f"{busiest:.1f}",
        f"{alone / busiest:.2f}",
        f"{took:.1f}",
    )


def watched(command: list[str]) -> tuple[float, dict[int, float]]:
    """Elapsed time (s) of a command, and processor time (s) of it and of each child process, by process id.

    Read from /proc twenty times a second: the last twentieth of a second of a process is missed.
    """
    used: dict[int, float] = {}
    start = time.perf_counter()
    with subprocess.Popen(command, cwd=ROOT) as process:
        while process.poll() is None:
            for number in (process.pid, *children(process.pid)):
                used[number] = processor_time(number) or used.get(number, 0.0)
            time.sleep(0.05)
    return time.perf_counter() - start, used


def children(number: int) -> list[int]:
    try:
        return [int(word) for word in Path(f"/proc/{number}/task/{number}/children").read_text().split()]
    except OSError:
        return []


def processor_time(number: int) -> float | None:
    """Processor time (s) of a process without its children; None if it has ended."""
    try:
        fields = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return None
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def as_table(files: list[str], count: int) -> str:
    """A table of count sets, taken from the files in turn."""
    settings = [line for line in files[0].splitlines() if line.startswith(("# units", "# tip_radius", "# sigma"))]
    header = next(line for line in files[0].splitlines() if not line.startswith("#"))
    bodies = [[line for line in text.splitlines() if line and line[0] != "#"][1:] for text in files]
    lines = (f"{k},{line}" for k in range(count) for line in bodies[k % len(bodies)])
    return "\n".join([*settings, "set," + header, *lines]) + "\n"


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:]]
    cores = os.cpu_count() or 1
    main(numbers[0] if numbers else 2000, numbers[1:] or sorted({1, 2, cores}))
