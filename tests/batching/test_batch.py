"""A batch gives each contact set the same result as locate does, in order, even if other sets fail."""

import pickle
import signal
from pathlib import Path

import numpy as np
import pytest

from tactfix import load_contacts, load_fixture, locate
from tactfix.batching.batch import here, run_batch, spread_over
from tactfix.batching.processes import LocalProcesses
from tactfix.batching.row import row_json, row_of_json
from tactfix.batching.task import BatchTask, ContactSet, locate_set
from tactfix.files.batch_journal import BatchJournal
from tests.support.contact_sets import PLAIN, blank, buggy, contact_file, contact_sets, deadly, pose, slow, write_cell


@pytest.fixture
def task(tmp_path: Path) -> BatchTask:
    fixture, _ = write_cell(tmp_path, 0)
    return BatchTask(load_fixture(fixture), PLAIN, blank)


def with_reader(task: BatchTask, read: object) -> BatchTask:
    return BatchTask(task.fixture, read, task.describe)  # type: ignore[arg-type]


def over(jobs: int):
    return lambda task, numbered: spread_over(LocalProcesses(jobs), task, numbered)


def run(task: BatchTask, sets, spread, directory: Path):
    with BatchJournal(directory / "journal") as journal:
        return list(run_batch(task, sets, spread, journal, "digest", lambda done: None))


def test_a_row_equals_the_result_of_locate(task: BatchTask) -> None:
    one = ContactSet("one", contact_file(5, noise=0.01).encode())
    result = locate(task.fixture, load_contacts(one.content, task.fixture))
    row = locate_set(task, one)
    assert (row.name, row.status, row.acceptable, row.message) == ("one", "located", True, "")
    assert np.array_equal(np.reshape(row.transform, (4, 4)), result.base_from_fixture)
    assert np.array_equal(np.square(row.sigmas), np.square(np.sqrt(np.diag(result.covariance))))
    assert (row.chi2, row.dof, row.rms) == (result.chi2, 9, result.rms)
    assert np.abs(np.reshape(row.transform, (4, 4)) - pose(5)).max() < 0.1


def test_rows_survive_json(task: BatchTask) -> None:
    for contact_set in (*contact_sets(1), ContactSet("no such", unreadable="gone")):
        row = locate_set(task, contact_set)
        assert row_of_json(row_json(row)) == row


def test_a_task_can_be_pickled(task: BatchTask) -> None:
    copy = pickle.loads(pickle.dumps(task))
    assert dict(copy.fixture.features).keys() == dict(task.fixture.features).keys()
    one = contact_sets(1)[0]
    assert locate_set(copy, one) == locate_set(task, one)


def test_workers_and_one_process_agree_in_order(task: BatchTask, tmp_path: Path) -> None:
    sets = contact_sets(12)
    alone = run(task, sets, here, tmp_path)
    (tmp_path / "journal").unlink()
    assert [row.name for row in alone] == [one.name for one in sets]
    assert run(task, sets, over(2), tmp_path) == alone
    for k, row in enumerate(alone):
        assert np.abs(np.reshape(row.transform, (4, 4)) - pose(k)).max() < 1e-6


def test_a_bug_is_a_row(task: BatchTask, tmp_path: Path) -> None:
    rows = run(with_reader(task, buggy), contact_sets(6), here, tmp_path)
    assert [row.status for row in rows] == ["located"] * 3 + ["error"] + ["located"] * 2
    assert "ZeroDivisionError: as any bug" in rows[3].message


def test_a_set_that_kills_its_worker_is_an_error_row(task: BatchTask, tmp_path: Path) -> None:
    rows = run(with_reader(task, deadly), contact_sets(8), over(2), tmp_path)
    assert [row.name for row in rows] == [f"set {k}" for k in range(8)]
    assert [row.status for row in rows] == ["located"] * 3 + ["error"] + ["located"] * 4
    assert "died" in rows[3].message


def test_sets_that_are_done_are_not_located_again(task: BatchTask, tmp_path: Path) -> None:
    sets = contact_sets(6)
    done = run(task, sets[:4], here, tmp_path)
    sent = []

    def watched(task: BatchTask, numbered):
        for one in numbered:
            sent.append(one[1].name)
            yield from here(task, iter([one]))

    changed = ContactSet("set 1", contact_file(77).encode())
    rows = run(task, [sets[0], changed, *sets[2:]], watched, tmp_path)
    assert sent == ["set 1", "set 4", "set 5"]
    assert [rows[0], *rows[2:4]] == [done[0], *done[2:]]
    assert rows[1] != done[1]


def test_another_fixture_or_option_repeats_all_sets(task: BatchTask, tmp_path: Path) -> None:
    sets = contact_sets(2)
    run(task, sets, here, tmp_path)
    with BatchJournal(tmp_path / "journal") as journal:
        assert all(one.key("digest") in journal for one in sets)
        assert not any(one.key("another digest") in journal for one in sets)


def test_sets_are_taken_only_as_workers_follow(task: BatchTask, tmp_path: Path) -> None:
    taken = []

    def sets():
        for k, one in enumerate(contact_sets(40)):
            taken.append(k)
            yield one

    rows = spread_over(LocalProcesses(2), with_reader(task, slow(0.05)), enumerate(sets()))
    next(rows)
    assert len(taken) < 20
    rows.close()


def test_exceeded_gates_are_reported_in_the_row(task: BatchTask) -> None:
    one = contact_sets(1)[0]
    strict = BatchTask(task.fixture, PLAIN, blank, max_sigma=1e-9)
    row = locate_set(strict, one)
    assert row.status == "located"
    assert not row.acceptable
    assert "above the limit of 1e-09" in row.message
    assert locate_set(BatchTask(task.fixture, PLAIN, blank, max_sigma=1.0), one).acceptable
    # At 12 m from the origin the same pose is less certain.
    far = BatchTask(task.fixture, PLAIN, blank, max_sigma=1.0, point_fixture=(0.0, 0.0, 1e6))
    assert not locate_set(far, one).acceptable


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="needs signal masks")
def test_a_worker_never_takes_an_interrupt_not_even_while_it_starts():
    with LocalProcesses(1).open() as (executor, _):
        assert signal.SIGINT in executor.submit(signal.pthread_sigmask, signal.SIG_BLOCK, ()).result()
        assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())
