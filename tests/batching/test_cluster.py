"""Work on a cluster of worker processes, one of which is killed: every set once, the same results as in process."""

import json
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from tactfix import load_fixture, locate, plan
from tactfix.batching.batch import run_batch, spread_over
from tactfix.batching.cluster import ClusterError, DaskCluster
from tactfix.batching.task import BatchTask, locate_set
from tactfix.cli import main
from tactfix.design.random_layouts import Study, study_layouts
from tactfix.files.batch_journal import BatchJournal
from tactfix.report.plan_report import plan_json
from tests.support.contact_sets import PLAIN, blank, contact_sets, rows, slow, write_cell

pytest.importorskip("distributed", reason="needs the extra: pip install 'tactfix[dask]'")
SCRIPT = Path(__file__).parents[1] / "support" / "local_cluster.py"
# Clients in this process leave threads behind, and their libraries issue warnings.
pytestmark = pytest.mark.filterwarnings("default")


class Cluster:
    """The address of the cluster, and a method that kills one of its workers."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.process = process
        assert process.stdout is not None
        self.address = process.stdout.readline().strip()

    def kill_one(self) -> int:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write("kill\n")
        self.process.stdin.flush()
        return int(self.process.stdout.readline())


@pytest.fixture(scope="module")
def cluster() -> Iterator[Cluster]:
    path = ":".join(sys.path)
    # Rows are compared bit by bit, so the workers need the same environment, which selects the BLAS kernels.
    environment = {**os.environ, "PYTHONPATH": path, "PATH": "", "OMP_NUM_THREADS": "1"}
    command = [sys.executable, str(SCRIPT)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        yield Cluster(process)
        process.communicate()


def test_one_worker_killed_half_way(cluster: Cluster, tmp_path: Path) -> None:
    fixture, _ = write_cell(tmp_path, 0)
    task = BatchTask(load_fixture(fixture), slow(0.05), blank)
    sets = contact_sets(24)
    killed: list[int] = []
    done: list[int] = []

    def kill_after_a_third(count: int) -> None:
        done.append(count)
        if count >= len(sets) // 3 and not killed:
            killed.append(cluster.kill_one())

    with BatchJournal(tmp_path / "journal") as journal:
        found = list(
            run_batch(
                task, sets, lambda *a: spread_over(DaskCluster(cluster.address), *a), journal, "", kill_after_a_third
            )
        )
    assert killed
    assert done == list(range(1, len(sets) + 1))
    written = [json.loads(line)["done"] for line in (tmp_path / "journal").read_text().splitlines()[1:]]
    assert Counter(line["row"]["set"] for line in written) == {one.name: 1 for one in sets}
    plain = BatchTask(task.fixture, PLAIN, blank)
    assert found == [locate_set(plain, one) for one in sets]


def test_a_study_of_layouts_survives_a_killed_worker(cluster: Cluster, tmp_path: Path) -> None:
    path, _ = write_cell(tmp_path, 0)
    fixture = load_fixture(path)
    study = Study(layouts=6, seed=1, sigma=0.02, tip_radius=0.0)
    locator = partial(locate, fixture, explain=False)
    sets = [("", dict.fromkeys(fixture.features, 2))]
    here = study_layouts(fixture, study, sets, locator)
    killed: list[int] = []

    def kill_after_start(share: float, _: str) -> None:
        if share > 0 and not killed:
            killed.append(cluster.kill_one())

    with DaskCluster(cluster.address).mapping() as over:
        assert study_layouts(fixture, study, sets, locator, progress=kill_after_start, over=over) == here
    assert killed


@pytest.mark.slow
def test_a_search_for_a_plan_survives_a_killed_worker(cluster: Cluster, tmp_path: Path) -> None:
    path, _ = write_cell(tmp_path, 0)
    fixture = load_fixture(path)
    here = plan(fixture, contacts=6, starts=12)
    killed: list[int] = []

    def kill_after_start(share: float, _: str) -> None:
        if share > 0 and not killed:
            killed.append(cluster.kill_one())

    with DaskCluster(cluster.address).mapping() as over:
        on_cluster = plan(fixture, contacts=6, starts=12, progress=kill_after_start, over=over)
    assert killed
    assert plan_json(on_cluster) == plan_json(here)
    assert here.starts == 12


@pytest.mark.parametrize(("command", "missing"), [("design-check", "--study N"), ("plan", "--starts N")])
def test_a_scheduler_without_a_study_is_refused(command: str, missing: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "no.yaml", "--scheduler", "tcp://nowhere:1"]) == 2
    assert missing in capsys.readouterr().err


@pytest.mark.slow
def test_the_command_gives_the_same_rows_with_a_cluster(cluster: Cluster, tmp_path: Path) -> None:
    fixture, _ = write_cell(tmp_path, 0)
    text = "set,feature,x,y,z,ax,ay,az\n" + "".join(f"s{k},{row}\n" for k in range(20) for row in rows(k))
    (tmp_path / "t.csv").write_text(text)
    printed = []
    for words in (["--scheduler", cluster.address], ["--jobs", "1"]):
        command = [sys.executable, "-m", "tactfix", "batch", str(fixture), str(tmp_path / "t.csv"), *words]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert done.stderr == "tactfix: 20 sets: 20 located\n"
        printed.append(done.stdout)
    assert printed[0] == printed[1]


def test_a_missing_cluster_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tactfix.batching.cluster._CONNECT_SECONDS", 1)
    with pytest.raises(ClusterError, match=r"tcp://127.0.0.1:9: no Dask scheduler answers"):
        DaskCluster("tcp://127.0.0.1:9").open().__enter__()
    with pytest.raises(ClusterError, match="no Dask scheduler"):
        DaskCluster("nonsense").open().__enter__()
