"""The command batch: one row for each set, in order, in three output formats, also when resumed."""

import csv
import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tactfix.batching.cluster import DaskCluster
from tactfix.errors import MissingExtraError
from tactfix.report.batch_report import WRITERS, find_writer
from tests.support.command_line import Ran, tactfix
from tests.support.contact_sets import contact_file, pose, rows, write_cell

TACTFIX = [sys.executable, "-m", "tactfix"]


def batch(*words: object, stdin: str = "") -> Ran:
    return tactfix("batch", *words, stdin=stdin)


def json_rows(path: Path) -> list[dict]:
    return [json.loads(line) for line in path.read_text().splitlines()]


@pytest.fixture
def cell(tmp_path: Path) -> tuple[Path, Path]:
    return write_cell(tmp_path, 5)


def damage(sets: Path) -> None:
    """Damage the sets: one of each kind of failure."""
    (sets / "001.csv").write_bytes(b"feature,x,y,z\n\xff")
    (sets / "002.csv").write_text("\n".join(contact_file(2).splitlines()[:8]))
    # Reversed approaches: a cause that is found quickly.
    normals = [",".join([*row.split(",")[:4], *(repr(-float(a)) for a in row.split(",")[4:])]) for row in rows(3)]
    (sets / "003.csv").write_text("\n".join(["feature,x,y,z,ax,ay,az", *normals]))


@pytest.fixture(scope="module")
def damaged(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Ran, Path]:
    """A fixture, damaged sets, the summary of a batch of them, and its JSON rows."""
    folder = tmp_path_factory.mktemp("spoilt")
    fixture, sets = write_cell(folder, 5)
    damage(sets)
    out = folder / "r.jsonl"
    return fixture, sets, batch(fixture, sets, "--output", out, "--jobs", 2), out


def test_every_set_is_a_row(damaged: tuple[Path, Path, Ran, Path]) -> None:
    _, sets, done, out = damaged
    output_rows = json_rows(out)
    assert done.returncode == 1
    assert done.stdout == ""
    assert [row["set"] for row in output_rows] == [str(sets / f"{k:03d}.csv") for k in range(5)]
    assert [row["status"] for row in output_rows] == ["located", "error", "underdetermined", "inconsistent", "located"]
    assert [row["acceptable"] for row in output_rows] == [True, False, False, False, True]
    assert "not UTF-8" in output_rows[1]["message"]
    assert "motion free" in output_rows[2]["message"]
    assert output_rows[2]["transform"] is output_rows[2]["sigmas"] is None
    for k in (0, 4):
        assert np.abs(np.array(output_rows[k]["transform"]) - pose(k)).max() < 1e-6
        assert len(output_rows[k]["sigmas"]) == 6
    assert "5 sets: 2 located, 1 underdetermined, 1 inconsistent, 1 error" in done.stderr
    assert not out.with_name("r.jsonl.partial.jsonl").exists()


def test_csv_and_parquet_agree_to_the_last_bit(damaged: tuple[Path, Path, Ran, Path], tmp_path: Path) -> None:
    fixture, sets, _, out = damaged
    for ending in ("csv", "parquet"):
        if ending == "parquet":
            pytest.importorskip("pyarrow")
        batch(fixture, sets, "--output", tmp_path / f"r.{ending}", "--jobs", 1)
    reference = json_rows(out)
    with (tmp_path / "r.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert [line["set"] for line in lines] == [row["set"] for row in reference]
    assert [line["message"] for line in lines] == [row["message"] for row in reference]
    first = [[float(lines[0][f"m{i}{k}"]) for k in range(1, 5)] for i in range(1, 5)]
    assert first == reference[0]["transform"]
    assert [float(lines[0][f"sigma_{name}"]) for name in ("rx", "ry", "rz", "tx", "ty", "tz")] == reference[0]["sigmas"]
    assert lines[1]["m11"] == lines[1]["rms"] == ""

    pq = pytest.importorskip("pyarrow.parquet")
    for row, expected in zip(pq.read_table(tmp_path / "r.parquet").to_pylist(), reference, strict=True):
        flat = expected["transform"] and [value for line in expected["transform"] for value in line]
        assert row == {**expected, "transform": flat}


def test_without_an_output_rows_are_printed(cell: tuple[Path, Path]) -> None:
    fixture, sets = cell
    done = batch(fixture, sets, "--jobs", 1, "--quiet")
    assert done.returncode == 0
    assert done.stderr == ""
    assert [json.loads(line)["status"] for line in done.stdout.splitlines()] == ["located"] * 5


def test_a_table_on_standard_input(cell: tuple[Path, Path]) -> None:
    fixture, _ = cell
    text = "set,feature,x,y,z,ax,ay,az\n" + "".join(f"s{k},{row}\n" for k in (1, 0) for row in rows(k))
    done = batch(fixture, "-", "--jobs", 1, stdin=text)
    assert [json.loads(line)["set"] for line in done.stdout.splitlines()] == ["s1", "s0"]


def test_options_apply_to_every_set(cell: tuple[Path, Path]) -> None:
    fixture, sets = cell
    done = batch(
        fixture, sets, "--jobs", 1, "--sigma", "0.5", "--max-rms", "1e-15", "--json", "--output", sets / "r.csv"
    )
    assert done.returncode == 1
    counted = json.loads(done.stdout)
    assert (counted["sets"], counted["acceptable"], counted["statuses"]["located"]) == (5, 0, 5)
    with (sets / "r.csv").open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert all(0.05 < float(line["sigma_tx"]) < 1 for line in lines)
    assert all("above the limit of 1e-15 mm" in line["message"] for line in lines)


def test_a_machine_log_for_each_set(tmp_path: Path) -> None:
    fixture, _ = write_cell(tmp_path, 0)
    log = "".join("[PRB:{},{},{}:1]\n".format(*row.split(",")[1:4]) for row in rows(0))
    (tmp_path / "one.log").write_text("[PRB:0,0,0:0]\n" + log)
    words = ("--contacts-format", "grbl", "--features", "a:5,b:5,c:5", "--units", "mm", "--jobs", 1)
    done = batch(fixture, tmp_path / "one.log", *words)
    (row,) = map(json.loads, done.stdout.splitlines())
    assert row["status"] == "located", row
    assert any("line 1" in warning for warning in row["warnings"])


@pytest.mark.parametrize(
    ("words", "status", "message"),
    [
        (("{cell}/sets", "--output", "r.xlsx"), 2, ".parquet, .csv, .jsonl"),
        (("{cell}/sets", "--jobs", "0"), 2, "--jobs"),
        (("{cell}/sets", "--jobs", "1", "--scheduler", "tcp://127.0.0.1:1"), 2, "--jobs"),
        (("{cell}/sets", "--json"), 2, "write their rows to a file: --output FILE"),
        (("{cell}/sets", "--json", "--output", "-"), 2, "write their rows to a file: --output FILE"),
        (("{cell}/sets", "--features", "a:1"), 2, "--contacts-format"),
        (("{cell}/sets", "--output", "nowhere/r.csv"), 3, "nowhere"),
        (("{cell}", "--output", "r.csv"), 3, "no contact files"),
        (("no-such.csv", "--output", "r.csv"), 3, "no-such.csv: there is no such file or folder; check the path"),
        (("no-such-folder", "--output", "r.csv"), 3, "no-such-folder: there is no such file or folder"),
        (("{cell}/t.parquet",), 3, "t.parquet"),
    ],
)
def test_invalid_input(
    cell: tuple[Path, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: tuple[str, ...],
    status: int,
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    done = batch(cell[0], *(word.format(cell=tmp_path) for word in words))
    assert done.returncode == status, done.stderr
    assert message in done.stderr
    assert not list(tmp_path.glob("*.partial.jsonl"))


def test_an_extra_that_is_missing_is_named_before_any_work(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("pyarrow", "distributed"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingExtraError, match=r"pip install '\.\[batch\]'"):
        find_writer(".parquet")
    with pytest.raises(MissingExtraError, match=r"pip install '\.\[dask\]'"):
        DaskCluster("tcp://127.0.0.1:1").open().__enter__()
    assert find_writer(".csv") is WRITERS[".csv"]


def wait_for_rows(journal: Path, count: int, process: subprocess.Popen[str]) -> None:
    until = time.monotonic() + 60
    while time.monotonic() < until and process.poll() is None:
        if journal.exists() and journal.read_bytes().count(b"\n") > count:
            return
        time.sleep(0.01)
    pytest.fail(f"no {count} rows, exit status {process.poll()}")


def children_of(pid: int) -> list[Path]:
    """The child processes of a process, as directories of /proc, which exist while they run; none without /proc."""
    listed = Path(f"/proc/{pid}/task/{pid}/children")
    return [Path("/proc", child) for child in listed.read_text().split()] if listed.exists() else []


def lives(process: Path) -> bool:
    try:
        return "\nState:\tZ" not in (process / "status").read_text()
    except OSError:
        return False


def assert_end(processes: list[Path]) -> None:
    until = time.monotonic() + 20
    while any(map(lives, processes)):
        assert time.monotonic() < until, "a worker outlives its parent"
        time.sleep(0.05)


MANY_EACH = 80
"""Sets for each process, which take about 0.4 s, so that a signal arrives before the last one."""


def marked(line: bytes) -> bytes:
    """A line of the journal with a changed message and a valid checksum."""
    done = re.fullmatch(rb'{"sha256": "\w+", "done": (.*)}\n', line)[1]  # type: ignore[index]
    done = done.replace(b'"message": ""', b'"message": "kept"')
    return b'{"sha256": "%s", "done": %s}\n' % (hashlib.sha256(done).hexdigest().encode(), done)


@pytest.mark.parametrize(
    ("stop", "jobs"),
    [("SIGKILL", 2), pytest.param("SIGINT", 2, marks=pytest.mark.slow), ("SIGINT", 1), ("SIGTERM", 1)],
)
def test_a_stopped_batch_resumes(tmp_path: Path, stop: str, jobs: int) -> None:
    if not hasattr(signal, stop) or os.name == "nt":
        pytest.skip(f"no {stop} here")
    fixture, _ = write_cell(tmp_path, 0)
    many = MANY_EACH * jobs
    text = "set,feature,x,y,z,ax,ay,az\n" + "".join(f"s{k},{row}\n" for k in range(many) for row in rows(k))
    (tmp_path / "t.csv").write_text(text)
    out, journal = tmp_path / "r.jsonl", tmp_path / "r.jsonl.partial.jsonl"
    words = [str(fixture), str(tmp_path / "t.csv"), "-o", str(out), "--jobs", str(jobs)]
    process = subprocess.Popen([*TACTFIX, "batch", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_for_rows(journal, 5, process)
    workers = children_of(process.pid)
    process.send_signal(getattr(signal, stop))
    _, errors = process.communicate(timeout=30)
    assert process.returncode == {"SIGKILL": -9, "SIGTERM": 143, "SIGINT": 130}[stop]
    if stop != "SIGKILL":
        assert "run the same command again to continue" in errors
        assert "Traceback" not in errors
    assert not out.exists()
    assert_end(workers)
    kept = journal.read_bytes().splitlines(keepends=True)
    assert 5 < len(kept) < many
    whole = [line for line in kept if line.endswith(b"\n")]
    # The kept rows are marked, so that the output shows whether they were read from the journal.
    journal.write_bytes(b"".join([whole[0], *map(marked, whole[1:])]))
    done = batch(*words)
    assert done.returncode == 0, done.stderr
    output_rows = json_rows(out)
    assert [row["set"] for row in output_rows] == [f"s{k}" for k in range(many)]
    assert sum(row["message"] == "kept" for row in output_rows) == len(whole) - 1
    for k, row in enumerate(output_rows):
        assert np.abs(np.array(row["transform"]) - pose(k)).max() < 1e-6
    assert not journal.exists()
