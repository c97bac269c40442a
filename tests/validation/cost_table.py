"""Time and memory of locate and batch against the numbers of contacts, features and sets, as tables for the README.

    OMP_NUM_THREADS=1 python -m tests.validation.cost_table [contacts|features|sets] [--most COUNT] [--patience SECONDS]

Each row is measured in a separate process; memory is its largest resident set, of which tactfix and numpy need about
40 MB without any contact. Times are processor times, which depend little on other processes. The tables take a few
minutes; rows that would exceed --patience are extrapolated and marked.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

import numpy as np

from tests.benchmarks.clock import heading, table
from tests.support.project import ROOT

SIGMA, RADIUS = 0.01, 12.7
PATIENCE = 100.0
"""Seconds after which a table is not continued by measuring."""


def fixture_text(balls: int) -> str:
    """Balls on a square grid, at slightly different heights so that no mirror image fits."""
    places = grid(balls)
    lines = [f"  b{k}: {{type: sphere, radius: {RADIUS}, center: {place.tolist()}}}" for k, place in enumerate(places)]
    head = f"tactfix: 1\nname: balls\nunits: mm\nprobe: {{tip_radius: 0.0, sigma: {SIGMA}}}\nfeatures:\n"
    return head + "\n".join(lines) + "\n"


def grid(balls: int) -> np.ndarray:
    side = int(np.ceil(np.sqrt(balls)))
    index = np.arange(balls)
    lift = np.random.default_rng(7).uniform(0, 60, balls)
    return np.column_stack([100.0 * (index % side), 100.0 * (index // side), lift])


def touches(balls: int, count: int, seed: int = 1) -> list[str]:
    """count rows of a contact file, on the balls in turn, at a fixed pose, with noise."""
    rng = np.random.default_rng(seed)
    q, r = np.linalg.qr(rng.standard_normal((3, 3)))
    q *= np.sign(np.diag(r))
    rotation = q * np.linalg.det(q)
    normals = rng.standard_normal((count, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    owner = np.arange(count) % balls
    points = grid(balls)[owner] + normals * (RADIUS + SIGMA * rng.standard_normal((count, 1)))
    cells = np.hstack([points @ rotation.T + [700.0, -300.0, 100.0], -normals @ rotation.T]).tolist()
    return [f"b{k},{','.join(map(repr, row))}" for k, row in zip(owner.tolist(), cells, strict=True)]


def contact_file(balls: int, count: int) -> str:
    return "\n".join(["feature,x,y,z,ax,ay,az", *touches(balls, count)]) + "\n"


def megabytes(who: int) -> float:
    """The largest resident set so far (MB): kilobytes on Linux, bytes on macOS."""
    return resource.getrusage(who).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)


def measure_locate(fixture_path: str, contacts: str) -> None:
    """Run in a separate process: read and locate, and print times (s) and memory (MB)."""
    from tactfix import load_contacts, load_fixture, locate

    times = [time.process_time()]
    fixture = load_fixture(fixture_path)
    read = load_contacts(contacts, fixture)
    times.append(time.process_time())
    memory = megabytes(resource.RUSAGE_SELF)
    result = locate(fixture, read)
    times.append(time.process_time())
    took = [after - before for before, after in pairwise(times)]
    print(json.dumps([*took, memory, megabytes(resource.RUSAGE_SELF), result.status]))


def located(directory: Path, balls: int, count: int) -> tuple[float, float, float, float, str]:
    fixture, contacts = directory / "fixture.yaml", directory / "contacts.csv"
    fixture.write_text(fixture_text(balls))
    contacts.write_text(contact_file(balls, count))
    command = [sys.executable, "-m", "tests.validation.cost_table", "--measure", str(fixture), str(contacts)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return tuple(json.loads(done.stdout))


def locate_row(directory: Path, balls: int, count: int) -> tuple[object, ...]:
    reading, locating, read, memory, status = located(directory, balls, count)
    return f"{balls:,}", f"{count:,}", status, f"{reading:.3f}", f"{locating:.3f}", f"{read:.0f}", f"{memory:.0f}"


def by_contacts(directory: Path, most: int, patience: float, jobs: int) -> str:
    del jobs
    return locate_table(directory, [(3, 10**k) for k in range(1, 7) if 10**k <= most], patience)


def by_features(directory: Path, most: int, patience: float, jobs: int) -> str:
    del jobs
    return locate_table(directory, [(n, 4 * n) for n in (1, 3, 10, 30, 100) if n <= most], patience)


def locate_table(directory: Path, cases: list[tuple[int, int]], patience: float) -> str:
    spent, rows = 0.0, []
    for balls, count in cases:
        if spent > patience:
            rows.append((f"{balls:,}", f"{count:,}", "not measured", *[""] * 4))
            continue
        rows.append(locate_row(directory, balls, count))
        spent += float(rows[-1][3]) + float(rows[-1][4])
    return table(("balls", "contacts", "status", "read, s", "locate, s", "MB when read", "MB in all"), rows)


def by_sets(directory: Path, most: int, patience: float, jobs: int) -> str:
    """Batches of sets of 12 contacts; rows beyond patience are extrapolated and marked."""
    fixture, source = directory / "fixture.yaml", directory / "table.csv"
    fixture.write_text(fixture_text(3))
    different = [touches(3, 12, seed) for seed in range(100)]
    rows, each, base = [], 0.0, 0.0
    for sets in (10**k for k in range(7)):
        if sets <= most and sets * each < patience:
            with source.open("w") as file:
                file.write("set,feature,x,y,z,ax,ay,az\n")
                file.writelines(f"{k},{row}\n" for k in range(sets) for row in different[k % 100])
            took, memory = batched(fixture, source, jobs)
            base = took if sets == 1 else base
            each = max(took - base, 1e-9) / sets
            rows.append((f"{sets:,}", f"{took:.1f}", f"{sets / took:.0f}", f"{memory:.0f}", "measured"))
        else:
            took = base + sets * each
            rows.append((f"{sets:,}", f"{took:.0f}", f"{sets / took:.0f}", "", "extrapolated"))
    return table(("sets of 12 contacts", "s", "sets a second", "memory, MB", ""), rows)


def batched(fixture: Path, source: Path, jobs: int) -> tuple[float, float]:
    """Processor time (s) of `tactfix batch` with its workers, and memory (MB) of the largest process."""
    command = [sys.executable, "-m", "tactfix", "batch", str(fixture), str(source), "-j", str(jobs), "-q"]
    with subprocess.Popen([*command, "-o", str(source.with_name("out.parquet"))], cwd=ROOT) as process:
        _, status, used = wait4(process)
    assert status == 0
    return used.ru_utime + used.ru_stime, used.ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)


def wait4(process: subprocess.Popen) -> tuple[int, int, resource.struct_rusage]:
    """The resources of this process alone, unlike RUSAGE_CHILDREN, which gives the maximum over all children."""
    found = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(found[1])
    return found


TABLES = {"contacts": (by_contacts, 1_000_000), "features": (by_features, 100), "sets": (by_sets, 1_000_000)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", nargs="?", choices=TABLES, help="all of them where none is named")
    parser.add_argument("--most", type=int, help="the largest count that is measured")
    parser.add_argument("--patience", type=float, default=PATIENCE, metavar="SECONDS", help="for one row, about")
    parser.add_argument("--jobs", type=int, default=1, help="processes of a batch")
    options = parser.parse_args()
    for name, (measure, usual) in TABLES.items():
        if options.table in (None, name):
            with tempfile.TemporaryDirectory() as directory:
                most = usual if options.most is None else options.most
                print(heading(f"Cost by {name}"))
                print("\n" + measure(Path(directory), most, options.patience, options.jobs) + "\n", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--measure"]:
        measure_locate(*sys.argv[2:])
    else:
        main()
