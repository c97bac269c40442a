"""The journal keeps every row that was done, whenever its writer was stopped."""

from pathlib import Path

import pytest

from tactfix.batching.row import BatchRow
from tactfix.errors import FileError
from tactfix.files.batch_journal import BatchJournal, journal_path


def row(name: str, status: str = "located") -> BatchRow:
    return BatchRow(name, status, True, "", "mm", tuple(map(float, range(16))), (0.1,) * 6, 1.5, 9, 1e-3, ("ä",))  # type: ignore[arg-type]


def test_rows_come_back_after_any_number_of_stops(tmp_path: Path) -> None:
    for k in range(3):
        with BatchJournal(tmp_path / "j") as journal:
            assert len(journal) == k
            journal.add(f"key {k}", row(f"set {k}"))
    with BatchJournal(tmp_path / "j") as journal:
        assert [journal.row(f"key {k}") for k in (2, 0, 1)] == [row(f"set {k}") for k in (2, 0, 1)]
        assert "key 3" not in journal


@pytest.mark.parametrize("cut", range(1, 60, 7))
def test_a_last_line_that_was_cut_off_is_dropped(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "j"
    with BatchJournal(path) as journal:
        journal.add("one", row("one"))
        journal.add("two", row("two"))
    path.write_bytes(path.read_bytes()[:-cut])
    with BatchJournal(path) as journal:
        assert "one" in journal
        assert "two" not in journal
        journal.add("two", row("two again"))
    with BatchJournal(path) as journal:
        assert journal.row("one") == row("one")
        assert journal.row("two") == row("two again")


@pytest.mark.parametrize("length", [0, 1, 20])
def test_a_journal_killed_in_its_first_line_begins_anew(tmp_path: Path, length: int) -> None:
    path = tmp_path / "j"
    with BatchJournal(path):
        pass
    path.write_bytes(path.read_bytes()[:length])
    with BatchJournal(path) as journal:
        journal.add("one", row("one"))
    with BatchJournal(path) as journal:
        assert journal.row("one") == row("one")


def test_errors_are_tried_again(tmp_path: Path) -> None:
    with BatchJournal(tmp_path / "j") as journal:
        journal.add("one", row("one", "error"))
        assert "one" in journal
    with BatchJournal(tmp_path / "j") as journal:
        assert "one" not in journal


def test_another_file_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "j").write_text("my diary\n")
    with pytest.raises(FileError, match="not the journal"):
        BatchJournal(tmp_path / "j")
    assert (tmp_path / "j").read_text() == "my diary\n"


def test_two_at_once_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("fcntl")
    with BatchJournal(tmp_path / "j"), pytest.raises(FileError, match="another batch"):
        BatchJournal(tmp_path / "j")


def test_it_stands_beside_the_output() -> None:
    assert journal_path(Path("a/results.parquet")) == Path("a/results.parquet.partial.jsonl")
