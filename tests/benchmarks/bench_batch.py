"""In bulk: sets a second of `tactfix batch` by the number of worker processes, against locate one at a time.

python tests/benchmarks/bench_batch.py [SETS] [JOBS ...]
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from clock import ROOT, heading, seconds, table

os.environ.setdefault("OMP_NUM_THREADS", "1")

from tactfix import load_fixture, locate, simulate
from tactfix.report.plan_csv import simulation_csv

FIXTURE = "fixtures/robot-cell-plate.yaml"


def main(count: int, jobs: list[int]) -> None:
    fixture = load_fixture(ROOT / FIXTURE)
    simulations = [simulate(fixture, seed=seed) for seed in range(min(count, 200))]
    touched = [one.contacts for one in simulations]
    alone = seconds(lambda: [locate(fixture, contacts) for contacts in touched]) / len(touched)
    rows = [("locate in process", "1", f"{1 / alone:.0f}", "1.00")]
    with tempfile.TemporaryDirectory() as directory:
        source = Path(directory) / "table.csv"
        source.write_text(as_table([simulation_csv(one) for one in simulations], count))
        for number in jobs:
            rows.append(batch_row(source, count, number, alone))
    print(heading(f"In bulk, {count} sets of {len(touched[0])} contacts, {FIXTURE}") + "\n")
    print(table(("what", "processes", "sets a second", "x one at a time"), rows))


def batch_row(source: Path, count: int, jobs: int, alone: float) -> tuple[str, ...]:
    out = source.with_name(f"{jobs}.csv")
    command = [sys.executable, "-m", "tactfix", "batch", FIXTURE, str(source), "-o", str(out), "-j", str(jobs), "-q"]
    took = seconds(lambda: subprocess.run(command, cwd=ROOT, check=False))
    return (
        f"`tactfix batch --jobs {jobs}`, whole command",
        str(jobs),
        f"{count / took:.0f}",
        f"{count * alone / took:.2f}",
    )


def as_table(files: list[str], count: int) -> str:
    """count sets as one table, by turns from the files."""
    settings = [line for line in files[0].splitlines() if line.startswith(("# units", "# tip_radius", "# sigma"))]
    header = next(line for line in files[0].splitlines() if not line.startswith("#"))
    bodies = [[line for line in text.splitlines() if line and line[0] != "#"][1:] for text in files]
    lines = (f"{k},{line}" for k in range(count) for line in bodies[k % len(bodies)])
    return "\n".join([*settings, "set," + header, *lines]) + "\n"


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:]]
    cores = os.cpu_count() or 1
    main(numbers[0] if numbers else 2000, numbers[1:] or sorted({1, 2, cores}))
