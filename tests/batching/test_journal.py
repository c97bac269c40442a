"""The journal keeps every finished row, whenever the writer is stopped."""

from pathlib import Path
from random import Random

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
def test_a_journal_cut_off_in_its_first_line_starts_again(tmp_path: Path, length: int) -> None:
    path = tmp_path / "j"
    with BatchJournal(path):
        pass
    path.write_bytes(path.read_bytes()[:length])
    with BatchJournal(path) as journal:
        journal.add("one", row("one"))
    with BatchJournal(path) as journal:
        assert journal.row("one") == row("one")


@pytest.mark.parametrize("seed", range(5))
def test_a_changed_line_of_a_journal_is_ignored(tmp_path: Path, seed: int) -> None:
    """A changed byte in any line except the first loses that row and no other."""
    random, path = Random(seed), tmp_path / "j"
    with BatchJournal(path) as journal:
        for name in "abc":
            journal.add(name, row(name))
    lines = path.read_bytes().splitlines(keepends=True)
    for _ in range(40):
        which = random.randrange(1, 4)
        line = bytearray(lines[which])
        line[random.randrange(len(line) - 1)] ^= random.randrange(1, 256)
        path.write_bytes(b"".join([*lines[:which], line, *lines[which + 1 :]]))
        with BatchJournal(path) as journal:
            left = [name for name in "abc" if name in journal]
            assert left == [name for name in "abc" if name != "abc"[which - 1]]
            assert all(journal.row(name) == row(name) for name in left)


@pytest.mark.parametrize("line", [b"[]", b"1", b'{"key": "a", "row": {"status": "located"}}', b"null", b"\xff" * 9])
def test_an_invalid_line_of_a_journal_is_skipped(tmp_path: Path, line: bytes) -> None:
    path = tmp_path / "j"
    with BatchJournal(path) as journal:
        journal.add("one", row("one"))
    path.write_bytes(path.read_bytes() + line + b"\n")
    with BatchJournal(path) as journal:
        assert len(journal) == 1


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


def test_the_journal_is_next_to_the_output() -> None:
    assert journal_path(Path("a/results.parquet")) == Path("a/results.parquet.partial.jsonl")
